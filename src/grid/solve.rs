//! From a problem to its density: the domain, which is widened where its edges lose what matters, the mesh, and the errors.

use super::density::GridDensity;
use super::field::{self, difference};
use super::iteration::THIN;
use super::kept::Kept;
use super::line::Line;
use super::mesh::{Side, Sides};
use super::operator::Layout;
use super::pilot::GridPilot;
use super::refinement::{Exhausted, Pair, resolve};
use super::start::Ground;
use super::stationary::Stationary;
use super::wells::Question;
use super::{Grid, GridProgress, shape, start, stationary};
use crate::checks::positive;
use crate::error::{Error, Result};
use crate::grid::{GRAZING, HOPELESS};
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::walls::{COLLAPSE, Wall};
use std::sync::Arc;

/// How often a domain that loses too much at its edges is made wider.
const WIDENINGS: usize = 2;
/// The share of the accuracy, in L¹, that what is lost at the edges of a domain may change before the domain is widened.
const SHARE: f64 = 0.2;
/// The degree of the polynomials, at any accuracy where there is a level or a wall with r < 1, next to which the density is not
/// smooth.
const ORDINARY_DEGREE: usize = 6;
/// Accuracies in L¹ with the degree of the polynomials for finer ones; the first pair that fits decides.
const FINER_DEGREES: [(f64, usize); 2] = [(3e-8, 10), (3e-6, 8)];
/// The same in three states, where the work grows with the sixth power of the degree.
const OF_SPACE: [(f64, usize); 2] = [(5e-4, 6), (5e-3, 5)];
const COARSEST: usize = 4;
/// The degree of the polynomials for the closed form of one state, where none is given.
const DEGREE: usize = 10;
/// The lowest degree of the polynomials for the closed form of one state: with a lower one what is left in the highest degree
/// of a cell falls too slowly to come to rounding.
const LEAST: usize = 6;
/// What is lost where no mesh line can follow a kink.
const OBLIQUE: &str = "the drift has a kink or a jump along a curve or an oblique line, which no mesh line follows: the error falls slowly there, \
    as the estimate says";
/// What remains open of a system whose trajectories were followed for too short a time.
const UNSETTLED: &str = "trajectories spread farther for as long as the work of a pilot allows: there may be no stationary density, so \
    compare with a long simulation";

impl Grid {
    /// The density, on a mesh that is fine next to the speed 0 at walls with r < 1 and at `other` sides of state 0.
    pub(super) fn resolved(
        &self,
        problem: &Problem,
        walls: [Option<Wall>; 2],
        pilot: GridPilot,
        other: [bool; 2],
    ) -> Result<GridDensity> {
        if problem.dimension() == 1 && self.domain.is_none() {
            return self.on_a_line(problem, pilot);
        }
        let limits: [[Option<f64>; 2]; shape::MOST] = std::array::from_fn(|axis| {
            let ends = problem.end_limits(axis);
            [0, 1].map(|side| walls[side].filter(|_| axis == 0).map(|wall| wall.offset()).or(ends[side]))
        });
        let sides: Sides = std::array::from_fn(|axis| {
            [0, 1].map(|side| match (walls[side].filter(|_| axis == 0), limits[axis][side]) {
                (Some(wall), _) => Side::Wall(wall.restitution()),
                (None, Some(_)) => Side::Closed,
                (None, None) => Side::Open,
            })
        });
        let target = self.target(problem.dimension());
        let own = sides[0].map(|side| start::smallest(side, target, problem.dimension()));
        let grazed = [0, 1].map(|side| own[side].or(other[side].then_some(GRAZING)));
        let degree = self.degree_for(problem.dimension(), target, grazed != [None; 2]);
        let question = Question { problem, states: &pilot.states, memory: self.memory, target };
        let rounds = std::cell::Cell::new(0);
        let mut report = |mut progress: GridProgress| {
            progress.rounds += rounds.get();
            self.report(|| progress)
        };
        let mut widened = 0;
        loop {
            let mut domain = self.domain.clone().unwrap_or_else(|| start::domain(problem, &pilot, widened));
            for (own, limits) in domain.iter_mut().zip(limits) {
                (0..2).for_each(|side| own[side] = limits[side].unwrap_or(own[side]));
            }
            for [low, high] in &domain {
                positive(
                    "side of the domain",
                    high - low,
                    "give lower and upper limits in this order, around the walls",
                )?;
            }
            let ground = Ground { problem, pilot: &pilot, domain, sides, grazed };
            // In three states a wider domain takes far more cells, so that its edges may lose their share.
            let aim = if problem.dimension() > 2 { (1.0 - SHARE) * target } else { target };
            let pair = resolve(question, ground.mesh(), (degree, aim), pilot.peak(), &mut report)?;
            let cut = pair.fine.leak.at_edges() && pair.fine.returned().size() > SHARE * target;
            let fixed = self.domain.is_some() || widened == WIDENINGS;
            rounds.set(rounds.get() + pair.rounds);
            if !cut || fixed || pair.exhausted.is_some() {
                return self.density(problem, walls, pilot.clone(), pair, (rounds.get(), cut));
            }
            widened += 1;
        }
    }

    /// The density of one state in closed form, on a mesh that holds it to rounding.
    fn on_a_line(&self, problem: &Problem, pilot: GridPilot) -> Result<GridDensity> {
        let degree = self.degree.map_or(DEGREE, |degree| degree.max(LEAST));
        let peak = pilot.peak();
        // Where the noise vanishes trajectories may leave one side for ever, on which nothing is stationary.
        let on = |inside: f64| Line::new(problem, inside, pilot.deviation(0));
        let [low, high] = pilot.reach()[0];
        let line = on(peak[0]).or_else(|error| on(low).or_else(|_| on(high)).map_err(|_| error))?;
        let question = Question { problem, states: &pilot.states, memory: self.memory, target: self.target(1) };
        let exact = line.resolved(degree);
        let layout = Layout::new(exact.mesh.as_ref().clone());
        let solved = |degree: usize, field: field::GridField| -> Result<Stationary> {
            let mut solution = stationary::solve(question, &layout, degree, std::slice::from_ref(&peak))?;
            // Both degrees have the closed form in place of the solution.
            solution.replace(field);
            Ok(solution)
        };
        let fine = solved(degree, exact.clone())?;
        let coarse = solved(degree - 1, exact.with_shape(shape::Shape { states: 1, degree: degree - 1 }))?;
        let difference = difference(&fine.density.field, &coarse.density.field);
        let pair = Pair { fine, coarse, difference, rounds: 2, exhausted: None };
        let parted = line.parted(&pilot.states);
        let mut density = self.density(problem, [None; 2], pilot, pair, (2, false))?;
        density.provenance.warning = parted.or(density.provenance.warning);
        Ok(density)
    }

    fn density(
        &self,
        problem: &Problem,
        walls: [Option<Wall>; 2],
        pilot: GridPilot,
        Pair { fine, coarse, difference, exhausted, .. }: Pair,
        (rounds, cut): (usize, bool),
    ) -> Result<GridDensity> {
        let field = fine.density.field.clone();
        let mut changes = fine.open.clone();
        changes.push(fine.returned());
        let changed: f64 = changes.iter().map(field::GridField::size).sum();
        let ([least, peak], negative_mass) = field.extremes();
        let mesh = &field.mesh;
        let mut edges = field.at_edges();
        let edge_level = edges.iter().map(|(.., level)| *level).fold(0.0, f64::max);
        let l1_estimate = difference + changed;
        let cut = cut.then_some(edge_level);
        let warning = self.warning(&fine, l1_estimate, (cut, exhausted, changed));
        let oblique = problem.is_bent_obliquely().then_some(OBLIQUE);
        let open = if pilot.settles { oblique } else { Some(UNSETTLED) };
        let collapsing = walls.iter().flatten().any(Wall::collapses).then_some(COLLAPSE);
        let warning = warning.or(open.or(collapsing).map(str::to_owned));
        if fine.wells.determined && (l1_estimate.is_nan() || l1_estimate >= HOPELESS) {
            let why = warning.unwrap_or_else(|| "check that the noise reaches every state".into());
            let reason = format!("its estimate of the error in L1 is {l1_estimate:.1e}; {why}");
            return Err(Error::NotResolved { estimate: l1_estimate, reason });
        }
        let provenance = Provenance {
            method: "grid".into(),
            cells: Some(mesh.cells.len()),
            degree: Some(field.shape.degree),
            unknowns: Some(fine.operator.unknowns()),
            iterations: Some(rounds),
            nonzeros: Some(fine.operator.numbers()),
            domain: Some(mesh.domain()),
            edge_level: Some(edge_level),
            leak: Some(fine.leak.lost),
            residual: Some(fine.residual),
            l1_estimate: Some(l1_estimate),
            most_negative: Some(least / peak),
            negative_mass: Some(negative_mass),
            warning,
            ..Provenance::default()
        };
        edges.retain(|_| fine.leak.at_edges());
        let coarse_field = coarse.density.field.clone();
        let kept = Kept { problem: problem.clone(), walls, grid: self.clone(), pilot, solutions: [fine, coarse] };
        let mut density = GridDensity {
            fine: field,
            coarse: coarse_field,
            changes,
            edges,
            graded: false,
            kept: Arc::new(kept),
            shear: None,
            provenance,
        };
        // What lies beyond the edges is not within the domain.
        density.provenance.l1_estimate = Some(l1_estimate + density.beyond(&vec![0; problem.dimension()]));
        Ok(density)
    }

    /// What no mesh mends within the memory, given the estimate, the level at the edges of a domain that cuts the density, and the part of
    /// the estimate that leaks, rounding and wells leave open.
    fn warning(
        &self,
        fine: &Stationary,
        l1_estimate: f64,
        (cut, exhausted, changed): (Option<f64>, Option<Exhausted>, f64),
    ) -> Option<String> {
        let states = fine.density.field.shape.states;
        let (in_space, target) = (states > 2, self.target(states));
        if !fine.wells.determined {
            Some(format!(
                "the shares of {} wells are not determined by the equation, since they exchange less than rounding: they are those of trajectories",
                fine.places().len()
            ))
        } else if let Some(edge_level) = cut.filter(|_| exhausted.is_none() || !in_space) {
            Some(format!(
                "the domain loses {:.1e} per unit time at its edges, where the density is {edge_level:.1e} of its peak: its tails are heavy",
                fine.leak.lost
            ))
        } else if let Some(what) = exhausted.filter(|_| l1_estimate > target) {
            let why = match what {
                Exhausted::Memory if in_space => {
                    "the density is too thin for the memory; raise `memory_limit`, or take the closure or the simulation"
                }
                Exhausted::Memory => "the density is too narrow for the memory; raise `memory_limit`",
                Exhausted::Steps => THIN,
            };
            let cells = fine.density.field.mesh.cells.len();
            Some(format!(
                "the mesh has {cells} cells and an estimate of {l1_estimate:.1e}, above the accuracy asked for: {why}"
            ))
        } else if l1_estimate > target {
            Some(format!(
                "the estimate is {l1_estimate:.1e}, above the accuracy asked for: rounding, leaks and the shares of wells that exchange little leave {changed:.1e} open, which no finer mesh lowers"
            ))
        } else {
            None
        }
    }

    /// Calls the callback, if there is one.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if it returns `Break`.
    pub(super) fn report(&self, progress: impl FnOnce() -> GridProgress) -> Result<()> {
        let Some(callback) = &self.progress else { return Ok(()) };
        let progress = progress();
        let stop = callback(progress).is_break();
        if stop { Err(Error::Cancelled { done: progress.rounds as u64, unit: "linear systems" }) } else { Ok(()) }
    }

    pub(super) fn degree_for(&self, states: usize, accuracy: f64, grazed: bool) -> usize {
        if states > 2 {
            let of_space = OF_SPACE.iter().find(|(limit, _)| accuracy < *limit);
            return self.degree.unwrap_or(of_space.map_or(COARSEST, |(_, degree)| *degree));
        }
        let finer = FINER_DEGREES.iter().find(|(limit, _)| accuracy < *limit && !grazed);
        self.degree.unwrap_or(finer.map_or(ORDINARY_DEGREE, |(_, degree)| *degree))
    }
}

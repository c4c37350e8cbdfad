//! From a domain to a density: the domain adjusted by cheap solutions, then two degrees on one mesh.

use super::density::GridDensity;
use super::domain::Profile;
use super::field::Field;
use super::layout::Layout;
use super::legendre::Axis;
use super::space::Space;
use super::{Grid, stationary};
use crate::checks::positive;
use crate::error::{Error, Result};
use crate::grid::tuning;
use crate::problem::{COLLAPSE, PlaneMotion, Problem, Wall};
use crate::provenance::Provenance;

type Domain = [[f64; 2]; 2];

pub(super) struct Solver<'a> {
    pub(super) grid: &'a Grid,
    pub(super) degree: usize,
    pub(super) cells: [usize; 2],
    pub(super) problem: &'a Problem,
    /// The walls below the motion and above it.
    pub(super) walls: [Option<Wall>; 2],
    /// What the density is differentiated along.
    pub(super) motions: &'a [PlaneMotion],
}

impl Solver<'_> {
    /// The density, and its derivatives in the order of [`GridDensity::solutions`].
    pub(super) fn run(&self, start: Domain, adjust: bool) -> Result<(GridDensity, Vec<[Field; 3]>)> {
        let memory = self.grid.memory;
        let mut domain = self.between_walls(start);
        for [low, high] in domain {
            positive("side of the domain", high - low, "give lower and upper limits in this order, around the walls")?;
        }
        let mut trial: Option<Field> = None;
        for attempt in 1..=tuning::domain::ATTEMPTS {
            let space = self.space(domain, tuning::domain::TRIAL_DEGREE, tuning::domain::TRIAL_CELLS, false);
            let centre = space.elements() / 2 + space.axes[1].cells() / 2;
            let pin = trial.as_ref().map_or(centre, |field| self.same_place(field, &space));
            let field = stationary::solve(self.problem, &space, pin, memory, &[])?.field;
            let next = self.between_walls(self.measured(&field));
            let settled = self.settled(domain, next);
            // A domain that is given is judged by the solution itself: steep forces are beyond this mesh.
            if adjust && attempt == tuning::domain::ATTEMPTS {
                self.edge_level(&field, domain, tuning::domain::CUT)?;
            }
            trial = Some(field);
            if !adjust {
                break;
            }
            domain = next;
            if settled {
                break;
            }
        }
        let degree = self.degree;
        let space = self.space(domain, degree, self.cells, true);
        let pin = trial.as_ref().map_or(0, |field| self.same_place(field, &space));
        let solve = |space: &Space, pin: usize| stationary::solve(self.problem, space, pin, memory, self.motions);
        let mut coarse = solve(&Space { degree: degree - 1, ..space.clone() }, pin)?;
        let mut fine = solve(&space, coarse.field.peak_element())?;
        let derivatives = [&mut fine, &mut coarse].map(|solution| std::mem::take(&mut solution.derivatives));
        let density = self.density(fine, coarse.field, domain)?;
        let [fine, coarse] = derivatives;
        let all = fine.into_iter().zip(coarse).map(|([fine, returned], [coarse, _])| [fine, coarse, returned]);
        Ok((density, all.collect()))
    }

    /// The domain with the walls as its limits.
    fn between_walls(&self, mut domain: Domain) -> Domain {
        for (side, wall) in self.walls.iter().enumerate() {
            if let Some(wall) = wall {
                domain[0][side] = wall.offset();
            }
        }
        domain
    }

    fn open(&self, state: usize, side: usize) -> bool {
        state == 1 || self.walls[side].is_none()
    }

    /// The domain at whose edges the density of `field` falls to the requested level.
    fn measured(&self, field: &Field) -> Domain {
        std::array::from_fn(|state| {
            let profile = Profile::new(field, state);
            std::array::from_fn(|side| profile.limit(side, self.grid.edge_level))
        })
    }

    /// Whether the limits have stopped moving outwards.
    fn settled(&self, old: Domain, new: Domain) -> bool {
        (0..2).all(|state| {
            let slack = 0.05 * (old[state][1] - old[state][0]);
            new[state][0] > old[state][0] - slack && new[state][1] < old[state][1] + slack
        })
    }

    /// The element of `space` that holds the peak of `field`.
    fn same_place(&self, field: &Field, space: &Space) -> usize {
        let place = field.space.place(field.peak_element());
        let cells: [usize; 2] = std::array::from_fn(|s| {
            let axis = &field.space.axes[s];
            let u = axis.origin + (axis.lines[place[s]] + axis.lines[place[s] + 1]) / 2.0 - space.axes[s].origin;
            space.axes[s].locate(u).unwrap_or(0)
        });
        space.element(cells[0], cells[1])
    }

    /// Whether grazing impacts on a wall make the density singular, or its derivative by the restitution.
    pub(super) fn grazed(&self, side: usize) -> bool {
        let lossy = self.walls[side].is_some_and(|wall| wall.restitution() < 1.0);
        lossy || self.motions.iter().any(|motion| motion.restitution[side] != 0.0)
    }

    /// The elements on `domain`; with `layers`, also those at the grazing points of walls that take energy.
    fn space(&self, domain: Domain, degree: usize, cells: [usize; 2], layers: bool) -> Space {
        let grazed = [0, 1].map(|side| layers && self.grazed(side));
        Layout { problem: self.problem, walls: self.walls, grazed, grazing: self.grid.grazing }
            .space(domain, degree, cells)
    }

    /// The largest density at an open edge relative to the peak, refused if above `accepted`.
    fn edge_level(&self, field: &Field, domain: Domain, accepted: f64) -> Result<f64> {
        let mut highest = 0.0;
        for state in 0..2 {
            let profile = Profile::new(field, state);
            for side in (0..2).filter(|side| self.open(state, *side)) {
                let level = profile.edge(side);
                if level.is_nan() || level > accepted {
                    let accepted = self.grid.edge_level;
                    return Err(Error::DomainCut { state, edge: domain[state][side], level, accepted });
                }
                highest = level.max(highest);
            }
        }
        Ok(highest)
    }

    fn density(&self, fine: stationary::Stationary, coarse: Field, domain: Domain) -> Result<GridDensity> {
        let stationary::Stationary { field, returned, leak, residual, nonzeros, .. } = fine;
        let error = difference(&field, &coarse);
        let edge_level = self.edge_level(&field, domain, self.grid.edge_level.max(error.min(tuning::domain::CUT)))?;
        let (mut peak, mut least, mut negative_mass) = (0.0_f64, 0.0_f64, 0.0);
        field.for_each_node(field.space.rule(0), |_, weight, p| {
            (peak, least) = (peak.max(p), least.min(p));
            negative_mass += weight * (-p).max(0.0);
        });
        if negative_mass.is_nan() || negative_mass > tuning::domain::NEGATIVE {
            return Err(Error::Negative { mass: negative_mass });
        }
        let provenance = Provenance {
            method: "grid".into(),
            cells: Some(field.space.axes.each_ref().map(Axis::cells)),
            degree: Some(field.space.degree),
            unknowns: Some(field.space.unknowns()),
            nonzeros: Some(nonzeros),
            domain: Some(domain.to_vec()),
            edge_level: Some(edge_level),
            leak: Some(leak),
            residual: Some(residual),
            l1_estimate: Some(error + returned.size()),
            most_negative: Some(least / peak),
            negative_mass: Some(negative_mass),
            warning: self.walls.iter().flatten().any(Wall::collapses).then(|| COLLAPSE.to_owned()),
            ..Provenance::default()
        };
        Ok(GridDensity {
            fine: field,
            coarse,
            returned,
            problem: self.problem.clone(),
            domain,
            edge_level,
            grid: *self.grid,
            provenance,
        })
    }
}

/// ∫ |p − q| dx for two degrees on one mesh.
pub(super) fn difference(fine: &Field, coarse: &Field) -> f64 {
    let (n, m) = (fine.space.modes(), coarse.space.modes());
    let mut gap = fine.clone();
    for (block, lower) in gap.coefficients.chunks_exact_mut(n * n).zip(coarse.coefficients.chunks_exact(m * m)) {
        for (row, lower) in block.chunks_exact_mut(n).zip(lower.chunks_exact(m)) {
            row.iter_mut().zip(lower).for_each(|(p, q)| *p -= q);
        }
    }
    gap.size()
}

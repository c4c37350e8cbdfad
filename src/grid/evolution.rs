//! A density on its way through time, on a mesh that follows it.

use super::field::GridField;
use super::initial::Initial;
use super::march::Stepper;
use super::mesh::Mesh;
use super::operator::Layout;
use super::refinement::{Finer, finer, indicator};
use super::shape::Shape;
use super::start::Ground;
use super::tree::Tree;
use crate::envelope::{Envelope, Piece};
use crate::error::{Error, Result};
use crate::grid::{Grid, GridProgress, HOPELESS, SHARE};
use crate::states::States;
use std::sync::Arc;

/// The least factor by which the length of a step in time changes: each new length costs new factors of the matrix, as much as
/// one to two steps.
const CHANGE: f64 = 1.6;
/// The least factor by which the length of a step in time changes under modulated noise, where every step has factors of the
/// matrix of its own.
const FINE_CHANGE: f64 = 1.4;
/// The largest factor by which the length of a step in time grows from one step to the next.
const GROWTH: f64 = 4.0;
/// The whole time of a transient over its first step.
const FIRST: f64 = 400.0;
/// In a transient two cells are joined where the pair would have this part of its share of the aim, or less, in its highest
/// degree.
const LOOSE: f64 = 0.8;
/// The number of steps in time after which a mesh is searched for cells to be joined.
const LOOK: usize = 4;
/// Cells of a transient's mesh are joined only if this part of all cells or less is left: a new mesh costs new factors of the
/// matrix.
const WORTH: f64 = 0.8;
/// The steps in time after which a transient is given up.
const MAX_STEPS: usize = 20_000;
/// The most unknowns times steps, of those to the end at their present length, for which a mesh is refined, and of all steps together: a
/// bound on work, of half an hour and more. Densities of one oscillator with an accuracy of 1e-5 take 1e8.
pub(super) const MOST_WORK: f64 = 1e9;
/// The density of the lower degree has up to 9 times the density's own aim in its highest degree. With more it has a mode of cells
/// where next to nothing is, which would grow: the mesh is refined for this one too.
const LOWER: f64 = 16.0;
/// Why a mesh is not refined.
const NO_MEMORY: &str = "the memory does not suffice for the mesh: raise `memory_limit`";
const NO_TIME: &str =
    "the mesh that the density needs is too large for so many steps: ask for an earlier time, or a larger accuracy";

/// What a density is followed by: the noise's envelope, and the accuracy of mesh and steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct EvolutionPlan<'a> {
    pub(super) envelope: Option<&'a Envelope>,
    pub(super) accuracy: f64,
    pub(super) degree: usize,
    /// Whose memory and progress these are.
    pub(super) grid: &'a Grid,
    /// The most unknowns times steps to the end for which the mesh is refined,
    pub(super) most_ahead: f64,
    /// and the most unknowns that all steps together solve for.
    pub(super) most_spent: f64,
}

impl<'a> EvolutionPlan<'a> {
    /// With the bounds on work of a grid.
    pub(super) fn new(envelope: Option<&'a Envelope>, accuracy: f64, degree: usize, grid: &'a Grid) -> Self {
        EvolutionPlan { envelope, accuracy, degree, grid, most_ahead: MOST_WORK, most_spent: MOST_WORK }
    }
}

/// Densities of two degrees on one mesh, which has cells where they need them: it is refined before a step that it would not hold,
/// and coarsened behind.
pub(super) struct Evolution<'a> {
    plan: EvolutionPlan<'a>,
    ground: &'a Ground<'a>,
    /// The coarsest mesh.
    base: Tree,
    steppers: [Stepper; 2],
    /// Those of the degree and of one less.
    pub(super) fields: [GridField; 2],
    pub(super) time: f64,
    /// The last time that is asked for.
    end: f64,
    /// The longest step that is tried next, the last one, and those since the mesh was looked through.
    step: f64,
    last: f64,
    since: usize,
    steps: usize,
    /// The unknowns of all steps together.
    spent: f64,
    /// The sum of the steps' differences from a lower order, relative to the root mean square of p,
    pub(super) error: f64,
    /// and that of their masses.
    pub(super) moved: f64,
    /// Why the mesh is no longer refined, once it is not.
    pub(super) exhausted: Option<&'static str>,
}

impl<'a> Evolution<'a> {
    /// Begins with a start; `stationary` are the solutions of both degrees, and `end` is the last time.
    pub(super) fn new(
        plan: EvolutionPlan<'a>,
        ground: &'a Ground<'a>,
        initial: &Initial,
        stationary: [&GridField; 2],
        end: f64,
    ) -> Result<Self> {
        let shapes = [0, 1].map(|less| Shape { states: ground.domain.len(), degree: plan.degree - less });
        let aim = SHARE * plan.accuracy;
        let (layout, field, exhausted) = initial.held(ground, stationary[0], (shapes[0], plan.grid.memory), aim)?;
        let coarse = initial.field(stationary[1], &layout.mesh, shapes[1])?;
        let base = ground.mesh_for(&States::new(ground.domain.len())).tree;
        let steppers = Self::steppers(plan, ground, &layout)?;
        let (time, step) = (initial.time, (end - initial.time) / FIRST);
        let fields = [field, coarse];
        Ok(Evolution {
            plan,
            ground,
            base,
            steppers,
            fields,
            time,
            end,
            step,
            last: f64::INFINITY,
            // The first mesh may be finer than it need be.
            since: LOOK - 1,
            steps: 0,
            spent: 0.0,
            error: 0.0,
            moved: 0.0,
            exhausted: exhausted.then_some(NO_MEMORY),
        })
    }

    fn steppers(plan: EvolutionPlan<'_>, ground: &Ground<'_>, layout: &Layout) -> Result<[Stepper; 2]> {
        let of = |degree| Stepper::new(ground.problem, layout, degree, plan.envelope.is_some(), plan.grid.memory);
        let (fine, coarse) = rayon::join(|| of(plan.degree), || of(plan.degree - 1));
        Ok([fine?, coarse?])
    }

    /// Goes on to `end`, at steps of the envelope in between anew.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the steps become too many, [`Error::NotResolved`] if their errors add up to the density itself,
    /// [`Error::Cancelled`].
    pub(super) fn advance(&mut self, end: f64) -> Result<()> {
        // Where every step needs new factors anyway its length follows the error more closely.
        let change = if self.plan.envelope.is_some() { FINE_CHANGE } else { CHANGE };
        let (aim, tolerance) = (SHARE * self.plan.accuracy, self.plan.accuracy);
        let mut refused = 0;
        while self.time < end {
            let (piece, until, step) = self.next_step(end, change)?;
            self.plan.grid.report(|| self.progress())?;
            let times = [self.time, step];
            let [fine, coarse] = &mut self.steppers;
            let [p, q] = self.fields.each_ref().map(|field| &field.coefficients);
            let (fine, coarse) = rayon::join(|| fine.stepped(p, times, piece), || coarse.stepped(q, times, piece));
            let ([p, difference], [q, other]) = (fine?, coarse?);
            let error = (norm(&difference) / norm(&p)).max(norm(&other) / norm(&q));
            if error.is_nan() || error > tolerance {
                // Where the density is not smooth errors fall with a low power of the step.
                refused += 1;
                self.step = step / change.powi(refused);
                continue;
            }
            refused = 0;
            let lasts = (tolerance / (2.0 * error)).powf(0.25);
            let next = GridField { coefficients: p, ..self.fields[0].clone() };
            let lower = GridField { coefficients: q, ..self.fields[1].clone() };
            if self.exhausted.is_none() {
                let longer = step * lasts.min(GROWTH);
                match self.refined([&next, &lower], aim, (self.end - self.time) / longer) {
                    Ok(None) => {}
                    Ok(Some(layout)) => {
                        self.move_to(&layout, longer)?;
                        continue;
                    }
                    Err(reason) => self.exhausted = Some(reason),
                }
            }
            self.time = if until - self.time <= step * (1.0 + 1e-12) { until } else { self.time + step };
            self.error += error;
            if self.error >= HOPELESS {
                let reason = "the errors of the steps in time add up to the density, which moves by many of its own widths: take a wider start or a smaller accuracy";
                return Err(Error::NotResolved { estimate: self.error, reason: reason.into() });
            }
            self.moved += GridField { coefficients: difference, ..next.clone() }.mass().abs();
            self.fields = [next, lower];
            // The error of a longer step grows with the fourth power of the length.
            if step * lasts > self.step * change {
                self.step = (step * lasts).min(self.step * GROWTH);
            }
            self.since += 1;
            if self.since >= LOOK {
                self.since = 0;
                if let Some(mesh) = self.coarser(aim) {
                    self.move_to(&Layout::new(mesh), step * lasts.min(GROWTH))?;
                }
            }
        }
        Ok(())
    }

    /// The piece of the envelope that the next step is in, the end of steps of its length, and this length.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if the steps become too many.
    fn next_step(&mut self, end: f64, change: f64) -> Result<(Option<&'a Piece>, f64, f64)> {
        let piece = self.plan.envelope.map(|envelope| envelope.piece(self.time));
        let until = piece.map_or(end, |piece| end.min(piece.until));
        let left = until - self.time;
        // Equal steps up to the end, and the last length again where it is not much too short: a new one needs new factors.
        let [fewest, same] = [left / self.step, left / self.last];
        let again = (same - same.round()).abs() < 1e-9 * same && (1.0..change).contains(&(self.step / self.last));
        let step = left / if again { same.round() } else { (fewest - 1e-9).ceil().max(1.0) };
        self.last = step;
        self.steps += 1;
        self.spent += self.fields[0].coefficients.len() as f64;
        let long = self.steps > MAX_STEPS || self.spent > self.plan.most_spent;
        if long || self.step < f64::EPSILON * left {
            let remedy = "too many steps are needed to get there: take an earlier time or a larger accuracy";
            return Err(Error::OutOfRange { name: "time", value: end, remedy });
        }
        Ok((piece, until, step))
    }

    /// Before a step.
    fn progress(&self) -> GridProgress {
        let field = &self.fields[0];
        let (rounds, cells, indicator) = (self.steps, field.mesh.cells.len(), indicator(&field.highest()));
        GridProgress { rounds, cells, indicator, time: Some(self.time), ..GridProgress::default() }
    }

    /// The mesh that holds the densities of both degrees, where theirs does not; or the reason why there is none.
    fn refined(
        &self,
        [fine, coarse]: [&GridField; 2],
        aim: f64,
        steps: f64,
    ) -> std::result::Result<Option<Layout>, &'static str> {
        let needed = match finer(fine, aim, self.plan.grid.memory) {
            Finer::Enough => finer(coarse, LOWER * aim, self.plan.grid.memory),
            needed => needed,
        };
        match needed {
            Finer::Enough => Ok(None),
            Finer::Layout(layout) => {
                let unknowns = (layout.mesh.cells.len() * fine.shape.block()) as f64;
                if unknowns * steps.min(MAX_STEPS as f64) <= self.plan.most_ahead {
                    Ok(Some(layout))
                } else {
                    Err(NO_TIME)
                }
            }
            Finer::Exhausted => Err(NO_MEMORY),
        }
    }

    /// What the mesh leaves in the highest degree of the density, where it is no longer refined.
    pub(super) fn unresolved(&self) -> f64 {
        if self.exhausted.is_some() { indicator(&self.fields[0].highest()) } else { 0.0 }
    }

    /// Goes on on another mesh, whose factors are new with any `step`.
    fn move_to(&mut self, layout: &Layout, step: f64) -> Result<()> {
        for field in &mut self.fields {
            *field = field.carried(&layout.mesh, field.shape);
        }
        self.steppers = Self::steppers(self.plan, self.ground, layout)?;
        (self.step, self.since) = (step, 0);
        Ok(())
    }

    /// The mesh in which cells are joined, pair by pair, where that holds the density well enough; none if it saves little.
    fn coarser(&self, aim: f64) -> Option<Mesh> {
        let own = &self.fields[0].mesh;
        let share = LOOSE * aim / own.cells.len() as f64;
        let mut mesh = Mesh::clone(own);
        while let Some(coarser) = self.joined(&mesh, share).filter(|joined| joined.cells.len() < mesh.cells.len()) {
            mesh = coarser;
        }
        (mesh.cells.len() as f64 <= WORTH * own.cells.len() as f64).then_some(mesh)
    }

    /// The mesh in which the pairs of cells are one whose part of the highest degree is then at most `share`; none if there are none.
    fn joined(&self, mesh: &Mesh, share: f64) -> Option<Mesh> {
        let field = &self.fields[0];
        let mut pairs = mesh.tree.joinable(&self.base);
        let all = Arc::new(Mesh::within(mesh.origin, mesh.tree.joined(&pairs), mesh.sides));
        let highest = field.carried(&all, field.shape).highest();
        pairs.retain(|node| {
            let there = all.locate(&mesh.middle(&mesh.tree.cell(*node)));
            there.is_some_and(|cell| highest[cell].iter().all(|part| *part <= share))
        });
        if pairs.is_empty() {
            return None;
        }
        let mut tree = mesh.tree.joined(&pairs);
        tree.balance();
        Some(Mesh::within(mesh.origin, tree, mesh.sides))
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::GridDensity;
    use crate::problem::Problem;
    use crate::transient::Start;

    /// A mesh that would be too large for the steps to the end stays as it is, and what it leaves in the highest degree is said.
    #[test]
    fn a_mesh_too_large_for_its_steps_is_not_refined() -> Result<()> {
        let text = "states = ['x', 'v']\ndrift = { x = 'v', v = '-0.2*v - x - 0.3*x^3' }\nnoise.w.v = 'sqrt(0.4)'";
        let GridDensity { fine, coarse, kept, .. } = Grid::new().accuracy(1e-2).solve(&Problem::from_toml(text)?)?;
        let ground = kept.ground(fine.mesh.domain(), fine.mesh.sides, 1e-3);
        let initial = Initial::new(&Start::Point(vec![1.0, 0.0]), &ground, None, (0.5, 1e-3))?;
        let after = |most_ahead: f64| -> Result<(Option<&'static str>, usize, f64)> {
            let plan = EvolutionPlan::new(None, 1e-3, fine.shape.degree, &kept.grid);
            let plan = EvolutionPlan { most_ahead, ..plan };
            let mut evolution = Evolution::new(plan, &ground, &initial, [&fine, &coarse], 1.0)?;
            evolution.advance(1.0)?;
            Ok((evolution.exhausted, evolution.fields[0].mesh.cells.len(), evolution.unresolved()))
        };
        let (reason, cells, unresolved) = after(MOST_WORK)?;
        assert!(reason.is_none() && unresolved == 0.0);
        let (reason, fewer, unresolved) = after(1.0)?;
        assert!(reason == Some(NO_TIME) && fewer < cells, "{fewer} cells for {cells}");
        // More than what a mesh is refined for.
        assert!(unresolved > SHARE * 1e-3, "{unresolved:e}");
        Ok(())
    }
}

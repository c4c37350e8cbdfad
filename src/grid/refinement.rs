//! From a mesh to the answer: solve, divide the cells that are not resolved, and stop by the solutions of two degrees.

use super::field::{GridField, difference};
use super::mesh::Mesh;
use super::operator::Layout;
use super::shape::{MOST, Place, Shape};
use super::stationary::{Stationary, solve};
use super::wells::Question;
use crate::error::{Error, Result};
use crate::grid::GridProgress;
use crate::grid::{NARROWEST, ROUNDS};
use crate::memory::MemoryLimit;
use crate::numerics::sort_by_number;

/// A cell of one state to three is not divided along a state along which its indicator is below this share of the largest.
const ALONE: [f64; MOST] = [0.1, 0.1, 0.3];
/// A cell is halved twice along a state if its indicator is so many times its share: that is what a halving takes of it at
/// degree 6 to 8.
const TWICE: f64 = 200.0;
/// Cells may be halved twice in one round where less than this, in L¹, is left in the highest degrees of all cells. That saves
/// a solution of five to seven; with 1e-2 narrow cycles and wells take 1.5 to 2 times the cells.
const SETTLED: f64 = 1e-3;
/// After a test by two degrees has failed, the refinement aims at this part of the indicator that would be expected to
/// suffice.
const CAUTION: f64 = 0.5;
/// The smallest factor by which a failed test by two degrees lowers the aim of the refinement.
const LEAST: f64 = 0.02;
/// All solutions on the way to a mesh together have at most so many times the numbers that the memory holds: a bound on work. Where
/// each mesh has twice the cells of the one before, they have three to four times the numbers of the last. A system with dozens of
/// wells that exchange next to nothing finds one of them with each solution.
const SOLUTIONS: f64 = 8.0;
/// In three states cells are divided that leave all but this part of the aim, or of what is left now where that is more: a tenth of
/// the cells has most of it, and a mesh of twice the cells takes three times the work.
const LEFT: f64 = 0.5;
const BULK: f64 = 0.1;
/// In three states the first aim over the accuracy: solutions of two degrees differ by 1.1 to 1.4 of what is in the highest degree.
const FINER: f64 = 0.75;
/// A mesh that a density on its way through time has outgrown is refined for this part of the aim: one that is just fine
/// enough would not be so for long.
const AHEAD: f64 = 0.5;
/// A mesh of so many cells has an indicator below 1, or it resolves nothing: meshes from the pilot's states begin with
/// hundreds of cells and an indicator below 1.
const BEGUN: usize = 5000;

/// Solutions of two degrees on one mesh.
#[derive(Debug)]
pub(super) struct Pair {
    pub(super) fine: Stationary,
    pub(super) coarse: Stationary,
    /// ∫ |p − q| dx of the two.
    pub(super) difference: f64,
    /// Linear systems that were solved on the way.
    pub(super) rounds: usize,
    /// What ended before the accuracy was reached.
    pub(super) exhausted: Option<Exhausted>,
}

/// Why a mesh is not refined further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exhausted {
    /// The memory, or the work that goes with it.
    Memory,
    /// Iterations take too many steps.
    Steps,
}

/// Refines from a mesh on until two degrees agree to `target` in L¹. `report` is called after each solution, and ends the work by
/// an error.
pub(super) fn resolve(
    question: Question<'_>,
    start: Mesh,
    (degree, target): (usize, f64),
    first_pin: Vec<f64>,
    mut report: impl FnMut(GridProgress) -> Result<()>,
) -> Result<Pair> {
    let aim = if start.dimension() > 2 { FINER * target } else { target };
    let (mut layout, mut places) = (Layout::new(start), vec![first_pin]);
    let (mut aim, mut rounds, mut exhausted, mut spent, mut last) = (aim, 0, None, 0.0, [f64::INFINITY; 2]);
    loop {
        rounds += 1;
        spent += layout.numbers(Shape { states: layout.mesh.dimension(), degree });
        let over = spent > SOLUTIONS * question.memory.numbers();
        exhausted = exhausted.or(over.then_some(Exhausted::Memory));
        let mut fine = solve(question, &layout, degree, &places)?;
        // A place that had a pin this time is not missed, whether it has a well or not.
        let missed = fine.missed(question.states).filter(|place| !places.contains(place));
        places = fine.places().into_iter().chain(missed.clone()).collect();
        let unresolved = fine.unresolved();
        let indicator = indicator(&unresolved);
        let progress = GridProgress { rounds, cells: layout.mesh.cells.len(), indicator, ..GridProgress::default() };
        report(progress)?;
        require_begun(progress)?;
        exhausted = exhausted.or(fine.is_slow().then_some(Exhausted::Steps));
        let enough = indicator <= aim || rounds >= ROUNDS || exhausted.is_some();
        if let Some(mesh) = if enough { None } else { refined(&layout.mesh, &unresolved, aim) } {
            let finer = Layout::new(mesh);
            match finer.fits(fine.operator.shape, question.memory) {
                Ok(()) => {
                    layout = finer;
                    continue;
                }
                Err(_) => exhausted = Some(Exhausted::Memory),
            }
        }
        if missed.is_some() && rounds < ROUNDS && !over {
            continue;
        }
        let mut coarse = solve(question, &layout, degree - 1, &fine.wells.places_of_pins())?;
        let rounding = fine.open();
        fine.compare(&mut coarse, question.states);
        let difference = difference(&fine.density.field, &coarse.density.field);
        let estimate = difference + fine.open();
        rounds += 1;
        report(GridProgress { rounds, estimate: Some(estimate), ..progress })?;
        // Of what shares of wells are off by rounding no mesh makes less.
        let stays = fine.wells.pins.len() > 1 && estimate > 0.5 * last[0] && indicator < 0.1 * last[1];
        last = [estimate, indicator];
        let least = estimate <= 2.0 * rounding || stays;
        let done = estimate <= target || least || exhausted.is_some() || rounds >= ROUNDS;
        aim = aim.min(indicator) * (CAUTION * target / estimate).max(LEAST);
        let next = if done { None } else { refined(&layout.mesh, &unresolved, aim) };
        let next = next.map(Layout::new).filter(|finer| finer.fits(fine.operator.shape, question.memory).is_ok());
        let Some(finer) = next else {
            // Neither the accuracy nor what rounding leaves.
            let exhausted = exhausted.or((!(least || estimate <= target)).then_some(Exhausted::Memory));
            return Ok(Pair { fine, coarse, difference, rounds, exhausted });
        };
        layout = finer;
    }
}

/// Refuses a mesh of many cells whose highest degree holds as much as the density itself: refining it leads nowhere.
fn require_begun(GridProgress { cells, indicator, .. }: GridProgress) -> Result<()> {
    let begun = indicator < 1.0 || cells < BEGUN;
    let reason = || {
        format!(
            "{cells} cells resolve nothing: the density is too narrow for its domain, or the drift has no stationary density"
        )
    };
    if begun { Ok(()) } else { Err(Error::NotResolved { estimate: indicator, reason: reason() }) }
}

/// The sum over all cells of what is left in the highest degree along each state.
pub(super) fn indicator(unresolved: &[Place]) -> f64 {
    unresolved.iter().map(|along| along.iter().fold(0.0, |a: f64, b| a.max(*b))).sum()
}

/// What the mesh of a field is to become.
pub(super) enum Finer {
    Enough,
    Layout(Layout),
    /// The memory does not suffice.
    Exhausted,
}

/// The mesh on which less than `aim` is left in the highest degree, or the next one towards it.
pub(super) fn finer(field: &GridField, aim: f64, memory: MemoryLimit) -> Finer {
    let unresolved = field.highest();
    if indicator(&unresolved) <= aim {
        return Finer::Enough;
    }
    match refined(&field.mesh, &unresolved, AHEAD * aim).map(Layout::new) {
        None => Finer::Enough,
        Some(layout) if layout.fits(field.shape, memory).is_ok() => Finer::Layout(layout),
        Some(_) => Finer::Exhausted,
    }
}

/// What a cell may leave so that all cells that leave less leave a part of `aim` together, or of what there is now.
fn threshold(unresolved: &[Place], aim: f64) -> f64 {
    let mut all: Vec<f64> = unresolved.iter().map(|along| along.iter().fold(0.0, |a: f64, b| a.max(*b))).collect();
    sort_by_number(&mut all, |part| *part);
    let left = (LEFT * aim).max(BULK * all.iter().sum::<f64>());
    let mut sum = 0.0;
    let kept = all
        .iter()
        .take_while(|part| {
            sum += **part;
            sum <= left
        })
        .count();
    kept.checked_sub(1).map_or(0.0, |last| all[last])
}

/// The mesh in which cells with more than their share of `aim` are divided, those with far more twice; none if there are none.
pub(super) fn refined(own: &Mesh, unresolved: &[Place], aim: f64) -> Option<Mesh> {
    let mut tree = own.tree.clone();
    let (root, states) = (tree.root(), own.dimension());
    let share = if states > 2 { threshold(unresolved, aim) } else { aim / own.cells.len() as f64 };
    // Before the solution takes shape what is left in the highest degree says where to divide, and not how finely.
    let settled = indicator(unresolved) < SETTLED;
    let mut divided = false;
    for (number, along) in unresolved.iter().enumerate() {
        let largest = along.iter().fold(0.0, |a: f64, b| a.max(*b));
        if largest.is_nan() || largest <= share {
            continue;
        }
        let cell = own.cells[number];
        let wide = |axis: usize| cell.width[axis] > NARROWEST * root.width[axis];
        let marked = |axis: &usize| along[*axis] > share && along[*axis] > ALONE[states - 1] * largest && wide(*axis);
        let mut parts = vec![own.leaf(number)];
        for axis in (0..states).filter(marked) {
            divided = true;
            for _ in 0..if settled && along[axis] > TWICE * share { 2 } else { 1 } {
                parts = parts
                    .into_iter()
                    .flat_map(|leaf| {
                        let first = tree.halve(leaf, axis);
                        [first, first + 1]
                    })
                    .collect();
            }
        }
    }
    divided.then(|| {
        tree.balance();
        Mesh::within(own.origin, tree, own.sides)
    })
}

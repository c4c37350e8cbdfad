//! The closure of a problem by the density of a grid.

use super::Closest;
use super::target::TargetDensity;
use crate::closure::candidates::indicator::Indication;
use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Content;
use crate::closure::density::exact::exact_about;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::discretisation::{locals, nodes};
use crate::closure::method::Closure;
use crate::closure::pilot::Pilot;
use crate::closure::projection::exactness::Exactness;
use crate::closure::projection::tempered;
use crate::closure::{GRID_MEMORY, HIGHEST_ORDER, HIGHEST_ORDER_AT_WALLS, REFERENCE_EXCESS};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::grid::{Grid, GridDensity};
use crate::numerics::weighted_sum;
use crate::problem::Problem;
use crate::provenance::Provenance;
use faer::Mat;
use std::time::Instant;

/// The accuracies, in L¹, of the grids that stand for a reference, each where that before is too coarse; and in three states.
const ACCURACIES: [f64; 3] = [1e-3, 1e-5, 1e-7];
const IN_SPACE: [f64; 2] = [1e-2, 1e-3];
/// A finer grid stands for the reference where the error of that before is above this share of the estimated L¹ distance.
const MINOR: f64 = 0.1;
/// In two states the moment equations' answer is taken where its estimate is below this share of that by a grid. None of nine
/// closures depends on the value.
const BETTER: f64 = 0.5;

impl Closure {
    /// The closest to the density of a grid, which in one state is a closed form; an exact one where the states of a pilot show it, which
    /// next to walls they do not.
    ///
    /// # Errors
    /// Those of the grid; [`Error::NotClosed`] where no polynomial is found.
    pub(in crate::closure) fn by_grid(
        &self,
        problem: &Problem,
        pilot: Option<&Pilot>,
        begin: Instant,
    ) -> Result<ClosureDensity> {
        let mut found = None;
        let accuracies = if problem.dimension() > 2 { &IN_SPACE[..] } else { &ACCURACIES };
        for &accuracy in accuracies {
            // A grid that the memory ends has what it reached as its estimate.
            let grid = Grid::new()
                .accuracy(accuracy)
                .within(self.memory.at_most(GRID_MEMORY[problem.dimension() - 1]))
                .solve(problem);
            let grid = match grid {
                Ok(grid) => grid,
                Err(error) => return found.unwrap_or(Err(error)),
            };
            // A mesh that is too coarse for the shares of wells may have no answer where a finer one has.
            match self.next_to_grid(&grid, problem, pilot, begin) {
                Ok((closed, limited)) if !limited || grid.l1_estimate() > accuracy => return Ok(closed),
                Ok((closed, _)) => found = Some(Ok(closed)),
                Err(error) => found = found.or(Some(Err(error))),
            }
        }
        let reason = "no polynomial is near the density of a grid; take the grid";
        found.unwrap_or(Err(Error::NotClosed { order: self.lowest(), reason }))
    }

    /// The closest to the density of this grid, and whether the grid's own error limits it.
    fn next_to_grid(
        &self,
        grid: &GridDensity,
        problem: &Problem,
        pilot: Option<&Pilot>,
        begin: Instant,
    ) -> Result<(ClosureDensity, bool)> {
        let symmetry = problem.symmetry();
        let mut closest = Closest::new(grid, self, &symmetry)?;
        let free = problem.walls().is_empty();
        let highest = if free { HIGHEST_ORDER } else { HIGHEST_ORDER_AT_WALLS };
        let closed = self.at_order(highest, false, |order| {
            let mut content = closest.content(order, begin)?;
            // Impacts, and forces that jump, have a part in the equations that the residual in between does not show.
            content.indication = if free && problem.surfaces().is_empty() {
                closest.indication(problem, &content.exponent, order)
            } else {
                None
            };
            if problem.dimension() == 1 {
                content.provenance.reference = Some(String::from("closed form"));
            }
            Ok(ClosureDensity::new(content))
        })?;
        let pilot = pilot.filter(|_| problem.operator().is_polynomial());
        if let Some(exact) = pilot.and_then(|pilot| exact(&closed, problem, pilot)) {
            return Ok((exact, false));
        }
        let limited = closest.target.error > MINOR * closed.l1_estimate();
        Ok((closed, limited && problem.dimension() > 1))
    }
}

/// The exact density next to the closest one, where there is one.
fn exact(closest: &ClosureDensity, problem: &Problem, pilot: &Pilot) -> Option<ClosureDensity> {
    let start = &closest.content.exponent;
    let exponent = Exactness::new(problem, &pilot.states, start.space.len())?.near(start)?;
    let symmetry = problem.symmetry();
    let (centre, _) = pilot.spread(&symmetry);
    let region = TrustDomain::new(pilot, &symmetry, centre, [None, None], 1.0);
    let provenance = Provenance { nodes: None, reference: None, ..closest.provenance().clone() };
    Some(ClosureDensity::new(Content { provenance, ..exact_about(exponent, &region)? }))
}

impl ClosureDensity {
    /// Whether it is by far the better answer than the density of moment equations.
    pub(in crate::closure) fn is_better_than(&self, by_equations: &Self) -> bool {
        self.l1_estimate() < BETTER * by_equations.l1_estimate()
    }

    /// Whether the density of moment equations is the better answer: in two states, and by far, since a grid's estimate is the better
    /// one.
    pub(in crate::closure) fn is_worse_than(&self, by_equations: &Self) -> bool {
        let better = by_equations.l1_estimate() < BETTER * self.l1_estimate();
        self.dimension() > 1 && by_equations.content.candidates[0].accepted && better
    }
}

impl Closest<'_> {
    /// How large the residual of a density is, tested as on other nodes. None where the test functions are linearly dependent.
    fn indication(&self, problem: &Problem, exponent: &Exponent, order: u32) -> Option<Indication> {
        let TargetDensity { points, weights, .. } = &self.target;
        let locals = locals(problem, points);
        let excess = REFERENCE_EXCESS[problem.dimension() - 1] - 2;
        let values = nodes::values(&self.families[0].functions(order + excess), points);
        let measure = tempered(&exponent.values(points), weights, 1.0);
        let residuals = exponent.residuals(points, |i| &locals[i]);
        let weighted: Vec<f64> = measure.iter().zip(&residuals).map(|(w, r)| w * r).collect();
        let tested = weighted_sum(values.as_ref(), &weighted);
        let tested = Mat::from_fn(tested.len(), 1, |k, _| tested[k]);
        Indication::of((values.as_ref(), &measure), tested, (exponent.space.len() + 1, order))
    }
}

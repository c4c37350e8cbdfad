use super::Dynamics;
use super::moment_system::{MomentSystem, modes};
use super::start::Weighted;
use crate::checks::require;
use crate::closure::discretisation::locals;
use crate::closure::discretisation::nodes::{self, NodalGenerator, Nodes, Table};
use crate::closure::space::Functions;
use crate::closure::space::nested_spaces::Smooth;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::tuning;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::numerics::{Rule, combination, propagated, weighted_product};
use crate::states::States;
use faer::prelude::*;
use faer::{Mat, MatRef, Scale};
use rayon::prelude::*;
use std::fmt;

/// The degrees that answers are given of, the highest first.
const DEGREES: usize = 3;

const NOT_CLOSED: Error = Error::NotClosed {
    order: tuning::dynamics::SURVIVAL_DEGREES[0],
    reason: "the moment equations between the levels have a growing mode: take the grid",
};

/// The moment equations of the part of a density that has passed no level of the displacement.
///
/// Trajectories leave through a level at the velocity with which they reach it, and none comes in: under the weight ω between
/// the levels the means of p = ω Σ d_l ψ_l change by A_kl = ∫ ω ψ_l Gψ_k dx − ∮ ω |v| ψ_l ψ_k dv, the second over outward
/// velocities at each level. The constant's row is the loss of mass.
#[derive(Clone)]
pub(super) struct Absorbed {
    pub(super) nodes: Nodes,
    space: Functions,
    functions: Orthonormal,
    /// The stationary masses at the nodes by the equations of two degrees.
    stationary: [Vec<f64>; 2],
    matrix: Mat<f64>,
    /// The columns of each degree.
    columns: [usize; DEGREES],
    /// The rate of the slowest mode.
    pub(super) rate: Estimate,
}

impl fmt::Debug for Absorbed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Absorbed { columns, rate, .. } = self;
        f.debug_struct("Absorbed").field("columns", columns).field("rate", rate).finish_non_exhaustive()
    }
}

impl Absorbed {
    /// # Errors
    /// [`Error::OutOfRange`] where the stationary density has hardly any mass between the levels, [`Error::NotClosed`] where a
    /// mode grows.
    pub(super) fn new(dynamics: &Dynamics, system: &MomentSystem, within: [f64; 2]) -> Result<Self> {
        let Dynamics { problem, domain, .. } = dynamics;
        let mut bounds = domain.bounds();
        bounds[0] = [bounds[0][0].max(within[0]), bounds[0][1].min(within[1])];
        let rule = Rule::legendre(tuning::nodes::FINE[1]);
        let nodes = Nodes::tensor(domain, bounds.iter().map(|[low, high]| rule.on(*low, *high)).collect());
        let densities = |points: &States, weights: &[f64]| -> Vec<f64> {
            let logs = system.weight.values(points);
            logs.iter().zip(weights).map(|(log, weight)| log.exp() * weight).collect()
        };
        let masses = densities(&nodes.points, &nodes.weights);
        let whole: f64 = masses.iter().sum();
        let remedy = "the levels leave the density no room: it lies beyond them";
        require(whole > tuning::dynamics::LEAST_ROOM, "probability between the levels", whole, remedy)?;
        let relative = |masses: &[f64]| -> Vec<f64> { masses.iter().map(|mass| mass / whole).collect() };
        let (centre, half_width) = bounds.iter().map(|[low, high]| ((low + high) / 2.0, (high - low) / 2.0)).unzip();
        let smooth = Smooth::complete(centre, half_width);
        let space = smooth.functions(tuning::dynamics::SURVIVAL_DEGREES[0]);
        let (impulses, locals) = (&problem.operator().impulse_terms(), locals(problem, &nodes.points));
        let generator = NodalGenerator { points: &nodes.points, locals: &locals, passages: &[], impulses, domain };
        let measure = relative(&masses);
        let Table { functions, rates, .. } = Table::new(generator, &space, &measure).ok_or(NOT_CLOSED)?;
        let mut matrix = weighted_product(rates.as_ref(), functions.values.as_ref(), &measure);

        let (mut outward, mut speeds, mut beyond) = (States::new(2), Vec::new(), 0.0);
        for (side, level) in within.into_iter().enumerate().filter(|(_, level)| level.is_finite()) {
            let [low, high] = bounds[1];
            let half = if side == 0 { rule.on(low.min(0.0), 0.0) } else { rule.on(0.0, high.max(0.0)) };
            for (v, weight) in half.iter() {
                let end = [level, v];
                if domain.contains(&end) {
                    outward.push(&end);
                    speeds.push(weight * v.abs());
                } else {
                    beyond += weight * v.abs() * domain.continued(&end, |x| system.weight.value(x)).exp();
                }
            }
        }
        let mut inward = States::new(2);
        outward.iter().for_each(|end| inward.push(&[end[0], -end[1]]));
        let at = |ends: &States| {
            let mut values = nodes::values(&space, ends);
            functions.transform(values.as_mut());
            (densities(ends, &speeds), values)
        };
        let (fluxes, values) = at(&outward);
        matrix -= weighted_product(values.as_ref(), values.as_ref(), &relative(&fluxes));

        let (columns, rates) = stable(&matrix, &smooth).ok_or(NOT_CLOSED)?;
        let matrix = matrix.get(..columns[0], ..columns[0]).to_owned();
        let (in_fluxes, values) = at(&inward);
        let [mass, power] =
            inflow(slowest(matrix.as_ref(), rates[0]), values.get(.., ..columns[0]), &relative(&in_fluxes));

        let d = [system.stationary(false), system.stationary(true)];
        let ratios = |points: &States| system.ratios_at(points, d.each_ref().map(Vec::as_slice));
        let times =
            |masses: &[f64], ratio: Vec<f64>| masses.iter().zip(ratio).map(|(mass, ratio)| mass * ratio).collect();
        let stationary: [Vec<f64>; 2] = ratios(&nodes.points).map(|ratio| times(&masses, ratio));
        let [own, below] = ratios(&outward).map(|ratio| times(&fluxes, ratio).iter().sum::<f64>());
        let plain: f64 = fluxes.iter().sum();
        // How little is known of the stationary density at the levels.
        let doubt = (own - below).abs().max((own - plain).abs()) + beyond;
        let apart = compared(rates).error.max(tuning::dynamics::INFLOW * power);
        let rate = Estimate::new(rates[0], apart + mass + doubt);
        Ok(Absorbed { nodes, space, functions, stationary, matrix, columns, rate })
    }
}

/// The columns of the highest degrees without a growing mode, and the rates of the slowest mode of each.
fn stable(matrix: &Mat<f64>, smooth: &Smooth) -> Option<([usize; DEGREES], [f64; DEGREES])> {
    let of = |degree: &u32| {
        let columns = smooth.functions(*degree).len() + 1;
        // The slowest one may be so slow that its rate is rounding.
        let modes = modes(matrix.get(..columns, ..columns), 1)?;
        Some((columns, modes.iter().map(|mode| mode[0]).fold(f64::INFINITY, f64::min).max(0.0)))
    };
    let all: Vec<Option<(usize, f64)>> = tuning::dynamics::SURVIVAL_DEGREES.par_iter().map(of).collect();
    all.windows(DEGREES).find_map(|row| {
        let row: Vec<(usize, f64)> = row.iter().copied().collect::<Option<_>>()?;
        Some((std::array::from_fn(|k| row[k].0), std::array::from_fn(|k| row[k].1)))
    })
}

/// The coefficients of the mode of a rate.
fn slowest(matrix: MatRef<'_, f64>, rate: f64) -> Vec<f64> {
    // Inverse iteration next to the eigenvalue, so near that every step gains many digits.
    let near = rate - tuning::dynamics::NEXT_TO * matrix.norm_max();
    let shifted = Mat::from_fn(matrix.nrows(), matrix.ncols(), |k, l| matrix[(k, l)] + if k == l { near } else { 0.0 });
    let factors = shifted.partial_piv_lu();
    let mut mode = Mat::from_fn(matrix.ncols(), 1, |k, _| if k == 0 { 1.0 } else { 0.0 });
    for _ in 0..tuning::dynamics::MODE_STEPS {
        mode = factors.solve(&mode);
        let norm = mode.norm_l2();
        mode *= Scale(1.0 / norm);
    }
    mode.col_as_slice(0).to_vec()
}

/// What a mode q = Σ d_l ψ_l, of ∫ ω q² = 1, has on the inward velocities at the levels, where it should vanish: the mass that
/// comes in per unit time, ∮ ω |v| q dv / ∫ ω q, and the part of its rate that is lost there, ½ ∮ ω |v| q² dv.
fn inflow(d: Vec<f64>, values: MatRef<'_, f64>, fluxes: &[f64]) -> [f64; 2] {
    let q = combination(values, &d);
    let sum = |of: fn(f64) -> f64| fluxes.iter().zip(&q).map(|(flux, q)| flux * of(*q)).sum::<f64>();
    [(sum(|q| q) / d[0]).abs(), sum(|q| q * q / 2.0)]
}

/// The answer of the highest degree, with an error by its distances from those of the others.
pub(super) fn compared(answers: [f64; DEGREES]) -> Estimate {
    let apart = answers.iter().map(|other| (answers[0] - other).abs()).fold(0.0, f64::max);
    Estimate::new(answers[0], tuning::dynamics::GRAZED * apart)
}

impl Absorbed {
    /// The means of ψ under the part of the stationary density between the levels, for each degree: under the best that is known
    /// of it for the highest, and under the next best one for the others.
    pub(super) fn stationary(&self) -> [Vec<f64>; DEGREES] {
        let [own, below] = self.stationary.each_ref().map(|masses| {
            let (points, masses) = (self.nodes.points.clone(), masses.clone());
            self.means(&Weighted { points, masses, error: 0.0 })
        });
        [own, below.clone(), below]
    }

    /// The functions of the highest degree.
    pub(super) fn unknowns(&self) -> usize {
        self.columns[0]
    }

    /// The means of ψ under a start.
    pub(super) fn means(&self, start: &Weighted) -> Vec<f64> {
        start.means(&self.space, &self.functions)
    }

    /// The masses that are left at some times, by each degree.
    pub(super) fn remaining(&self, start: &[Vec<f64>; DEGREES], times: &[f64]) -> Vec<[f64; DEGREES]> {
        let of = |k: &usize| propagated(self.of(*k), &start[*k][..self.columns[*k]], times);
        let d: Vec<Mat<f64>> = (0..DEGREES).collect::<Vec<_>>().par_iter().map(of).collect();
        (0..times.len()).map(|time| std::array::from_fn(|k| d[k][(0, time)])).collect()
    }

    /// The integrals over all times of the masses that are left, by each degree.
    pub(super) fn integrals(&self, start: &[Vec<f64>; DEGREES]) -> [f64; DEGREES] {
        std::array::from_fn(|k| {
            let begin = Mat::from_fn(self.columns[k], 1, |l, _| start[k][l]);
            -self.of(k).partial_piv_lu().solve(begin)[(0, 0)]
        })
    }

    fn of(&self, degree: usize) -> MatRef<'_, f64> {
        let columns = self.columns[degree];
        self.matrix.get(..columns, ..columns)
    }
}

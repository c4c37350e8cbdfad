//! Exact densities, found at the states of a pilot alone.
//!
//! The residual of exp(Q) is a polynomial where the system is one. If it vanishes at more states than it has monomials, it vanishes
//! everywhere, and an exp(Q) that satisfies the stationary equation and has a finite integral is the stationary density; above elastic
//! walls where it has the same value before impacts and after them. Neither nodes nor integrals come in, so that narrow wells and thin
//! ridges are no obstacle. With functions of states in the drift and in Q it is no polynomial, but as smooth as these, and vanishes at
//! thousands of states to the rounding of their tables.

use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::{locals, nodes};
use crate::closure::pilot::normal_density;
use crate::closure::space::sweep;
use crate::closure::{CONVERGING, EXACT_STEPS, ROUNDING, SOLVED};
use crate::fokker_planck::Local;
use crate::functions::Functions;
use crate::numerics::{combination, least_norm, triangle};
use crate::polynomial::{Gaussian, monomials};
use crate::problem::Problem;
use crate::states::States;
use crate::walls::Contact;
use faer::{Col, Mat};
use nalgebra::DVector;
use std::cell::OnceCell;

/// The fewest states at which the residual of an exact density is to vanish, and those by which its root is first guessed: bounds on
/// work, as three times as many give the same.
const AT_STATES: [usize; 2] = [4000, 20_000];
/// The states for each function: with 11 no root is found for wells beside seven linear states, and with 16 one is.
const EACH: usize = 30;
/// The most states times functions: a bound on memory, of 130 MB a table.
const MOST_VALUES: usize = 16_000_000;
/// The states at which impacts on a wall are to leave an exact density as it is.
const AT_WALL: usize = 1000;
/// The most functions of an exact density that is sought at states of the pilot: a bound on work.
const MOST: usize = 150;

/// The distances from the middle of the pilot's states at which the residual is to vanish too, over theirs. A normal density is exp(-32) of
/// its peak there.
const FARTHER: f64 = 1.9;
/// The residual vanishes there where it is no larger a part of what it is made of: tables of functions are right to 1e-9 of it.
const HOLDS: f64 = 1e-6;

/// The search for the exact density of a problem.
pub(in crate::closure) struct Exactness<'a> {
    problem: &'a Problem,
    /// All states of the pilot.
    pilot: &'a States,
    /// The most functions of the densities that are sought.
    functions: usize,
    /// Whether it is for integrals to show that exp(Q) falls, and not for the highest powers of a polynomial.
    by_integrals: bool,
    /// Made for the first candidate.
    conditions: OnceCell<Conditions>,
}

impl<'a> Exactness<'a> {
    /// The search among densities of so many functions at most. None where none may be exact: impulses are an integral in the equation,
    /// and impacts that take energy make a singularity.
    pub(in crate::closure) fn new(problem: &'a Problem, pilot: &'a States, functions: usize) -> Option<Self> {
        let elastic = problem.walls().iter().all(|wall| wall.restitution() == 1.0);
        let served = problem.impulses().is_empty() && elastic;
        served.then_some(Exactness { problem, pilot, functions, by_integrals: false, conditions: OnceCell::new() })
    }

    /// The same for densities of which integrals show that they fall.
    pub(in crate::closure) fn falling_by_integrals(self) -> Self {
        Exactness { by_integrals: true, ..self }
    }

    /// The orders at which a density of an order may be exact, the lowest first: equations of a higher one are all but singular at it.
    pub(in crate::closure) fn orders(order: u32) -> impl Iterator<Item = u32> {
        (2..order).step_by(2).chain([order])
    }

    /// The exact density of the lowest order up to one at which there is one, in the functions of that order; its constant is 0.
    pub(in crate::closure) fn lowest(&self, order: u32, functions: impl Fn(u32) -> Functions) -> Option<Exponent> {
        let mut spaces = Self::orders(order).filter(|order| *order > 1).map(functions);
        if let Some(normal) = normal_density(self.problem) {
            return spaces.find_map(|space| quadratic(&space, &normal));
        }
        let more = self.pilot.evenly(AT_STATES[1]);
        spaces.find_map(|space| {
            if space.len() > MOST || self.conditions().are_too_few(&space) {
                return None;
            }
            let start = by_scores(&space, &self.problem.contacts(), &more)?;
            self.root(Exponent { known: Vec::new(), space, constant: 0.0, coefficients: start })
        })
    }

    /// The exact density near another one.
    pub(in crate::closure) fn near(&self, start: &Exponent) -> Option<Exponent> {
        let sought = start.known.is_empty() && !self.conditions().are_too_few(&start.space);
        sought.then(|| self.root(start.clone()))?
    }

    /// The root near a start that satisfies the equation everywhere, and falls.
    fn root(&self, start: Exponent) -> Option<Exponent> {
        let conditions = self.conditions();
        // Between walls a polynomial need not fall in every direction.
        let falls = |found: &Exponent| self.by_integrals || conditions.walled || found.is_normalisable();
        conditions.root(start).filter(|found| falls(found) && self.holds_farther(found))
    }

    /// Whether the residual vanishes farther out than the pilot's states as well, to a part of what it is made of there and at these.
    /// Functions of the states may have a kink where no state has been. Where a table ends the density is negligible.
    fn holds_farther(&self, density: &Exponent) -> bool {
        if self.problem.operator().is_polynomial() {
            return true;
        }
        let own = self.conditions();
        let [low, high] = own.states.range();
        let folds = density.space.folds();
        let covers =
            |x: &[f64]| folds.iter().all(|fold| fold.curve.as_ref().is_none_or(|own| own.covers(x[fold.state])));
        let mut farther = States::new(low.len());
        for x in &own.states {
            let from = |i: usize| (low[i] + high[i]) / 2.0;
            let x: Vec<f64> = (0..x.len()).map(|i| from(i) + FARTHER * (x[i] - from(i))).collect();
            if covers(&x) {
                farther.push(&x);
            }
        }
        let parts = |(_, parts, _): &(f64, f64, Vec<f64>)| *parts;
        let usual = own.linearised(density).iter().map(parts).sum::<f64>() / own.states.len() as f64;
        let farther = Conditions::new(self.problem, farther).linearised(density);
        farther.iter().all(|(residual, parts, _)| residual * residual <= HOLDS * HOLDS * (parts + usual))
    }

    fn conditions(&self) -> &Conditions {
        self.conditions.get_or_init(|| {
            let most = (MOST_VALUES / self.functions.max(1)).max(AT_STATES[0]);
            let states = self.pilot.evenly((EACH * self.functions).clamp(AT_STATES[0], most));
            Conditions::new(self.problem, states)
        })
    }
}

/// What an exact density satisfies: its residual vanishes at states, and impacts, which are elastic, leave it as it is.
struct Conditions {
    walled: bool,
    states: States,
    locals: Vec<Local>,
    /// States before impacts, and after them.
    impacts: [States; 2],
}

impl Conditions {
    fn new(problem: &Problem, states: States) -> Self {
        let [mut before, mut after] = [(); 2].map(|()| States::new(problem.dimension()));
        for contact in problem.contacts() {
            for x in &states.evenly(AT_WALL) {
                let mut x = x.to_vec();
                contact.close(&mut x);
                before.push(&x);
                contact.collide(1.0, &mut x);
                after.push(&x);
            }
        }
        let (walled, locals) = (!before.is_empty(), locals(problem, &states));
        Conditions { walled, states, locals, impacts: [before, after] }
    }

    fn are_too_few(&self, space: &Functions) -> bool {
        self.states.len() < 2 * space.len()
    }

    /// What the functions change by at impacts, after the constant.
    fn jumps(&self, space: &Functions) -> Mat<f64> {
        let [before, after] = self.impacts.each_ref().map(|points| nodes::values(space, points));
        (after - before).get(.., 1..).to_owned()
    }

    /// The root of the residual at the states and of the jumps of Q, by steps of Gauss and Newton. None where they do not come to one.
    fn root(&self, start: Exponent) -> Option<Exponent> {
        let (count, size, jumps) = (self.states.len(), start.space.len(), self.jumps(&start.space));
        let impacts = jumps.nrows();
        let share = |all: usize| (all.max(1) as f64).recip();
        let measure = [vec![share(count); count], vec![share(impacts); impacts]].concat();
        let (mut current, [mut before, mut last]) = (start, [f64::INFINITY; 2]);
        for _ in 0..EXACT_STEPS {
            let linearised = self.linearised(&current);
            let missed = combination(jumps.as_ref(), &current.coefficients);
            let [square, parts] =
                linearised.iter().fold([0.0; 2], |[square, parts], (r, part, _)| [square + r * r, parts + part]);
            // A jump of ln p counts as a residual of the size of its parts does.
            let unit = (parts * share(count)).sqrt();
            let apart = missed.iter().map(|jump| jump * jump).sum::<f64>() * share(impacts);
            let own = (square / parts.max(f64::MIN_POSITIVE) + apart).sqrt();
            let solved = own < SOLVED;
            // A step converges, or two of them do: from the start the first may lead away, and of many functions the second may be slow. The
            // negation also excludes NaN.
            if !(solved || own < CONVERGING * last || own < CONVERGING.powi(2) * before) {
                return None;
            }
            (before, last) = (last, own);
            let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(count, size + 1));
            let local = |i: usize| (&linearised[i].2[..], &self.locals[i].diffusion[..]);
            sweep::tabulate_rates(&current.space, &self.states, &local, [values.as_mut(), rates.as_mut()]);
            let scale: Vec<f64> = (1..=size).map(|k| rates.col(k).norm_l2().max(f64::MIN_POSITIVE).recip()).collect();
            // The residual stands in the last column.
            let system = Mat::from_fn(count + impacts, size + 1, |i, k| match (i.checked_sub(count), k < size) {
                (None, true) => rates[(i, k + 1)] * scale[k],
                (None, false) => linearised[i].0,
                (Some(i), true) => unit * jumps[(i, k)] * scale[k],
                (Some(i), false) => unit * missed[i],
            });
            let r = triangle(system.as_ref(), &measure);
            let right = Col::from_fn(size, |k| -r[(k, size)]);
            let matrix = r.get(..size, ..size).to_owned();
            let change = least_norm(&matrix, &right, ROUNDING * matrix.norm_l2())?;
            current.coefficients.iter_mut().enumerate().for_each(|(k, a)| *a += scale[k] * change[k]);
            if solved {
                return Some(current);
            }
        }
        None
    }

    /// The residual at each state, the squares of its parts by the drift, and the drift of its linearisation.
    fn linearised(&self, current: &Exponent) -> Vec<(f64, f64, Vec<f64>)> {
        current.linearised(
            &self.states,
            |i| &self.locals[i],
            |i, residual, gradient| {
                let local = &self.locals[i];
                let mut reversed = vec![0.0; gradient.len()];
                local.reversed(gradient, &mut reversed);
                let parts: f64 = local.drift.iter().zip(gradient).map(|(f, slope)| (f * slope).powi(2)).sum();
                (residual, parts, reversed)
            },
        )
    }
}

/// ln p of a normal density, up to a constant. None where the covariance has no inverse, or a monomial is not among the functions.
///
/// The residual of a system whose rates are far apart is that of the fastest, and does not show what the slowest states do.
pub(in crate::closure) fn quadratic(space: &Functions, Gaussian { mean, covariance }: &Gaussian) -> Option<Exponent> {
    let polynomials = space.polynomials()?;
    let precision = covariance.clone().cholesky()?.inverse();
    let half_width = polynomials.half_width();
    let from_mean = DVector::from_fn(mean.len(), |i, _| polynomials.centre()[i] - mean[i]);
    let slope = &precision * from_mean;
    let coefficient = |alpha: &Vec<u32>| {
        let states: Vec<usize> = alpha.iter().enumerate().flat_map(|(i, n)| vec![i; *n as usize]).collect();
        match states[..] {
            [i] => -half_width[i] * slope[i],
            // t² is two thirds of the second Legendre polynomial, and a constant.
            [i, j] if i == j => -precision[(i, i)] * half_width[i].powi(2) / 3.0,
            [i, j] => -precision[(i, j)] * half_width[i] * half_width[j],
            _ => 0.0,
        }
    };
    let listed = |alpha: &Vec<u32>| polynomials.exponents().contains(alpha);
    let all = monomials(mean.len(), 2);
    let missing = all.iter().filter(|alpha| !listed(alpha)).map(coefficient);
    if missing.fold(0.0, |most: f64, c| most.max(c.abs())) > SOLVED {
        return None;
    }
    let coefficients = polynomials.exponents().iter().map(coefficient).collect();
    Some(Exponent { known: Vec::new(), space: space.clone(), constant: 0.0, coefficients })
}

/// The coefficients that make E[½ |s∇Q|² + s²·∇∇Q] least, s the states' standard deviations: those of the density itself where it is
/// exp(Q) (Aapo Hyvärinen, 2005, Journal of Machine Learning Research 6, 695-709). The equations are linear, and no integral of exp(Q)
/// is in them. The part of a displacement that has walls has a factor g, the product of its gaps, so that nothing is left at the walls
/// of the integration by parts: E[½ g (s ∂Q)² + s² ∂(g ∂Q)] (the same, 2007, doi:10.1016/j.csda.2006.09.003).
fn by_scores(space: &Functions, contacts: &[Contact], states: &States) -> Option<Vec<f64>> {
    let (count, size, n) = (states.len(), space.len(), states.dimension());
    let deviations = states.deviations();
    let mut slopes = Mat::zeros(count * n, size);
    let mut bends = Col::<f64>::zeros(size);
    for (state, s) in deviations.iter().enumerate() {
        let own: Vec<&Contact> = contacts.iter().filter(|contact| contact.gap_slope(state) != 0.0).collect();
        let gaps: Vec<[f64; 2]> = states.iter().map(|x| gap_product(&own, x, state)).collect();
        let [mut first, mut second] = [(); 2].map(|()| [vec![0.0; count * n], vec![0.0; count * n * n]]);
        for (i, [gap, slope]) in gaps.iter().enumerate() {
            first[0][i * n + state] = gap.max(0.0).sqrt() * s;
            second[0][i * n + state] = slope * s * s;
            second[1][(i * n + state) * n + state] = 2.0 * gap * s * s;
        }
        let rates = |[drift, diffusion]: [Vec<f64>; 2]| {
            let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(count, size + 1));
            let local = |i: usize| (&drift[i * n..(i + 1) * n], &diffusion[i * n * n..(i + 1) * n * n]);
            sweep::tabulate_rates(space, states, &local, [values.as_mut(), rates.as_mut()]);
            rates
        };
        slopes.get_mut(state * count..(state + 1) * count, ..).copy_from(rates(first).get(.., 1..));
        let second = rates(second);
        (0..size).for_each(|k| bends[k] += second.col(k + 1).sum() / count as f64);
    }
    let r = triangle(slopes.as_ref(), &vec![(count as f64).recip(); count * n]);
    let svd = r.thin_svd().ok()?;
    let (sizes, along) = (svd.S(), svd.V().transpose() * bends);
    let cut = SOLVED * sizes[0];
    let parts = Col::from_fn(size, |k| if sizes[k] > cut { -along[k] / (sizes[k] * sizes[k]) } else { 0.0 });
    let a = svd.V() * parts;
    Some((0..size).map(|k| a[k]).collect())
}

/// The product of some gaps and its slope in a state; 1 and 0 without any.
fn gap_product(contacts: &[&Contact], x: &[f64], state: usize) -> [f64; 2] {
    contacts.iter().fold([1.0, 0.0], |[product, slope], contact| {
        let gap = contact.gap(x);
        [product * gap, slope * gap + product * contact.gap_slope(state)]
    })
}

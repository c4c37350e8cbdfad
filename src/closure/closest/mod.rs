//! The exponential polynomial closest to a density that is known: that of a grid where the moment equations have no solution, or any
//! other.
//!
//! - `target`: the density on cells that resolve it;
//! - `by_grid`: the closure of a problem by the density of a grid.
//!
//! exp(Q) is closest in the Kullback-Leibler distance, in which it has the moments of the density up to its order. Its estimate is
//! ∫ |exp(Q) − p| dx, with the error of p and what lies beyond the cells.

mod by_grid;
mod target;

use super::candidates::{Candidate, Fitted, Origin, chosen};
use super::density::ClosureDensity;
use super::density::content::{Content, Integrals};
use super::density::exponent::{Exponent, known_values};
use super::density::moment::Moment;
use super::discretisation::nodes;
use super::discretisation::trust_domain::TrustDomain;
use super::method::Closure;
use super::projection::{mixed, project, tempered};
use super::reference::{normalised, scaled_mass};
use super::space::folded;
use super::space::nested_spaces::{Smooth, SpaceFamily, Walled};
use super::space::orthonormal::Orthonormal;
use crate::closure::{HIGHEST_ORDER, HIGHEST_ORDER_AT_WALLS, LOWEST_COMPARED};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::functions::{Corner, Functions};
use crate::parallel;
use crate::problem::Symmetry;
use crate::provenance::Provenance;
use crate::states::States;
use std::collections::BTreeMap;
use std::time::Instant;
use target::TargetDensity;

/// Gauss nodes along each side of a cell. 6 give the same distances to a hundredth for twice the nodes.
const ALONG: usize = 4;
/// The density is followed down to this share of its peak: 1e-4 leaves 1e-3 of a heavy tail's mass out, with 1e-8 the tail decides.
const LEVEL: f64 = 1e-6;
/// The tail of a density is what is below this share of its peak.
const TAIL: f64 = 1e-3;
/// The share of the mass above which a tail is heavy. A normal density of two states has 1e-3 in its tail, one of one state a fifth
/// of that.
const HEAVY: f64 = 0.002;
/// The L¹ distance of the closest polynomial above which none is sought without the tail: what is farther off is so in the middle
/// too.
const FAR: f64 = 0.5;
/// Gauss nodes along each side of a cell in the finer rule by which integrals of exp(Q) are checked.
const FINER: usize = 6;
/// Cells are divided while two rules for the mass of exp(Q) differ by more than this share of the distance that is found, with the
/// density's own error.
const APART: f64 = 1e-2;
/// The most rounds of division of the cells on which two rules for the mass of exp(Q) differ.
const ROUNDS: usize = 5;

const METHOD: &str = "closure";

impl Closure {
    /// The exponential polynomial of the order that is closest to a density of one state to three, such as a grid's, also one in time, or
    /// a simulation's: the best that the order can do, with its distance as the estimate, in which a simulation's noise is. Of all even
    /// orders up to the one given it is the closest one; an adaptive closure takes the lowest that meets its target. Next to the walls of
    /// an oscillator on a grid or of a closure, ln p has what [`Closure::solve`] gives it there, up to order 10.
    ///
    /// It is closest in the Kullback-Leibler distance where the density is above a millionth of its peak, so that its moments up to
    /// the order are those of the density; [`Closure::weight`] may give the tails more. A heavy tail decides that distance, and what is
    /// closest in it is far off in L¹: where more than a five-hundredth of the mass lies below a thousandth of the peak, it is sought
    /// above that level too, and the nearer one in L¹ is the answer, with what is left out in the estimate. The moments in the answer,
    /// up to the order, are the density's own, with their errors.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] and [`Error::Dimension`] as in [`Closure::solve`]; [`Error::NotServed`] for four states and more;
    /// [`Error::NotClosed`] where no polynomial is found; the errors of the density's values.
    ///
    /// ```
    /// use expoly::{Closure, Density, Grid, Problem};
    /// // A limit cycle, x″ − (1 − x²) x′ + x = ξ, D = 1: quartics are off by a fifth, and order 8 by 4 %.
    /// let text = "states = ['x', 'v']\ndrift = { x = 'v', v = '(1 - x^2)*v - x' }\nnoise.w.v = 'sqrt(2)'";
    /// let exact = Grid::new().accuracy(1e-4).solve(&Problem::from_toml(text)?)?;
    /// let distance = |order| Ok::<_, expoly::Error>(Closure::new(order).fit(&exact)?.l1_estimate());
    /// assert!((distance(4)? - 0.18).abs() < 0.02 && (distance(8)? - 0.041).abs() < 0.004);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn fit(&self, density: &dyn Density) -> Result<ClosureDensity> {
        let begin = Instant::now();
        let states = density.dimension();
        let walled = !density.evidence().grazed_walls().is_empty();
        let highest = if walled { HIGHEST_ORDER_AT_WALLS } else { HIGHEST_ORDER };
        self.check(states, highest)?;
        if walled {
            self.require_complete_degrees()?;
        }
        if states > 3 {
            let (what, remedy) = ("a density of four states and more to be close to", "solve the problem");
            return Err(Error::NotServed { method: METHOD, what, remedy });
        }
        let symmetry = Symmetry::none(states);
        let mut closest = Closest::new(density, self, &symmetry)?;
        self.at_order(highest, false, |order| Ok(ClosureDensity::new(closest.content(order, begin)?)))
    }
}

/// A density, and how exponential polynomials close to it are sought.
pub(super) struct Closest<'a> {
    density: &'a dyn Density,
    closure: &'a Closure,
    symmetry: &'a Symmetry,
    target: TargetDensity<'a>,
    /// The closest density of each order on the present cells, where there is one.
    found: BTreeMap<u32, Option<(Fitted, Functions)>>,
    /// The same without the tail, once this has been found to hold much.
    above_tail: Option<Box<Self>>,
    /// The functions of all orders on the box around the cells, without potentials and with them, and the part of ln p next to walls
    /// that no function here can follow.
    families: Vec<SpaceFamily>,
    known: Vec<Corner>,
}

impl<'a> Closest<'a> {
    /// # Errors
    /// Those of the density's values.
    pub(super) fn new(density: &'a dyn Density, closure: &'a Closure, symmetry: &'a Symmetry) -> Result<Self> {
        Self::above(density, closure, symmetry, LEVEL)
    }

    /// Where the density is above a share of its peak.
    fn above(density: &'a dyn Density, closure: &'a Closure, symmetry: &'a Symmetry, level: f64) -> Result<Self> {
        let target = TargetDensity::new(density, symmetry, level)?;
        let (families, known) = spaces(density, closure, symmetry, &target.bounds());
        Ok(Closest { density, closure, symmetry, target, found: BTreeMap::new(), above_tail: None, families, known })
    }

    /// The content of the closest density of an order, or of a lower one if that is closer, with or without the tail.
    ///
    /// # Errors
    /// [`Error::NotClosed`] where none is found; those of the density's values.
    pub(super) fn content(&mut self, order: u32, begin: Instant) -> Result<Content> {
        let whole = self.on_cells(order, begin);
        let estimate = |content: &Content| content.candidates[0].l1_estimate;
        // What is farther off is so in the middle too.
        let far = whole.as_ref().is_ok_and(|whole| estimate(whole) > FAR);
        if far || self.target.tail() <= HEAVY {
            return whole;
        }
        let above_tail = match self.above_tail.take() {
            Some(above) => above,
            None => Box::new(Self::above(self.density, self.closure, self.symmetry, TAIL)?),
        };
        let without = self.above_tail.insert(above_tail).on_cells(order, begin);
        match (whole, without) {
            (Ok(whole), Ok(without)) => Ok(if estimate(&without) < estimate(&whole) { without } else { whole }),
            (whole, without) => whole.or(without),
        }
    }

    /// The content of the closest density on the target's cells.
    fn on_cells(&mut self, order: u32, begin: Instant) -> Result<Content> {
        let reason = "no polynomial of it is near the density; it may be too narrow: take a lower order";
        let failed = || Error::NotClosed { order, reason };
        let (space, apart) = self.on_resolved_cells(order)?.ok_or_else(failed)?;
        let mut tried = chosen(self.closure.weight, |share| self.fitted(&space, share));
        if tried.is_empty() {
            return Err(failed());
        }
        let open = self.target.error + apart;
        tried
            .iter_mut()
            .for_each(|fitted| fitted.candidate.l1_estimate = (fitted.candidate.l1_estimate + open).min(2.0));
        let candidates = tried.iter().map(|fitted| fitted.candidate).collect();
        let exponent = tried.swap_remove(0).exponent;
        let cells = self.target.cells(open);
        let bounds = cells.bounds();
        let (centre, half_width): (Vec<f64>, Vec<f64>) =
            bounds.iter().map(|[low, high]| ((low + high) / 2.0, (high - low) / 2.0)).unzip();
        let reach = (centre.len() as f64).sqrt();
        let provenance = Provenance {
            order: Some(order),
            unknowns: Some(exponent.coefficients.len()),
            nodes: Some(self.target.weights.len()),
            reference: reference(self.density.provenance()),
            seconds: begin.elapsed().as_secs_f64(),
            ..Provenance::default()
        };
        Ok(Content {
            moments: self.moments(&exponent.space),
            exponent,
            reference: None,
            domain: TrustDomain::whole(centre, half_width, reach),
            integrals: Integrals::Cells(cells),
            lattice: None,
            impacts: Vec::new(),
            rare: false,
            candidates,
            indication: None,
            provenance,
        })
    }

    /// The functions of the closest density, with what two rules on the cells differ by: cells are divided until it is a small part of
    /// the distance. None where there is none, or none whose integrals are known.
    fn on_resolved_cells(&mut self, order: u32) -> Result<Option<(Functions, f64)>> {
        for round in 0.. {
            let Some((fitted, space)) = self.best(order) else { break };
            let differences = self.differences(&fitted.exponent);
            let apart: f64 = differences.iter().sum();
            let share = APART * (fitted.candidate.l1_estimate + self.target.error);
            let coarse = |k: usize| differences[k].is_nan() || differences[k] > share / differences.len() as f64;
            let count = (0..differences.len()).filter(|k| coarse(*k)).count();
            if apart <= share || round == ROUNDS || !self.target.has_room(count) {
                // What is no number is not small.
                return Ok((apart < 1.0).then_some((space, apart)));
            }
            self.target.divide(coarse)?;
            self.found.clear();
        }
        Ok(None)
    }

    /// The closest density of an even order up to one, or of that order, with its functions: the lowest that is as close as the density
    /// is known.
    fn best(&mut self, order: u32) -> Option<(Fitted, Functions)> {
        let mut best: Option<(Fitted, Functions)> = None;
        for lower in (2..order).step_by(2).chain([order]) {
            let distance = |found: &(Fitted, Functions)| found.0.candidate.l1_estimate;
            let fitted = || {
                let of_family = |family: &SpaceFamily| {
                    let space = folded::independent(family.functions(lower), &self.target.points);
                    Some((self.fitted(&space, 0.0)?, space))
                };
                let all = self.families.iter().filter_map(of_family);
                all.reduce(|one, other| if distance(&other) < distance(&one) { other } else { one })
            };
            let found = match self.found.get(&lower) {
                Some(found) => found.clone(),
                None => fitted(),
            };
            self.found.insert(lower, found.clone());
            let least = best.as_ref().map_or(f64::INFINITY, distance);
            best = found.filter(|found| distance(found) < least).or(best);
            if best.as_ref().is_some_and(|best| distance(best) <= self.target.error) {
                break;
            }
        }
        best
    }

    /// The closest density in some functions, with a share of the weight for the tails.
    fn fitted(&self, space: &Functions, share: f64) -> Option<Fitted> {
        let TargetDensity { points, weights, logarithm, .. } = &self.target;
        let target = normalised(logarithm, weights);
        let measure = mixed(&target, weights, share);
        let functions = Orthonormal::new(nodes::values(space, points), &measure)?;
        let fixed = known_values(&self.known, points);
        let fit = project((&functions, functions.values.as_ref()), &fixed, &target, &measure)?;
        let (top, mass) = scaled_mass(&fit.logarithm, weights);
        let shift = -top - mass.ln();
        let exponent = Exponent {
            known: self.known.clone(),
            space: space.clone(),
            constant: fit.constant + shift,
            coefficients: fit.coefficients,
        };
        let peak = target.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let off = |(q, p): (&f64, &f64)| (q + shift - p).abs();
        let pairs = || fit.logarithm.iter().zip(&target);
        let tail = pairs().filter(|(_, p)| **p > peak + LOWEST_COMPARED.ln()).map(off).fold(0.0, f64::max);
        let likely = pairs().zip(weights).map(|((q, p), w)| w * p.exp() * (p - q - shift)).sum();
        // exp(Q) has the mass 1 on the cells, and p less.
        let [own, target] = [&fit.logarithm, &target].map(|log| tempered(log, weights, 1.0));
        let apart = own.iter().zip(&target).map(|(q, p)| (q - (1.0 - self.target.lost) * p).abs()).sum();
        let candidate = Candidate {
            origin: Origin::Closest { tails: share },
            l1_estimate: apart,
            tail_estimate: tail / std::f64::consts::LN_10,
            likelihood_loss: likely,
            accepted: true,
        };
        Some(Fitted { candidate, exponent })
    }

    /// What two rules differ by in the mass of exp(Q), on each cell.
    fn differences(&self, exponent: &Exponent) -> Vec<f64> {
        let sums = |(points, weights): (States, Vec<f64>)| -> Vec<f64> {
            let logs = exponent.values(&points);
            let each = weights.len() / self.target.len();
            let masses: Vec<f64> = logs.iter().zip(&weights).map(|(q, w)| w * q.exp()).collect();
            masses.chunks(each).map(|masses| masses.iter().sum()).collect()
        };
        let [own, finer] = [ALONG, FINER].map(|count| sums(self.target.finer(count)));
        own.iter().zip(finer).map(|(own, finer)| (own - finer).abs()).collect()
    }

    /// The moments of the density that exp(Q) has too, where they are known.
    fn moments(&self, space: &Functions) -> Vec<Moment> {
        let powers = space.powers();
        let known = parallel::map(powers.len(), |k| {
            let (_, powers) = powers[k];
            let moment = self.density.moment(powers).ok()?;
            Some(Moment { powers: powers.to_vec(), value: moment.value, error: moment.error })
        });
        known.into_iter().flatten().collect()
    }
}

/// The functions of all orders on a box, and what ln p has next to walls beside them.
fn spaces(
    density: &dyn Density,
    closure: &Closure,
    symmetry: &Symmetry,
    bounds: &[[f64; 2]],
) -> (Vec<SpaceFamily>, Vec<Corner>) {
    let side = |(i, [low, high]): (usize, &[f64; 2])| {
        // Functions with the symmetry have it about 0.
        let centre = if symmetry.flips(i) { 0.0 } else { (low + high) / 2.0 };
        (centre, (high - centre).max(centre - low))
    };
    let (centre, half_width): (Vec<f64>, Vec<f64>) = bounds.iter().enumerate().map(side).unzip();
    let walls = density.evidence().grazed_walls();
    if walls.is_empty() {
        let smooth = Smooth {
            degrees: closure.degrees.clone(),
            symmetry: symmetry.clone(),
            centre,
            half_width,
            folds: Vec::new(),
        };
        let families = match density.evidence().problem() {
            Some(problem) => {
                let bent = smooth.bent(problem, bounds);
                let more = bent.with_potentials(problem, &|state, _| bounds[state]);
                std::iter::once(bent).chain(more).map(SpaceFamily::Smooth).collect()
            }
            None => vec![SpaceFamily::Smooth(smooth)],
        };
        return (families, Vec::new());
    }
    let speed = bounds[1][0].abs().max(bounds[1][1].abs());
    let corner = |(wall, intensity)| Corner::new(wall, vec![1], intensity, [2.0 * half_width[0], speed]);
    let corners: Vec<Corner> = walls.into_iter().map(corner).collect();
    (vec![SpaceFamily::Walled(Walled { corners: corners.clone(), centre, half_width })], corners)
}

/// What a density is closest to.
fn reference(Provenance { cells, l1_estimate, .. }: &Provenance) -> Option<String> {
    let (cells, estimate) = ((*cells)?, (*l1_estimate)?);
    Some(format!("grid of {cells} cells, estimate {estimate:.1e}"))
}

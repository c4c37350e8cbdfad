//! A density that is easy to draw from and close to the pilot's.

use crate::closure::pilot::Pilot;
use crate::closure::samples::WIDENING_AT_WALLS;
use crate::closure::{CUT_AT_WALLS, WIDENING};
use crate::error::{Error, Result};
use crate::polynomial::odd;
use crate::problem::Symmetry;
use crate::record::{Read, positive, states};
use crate::states::States;
use crate::walls::Contact;
use nalgebra::{Cholesky, DMatrix};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// Normal scores between which a state is a linear function of its score.
const KNOTS: usize = 13;
const SPACING: f64 = 0.5;

/// Normal scores with the pilot's correlations, stretched state by state to the pilot's quantiles: a Gaussian copula.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Copula {
    /// The distance between the normal scores that belong to the values of `knots`; the score of the middle one is 0.
    pub(crate) spacing: f64,
    /// For each state, its values at the scores.
    pub(crate) knots: Vec<Vec<f64>>,
    /// The covariance of the scores, by rows.
    covariance: Vec<Vec<f64>>,
    /// L⁻¹ of the covariance L Lᵀ, by rows: for distances.
    pub(crate) inverse: Vec<Vec<f64>>,
    /// The square of the radius of the trust domain.
    pub(crate) farthest: f64,
    /// Sign changes of states, of which others are made, that leave the density as it is, and those that its draws carry.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    flips: Vec<Vec<bool>>,
}

/// The score of a knot.
fn score(k: usize) -> f64 {
    (k as f64 - (KNOTS - 1) as f64 / 2.0) * SPACING
}

/// The state at a score, and the piece that it is on: linear between knots and beyond them.
fn state_at(knots: &[f64], z: f64) -> (f64, usize) {
    let piece = ((z - score(0)) / SPACING).floor().clamp(0.0, (KNOTS - 2) as f64) as usize;
    let slope = (knots[piece + 1] - knots[piece]) / SPACING;
    (knots[piece] + slope * (z - score(piece)), piece)
}

/// The score of a state.
fn score_of(knots: &[f64], x: f64) -> f64 {
    let piece = knots[1..KNOTS - 1].partition_point(|v| *v <= x);
    let slope = (knots[piece + 1] - knots[piece]) / SPACING;
    score(piece) + (x - knots[piece]) / slope
}

fn rising(knots: &[f64]) -> bool {
    knots.windows(2).all(|pair| pair[0] < pair[1])
}

/// The square of the length of L⁻¹z.
fn distance(inverse: &[Vec<f64>], z: &[f64]) -> f64 {
    let along = |row: &Vec<f64>| row.iter().zip(z).map(|(l, z)| l * z).sum::<f64>().powi(2);
    inverse.iter().map(along).sum()
}

impl Copula {
    /// The same with a trust domain so many times wider.
    pub(in crate::closure) fn followed(self, times: f64) -> Self {
        Copula { farthest: self.farthest * times * times, ..self }
    }

    /// The radius of the trust domain, relative to the farthest of the pilot's states.
    pub(super) fn beyond(&self, pilot: &Pilot) -> f64 {
        let farthest = pilot.states.iter().map(|x| distance(&self.inverse, &self.scores(x))).fold(0.0, f64::max);
        (self.farthest / farthest).sqrt()
    }

    fn scores(&self, x: &[f64]) -> Vec<f64> {
        self.knots.iter().zip(x).map(|(knots, x)| score_of(knots, *x)).collect()
    }

    /// Of the pilot's states and their mirror images. None where they lie on a surface.
    pub(in crate::closure) fn new(pilot: &Pilot, symmetry: &Symmetry) -> Option<Self> {
        Copula::of(symmetry, &|| pilot.states.iter(), WIDENING)
    }

    /// Of the pilot's states and their reflections at each wall, so that the density does not fall off towards walls.
    pub(in crate::closure) fn next_to(contacts: &[Contact], pilot: &Pilot) -> Option<Self> {
        let reflected = |x: &[f64]| {
            let behind = contacts.iter().map(|contact| {
                let mut image = x.to_vec();
                contact.mirror(&mut image);
                contact.collide(1.0, &mut image);
                image
            });
            behind.chain([x.to_vec()]).collect::<Vec<_>>()
        };
        let images = || pilot.states.iter().flat_map(reflected);
        let none = Symmetry::none(pilot.states.dimension());
        let copula = Copula::of(&none, &images, WIDENING_AT_WALLS)?;
        let of = |x: &[f64]| distance(&copula.inverse, &copula.scores(x));
        let mut distances: Vec<f64> = pilot.states.iter().map(of).collect();
        let last = distances.len().checked_sub(1)?;
        let kept = ((1.0 - CUT_AT_WALLS) * last as f64) as usize;
        let (_, farthest, _) = distances.select_nth_unstable_by(kept, f64::total_cmp);
        Some(Copula { farthest: *farthest, ..copula })
    }

    /// Of any states and their mirror images; the covariance of the scores is `wider` times theirs. None where they lie on a surface.
    pub(super) fn of<I>(symmetry: &Symmetry, states: &impl Fn() -> I, wider: f64) -> Option<Self>
    where
        I: Iterator<Item: AsRef<[f64]>>,
    {
        let n = symmetry.changes()[0].len();
        let quantiles = |i: usize| -> Vec<f64> {
            let own = || states().map(|x| x.as_ref()[i]);
            let mut all: Vec<f64> = own().collect();
            all.extend(own().filter(|_| symmetry.flips(i)).map(|x| -x));
            all.sort_by(f64::total_cmp);
            let quantile = |p: f64| all[((p * all.len() as f64) as usize).min(all.len() - 1)];
            (0..KNOTS).map(|k| quantile(normal_distribution(score(k)))).collect()
        };
        let knots: Vec<Vec<f64>> = (0..n).map(quantiles).collect();
        if !knots.iter().all(|knots| rising(knots)) {
            return None;
        }
        let scores = |x: &[f64]| -> Vec<f64> { knots.iter().zip(x).map(|(knots, x)| score_of(knots, *x)).collect() };
        let mut covariance = DMatrix::zeros(n, n);
        let mut count = 0.0;
        for x in states() {
            let z = scores(x.as_ref());
            for i in 0..n {
                (0..n).for_each(|j| covariance[(i, j)] += z[i] * z[j]);
            }
            count += 1.0;
        }
        covariance *= wider / count;
        symmetry.average(&mut covariance);
        let rows =
            |m: &DMatrix<f64>| -> Vec<Vec<f64>> { m.row_iter().map(|row| row.iter().copied().collect()).collect() };
        let inverse = rows(&Cholesky::new(covariance.clone())?.l().try_inverse()?);
        // Mirror images are about as far.
        let farthest = states().map(|x| distance(&inverse, &scores(x.as_ref()))).fold(0.0, f64::max);
        let covariance = rows(&covariance);
        Some(Copula {
            spacing: SPACING,
            knots,
            covariance,
            inverse,
            farthest: farthest * WIDENING * WIDENING,
            flips: symmetry.generators(),
        })
    }

    /// The same for `n` states, if its numbers have a meaning.
    pub(super) fn checked(self, n: usize) -> Read<Self> {
        if self.spacing != SPACING {
            return Err(format!("the spacing of its scores is {}, not {SPACING}", self.spacing));
        }
        if [&self.knots, &self.covariance, &self.inverse].iter().any(|rows| rows.len() != n) {
            return Err(format!("its knots and scores are not those of {n} states"));
        }
        for knots in &self.knots {
            states("a list of knots", knots, KNOTS)?;
            if !rising(knots) {
                return Err(format!("the knots {knots:?} do not rise"));
            }
        }
        self.covariance.iter().try_for_each(|row| states("the covariance of the scores", row, n))?;
        self.inverse.iter().try_for_each(|row| states("the inverse of the scores' scale", row, n))?;
        let covariance = DMatrix::from_fn(n, n, |i, j| self.covariance[i][j]);
        Cholesky::new(covariance).ok_or("the covariance of the scores is not positive definite")?;
        positive("the farthest distance", self.farthest)?;
        if self.flips.iter().any(|flip| flip.len() != n) {
            return Err(format!("its sign changes are not those of {n} states"));
        }
        Ok(self)
    }

    /// Draws of all states but those given, which are held at their values.
    pub(super) fn sampler(&self, given: &[(usize, f64)]) -> Result<Sampler<'_>> {
        let n = self.knots.len();
        let mut order: Vec<usize> = (0..n).collect();
        for (place, (state, _)) in given.iter().enumerate() {
            let from = order.iter().position(|i| i == state).unwrap_or(place);
            order.swap(place, from);
        }
        let permuted = DMatrix::from_fn(n, n, |i, j| self.covariance[order[i]][order[j]]);
        let lower = Cholesky::new(permuted).map(|factor| factor.l()).ok_or_else(|| Error::NotKnown {
            what: String::from("integrals over its draws"),
            remedy: "the scores of the pilot's states are dependent; take more pilot states",
        })?;
        let mut held: Vec<(f64, f64)> = Vec::with_capacity(given.len());
        for (i, &(state, x)) in given.iter().enumerate() {
            let known: f64 = held.iter().enumerate().map(|(j, (u, _))| lower[(i, j)] * u).sum();
            held.push(((score_of(&self.knots[state], x) - known) / lower[(i, i)], x));
        }
        let logarithms = |i: usize| -> Vec<f64> {
            let diagonal = lower[(i, i)].ln() + 0.5 * std::f64::consts::TAU.ln();
            self.knots[order[i]].windows(2).map(|pair| ((pair[1] - pair[0]) / SPACING).ln() + diagonal).collect()
        };
        let steepness = (0..n).map(logarithms).collect();
        let lower = (0..n).map(|i| (0..=i).map(|j| lower[(i, j)]).collect()).collect();
        Ok(Sampler { copula: self, order, lower, steepness, held })
    }

    /// Whether a monomial is the same at all mirror images of a state.
    pub(in crate::closure) fn keeps(&self, powers: &[u32]) -> bool {
        !self.flips.iter().any(|flip| odd(flip, powers))
    }

    /// A state and its mirror images, of which some may be the same, each with whether one of the states has its sign changed.
    pub(super) fn images_and(&self, x: &[f64], state: usize) -> Vec<(Vec<f64>, bool)> {
        let mut images = vec![(x.to_vec(), false)];
        for flip in &self.flips {
            let flipped = |(x, own): &(Vec<f64>, bool)| {
                (x.iter().zip(flip).map(|(x, flip)| if *flip { -x } else { *x }).collect(), own ^ flip[state])
            };
            let more: Vec<(Vec<f64>, bool)> = images.iter().map(flipped).collect();
            images.extend(more);
        }
        images
    }

    /// Whether a state lies in the trust domain: where the pilot has been, or a little farther out.
    pub(super) fn trusts(&self, x: &[f64]) -> bool {
        self.distance(x) <= self.farthest
    }

    /// The square of the distance of a state's scores from their middle, in their standard deviations,
    pub(in crate::closure) fn distance(&self, x: &[f64]) -> f64 {
        distance(&self.inverse, &self.scores(x))
    }

    /// the largest one in the trust domain,
    pub(in crate::closure) fn farthest(&self) -> f64 {
        self.farthest
    }

    /// and the same with a smaller one.
    pub(in crate::closure) fn ending_at(self, farthest: f64) -> Self {
        Copula { farthest, ..self }
    }

    /// States that fill the trust domain evenly by their scores, with the logarithms of their weights but for a constant.
    pub(in crate::closure) fn scattered(&self, count: usize, seed: u64) -> Result<(States, Vec<f64>)> {
        let (sampler, n) = (self.sampler(&[])?, self.knots.len());
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let (mut scattered, mut weights) = (States::new(n), Vec::with_capacity(count));
        let (mut u, mut x) = (vec![0.0; n], vec![0.0; n]);
        for _ in 0..count {
            u.iter_mut().for_each(|u| *u = generator.sample(StandardNormal));
            let share = generator.random::<f64>().powf((n as f64).recip());
            let length = u.iter().map(|u| u * u).sum::<f64>().sqrt();
            let radius = share * self.farthest.sqrt();
            u.iter_mut().for_each(|u| *u *= radius / length);
            if let Some(logarithm) = sampler.draw(&mut u, &mut x) {
                scattered.push(&x);
                weights.push(-logarithm - 0.5 * radius * radius);
            }
        }
        Ok((scattered, weights))
    }
}

/// Draws with some states held fast.
#[derive(Clone, Debug)]
pub(super) struct Sampler<'a> {
    copula: &'a Copula,
    /// The states in the order in which they are drawn.
    order: Vec<usize>,
    /// The rows of the Cholesky factor in that order, up to the diagonal.
    lower: Vec<Vec<f64>>,
    /// For each of these states the logarithm of the slope of each of its pieces and of the factor's diagonal.
    steepness: Vec<Vec<f64>>,
    /// The states held, as the first normal numbers, and themselves.
    held: Vec<(f64, f64)>,
}

impl Sampler<'_> {
    /// Enters a state from normal numbers, and gives the logarithm of the density with which it is drawn. None where the
    /// state lies outside the trust domain, where the density is zero.
    pub(super) fn draw(&self, u: &mut [f64], x: &mut [f64]) -> Option<f64> {
        u.iter_mut().zip(&self.held).for_each(|(u, (held, _))| *u = *held);
        // Distances do not depend on the order of the states.
        let distance: f64 = u.iter().map(|u| u * u).sum();
        if distance > self.copula.farthest {
            return None;
        }
        let mut logarithm = 0.0;
        for (i, (row, &state)) in self.lower.iter().zip(&self.order).enumerate() {
            let z: f64 = row.iter().zip(&*u).map(|(l, u)| l * u).sum();
            let (value, piece) = state_at(&self.copula.knots[state], z);
            x[state] = value;
            if i >= self.held.len() {
                logarithm -= 0.5 * u[i] * u[i] + self.steepness[i][piece];
            }
        }
        self.order.iter().zip(&self.held).for_each(|(&state, (_, held))| x[state] = *held);
        Some(logarithm)
    }
}

/// Φ(z), by Zelen and Severo's rational approximation: seven digits, more than a quantile of a sample needs.
pub(super) fn normal_distribution(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let series =
        t * (0.319_381_530 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * series;
    if z > 0.0 { 1.0 - tail } else { tail }
}

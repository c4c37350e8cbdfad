//! Random systems with a density that is known in any number of states.

use expoly::{Density, Result, Scalar, System};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;
use std::fmt;

/// dX = (A − ½B) ∇U dt + G dW with B = GGᵀ and an antisymmetric A, whose stationary density is exp(−U): the antisymmetric part
/// moves along the level sets of U, the rest is a gradient flow with its own noise. U is a sum of powers of linear forms, of
/// either sign but for the highest, so that wells and ridges are among them; noise drives the last states alone.
#[derive(Clone, Debug)]
pub struct Exact {
    /// The linear form, its power and the factor of each term of U.
    terms: Vec<(Vec<f64>, u32, f64)>,
    /// A − ½B, by rows.
    rates: Vec<Vec<f64>>,
    noisy: usize,
    name: String,
}

impl Exact {
    /// The system of this index: 3 to 6 states, U of degree 6 or 8, noise on one state or on two, every other one without
    /// symmetry.
    pub fn random(seed: u64, index: usize) -> Self {
        let (states, degree) = (3 + index % 4, if index / 4 % 3 == 2 { 8 } else { 6 });
        let noisy = 1 + (index / 8 + usize::from(states > 4)) % 2;
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        stream.set_stream(index as u64);
        let within = |stream: &mut ChaCha8Rng, low: f64, high: f64| low + (high - low) * stream.random::<f64>();
        let unit = |i: usize| (0..states).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>();
        let form = |stream: &mut ChaCha8Rng| -> Vec<f64> {
            (0..states).map(|_| stream.sample::<f64, _>(StandardNormal) / (states as f64).sqrt()).collect()
        };
        let mut terms: Vec<_> = (0..states).map(|i| (unit(i), 2, 0.5 * within(&mut stream, 0.3, 1.2))).collect();
        terms.extend((0..states).map(|_| (form(&mut stream), 4, within(&mut stream, -0.3, 0.6))));
        terms.extend((0..states).map(|i| (unit(i), degree, 0.08)));
        terms.extend((0..2).map(|_| (form(&mut stream), degree, 0.2)));
        if index / 4 % 2 == 1 {
            terms.push((form(&mut stream), 3, 0.4));
        }
        let mut rates = vec![vec![0.0; states]; states];
        for i in 0..states {
            for j in 0..i {
                let [a, b] = [(); 2].map(|()| stream.sample::<f64, _>(StandardNormal));
                let rate = (a - b) / (states as f64).sqrt();
                (rates[i][j], rates[j][i]) = (rate, -rate);
            }
            if i + noisy >= states {
                // G is √2 there.
                rates[i][i] = -1.0;
            }
        }
        let name = format!("{states} states, {noisy} with noise, U of degree {degree}, {} terms", terms.len());
        Exact { terms, rates, noisy, name }
    }

    /// ln p up to a constant, −U.
    pub fn log_density(&self, x: &[f64]) -> f64 {
        let term = |(form, power, c): &(Vec<f64>, u32, f64)| {
            let along = along(form, x);
            (0..*power).fold(*c, |product, _| product * along)
        };
        -self.terms.iter().map(term).sum::<f64>()
    }

    /// ∫ |p̃ − p| dx of a density p̃: by its own nodes where these cover p, and by draws from p otherwise.
    ///
    /// # Errors
    /// Those of p̃'s expectations.
    pub fn l1(&self, density: &dyn Density, truth: &Truth) -> Result<f64> {
        let log_ratio = |x: &[f64]| density.log_pdf(x).map_or(f64::NAN, |log| self.log_density(x) - log);
        let log_mass = density.expectation(&|x| log_ratio(x).exp())?.value.ln();
        if (log_mass - truth.log_mass).abs() < SAME {
            Ok(density.expectation(&|x| 2.0 * (1.0 - (log_ratio(x) - log_mass).exp()).max(0.0))?.value)
        } else {
            let part = |x: &Vec<f64>| 2.0 * (1.0 - (truth.log_mass - log_ratio(x)).exp()).max(0.0);
            Ok(truth.draws.iter().map(part).sum::<f64>() / truth.draws.len() as f64)
        }
    }

    /// Draws from the density, and ln ∫ exp(−U): particles that begin normal and are led to exp(−U) in steps, resampled and
    /// moved by Metropolis' rule at each (P. Del Moral, A. Doucet and A. Jasra, 2006, doi:10.1111/j.1467-9868.2006.00553.x).
    /// They find wells that one path hardly leaves.
    pub fn truth(&self, count: usize, seed: u64) -> Truth {
        const STEPS: usize = 48;
        const MOVES: usize = 8;
        let states = self.rates.len();
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        let normal = |x: &[f64]| x.iter().map(|x| -0.5 * x * x / WIDE.powi(2)).sum::<f64>();
        let mut particles: Vec<Vec<f64>> =
            (0..count).map(|_| (0..states).map(|_| WIDE * stream.sample::<f64, _>(StandardNormal)).collect()).collect();
        let mut log_mass = 0.5 * states as f64 * (std::f64::consts::TAU * WIDE * WIDE).ln();
        let mut length = WIDE / (states as f64).sqrt();
        for step in 0..STEPS {
            // Short steps at first, where little of U is far.
            let share = |step: usize| (step as f64 / STEPS as f64).powi(3);
            let (before, now) = (share(step), share(step + 1));
            let weights: Vec<f64> =
                particles.iter().map(|x| ((now - before) * (self.log_density(x) - normal(x))).exp()).collect();
            let sum: f64 = weights.iter().sum();
            log_mass += (sum / count as f64).ln();
            // Systematic resampling.
            let (mut next, mut all) = (Vec::with_capacity(count), 0.0);
            let shift: f64 = stream.random();
            for (x, w) in particles.iter().zip(&weights) {
                all += w / sum * count as f64;
                while (next.len() as f64) + shift < all && next.len() < count {
                    next.push(x.clone());
                }
            }
            while next.len() < count {
                next.push(particles[count - 1].clone());
            }
            particles = next;
            let log = |x: &[f64]| now * self.log_density(x) + (1.0 - now) * normal(x);
            for _ in 0..MOVES {
                let mut moved = 0;
                for x in &mut particles {
                    let new: Vec<f64> =
                        x.iter().map(|x| x + length * stream.sample::<f64, _>(StandardNormal)).collect();
                    if stream.random::<f64>() < (log(&new) - log(x)).exp() {
                        *x = new;
                        moved += 1;
                    }
                }
                length *= if moved * 10 > 3 * count { 1.1 } else { 0.9 };
            }
        }
        Truth { draws: particles, log_mass }
    }
}

/// A density that is known, by its draws.
#[derive(Clone, Debug)]
pub struct Truth {
    draws: Vec<Vec<f64>>,
    /// ln ∫ exp(−U) dx, to about a hundredth by some ten thousand draws.
    log_mass: f64,
}

/// ln ∫ exp(−U) by the draws and by a density's own nodes are the same but for chance, or these miss a part.
const SAME: f64 = 0.03;
/// The standard deviation of the particles at the beginning.
const WIDE: f64 = 1.5;

fn along(form: &[f64], x: &[f64]) -> f64 {
    form.iter().zip(x).map(|(w, x)| w * x).sum()
}

impl System for Exact {
    fn dimension(&self) -> usize {
        self.rates.len()
    }

    fn processes(&self) -> usize {
        self.noisy
    }

    fn drift<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let mut gradient = vec![S::from(0.0); x.len()];
        for (form, power, c) in &self.terms {
            let along = form.iter().zip(x).fold(S::from(0.0), |sum, (w, x)| sum + *x * *w);
            let slope = if *power == 2 { along } else { along.powi(power - 1) };
            for (gradient, w) in gradient.iter_mut().zip(form).filter(|(_, w)| **w != 0.0) {
                *gradient = *gradient + slope * (c * f64::from(*power) * w);
            }
        }
        self.rates
            .iter()
            .map(|row| row.iter().zip(&gradient).fold(S::from(0.0), |sum, (rate, slope)| sum + *slope * *rate))
            .collect()
    }

    fn noise<S: Scalar>(&self, x: &[S]) -> Vec<Vec<S>> {
        let n = x.len();
        let entry = |i: usize, j: usize| if i + self.noisy == n + j { 2.0_f64.sqrt() } else { 0.0 };
        (0..n).map(|i| (0..self.noisy).map(|j| S::from(entry(i, j))).collect()).collect()
    }
}

impl fmt::Display for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

//! Draws on lattices under random shifts.

use crate::record::{Read, states};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use serde::{Deserialize, Serialize};

/// Random shifts of the lattice of draws for integrals: the spread between them is the standard error.
pub(super) const SHIFTS: usize = 16;
/// Draws that a thread takes at a time.
pub(super) const BLOCK: usize = 2048;

/// The most blocks of draws for each shift in a file: some minutes of work for an integral.
const MOST_BLOCKS: usize = 1 << 16;

/// Points of a lattice in the unit cube under random shifts.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Shifts {
    /// The shifts, a number for each state.
    starts: Vec<Vec<f64>>,
    /// Blocks for each shift.
    pub(super) blocks: usize,
    /// The step of the lattice from point to point, for each state.
    #[serde(skip)]
    advance: Vec<f64>,
}

impl Shifts {
    /// About so many points in `n` dimensions.
    pub(super) fn new(n: usize, draws: usize, seed: u64) -> Self {
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        let starts = (0..SHIFTS).map(|_| (0..n).map(|_| stream.random()).collect()).collect();
        let blocks = draws.div_ceil(BLOCK * SHIFTS).max(1);
        Shifts { starts, blocks, advance: square_roots(n) }
    }

    /// Blocks under all shifts.
    pub(super) fn blocks_in_all(&self) -> usize {
        self.starts.len() * self.blocks
    }

    /// The number of points.
    pub(super) fn count(&self) -> usize {
        self.blocks_in_all() * BLOCK
    }

    /// The same in `n` dimensions, if the numbers have a meaning.
    pub(super) fn checked(self, n: usize) -> Read<Self> {
        if self.starts.len() != SHIFTS {
            return Err(format!("there are {} shifts, not {}", self.starts.len(), SHIFTS));
        }
        self.starts.iter().try_for_each(|shift| states("a shift of the draws", shift, n))?;
        if !(1..=MOST_BLOCKS).contains(&self.blocks) {
            return Err(format!("{} blocks of draws are not between 1 and {}", self.blocks, MOST_BLOCKS));
        }
        Ok(Shifts { advance: square_roots(n), ..self })
    }
}

/// The draws of one of all blocks in a sampler's trust domain, each with the logarithm of the density that it is drawn with.
pub(super) fn each_draw(
    draw: &impl Fn(&mut [f64], &mut [f64]) -> Option<f64>,
    shifts: &Shifts,
    block: usize,
    mut visit: impl FnMut(&[f64], f64),
) {
    let (start, block) = (&shifts.starts[block / shifts.blocks], block % shifts.blocks);
    let [mut normals, mut x] = [(); 2].map(|()| vec![0.0; start.len()]);
    for k in block * BLOCK..(block + 1) * BLOCK {
        for ((u, start), advance) in normals.iter_mut().zip(start).zip(&shifts.advance) {
            *u = normal_quantile((start + k as f64 * advance).fract());
        }
        if let Some(logarithm) = draw(&mut normals, &mut x) {
            visit(&x, logarithm);
        }
    }
}

/// The square roots of the first primes: no combination of them with small whole numbers is a whole number, so that their
/// multiples fill the unit cube evenly.
fn square_roots(count: usize) -> Vec<f64> {
    let primes = (2_u32..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0));
    primes.take(count).map(|p| f64::from(p).sqrt().fract()).collect()
}

/// The inverse of the normal distribution, by Acklam's rational approximations: nine digits.
fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -39.69683028665376,
        220.9460984245205,
        -275.9285104469687,
        138.357751867269,
        -30.66479806614716,
        2.506628277459239,
    ];
    const B: [f64; 6] =
        [-54.47609879822406, 161.5858368580409, -155.6989798598866, 66.80131188771972, -13.28068155288572, 1.0];
    const C: [f64; 6] = [
        -0.007784894002430293,
        -0.3223964580411365,
        -2.400758277161838,
        -2.549732539343734,
        4.374664141464968,
        2.938163982698783,
    ];
    const D: [f64; 5] = [0.007784695709041462, 0.3224671290700398, 2.445134137142996, 3.754408661907416, 1.0];
    const TAIL: f64 = 0.02425;
    let horner = |c: &[f64], t: f64| c.iter().fold(0.0, |sum, c| sum * t + c);
    let tail = |p: f64| {
        let q = (-2.0 * p.max(f64::MIN_POSITIVE).ln()).sqrt();
        horner(&C, q) / horner(&D, q)
    };
    if p < TAIL {
        tail(p)
    } else if p > 1.0 - TAIL {
        -tail(1.0 - p)
    } else {
        let q = p - 0.5;
        q * horner(&A, q * q) / horner(&B, q * q)
    }
}

use crate::density::{Cell, cell_lines};
use crate::{Density, Error, Result};
use nalgebra::{Cholesky, SMatrix, SVector};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;
use rayon::prelude::*;

/// Samples that one random stream makes.
const BLOCK: usize = 1024;
/// Cells along each state to begin with.
const CELLS: usize = 16;
/// A cell is halved while its highest and lowest value differ by more than this factor,
const UNEVEN: f64 = 1.5;
/// and it holds more than this share of the mass,
const SHARE: f64 = 1e-5;
/// this often at most.
const HALVINGS: usize = 10;
/// The density within a cell is taken to be at most this factor above its highest known value there.
const MARGIN: f64 = 1.1;
/// How often that factor is raised before the density is given up.
const ATTEMPTS: usize = 12;
/// Draws of the proposal where a density in many states has none of its own.
const DRAWS: usize = 1 << 17;
/// The proposal's standard deviations relative to the density's.
const WIDENED: f64 = 1.25;

/// Independent states drawn from a density.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples<const N: usize> {
    /// The states.
    pub states: Vec<[f64; N]>,
    /// Where the states are drawn again from weighted ones: how many independent ones those are worth, (Σw)²/Σw². States
    /// repeat themselves when more than a fraction of that many are drawn. None where all are independent.
    pub effective: Option<f64>,
}

/// Draws `count` states from a density: the same bits for the same `seed` on any number of threads.
///
/// In one state and in two the states are independent and exact, by rejection from a piecewise constant envelope: cells
/// are halved until the density varies little on each, and an envelope that a draw finds too low is raised, and all draws
/// begin anew. Only a peak that is narrower than a cell and never met would be missed. In more states they are drawn again from
/// weighted ones: those that the density was integrated on, [`Density::weighted_states`], or draws from a normal density
/// with the same mean and covariance; [`Samples::effective`] says what that is worth, and tails beyond these states are not
/// there.
///
/// # Errors
/// [`Error::NoSamples`] for a `count` of zero; [`Error::NotKnown`] if the density does not know its values, as a simulation of
/// more than two states, or is too uneven for an envelope.
///
/// ```
/// use expoly::{models::{Duffing, Solved}, statistics::samples};
/// let exact = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact()?;
/// let states = samples(&exact, 10_000, 1)?.states;
/// let square = states.iter().map(|x| x[0] * x[0]).sum::<f64>() / 1e4;
/// // The standard error is 0.008.
/// assert!((square - 0.6617).abs() < 0.032);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn samples<const N: usize>(density: &dyn Density<N>, count: usize, seed: u64) -> Result<Samples<N>> {
    if count == 0 {
        return Err(Error::NoSamples { what: "the number of states to draw", least: 1 });
    }
    if N <= 2 {
        return Ok(Samples { states: by_rejection(density, count, seed)?, effective: None });
    }
    let weighted = density.weighted_states().map_or_else(|| proposed(density, seed), Ok)?;
    let [sum, squares] = weighted.iter().fold([0.0; 2], |[sum, squares], (_, w)| [sum + w, squares + w * w]);
    if !(sum.is_finite() && sum > 0.0) {
        return Err(UNKNOWN_VALUES);
    }
    let cumulative = cumulated(weighted.iter().map(|(_, w)| *w));
    let draw = |stream: &mut ChaCha8Rng| Ok(weighted[chosen(&cumulative, stream.random())].0);
    Ok(Samples { states: in_blocks(count, seed, draw)?, effective: Some(sum * sum / squares) })
}

const UNKNOWN_VALUES: Error = Error::NotKnown {
    what: "its value at a state",
    remedy: "in more than two states draw from a closure, or take the simulation's own states",
};

/// `count` draws, each block from a random stream of its own.
fn in_blocks<const N: usize>(
    count: usize,
    seed: u64,
    draw: impl Fn(&mut ChaCha8Rng) -> Result<[f64; N]> + Sync,
) -> Result<Vec<[f64; N]>> {
    let blocks: Result<Vec<Vec<[f64; N]>>> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut stream = ChaCha8Rng::seed_from_u64(seed);
            stream.set_stream(block as u64);
            (0..BLOCK.min(count - block * BLOCK)).map(|_| draw(&mut stream)).collect()
        })
        .collect();
    Ok(blocks?.concat())
}

fn cumulated(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    let running = weights.scan(0.0, |sum, w| {
        *sum += w;
        Some(*sum)
    });
    running.collect()
}

/// The place that holds the share `u` of the whole.
fn chosen(cumulative: &[f64], u: f64) -> usize {
    let total = cumulative.last().copied().unwrap_or(0.0);
    cumulative.partition_point(|sum| *sum <= u * total).min(cumulative.len() - 1)
}

/// A cell, the highest and the lowest density met on it.
#[derive(Clone, Copy, Debug)]
struct Piece<const N: usize> {
    cell: Cell<N>,
    highest: f64,
    lowest: f64,
}

impl<const N: usize> Piece<N> {
    /// Looks at corners, middles of sides and centre.
    fn new(density: &dyn Density<N>, cell: Cell<N>) -> Self {
        let mut piece = Piece { cell, highest: 0.0, lowest: f64::INFINITY };
        for k in 0..3_usize.pow(N as u32) {
            let shares = std::array::from_fn(|i| (k / 3_usize.pow(i as u32) % 3) as f64 / 2.0);
            let p = density.pdf(&cell.at(shares)).value.max(0.0);
            (piece.highest, piece.lowest) = (piece.highest.max(p), piece.lowest.min(p));
        }
        piece
    }

    fn mass(&self) -> f64 {
        self.highest * self.cell.volume()
    }
}

/// Cells on which the density varies little.
fn pieces<const N: usize>(density: &dyn Density<N>) -> Vec<Piece<N>> {
    let of = |cells: Vec<Cell<N>>| -> Vec<Piece<N>> {
        cells.into_par_iter().map(|cell| Piece::new(density, cell)).collect()
    };
    let mut pieces = of(Cell::between(&cell_lines(&density.bounds(), CELLS, |_| Vec::new())));
    for _ in 0..HALVINGS {
        let total: f64 = pieces.iter().map(Piece::mass).sum();
        let (uneven, even): (Vec<_>, Vec<_>) =
            pieces.iter().partition(|piece| piece.mass() > SHARE * total && piece.highest > UNEVEN * piece.lowest);
        if uneven.is_empty() {
            break;
        }
        pieces = even;
        pieces.extend(of(uneven.iter().flat_map(|piece| piece.cell.children()).collect()));
    }
    pieces.retain(|piece| piece.highest > 0.0 && piece.highest.is_finite());
    pieces
}

fn by_rejection<const N: usize>(density: &dyn Density<N>, count: usize, seed: u64) -> Result<Vec<[f64; N]>> {
    let too_low = Error::NotKnown {
        what: "an upper bound of its values",
        remedy: "it is too uneven to draw from, or infinite somewhere",
    };
    let pieces = pieces(density);
    if pieces.is_empty() {
        return Err(UNKNOWN_VALUES);
    }
    let cumulative = cumulated(pieces.iter().map(Piece::mass));
    let mut margin = MARGIN;
    for _ in 0..ATTEMPTS {
        let draw = |stream: &mut ChaCha8Rng| {
            loop {
                let piece = &pieces[chosen(&cumulative, stream.random())];
                let x = piece.cell.at(std::array::from_fn(|_| stream.random()));
                let (p, envelope) = (density.pdf(&x).value, margin * piece.highest);
                // What is not a number is no bound either.
                if p.is_nan() || p > envelope {
                    return Err(too_low.clone());
                }
                if stream.random::<f64>() * envelope < p {
                    return Ok(x);
                }
            }
        };
        match in_blocks(count, seed, draw) {
            Err(error) if error == too_low => margin *= 1.5,
            answer => return answer,
        }
    }
    Err(too_low)
}

/// States from a normal density with the density's mean and covariance, weighted.
fn proposed<const N: usize>(density: &dyn Density<N>, seed: u64) -> Result<Vec<([f64; N], f64)>> {
    let power = |powers: [usize; 2], count: usize| -> f64 {
        density
            .moment(std::array::from_fn(|i| powers[..count].iter().filter(|&&state| state == i).count() as u32))
            .value
    };
    let mean = SVector::<f64, N>::from_fn(|i, _| power([i, i], 1));
    let covariance = SMatrix::<f64, N, N>::from_fn(|i, j| power([i, j], 2) - mean[i] * mean[j]);
    let lower = Cholesky::new(covariance).ok_or(UNKNOWN_VALUES)?.l() * WIDENED;
    // Streams of its own, so that the draws from these states are independent of them.
    let normals = in_blocks(DRAWS, seed ^ 0x9e37_79b9_7f4a_7c15, |stream| {
        Ok(std::array::from_fn(|_| stream.sample(StandardNormal)))
    })?;
    let states: Vec<([f64; N], f64)> = normals
        .into_par_iter()
        .map(|z: [f64; N]| {
            let z = SVector::from(z);
            let x: [f64; N] = (mean + lower * z).into();
            (x, density.log_pdf(&x) + z.norm_squared() / 2.0)
        })
        .collect();
    let top = states.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
    Ok(states.into_iter().map(|(x, log)| (x, (log - top).exp())).collect())
}

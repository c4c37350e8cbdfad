use crate::checks::require;
use crate::density::{Cell, Density, cell_lines};
use crate::error::{Error, Result};
use crate::memory::MemoryLimit;
use crate::parallel;
use crate::polynomial::of_one;
use crate::states::States;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;

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
/// A cell that is still as uneven then has a singularity, as where a lossy wall is grazed. The density is cut off at this
/// factor above its value in the cell's middle; next to nothing of the mass is so close.
const SINGULAR: f64 = 10.0;
/// The density within a cell is taken to be at most this factor above its highest known value there.
const MARGIN: f64 = 1.1;
/// The number of times that factor is raised before the density is given up.
const ATTEMPTS: usize = 12;
/// Trials for one state: on cells this even, of a density whose mass is 1, a few are enough.
const TRIALS: usize = 100_000;
/// Draws of the proposal where a density in many states has none of its own.
const DRAWS: usize = 1 << 17;
/// The proposal's standard deviations relative to the density's.
const WIDENED: f64 = 1.25;

/// Draws `count` states from a density: the same bits for the same `seed` on any number of threads.
///
/// In one state and in two the states are independent and exact, by rejection from a piecewise constant envelope: cells
/// are halved until the density varies little on each, and an envelope that is below the density at a draw is raised, and all
/// draws begin anew. Only a peak that is narrower than a cell and at no evaluated point would be missed. In more states they
/// are drawn again from weighted ones: the draws that the density was integrated on, or draws from
/// a normal density with the same mean and covariance; tails beyond these states are not there.
///
/// The number beside the states is the effective number of independent ones among the weighted ones, (Σw)²/Σw², and none
/// where all are independent. States repeat themselves when more than a fraction of that many are drawn.
///
/// # Errors
/// [`Error::OutOfRange`] for a `count` of zero, [`Error::TooMuchMemory`] for more than 2³⁰ numbers in all; [`Error::NotKnown`] if the density does not know its values, as a simulation
/// of more than two states, or is too uneven for an envelope.
///
/// ```
/// use expoly::{models::{Duffing, Solved}, statistics::samples};
/// let exact = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact()?;
/// let (states, _) = samples(&exact, 10_000, 1)?;
/// let square = states.iter().map(|x| x[0] * x[0]).sum::<f64>() / 1e4;
/// // The standard error is 0.008.
/// assert!((square - 0.6617).abs() < 0.032);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn samples(density: &dyn Density, count: usize, seed: u64) -> Result<(States, Option<f64>)> {
    require(count > 0, "number of states to draw", 0.0, "take at least 1")?;
    let dimension = density.dimension();
    let numbers = count as f64 * dimension as f64;
    MemoryLimit::default().holds("the states to draw", numbers, "draw fewer, several times, with another seed each")?;
    if dimension <= 2 {
        return Ok((by_rejection(density, count, seed)?, None));
    }
    let (states, weights) = density.evidence().weighted_states().map_or_else(|| proposed(density, seed), Ok)?;
    let [sum, squares] = weights.iter().fold([0.0; 2], |[sum, squares], w| [sum + w, squares + w * w]);
    if !(sum.is_finite() && sum > 0.0) {
        return Err(unknown_values());
    }
    let cumulative = cumulated(weights.iter().copied());
    let draw = |stream: &mut ChaCha8Rng, drawn: &mut Vec<f64>| {
        drawn.extend_from_slice(states.state(chosen(&cumulative, stream.random())));
        Ok(())
    };
    Ok((in_blocks(dimension, count, seed, draw)?, Some(sum * sum / squares)))
}

fn unknown_values() -> Error {
    let remedy = "in more than two states draw from a closure, or take the simulation's own states";
    Error::NotKnown { what: "its value at a state".into(), remedy }
}

/// `count` draws, each block from a random stream of its own; `draw` appends a state.
fn in_blocks(
    dimension: usize,
    count: usize,
    seed: u64,
    draw: impl Fn(&mut ChaCha8Rng, &mut Vec<f64>) -> Result<()> + Sync,
) -> Result<States> {
    let blocks = parallel::map(count.div_ceil(BLOCK), |block| {
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        stream.set_stream(block as u64);
        let size = BLOCK.min(count - block * BLOCK);
        let mut drawn = Vec::with_capacity(dimension * size);
        (0..size).try_for_each(|_| draw(&mut stream, &mut drawn))?;
        Ok(drawn)
    });
    Ok(States::from_values(dimension, blocks.into_iter().collect::<Result<Vec<_>>>()?.concat()))
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

/// A cell, the highest and the lowest density met on it, and that at its centre.
#[derive(Clone, Debug)]
struct CellExtremes {
    cell: Cell,
    highest: f64,
    lowest: f64,
    centre: f64,
    /// Whether a singularity of the density is cut off at `highest`.
    capped: bool,
}

impl CellExtremes {
    /// Evaluates the density at corners, middles of sides and centre.
    fn new(density: &dyn Density, cell: Cell) -> Result<Self> {
        let states = density.dimension();
        let centre = density.pdf(&cell.at(&vec![0.5; states]))?.value.max(0.0);
        let mut piece = CellExtremes { cell, highest: 0.0, lowest: f64::INFINITY, centre, capped: false };
        for k in 0..3_usize.pow(states as u32) {
            let shares: Vec<f64> = (0..states).map(|i| (k / 3_usize.pow(i as u32) % 3) as f64 / 2.0).collect();
            let p = density.pdf(&piece.cell.at(&shares))?.value.max(0.0);
            (piece.highest, piece.lowest) = (piece.highest.max(p), piece.lowest.min(p));
        }
        Ok(piece)
    }

    fn mass(&self) -> f64 {
        self.highest * self.cell.volume()
    }
}

/// Cells on which the density varies little.
fn pieces(density: &dyn Density) -> Result<Vec<CellExtremes>> {
    let of = |cells: Vec<Cell>| -> Result<Vec<CellExtremes>> {
        parallel::map_into(cells, |_, cell| CellExtremes::new(density, cell)).into_iter().collect()
    };
    let mut pieces = of(Cell::between(&cell_lines(&density.bounds(), CELLS, |_| Vec::new())))?;
    // Not by the highest values, of which one may be infinite.
    let total = |pieces: &[CellExtremes]| pieces.iter().map(|piece| piece.centre * piece.cell.volume()).sum::<f64>();
    for _ in 0..HALVINGS {
        let total = total(&pieces);
        let (uneven, even): (Vec<_>, Vec<_>) =
            pieces.into_iter().partition(|piece| piece.mass() > SHARE * total && piece.highest > UNEVEN * piece.lowest);
        pieces = even;
        if uneven.is_empty() {
            break;
        }
        pieces.extend(of(uneven.iter().flat_map(|piece| piece.cell.children()).collect())?);
    }
    let total = total(&pieces);
    for piece in &mut pieces {
        if piece.mass() > SHARE * total && piece.highest > SINGULAR * piece.centre {
            (piece.highest, piece.capped) = (SINGULAR * piece.centre, true);
        }
    }
    pieces.retain(|piece| piece.highest > 0.0 && piece.highest.is_finite());
    Ok(pieces)
}

fn by_rejection(density: &dyn Density, count: usize, seed: u64) -> Result<States> {
    let remedy = "it is too uneven to draw from, or infinite somewhere";
    let bound = "an upper bound of its values";
    let too_low = Error::NotKnown { what: bound.into(), remedy };
    let too_uneven = Error::NotKnown { what: "where most of its mass is".into(), remedy };
    let pieces = pieces(density)?;
    if pieces.is_empty() {
        return Err(unknown_values());
    }
    let dimension = density.dimension();
    let cumulative = cumulated(pieces.iter().map(CellExtremes::mass));
    let mut margin = MARGIN;
    for _ in 0..ATTEMPTS {
        let draw = |stream: &mut ChaCha8Rng, drawn: &mut Vec<f64>| {
            for _ in 0..TRIALS {
                let piece = &pieces[chosen(&cumulative, stream.random())];
                let shares: Vec<f64> = (0..dimension).map(|_| stream.random()).collect();
                let x = piece.cell.at(&shares);
                let (p, envelope) = (density.pdf(&x)?.value, margin * piece.highest);
                // NaN is no bound either.
                if p.is_nan() || p > envelope && !piece.capped {
                    return Err(too_low.clone());
                }
                if stream.random::<f64>() * envelope < p {
                    drawn.extend(x);
                    return Ok(());
                }
            }
            Err(too_uneven.clone())
        };
        match in_blocks(dimension, count, seed, draw) {
            Err(Error::NotKnown { what, .. }) if what == bound => margin *= 1.5,
            answer => return answer,
        }
    }
    Err(too_low)
}

/// States from a normal density with the density's mean and covariance, weighted.
fn proposed(density: &dyn Density, seed: u64) -> Result<(States, Vec<f64>)> {
    let n = density.dimension();
    let mut mean = DVector::zeros(n);
    for i in 0..n {
        mean[i] = density.moment(&of_one(n, i, 1))?.value;
    }
    let mut covariance = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            let powers: Vec<u32> = (0..n).map(|k| u32::from(k == i) + u32::from(k == j)).collect();
            covariance[(i, j)] = density.moment(&powers)?.value - mean[i] * mean[j];
        }
    }
    let lower = Cholesky::new(covariance).ok_or_else(unknown_values)?.l() * WIDENED;
    // Streams of its own, so that the draws from these states are independent of them.
    let normals = in_blocks(n, DRAWS, seed ^ 0x9e37_79b9_7f4a_7c15, |stream, drawn| {
        drawn.extend((0..n).map(|_| stream.sample::<f64, _>(StandardNormal)));
        Ok(())
    })?;
    let weighted = parallel::map(normals.len(), |k| {
        let z = DVector::from_column_slice(normals.state(k));
        let x: Vec<f64> = (&mean + &lower * &z).iter().copied().collect();
        let log = density.log_pdf(&x)? + z.norm_squared() / 2.0;
        Ok((x, log))
    });
    let weighted = weighted.into_iter().collect::<Result<Vec<(Vec<f64>, f64)>>>()?;
    let top = weighted.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
    let weights = weighted.iter().map(|(_, log)| (log - top).exp()).collect();
    Ok((States::from_values(n, weighted.into_iter().flat_map(|(x, _)| x).collect()), weights))
}

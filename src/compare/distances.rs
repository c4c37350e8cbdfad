use crate::checks::dimension;
use crate::density::{Cell, Density, cell_lines};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::parallel;
use std::sync::atomic::{AtomicU64, Ordering};

/// Cells along each state to begin with.
const CELLS: usize = 8;
/// Cells are halved until their errors together are below this,
const TOLERANCE: f64 = 1e-10;
/// or there are so many of them.
const MOST_CELLS: usize = 1500;
/// Gauss nodes along each side of a cell, and those that the error is estimated with.
const NODES: [usize; 2] = [8, 5];

/// Distances between two densities p and q, q being the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// ∫ |p − q| dx, between 0 and 2: twice the largest difference of the probabilities of any event.
    pub l1: Estimate,
    /// Hellinger's distance √(½ ∫ (√p − √q)² dx), between 0 and 1.
    pub hellinger: Estimate,
    /// Kullback's and Leibler's divergence ∫ p ln(p/q) dx, in nats; computed as ∫ (p ln(p/q) − p + q) dx, whose integrand
    /// is nowhere negative.
    pub kullback_leibler: Estimate,
}

/// The distances of `density` from `reference`.
///
/// In one state and in two they are integrals over both densities' bounds, on cells that are halved where the integrands are
/// rough; values below zero, as a grid has them, count as 0. In more they are averages over the nodes of the density that has
/// them, the first one if both have; mass of the other outside the nodes is added. Where a reference differs from 0 by less
/// than its error, the divergence takes the value within that error that is closest to p.
///
/// # Errors
/// [`Error::Dimension`](crate::Error::Dimension) for densities of different numbers of states;
/// [`Error::NotKnown`](crate::Error::NotKnown) if neither has averages, as simulations of more than two states.
///
/// # Reference
/// S. Kullback and R. A. Leibler, On information and sufficiency, Annals of Mathematical Statistics 22 (1951) 79-86,
/// doi:10.1214/aoms/1177729694.
///
/// ```
/// use expoly::{compare, models::{Linear, Solved}};
/// let [one, two] = [0.5, 0.6].map(|d| Linear::new(0.5, 1.0, d).and_then(|system| system.exact()));
/// let found = compare::distances(&one?, &two?)?;
/// // Two normal densities of two states with variances 1 and 1.2.
/// assert!((found.hellinger.value.powi(2) - (1.0 - 2.0 * 1.2_f64.sqrt() / 2.2)).abs() < 1e-10);
/// assert!((found.kullback_leibler.value - (1.0 / 1.2 - 1.0 + 1.2_f64.ln())).abs() < 1e-10);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn distances(density: &dyn Density, reference: &dyn Density) -> Result<Distances> {
    let [l1, half_square, kullback_leibler] = if of_one_dimension(density, reference)? <= 2 {
        over_cells(density, reference)?
    } else {
        [over_nodes(density, reference, 0)?, over_nodes(density, reference, 1)?, over_nodes(density, reference, 2)?]
    };
    let root = half_square.value.max(0.0).sqrt();
    // √(h² + δ) − h, which is √δ where h vanishes.
    let moved = (half_square.value.max(0.0) + half_square.error).sqrt() - root;
    Ok(Distances { l1, hellinger: Estimate::new(root, moved), kullback_leibler })
}

/// The joint distance ∫ |p − q| dx of `density` from `reference`, as [`distances`] has it.
///
/// # Errors
/// As [`distances`].
///
/// ```
/// use expoly::{Closure, compare, models::{Duffing, Solved}};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let closed = Closure::classical(4).solve(&duffing.problem()?)?.density()?;
/// assert!(compare::l1(&closed, &duffing.exact()?)?.value < 1e-10);
/// # Ok::<(), expoly::Error>(())
/// ```
pub fn l1(density: &dyn Density, reference: &dyn Density) -> Result<Estimate> {
    if of_one_dimension(density, reference)? > 2 {
        return over_nodes(density, reference, 0);
    }
    let [l1, _, _] = over_cells(density, reference)?;
    Ok(l1)
}

/// The number of states of two densities, which must be the same.
pub(super) fn of_one_dimension(density: &dyn Density, reference: &dyn Density) -> Result<usize> {
    let states = density.dimension();
    dimension("a reference", reference.dimension(), states)?;
    Ok(states)
}

/// |p − q|, ½ (√p − √q)² and, with another value of q, p ln(p/q) − p + q.
fn integrands(p: f64, q: f64, raised: f64) -> [f64; 3] {
    if p.is_nan() || q.is_nan() {
        return [f64::NAN; 3];
    }
    let positive = p.max(0.0);
    let divergence = match () {
        () if positive == 0.0 => raised.max(0.0),
        () if raised <= 0.0 => f64::INFINITY,
        // With t = q/p − 1 this is p (t − ln(1 + t)), which loses nothing where p and q are close.
        () => {
            let t = (raised - positive) / positive;
            positive * (t - t.ln_1p())
        }
    };
    [(p - q).abs(), 0.5 * (positive.sqrt() - q.max(0.0).sqrt()).powi(2), divergence]
}

/// The integrands, and how far they move with the reference's error.
fn with_errors(p: f64, q: Estimate) -> [Estimate; 3] {
    let (low, high) = (q.value - q.error, q.value + q.error);
    // A reference that does not differ from 0 by more than its error takes the value of p, as far as the error allows.
    let raised = if 2.0 * q.error < q.value {
        [low, q.value, high]
    } else {
        let (least, most) = (0.5 * q.error, high.max(q.error));
        [least, p.max(least).min(most), most]
    };
    let [below, here, above] =
        [(low, raised[0]), (q.value, raised[1]), (high, raised[2])].map(|(q, raised)| integrands(p, q, raised));
    std::array::from_fn(|k| Estimate::new(here[k], (below[k] - here[k]).abs().max((above[k] - here[k]).abs())))
}

/// The integrals over a cell by both rules, and of the errors.
#[derive(Clone, Debug)]
struct CellIntegrals {
    cell: Cell,
    value: [f64; 3],
    stated: [f64; 3],
    /// The difference of the two rules.
    change: [f64; 3],
}

impl CellIntegrals {
    fn new(cell: Cell, rules: &[Rule; 2], values: &impl Fn(&[f64]) -> Result<[Estimate; 3]>) -> Result<Self> {
        let states = cell.limits.len();
        let sums_by = |rule: &Rule| -> Result<[Estimate; 3]> {
            let count = rule.nodes.len();
            let mut sums = [Estimate::new(0.0, 0.0); 3];
            let mut shares = vec![0.0; states];
            for k in 0..count.pow(states as u32) {
                let mut weight = 1.0;
                for (i, share) in shares.iter_mut().enumerate() {
                    let node = k / count.pow(i as u32) % count;
                    *share = (rule.nodes[node] + 1.0) / 2.0;
                    weight *= rule.weights[node] / 2.0;
                }
                weight *= cell.volume();
                for (sum, value) in sums.iter_mut().zip(values(&cell.at(&shares))?) {
                    *sum = Estimate::new(sum.value + weight * value.value, sum.error + weight * value.error);
                }
            }
            Ok(sums)
        };
        let (fine, coarse) = (sums_by(&rules[0])?, sums_by(&rules[1])?);
        Ok(CellIntegrals {
            cell,
            value: fine.map(|sum| sum.value),
            stated: fine.map(|sum| sum.error),
            change: std::array::from_fn(|k| (fine[k].value - coarse[k].value).abs()),
        })
    }

    /// The priority of halving the cell: none where the reference's own error is larger than the change.
    fn roughness(&self) -> f64 {
        (0..3).map(|k| (self.change[k] - 0.01 * self.stated[k]).max(0.0)).fold(0.0, f64::max)
    }
}

fn over_cells(density: &dyn Density, reference: &dyn Density) -> Result<[Estimate; 3]> {
    let (ours, theirs) = (density.bounds(), reference.bounds());
    let both = |(a, b): (&[f64; 2], &[f64; 2])| [a[0].min(b[0]), a[1].max(b[1])];
    let bounds: Vec<[f64; 2]> = ours.iter().zip(&theirs).map(both).collect();
    let through = |i: usize| [ours[i], theirs[i]].concat();
    let rules = NODES.map(Rule::legendre);
    let values = |x: &[f64]| -> Result<[Estimate; 3]> { Ok(with_errors(density.log_pdf(x)?.exp(), reference.pdf(x)?)) };
    let of = |cells: Vec<Cell>| -> Result<Vec<CellIntegrals>> {
        parallel::map_into(cells, |_, cell| CellIntegrals::new(cell, &rules, &values)).into_iter().collect()
    };
    let mut pieces = of(Cell::between(&cell_lines(&bounds, CELLS, through)))?;
    loop {
        let total: f64 = pieces.iter().map(CellIntegrals::roughness).sum();
        if !(total > TOLERANCE && total.is_finite()) || pieces.len() >= MOST_CELLS {
            break;
        }
        let mean = total / pieces.len() as f64;
        let (rough, smooth): (Vec<_>, Vec<_>) = pieces.into_iter().partition(|piece| piece.roughness() >= mean);
        pieces = smooth;
        pieces.extend(of(rough.iter().flat_map(|piece| piece.cell.children()).collect())?);
    }
    Ok(std::array::from_fn(|k| {
        let sum = |part: fn(&CellIntegrals) -> &[f64; 3]| pieces.iter().map(|piece| part(piece)[k]).sum::<f64>();
        Estimate::new(sum(|piece| &piece.value), sum(|piece| &piece.stated) + sum(|piece| &piece.change))
    }))
}

/// A reference whose relative error is below this at all nodes needs no mean of its errors.
const EXACT: f64 = 1e-9;

/// One of the integrals as a mean under the density, or under the reference if only that has means.
fn over_nodes(density: &dyn Density, reference: &dyn Density, which: usize) -> Result<Estimate> {
    let mean_under = |under_density: bool| -> Result<Estimate> {
        // The largest relative error of the reference; for numbers that are not negative, bits are in their order.
        let worst = AtomicU64::new(0);
        // p and q relative to the density that the nodes belong to.
        let relative = |x: &[f64]| {
            let nothing = (f64::NAN, Estimate::new(f64::NAN, f64::INFINITY));
            let (Ok(p), Ok(q), Ok(log)) = (density.log_pdf(x), reference.pdf(x), reference.log_pdf(x)) else {
                return nothing;
            };
            let spread = if q.value > 0.0 { q.error / q.value } else { 0.0 };
            worst.fetch_max(spread.to_bits(), Ordering::Relaxed);
            let q = if q.value > 0.0 { q.value.ln() } else { log };
            let scale = if under_density { p } else { q };
            if scale == f64::NEG_INFINITY {
                // A grid has values below zero; they count as 0, and nothing is under them.
                return (1.0, Estimate::exact(1.0));
            }
            let q = (q - scale).exp();
            ((p - scale).exp(), Estimate::new(q, q * spread))
        };
        let base = if under_density { density } else { reference };
        let ratio = |x: &[f64]| {
            let (p, q) = relative(x);
            if under_density { q.value } else { p }
        };
        let mean = match which {
            // Both have the mass 1: ∫ |p − q| dx = 2 ∫ (p − q)₊ dx, which needs nothing beyond the nodes.
            0 => base.expectation(&|x| {
                let ratio = ratio(x);
                // A ratio that is NaN remains NaN.
                if ratio > 1.0 { 0.0 } else { 2.0 * (1.0 - ratio) }
            })?,
            _ => base.expectation(&|x| {
                let (p, q) = relative(x);
                with_errors(p, q)[which].value
            })?,
        };
        let worst = f64::from_bits(worst.load(Ordering::Relaxed));
        let stated = if worst < EXACT {
            worst
        } else {
            let error = |x: &[f64]| {
                let (p, q) = relative(x);
                with_errors(p, q)[which].error
            };
            base.expectation(&error)?.value
        };
        // The mass of the other density where there are no nodes counts in full, or by half; where only the reference has
        // nodes, p ln p beyond them is not known. The error of the sampled mean may be less than the missing mass.
        let share = match which {
            0 => return Ok(Estimate::new(mean.value, mean.error + stated)),
            1 => 0.5,
            _ => f64::from(u8::from(under_density)),
        };
        let covered = base.expectation(&ratio)?;
        let missing = share * (1.0 - covered.value).max(0.0);
        Ok(Estimate::new(mean.value + missing, mean.error + stated + share * covered.error))
    };
    mean_under(true).or_else(|_| mean_under(false))
}

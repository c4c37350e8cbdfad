//! The most likely exponential polynomial with given means, by integrals over draws.

use super::nodes::SampleNodes;
use super::wall_nodes::WallNodes;
use crate::estimate::Estimate;
use crate::functions::{Corner, Functions, Scratch};
use crate::numerics::{Concave, EIGHT, Eight, Search, exponentials};
use crate::parallel;
use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};

/// Draws in a block: its tables stay in a core's cache.
pub(super) const BLOCK: usize = 512;
/// Rows of a table of functions at the draws of a block: the same rows of all columns are written one after the other, and
/// columns a power of two apart would fall onto the same few lines of the cache.
pub(super) const ROWS: usize = BLOCK + EIGHT;
/// Matrices that are summed side by side hold about so many numbers together.
pub(super) const ROOM: usize = 30_000_000;

/// One of the runs of `length` masses, the last one perhaps shorter.
pub(super) fn run_of(masses: &[f64], length: usize, run: usize) -> &[f64] {
    &masses[run * length..masses.len().min((run + 1) * length)]
}

/// Q = Σ a_k φ_k, with the mass of exp(Q) at each draw.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// Constant first, which is zero.
    pub(super) a: Vec<f64>,
    /// The share of the draws that independent draws from exp(Q) itself would need.
    pub(super) effective: f64,
    pub(super) steps: usize,
    /// Whether the search came to its end, and the step that would come next, in standard deviations of ln p.
    pub(super) converged: bool,
    pub(super) next: f64,
    /// The mass of each draw.
    pub(super) masses: Vec<f64>,
}

/// Functions on draws.
#[derive(Clone, Copy, Debug)]
pub(super) struct Likelihood<'a> {
    pub(super) nodes: &'a SampleNodes,
    pub(super) space: &'a Functions,
    /// The walls, and the nodes on each of them.
    pub(super) corners: &'a [Corner],
    pub(super) walls: &'a [WallNodes],
}

impl Likelihood<'_> {
    /// The most likely density whose functions have the `means`, the constant left out: a·m − ln ∫ exp(Q) is concave. None
    /// where integrals are not finite.
    pub(super) fn most_likely(&self, means: &[f64], start: Vec<f64>, search: Search) -> Option<Fit> {
        if self.nodes.thin {
            return self.most_likely_in_frames(means, start, search);
        }
        let summit = search.ascend(&Towards { likelihood: self, means }, start[1..].to_vec(), None)?;
        let (steps, converged, next, masses) = (summit.steps, summit.converged, summit.next, summit.at);
        Some(Fit { a: with_constant(&summit.a), effective: effective(&masses), steps, converged, next, masses })
    }

    /// E|δ| of the first-order change δ of ln p that a change of the means makes.
    pub(super) fn change(&self, fit: &Fit, means: [&[f64]; 2]) -> Option<f64> {
        let found = self.means(&fit.masses);
        let difference: Vec<f64> = means[0].iter().zip(means[1]).map(|(one, other)| one - other).collect();
        let step = if self.nodes.thin {
            self.change_in_frame(&fit.masses, &difference)?
        } else {
            let right = Mat::from_fn(found.len(), 1, |k, _| difference[k]);
            self.curvature(&fit.masses, &found)?.solve(&right).col_as_slice(0).to_vec()
        };
        let constant: f64 = step.iter().zip(&found).map(|(step, mean)| step * mean).sum();
        let change: Vec<f64> = std::iter::once(-constant).chain(step).collect();
        Some(self.mean_size(&change, &fit.masses))
    }

    /// E|Σ a_k φ_k|, the constant first.
    pub(super) fn mean_size(&self, a: &[f64], masses: &[f64]) -> f64 {
        let part = |block: usize| {
            let (p, mut sum) = (run_of(masses, BLOCK, block), 0.0);
            self.each(block * BLOCK, p.len(), &mut Scratch::default(), |at, count, scratch| {
                let delta = self.combined(a, scratch);
                sum += (0..count).map(|l| p[at + l] * delta[l].abs()).sum::<f64>();
            });
            sum
        };
        parallel::map(masses.len().div_ceil(BLOCK), part).iter().sum()
    }

    /// Q at each draw, the constant first.
    pub(super) fn combination(&self, a: &[f64]) -> Vec<f64> {
        let mut q = vec![0.0; self.nodes.base.len()];
        parallel::on_runs(&mut q, BLOCK, |block, q| {
            self.each(block * BLOCK, q.len(), &mut Scratch::default(), |at, count, scratch| {
                q[at..at + count].copy_from_slice(&self.combined(a, scratch).0[..count]);
            });
        });
        q
    }

    /// ln ∫ exp(Q), and the mass of each draw, for Q at each draw. None where exp(Q) has no finite integral.
    pub(super) fn integral(&self, q: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut masses: Vec<f64> = q.iter().zip(&self.nodes.base).map(|(q, base)| q + base).collect();
        let top = masses.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        parallel::on_runs(&mut masses, BLOCK, |_, masses| {
            masses.iter_mut().for_each(|q| *q -= top);
            exponentials(masses);
        });
        let sum: f64 = masses.iter().sum();
        masses.iter_mut().for_each(|p| *p /= sum);
        let integral = sum.ln() + top;
        integral.is_finite().then_some((integral, masses))
    }

    /// ln ∫ exp(Q), where the mass of each draw is known, from the heaviest of them.
    pub(super) fn log_mass_by(&self, a: &[f64], masses: &[f64]) -> f64 {
        let heaviest = (0..masses.len()).max_by(|i, k| masses[*i].total_cmp(&masses[*k])).unwrap_or(0);
        let mut q = Eight::ZERO;
        self.each(heaviest, 1, &mut Scratch::default(), |_, _, scratch| q = self.combined(a, scratch));
        q[0] + self.nodes.base[heaviest] - masses[heaviest].ln()
    }

    /// The mass of each draw. None where exp(Q) has no finite integral.
    pub(super) fn masses(&self, a: &[f64]) -> Option<Vec<f64>> {
        Some(self.integral(&self.combination(a))?.1)
    }

    /// E φ_k, the constant left out.
    pub(super) fn means(&self, masses: &[f64]) -> Vec<f64> {
        let size = self.space.len();
        let part = |block: usize| {
            let (p, mut sums) = (run_of(masses, BLOCK, block), vec![Eight::ZERO; size]);
            self.each(block * BLOCK, p.len(), &mut Scratch::default(), |at, count, scratch| {
                let p = lane(&p[at..at + count]);
                for (k, sum) in sums.iter_mut().enumerate() {
                    let value = self.space.value(scratch, k + 1);
                    *sum += p * value;
                }
            });
            sums.iter().map(|sum| sum.0.iter().sum()).collect()
        };
        let parts: Vec<Vec<f64>> = parallel::map(masses.len().div_ceil(BLOCK), part);
        let mut sums = vec![0.0; size];
        parts.iter().for_each(|part| sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part));
        sums
    }

    /// ln ∫ exp(Q) dx, where the nodes' weights are volumes.
    pub(super) fn log_mass(&self, fit: &Fit) -> Option<Estimate> {
        let zeros = vec![0.0; self.space.len()];
        let (integral, _) = self.integral(&self.combination(&fit.a))?;
        let parts = self.parts(&fit.masses, &zeros);
        let count = parts.len() as f64;
        let square: f64 = parts.iter().map(|part| (count * part.mass - 1.0).powi(2)).sum();
        Some(Estimate::new(integral, (square / count / (count - 1.0)).sqrt()))
    }

    /// Q at the points placed, the constant first among its coefficients.
    #[inline(always)]
    pub(super) fn combined(&self, a: &[f64], scratch: &Scratch<Eight>) -> Eight {
        self.space.sum(&a[1..], scratch) + a[0]
    }

    /// Places the functions at `count` draws from `first` on, eight at a time: the place of the first of them, and their
    /// number.
    pub(super) fn each(
        &self,
        first: usize,
        count: usize,
        scratch: &mut Scratch<Eight>,
        mut visit: impl FnMut(usize, usize, &Scratch<Eight>),
    ) {
        let n = self.space.dimension();
        let mut lanes = vec![Eight::ZERO; n];
        for at in (0..count).step_by(EIGHT) {
            let used = EIGHT.min(count - at);
            for l in 0..EIGHT {
                let x = self.nodes.points.state(first + at + l.min(used - 1));
                lanes.iter_mut().zip(x).for_each(|(lane, x)| lane[l] = *x);
            }
            self.space.place_values(&lanes, scratch);
            visit(at, used, scratch);
        }
    }
}

/// The likelihood of means, without the constant function.
struct Towards<'a> {
    likelihood: &'a Likelihood<'a>,
    means: &'a [f64],
}

/// Coefficients with that of the constant function, zero, before them.
pub(super) fn with_constant(a: &[f64]) -> Vec<f64> {
    std::iter::once(0.0).chain(a.iter().copied()).collect()
}

impl Concave for Towards<'_> {
    /// The mass of each draw.
    type At = Vec<f64>;

    fn combination(&self, a: &[f64]) -> Vec<f64> {
        self.likelihood.combination(&with_constant(a))
    }

    fn value(&self, a: &[f64], combination: &[f64]) -> Option<(f64, Vec<f64>)> {
        let (integral, masses) = self.likelihood.integral(combination)?;
        let along: f64 = a.iter().zip(self.means).map(|(a, m)| a * m).sum();
        Some((along - integral, masses)).filter(|(value, _)| value.is_finite())
    }

    fn gradient(&self, masses: &Vec<f64>) -> Vec<f64> {
        self.means.iter().zip(self.likelihood.means(masses)).map(|(wanted, found)| wanted - found).collect()
    }

    fn curvature(&self, masses: &Vec<f64>, gradient: &[f64]) -> Option<Llt<f64>> {
        let found: Vec<f64> = self.means.iter().zip(gradient).map(|(wanted, g)| wanted - g).collect();
        self.likelihood.curvature(masses, &found)
    }
}

/// At most eight numbers, and zeros in place of those that are missing.
pub(super) fn lane(values: &[f64]) -> Eight {
    let mut lane = Eight::ZERO;
    lane.0[..values.len()].copy_from_slice(values);
    lane
}

/// The share of the draws that as many independent ones would be worth.
pub(super) fn effective(masses: &[f64]) -> f64 {
    masses.iter().map(|p| p * p).sum::<f64>().recip() / masses.len() as f64
}

/// ∫ |p − q| dx of two densities by their masses on the same draws.
pub(super) fn distance(p: &[f64], q: &[f64]) -> f64 {
    p.iter().zip(q).map(|(p, q)| (p - q).abs()).sum()
}

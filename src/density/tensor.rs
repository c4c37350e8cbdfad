//! Integrals of exp(Q) over R^N, a half space, or a section of either.
//!
//! In the scaled coordinates exp(Q) is an analytic function of ordinary width, for which Gauss rules converge
//! geometrically. Up to two states, and on a half space, Gauss-Legendre rules cover a box outside of which exp(Q) is
//! below e^−50 of its maximum. In more states that is too many nodes; there exp(Q + z²/2) is integrated by Gauss-Hermite
//! rules, which take few nodes for a direction in which the density is normal. Each axis is refined on its own until the
//! integral stops changing. Three nodes at least make means of fourth powers right.

use super::{Crossing, Support};
use crate::error::{Error, Result};
use crate::numerics::Rule;
use crate::polynomial::{Frame, Polynomial};
use std::sync::OnceLock;

/// exp(Q) is neglected where it is below e^−50 = 2e-22 of its maximum.
const DEPTH: f64 = 50.0;
/// An axis is fine enough when a refinement changes ln ∫exp(Q) by less.
const TOLERANCE: f64 = 1e-13;
/// Nodes of a rule at most: about a second of work.
const MAX_NODES: usize = 4_000_000;
/// The size of a rule up to which every axis is made finer than the mass needs.
const CHEAP: usize = 20_000;
/// Grid lines per axis of the search for the box.
const GRID: usize = 61;
/// A box this wide, in units of the Gaussian closure's standard deviation, means that the mass never ends.
const TOO_WIDE: f64 = 1e4;

/// The rule along one axis.
#[derive(Clone, Debug)]
struct TensorAxis {
    low: f64,
    high: f64,
    hermite: bool,
    /// Pairs (z, weight) of ∫ … dz.
    nodes: Vec<(f64, f64)>,
    /// The rule on [−1, 1] for one sign of the state, made when it is first needed.
    signed: OnceLock<Rule>,
}

impl TensorAxis {
    fn new(low: f64, high: f64, hermite: bool, count: usize) -> Self {
        let nodes = if hermite {
            let density = |z: f64| (-z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
            Rule::hermite(count).iter().map(|(z, w)| (z, w / density(z))).collect()
        } else {
            Rule::legendre(count).on(low, high).iter().collect()
        };
        TensorAxis { low, high, hermite, nodes, signed: OnceLock::new() }
    }

    fn refined(&self) -> Self {
        TensorAxis::new(self.low, self.high, self.hermite, (self.nodes.len() * 3).div_ceil(2))
    }

    fn count(&self) -> usize {
        self.nodes.len()
    }
}

/// The part of the space that an integral runs over, in terms of the states.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Section {
    /// States held at values.
    pub(super) fixed: [Option<(usize, f64)>; 2],
    /// A state of one sign: true for positive.
    pub(super) sign: Option<(usize, bool)>,
}

impl Section {
    pub(super) fn at(state: usize, value: f64) -> Self {
        Section { fixed: [Some((state, value)), None], sign: None }
    }

    pub(super) fn at_pair(states: [usize; 2], values: [f64; 2]) -> Self {
        Section { fixed: [0, 1].map(|k| Some((states[k], values[k]))), sign: None }
    }

    /// The value at which a state is held.
    fn held(&self, state: usize) -> Option<f64> {
        self.fixed.iter().flatten().find(|(held, _)| *held == state).map(|(_, value)| *value)
    }

    /// The sign that a state has.
    fn sign_of(&self, state: usize) -> Option<bool> {
        self.sign.filter(|(signed, _)| *signed == state).map(|(_, positive)| positive)
    }

    pub(super) fn crossing(crossing: Crossing) -> Self {
        Section {
            fixed: [Some((crossing.displacement, crossing.level)), None],
            sign: Some((crossing.velocity, crossing.upward)),
        }
    }
}

/// A tensor rule in scaled coordinates, fine enough for exp(Q).
#[derive(Clone, Debug)]
pub(super) struct TensorRule {
    axes: Vec<TensorAxis>,
    /// Q at the highest point of the search for the box; exp(Q) is scaled by it.
    pub(super) top: f64,
}

impl TensorRule {
    /// Two rules for exp(Q) on `support`: the second is fine enough, the first is
    /// finer still on every axis that needed refinement, and their difference estimates the error of the second.
    ///
    /// # Errors
    /// [`Error::NotNormalisable`] if the mass never ends, [`Error::NotServed`] if the grid that searches for its end has too
    /// many points.
    pub(super) fn fitted(q: &Polynomial, frame: &Frame, support: &Support) -> Result<(Self, Self)> {
        let n = frame.dimension();
        let hermite = n > 2 && *support == Support::WholeSpace;
        let (bounds, top) = match support {
            Support::WholeSpace if hermite => {
                // The widest box that a half line of a Gauss-Hermite axis can need.
                let reach = (2.0 * DEPTH).sqrt();
                (vec![(-reach, reach); n], q.evaluate(&vec![0.0; n]))
            }
            Support::WholeSpace => bounding_box(q, None)?,
            Support::Above(bound) => bounding_box(q, Some((bound - frame.origin()[0]) / frame.scale()[(0, 0)]))?,
            Support::Region(limits) => {
                let corner = |side: usize| frame.coordinates(&limits.iter().map(|ends| ends[side]).collect::<Vec<_>>());
                let bounds: Vec<(f64, f64)> = corner(0).into_iter().zip(corner(1)).collect();
                let top = occupied_cells(q, &bounds)?.1;
                (bounds, top)
            }
        };
        let count = if hermite { 3 } else { 24 };
        let mut rule = TensorRule {
            axes: bounds.into_iter().map(|(low, high)| TensorAxis::new(low, high, hermite, count)).collect(),
            top,
        };
        let mass = |rule: &Self| rule.integrate(q, frame, Section::default(), |_| 1.0).ln();
        let first = rule.clone();
        let mut last = mass(&rule);
        loop {
            let mut changed = false;
            for d in 0..n {
                let mut finer = rule.clone();
                finer.axes[d] = rule.axes[d].refined();
                if finer.size() > MAX_NODES {
                    continue;
                }
                let next = mass(&finer);
                // An axis that is fine enough already keeps the coarser rule.
                if (next - last).abs() >= TOLERANCE * last.abs().max(1.0) {
                    (rule, last, changed) = (finer, next, true);
                }
            }
            if !changed {
                break;
            }
        }
        let mut finer = rule.clone();
        for d in 0..n {
            let needed = rule.axes[d].count() > first.axes[d].count();
            // An axis that is fine enough for the mass may not be so for a mean.
            let most = if needed { MAX_NODES } else { CHEAP };
            if (needed || hermite) && finer.size() / rule.axes[d].count() * rule.axes[d].refined().count() <= most {
                finer.axes[d] = rule.axes[d].refined();
            }
        }
        Ok((finer, rule))
    }

    /// The box that the rule covers, in the states: the smallest with sides along the states that holds the box in z.
    pub(super) fn bounds(&self, frame: &Frame) -> Vec<[f64; 2]> {
        let side = |i: usize| {
            let mut bounds = [frame.origin()[i]; 2];
            for (j, axis) in self.axes.iter().enumerate().take(i + 1) {
                let ends = [axis.low, axis.high].map(|z| frame.scale()[(i, j)] * z);
                bounds[0] += ends[0].min(ends[1]);
                bounds[1] += ends[0].max(ends[1]);
            }
            bounds
        };
        (0..frame.dimension()).map(side).collect()
    }

    fn size(&self) -> usize {
        self.axes.iter().map(TensorAxis::count).product()
    }

    /// ∫ g(x) exp(Q − top) dz over a section. Where a state is held, the result is a density in that state.
    pub(super) fn integrate(
        &self,
        q: &Polynomial,
        frame: &Frame,
        section: Section,
        mut g: impl FnMut(&[f64]) -> f64,
    ) -> f64 {
        let mut z = vec![0.0; frame.dimension()];
        let mut x = z.clone();
        self.sum_from(0, &mut z, &mut x, frame, section, &mut |z, x| {
            let p = (q.evaluate(z) - self.top).exp();
            if p == 0.0 { 0.0 } else { p * g(x) }
        })
    }

    /// The sum over axis `d` and all after it. L is triangular, so that a state is determined by its own coordinate and those
    /// before it.
    fn sum_from(
        &self,
        d: usize,
        z: &mut [f64],
        x: &mut [f64],
        frame: &Frame,
        section: Section,
        g: &mut impl FnMut(&[f64], &[f64]) -> f64,
    ) -> f64 {
        if d == x.len() {
            return g(z, x);
        }
        let scale = frame.scale();
        let shift = frame.origin()[d] + (0..d).map(|j| scale[(d, j)] * z[j]).sum::<f64>();
        let width = scale[(d, d)];
        let mut step = |z: &mut [f64], x: &mut [f64], value: f64, weight: f64| {
            z[d] = value;
            x[d] = shift + width * value;
            weight * self.sum_from(d + 1, z, x, frame, section, g)
        };
        match (section.held(d), section.sign_of(d)) {
            (Some(value), _) => step(z, x, (value - shift) / width, width.recip()),
            (None, Some(positive)) => {
                let axis = &self.axes[d];
                let zero = (-shift / width).clamp(axis.low, axis.high);
                let (low, high) = if positive { (zero, axis.high) } else { (axis.low, zero) };
                let rule = axis.signed.get_or_init(|| Rule::legendre(axis.nodes.len().max(32))).on(low, high);
                rule.iter().map(|(value, weight)| step(z, x, value, weight)).sum()
            }
            (None, None) => self.axes[d].nodes.iter().map(|&(value, weight)| step(z, x, value, weight)).sum(),
        }
    }
}

/// The box outside of which exp(Q) is negligible, and the largest Q on it.
fn bounding_box(q: &Polynomial, wall: Option<f64>) -> Result<(Vec<(f64, f64)>, f64)> {
    let n = q.dimension();
    let mut bounds = vec![(-6.0, 6.0); n];
    if let Some(wall) = wall {
        bounds[0] = (wall, wall + 12.0);
    }
    let mut top = occupied_cells(q, &bounds)?.1;
    // Outwards on every side that the mass reaches, until it reaches none.
    loop {
        let mut settled = true;
        for d in 0..n {
            let (low, high) = bounds[d];
            let grown = 0.5 * (high - low);
            let held = d == 0 && wall.is_some();
            let (from_low, from_high) = (face_maximum(q, &bounds, d, low), face_maximum(q, &bounds, d, high));
            top = top.max(from_low).max(from_high);
            let (below, above) = (!held && from_low > top - DEPTH, from_high > top - DEPTH);
            bounds[d] = (if below { low - grown } else { low }, if above { high + grown } else { high });
            settled &= !below && !above;
            if bounds[d].1 - bounds[d].0 >= TOO_WIDE {
                let direction = (0..n).map(|i| f64::from(i == d)).collect();
                return Err(Error::NotNormalisable { order: q.degree(), direction });
            }
        }
        if settled {
            break;
        }
    }
    // Inwards to where it begins, twice, since the second grid is finer.
    for _ in 0..2 {
        let (cells, highest) = occupied_cells(q, &bounds)?;
        top = top.max(highest);
        let full = bounds.clone();
        for (d, (first, last)) in cells.into_iter().enumerate() {
            let (low, high) = full[d];
            let width = (high - low) / (GRID - 1) as f64;
            let inner = (low + (first as f64 - 1.0) * width, low + (last as f64 + 1.0) * width);
            let free = |side: f64| face_maximum(q, &full, d, side) <= top - DEPTH;
            if first > 0 && free(inner.0) {
                bounds[d].0 = inner.0;
            }
            if last < GRID - 1 && free(inner.1) {
                bounds[d].1 = inner.1;
            }
        }
    }
    Ok((bounds, top))
}

/// The largest Q on the face z_`d` = `side` of a box. A ridge far out is narrow in exp(Q) but not in Q, a polynomial with
/// few extrema: the highest points of a coarse walk along the face, each refined, are enough.
fn face_maximum(q: &Polynomial, bounds: &[(f64, f64)], d: usize, side: f64) -> f64 {
    const STEPS: usize = 100;
    let mut point = vec![side; bounds.len()];
    let Some(other) = (0..bounds.len()).find(|&i| i != d) else { return q.evaluate(&point) };
    let (low, high) = bounds[other];
    // Along the diagonal of the face where it has more than one side.
    let mut value = |s: f64| {
        (0..point.len()).filter(|&i| i != d).for_each(|i| point[i] = low + s * (high - low));
        q.evaluate(&point)
    };
    let walk: Vec<f64> = (0..=STEPS).map(|k| value(k as f64 / STEPS as f64)).collect();
    let mut highest = walk[0].max(walk[STEPS]);
    for k in 1..STEPS {
        if walk[k] >= walk[k - 1] && walk[k] >= walk[k + 1] {
            let (mut left, mut right) = ((k - 1) as f64 / STEPS as f64, (k + 1) as f64 / STEPS as f64);
            for _ in 0..40 {
                let third = (right - left) / 3.0;
                if value(left + third) < value(right - third) { left += third } else { right -= third }
            }
            highest = highest.max(value((left + right) / 2.0));
        }
    }
    highest
}

/// The first and last grid line of each axis on which exp(Q) matters, and the largest Q on the grid.
///
/// # Errors
/// [`Error::NotServed`] where the grid has more points than a rule may have nodes.
fn occupied_cells(q: &Polynomial, bounds: &[(f64, f64)]) -> Result<(Vec<(usize, usize)>, f64)> {
    let n = bounds.len();
    let total = GRID.checked_pow(n as u32).filter(|total| *total <= 4 * MAX_NODES).ok_or(Error::NotServed {
        method: "quadrature on a half space or a region",
        what: "a density of more than four states",
        remedy: "only densities on the whole space are integrated in so many states",
    })?;
    let line = |k: usize, d: usize| k / GRID.pow(d as u32) % GRID;
    let mut point = vec![0.0; n];
    let mut value = |k: usize| {
        for (d, (low, high)) in bounds.iter().enumerate() {
            point[d] = low + line(k, d) as f64 * (high - low) / (GRID - 1) as f64;
        }
        q.evaluate(&point)
    };
    let values: Vec<f64> = (0..total).map(&mut value).collect();
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut cells = vec![(GRID - 1, 0); n];
    for k in (0..total).filter(|&k| values[k] > highest - DEPTH) {
        for (d, cell) in cells.iter_mut().enumerate() {
            *cell = (cell.0.min(line(k, d)), cell.1.max(line(k, d)));
        }
    }
    Ok((cells, highest))
}

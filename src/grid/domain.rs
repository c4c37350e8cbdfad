//! The domain that holds the density, found by a pilot simulation and then by the solution itself.

use super::field::Field;
use crate::error::Result;
use crate::grid::tuning;
use crate::numerics::Rule;
use crate::problem::{Problem, Wall};
use crate::simulation::Simulation;

/// The box that a short simulation finds to contain the density. Of the walls the simulation has the one below the motion
/// alone.
pub(super) fn pilot(problem: &Problem, walls: [Option<Wall>; 2]) -> Result<[[f64; 2]; 2]> {
    let free = problem.without_walls();
    let served = walls[0].map_or(Ok(free.clone()), |lower| free.with_wall(lower))?;
    let result = Simulation::new().trajectories(512).samples(51_200).run(&served)?;
    let mut limits = [[0.0; 2]; 2];
    for (state, limit) in limits.iter_mut().enumerate() {
        let histogram = result.histogram(state)?;
        let edges: Vec<f64> = histogram.edges(0).collect();
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for k in 0..histogram.len() {
            if histogram.bin(k)?.value > 0.0 {
                range = [range[0].min(edges[k]), range[1].max(edges[k + 1])];
            }
        }
        let middle = result.mean(state)?.value;
        *limit = range.map(|edge| middle + tuning::domain::WIDENING * (edge - middle));
    }
    // Without the wall above the motion the pilot may not have covered all of the domain below it.
    if let [None, Some(upper)] = walls {
        let [low, high] = limits[0];
        limits[0][0] = low.min(upper.offset() - (high - low) / 2.0);
    }
    Ok(limits)
}

/// The profile of a density along one state: positions, rising, and the largest |p| over the other state there.
pub(super) struct Profile {
    points: Vec<(f64, f64)>,
    pub(super) peak: f64,
}

impl Profile {
    pub(super) fn new(field: &Field, state: usize) -> Self {
        let rule = Rule::legendre(field.space.degree.max(2));
        let mut points: Vec<(f64, f64)> = Vec::new();
        field.for_each_node(rule, |x, _, p| points.push((x[state], p.abs())));
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|next, kept| {
            kept.1 = if next.0 == kept.0 { kept.1.max(next.1) } else { kept.1 };
            next.0 == kept.0
        });
        let peak = points.iter().fold(0.0, |a: f64, (_, p)| a.max(*p));
        Profile { points, peak }
    }

    /// The largest |p| next to the lower (0) or upper (1) edge, relative to the peak.
    pub(super) fn edge(&self, side: usize) -> f64 {
        let point = if side == 0 { self.points.first() } else { self.points.last() };
        point.map_or(0.0, |(_, p)| p / self.peak)
    }

    /// Where the density has fallen to `level` of its peak for good, on one side. Beyond the points of the profile the fall
    /// is continued as ln p ~ −|x − m|^k.
    pub(super) fn limit(&self, side: usize, level: f64) -> f64 {
        let middle = self.points.iter().fold((0.0, 0.0), |best, p| if p.1 > best.1 { *p } else { best }).0;
        let inwards: Vec<(f64, f64)> = match side {
            0 => self.points.clone(),
            _ => self.points.iter().rev().copied().collect(),
        };
        let outermost = |share: f64| {
            let level = share * self.peak;
            let first = inwards.iter().position(|(_, p)| *p >= level).unwrap_or(0);
            let (x, p) = inwards[first];
            // Between two nodes ln p is nearly straight.
            let beyond = first.checked_sub(1).map(|k| inwards[k]).filter(|(_, q)| *q > 0.0);
            beyond.map_or(x, |(y, q)| y + (x - y) * (level / q).ln() / (p / q).ln())
        };
        let [near, far] =
            [tuning::domain::NEAR, tuning::domain::FAR].map(|share: f64| (outermost(share) - middle).abs());
        let power = ((tuning::domain::FAR.ln() / tuning::domain::NEAR.ln()).ln() / (far / near).ln()).clamp(0.5, 8.0);
        let reach = far * (level.ln() / tuning::domain::FAR.ln()).powf(power.recip());
        // From a density that does not fall within the domain nothing can be concluded far outside.
        let edge = if side == 0 { self.points.first() } else { self.points.last() };
        let farthest = 1.6 * edge.map_or(far, |(x, _)| (x - middle).abs());
        let reach = if reach.is_finite() { (tuning::domain::SAFETY * reach).min(farthest) } else { farthest };
        if side == 0 { middle - reach } else { middle + reach }
    }
}

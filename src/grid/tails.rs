//! What lies beyond the domain, by the marginal density next to its edges.

use super::density::{GridDensity, at};
use std::f64::consts::{SQRT_2, TAU};

/// The marginal density at an edge, continued, over what is left of it there: an edge that lets out has less next to it.
const LET_OUT: f64 = 6.0;
/// What a moment lacks, over what is beyond by a power: the mass beyond is within as well. Of a cycle with p ~ x⁻⁴ the moments lacked
/// 0.9 to 1.1 of it.
const TWICE: f64 = 2.0;
/// A density falls as a power if its exponent grows by no more than this over a factor of √2: that of a normal density doubles, that
/// of an exponential one grows by 1.41.
const STEADY: f64 = 1.2;

impl GridDensity {
    /// A rough estimate of the mean of |x₁^p₁ x₂^p₂| beyond the edges. Where the marginal density falls as a power it does so beyond
    /// as well, whether or not anything leaks; else, at edges that lose something, it falls as a normal density does there. For high
    /// powers that exceeds the difference of the two degrees.
    pub(super) fn beyond(&self, powers: &[u32]) -> f64 {
        let mesh = &self.fine.mesh;
        let sides = (0..powers.len()).flat_map(|axis| [(axis, 0), (axis, 1)]);
        let open = sides.filter(|(axis, side)| mesh.open(*axis, *side));
        let beyond = |(axis, side): (usize, usize), power: u32| {
            self.power_beyond(axis, side, power).or_else(|| {
                let leaks = self.edges.iter().any(|edge| (edge.0, edge.1) == (axis, side));
                leaks.then(|| self.normal_beyond(axis, side, power))
            })
        };
        let of = |(axis, side): (usize, usize)| match &self.shear {
            None => beyond((axis, side), powers[axis]).map_or(0.0, |own| {
                let others = (0..powers.len()).filter(|other| *other != axis);
                own * others.map(|other| self.size(other, powers[other])).product::<f64>()
            }),
            // There each state is as large as that of the edge and its own deviation together.
            Some(shear) => beyond((axis, side), 0).map_or(0.0, |own| {
                let edge = mesh.domain()[axis][side];
                let used = (0..powers.len()).filter(|state| powers[*state] > 0);
                let size = |state: usize| {
                    let square = self.mean(&self.fine, &|x| x[state].powi(2));
                    ((shear.row(state)[axis] * edge).abs() + square.abs().sqrt()).powi(powers[state] as i32)
                };
                own * used.map(size).product::<f64>()
            }),
        };
        open.map(of).sum()
    }

    /// E|x|^power of a state within the domain.
    fn size(&self, state: usize, power: u32) -> f64 {
        self.fine.integral_over(state, &|x: f64| x.abs().powi(power as i32), power as usize)
    }

    /// ∫ |x|^power p dx of a state beyond a side, by a power of the distance from the mean; none where p falls faster, or where it is
    /// not determined.
    fn power_beyond(&self, state: usize, side: usize, power: u32) -> Option<f64> {
        let edge = self.fine.mesh.domain()[state][side];
        let mean = self.fine.integral_over(state, &|x| x, 1);
        // Not up to the edge, next to which a leak takes away.
        let near = |share: f64| {
            let place = at(&self.fine, state, mean + share * (edge - mean));
            let p = self.estimate(|field| field.integral(&place));
            (p.value > 3.0 * p.error).then_some(p.value)
        };
        let [inner, middle, outer] = [near(0.4)?, near(0.4 * SQRT_2)?, near(0.8)?];
        let [first, exponent] = [inner / middle, middle / outer].map(|ratio| ratio.ln() / SQRT_2.ln());
        let falls = first > 0.0 && exponent < STEADY * first;
        let left = (exponent - f64::from(power) - 1.0).max(0.0);
        falls.then(|| {
            TWICE * outer * 0.8_f64.powf(exponent) * edge.abs().powi(power as i32) * (edge - mean).abs() / left
        })
    }

    /// The same by a normal density.
    fn normal_beyond(&self, state: usize, side: usize, power: u32) -> f64 {
        let ([low, high], edge) = (self.fine.mesh.domain()[state], self.fine.mesh.domain()[state][side]);
        let variance = self.size(state, 2) - self.fine.integral_over(state, &|x| x, 1).powi(2);
        let peak = (TAU * variance.abs()).sqrt().recip();
        let level = (self.fine.integral(&at(&self.fine, state, edge)).abs() / peak).clamp(f64::MIN_POSITIVE, 0.5);
        let decay = (high - low) / (4.0 * -level.ln());
        LET_OUT * level * peak * decay * edge.abs().powi(power as i32)
    }
}

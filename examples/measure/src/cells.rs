//! The density of two states by a long simulation, on cells.

use expoly::{Density, Problem, Result, Simulation};

/// The cells of the first two states that most of a simulation's states are in, and the share of the states in each.
pub(crate) struct Cells {
    /// Along either state.
    count: usize,
    low: [f64; 2],
    width: [f64; 2],
    shares: Vec<f64>,
    /// Shares up to this are left out.
    least: f64,
}

impl Cells {
    /// By so many millions of states.
    pub(crate) fn new(problem: &Problem, count: usize, time_step: f64, millions: u64) -> Result<Self> {
        let states = |seed, samples| Simulation::new().samples(samples).time_step(time_step).seed(seed).states(problem);
        let first = states(76, 20_000)?;
        let range =
            |i: usize| first.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x[i]), b.max(x[i])]);
        let [y, v] = [range(0), range(1)];
        let low = [y[0], v[0]];
        let width = [y, v].map(|[low, high]| (high - low) / count as f64);
        let mut cells =
            Cells { count, low, width, shares: vec![0.0; count * count], least: 0.012 / (count * count) as f64 };
        for seed in 0..millions {
            for x in &states(1000 + seed, 1_000_000)? {
                let at = |i: usize| ((x[i] - low[i]) / width[i]).floor();
                let [p, q] = [at(0), at(1)];
                if p.min(q) >= 0.0 && p.max(q) < count as f64 {
                    cells.shares[p as usize * count + q as usize] += 1e-6 / millions as f64;
                }
            }
        }
        Ok(cells)
    }

    /// Σ |∫ p̃ dy dv − share| over the cells with enough states, by Gauss' rule with two points along v and with three along the cube root of y less
    /// its least value, which is that at the wall if there is one.
    pub(crate) fn distance(&self, density: &dyn Density) -> Result<f64> {
        let mut sum = 0.0;
        for (k, share) in self.shares.iter().enumerate().filter(|(_, share)| **share > self.least) {
            let [p, q] = [k / self.count, k % self.count].map(|place| place as f64);
            let [from, to] = [p, p + 1.0].map(f64::cbrt);
            let mut mass = 0.0;
            for (t, w) in [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)] {
                let s = from + (to - from) * 0.5 * (1.0 + t);
                let y = self.low[0] + self.width[0] * s.powi(3);
                let weight = w * (to - from) * 3.0 * s * s * self.width[0];
                for t in [-1.0, 1.0].map(|sign| 0.5 + sign * 0.5 / 3.0_f64.sqrt()) {
                    let v = self.low[1] + self.width[1] * (q + t);
                    mass += weight * 0.5 * self.width[1] * density.joint_marginal([0, 1], [y, v])?.value;
                }
            }
            sum += (mass - share).abs();
        }
        Ok(sum)
    }
}

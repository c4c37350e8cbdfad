//! Duffing's oscillator with elastic walls: p = C exp(−(c/D) H) between them.

use expoly::models::{Duffing, Solved};
use expoly::{Problem, Result, Wall};

/// The oscillator c, k, μ, D with walls below the motion and above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Elastic {
    pub(crate) parameters: [f64; 4],
    pub(crate) walls: [Option<f64>; 2],
}

impl Elastic {
    pub(crate) fn problem(&self) -> Result<Problem> {
        let [c, k, mu, d] = self.parameters;
        let mut problem = Duffing::new(c, k, mu, d)?.problem()?;
        for (wall, make) in self.walls.into_iter().zip([Wall::above, Wall::below]) {
            if let Some(offset) = wall {
                problem = problem.with_wall(make(offset, 1.0)?)?;
            }
        }
        Ok(problem)
    }

    /// The parameters that the closed form has.
    pub(crate) fn names(problem: &Problem) -> Vec<&str> {
        let names = problem.parameters().iter().map(|(name, _)| name.as_str());
        names.filter(|name| !name.ends_with("restitution")).collect()
    }

    /// ∂ ln p/∂θ by a parameter, up to a constant.
    pub(crate) fn slope(&self, name: &str, x: &[f64]) -> f64 {
        let [c, k, mu, d] = self.parameters;
        let energy = x[1] * x[1] / 2.0 + k * x[0] * x[0] / 2.0 + mu * x[0].powi(4) / 4.0;
        match name {
            "c" => -energy / d,
            "k" => -(c / d) * x[0] * x[0] / 2.0,
            "mu" => -(c / d) * x[0].powi(4) / 4.0,
            "D" => c * energy / (d * d),
            _ => 0.0,
        }
    }

    /// The mean of x, of x² and of v², P(x > 0.4) and the impact rate, by Simpson's rule on 4000 intervals: 1e-12.
    pub(crate) fn answers(&self) -> [f64; 5] {
        let Elastic { parameters: [c, k, mu, d], walls } = *self;
        let p = |x: f64| (-(c / d) * (k * x * x / 2.0 + mu * x.powi(4) / 4.0)).exp();
        let (low, high) = (walls[0].unwrap_or(-7.0), walls[1].unwrap_or(7.0));
        let over = |from: f64, g: &dyn Fn(f64) -> f64| {
            let h = (high - from) / 4000.0;
            let weight = |i: u32| if i == 0 || i == 4000 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            let at = |i: u32| from + h * f64::from(i);
            (0..=4000).map(|i| weight(i) * g(at(i)) * p(at(i))).sum::<f64>() * h / 3.0
        };
        let mass = over(low, &|_| 1.0);
        let impacts =
            walls.iter().flatten().map(|b| p(*b)).sum::<f64>() / mass * (d / c / std::f64::consts::TAU).sqrt();
        [over(low, &|x| x) / mass, over(low, &|x| x * x) / mass, d / c, over(low.max(0.4), &|_| 1.0) / mass, impacts]
    }

    /// The same with a parameter moved.
    fn moved(&self, name: &str, h: f64) -> Self {
        let mut moved = *self;
        match name {
            "x.above.offset" => moved.walls[0] = moved.walls[0].map(|b| b + h),
            "x.below.offset" => moved.walls[1] = moved.walls[1].map(|b| b + h),
            name => moved.parameters[["c", "k", "mu", "D"].iter().position(|own| *own == name).unwrap()] += h,
        }
        moved
    }

    /// Their derivatives by a parameter, by differences of fourth order: h⁴ of a fifth derivative and rounding over h, 1e-11 relative.
    pub(crate) fn derivatives(&self, name: &str) -> [f64; 5] {
        slopes(2e-4, |h| self.moved(name, h).answers())
    }
}

fn slopes(h: f64, at: impl Fn(f64) -> [f64; 5]) -> [f64; 5] {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * h));
    std::array::from_fn(|k| (8.0 * (c[k] - b[k]) - (d[k] - a[k])) / (12.0 * h))
}

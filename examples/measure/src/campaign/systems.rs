//! Random systems: each is determined by the campaign's seed and its own index.

use super::runner::Named;
use crate::draw::Draw;
use expoly::models::{Duffing, VibroImpactDuffing};
use expoly::{Drift, Interpretation, Problem, Scalar};
use std::fmt;
use support::exact::Exact;

/// x″ + h(x, x′) = (1 + βx + γx′) ξ.
#[derive(Clone, Debug)]
pub(crate) struct System {
    /// h: powers of x and v, and their coefficient.
    terms: Vec<([u32; 2], f64)>,
    intensity: f64,
    /// β and γ.
    multiplicative: [f64; 2],
    interpretation: Interpretation,
}

impl Drift<2, 1> for System {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        let mut force = S::from(0.0);
        for ([i, j], c) in &self.terms {
            // Only products of states: a power of zero would give a symbol a term that it does not have.
            force = force
                + match (i, j) {
                    (0, j) => v.powi(*j) * *c,
                    (i, 0) => x.powi(*i) * *c,
                    (i, j) => x.powi(*i) * v.powi(*j) * *c,
                };
        }
        [v, -force]
    }

    fn noise<S: Scalar>(&self, [x, v]: [S; 2]) -> [[S; 1]; 2] {
        let amplitude = (2.0 * self.intensity).sqrt();
        let [by_x, by_v] = self.multiplicative.map(|share| share * amplitude);
        [[S::from(0.0)], [x * by_x + v * by_v + amplitude]]
    }

    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }
}

impl Named for Exact {
    fn problem(&self) -> expoly::Result<Problem> {
        Problem::of(self.clone())
    }
}

impl Named for System {
    fn problem(&self) -> expoly::Result<Problem> {
        Problem::of(self.clone())
    }
}

impl System {
    /// A system whose linear terms may have either sign and whose highest ones confine it: limit cycles and several wells
    /// are among them.
    pub(crate) fn random(seed: u64, index: usize) -> Self {
        let mut draw = Draw::new(seed, index);
        let mut terms = vec![([1, 0], draw.within(-1.5, 1.5))];
        if draw.with(0.7) {
            terms.push(([3, 0], draw.log_within(0.3, 1.5)));
        } else {
            terms.push(([3, 0], draw.within(-1.0, 1.0)));
            terms.push(([5, 0], draw.log_within(0.1, 0.5)));
        }
        if draw.with(0.3) {
            terms.push(([2, 0], draw.within(-0.5, 0.5)));
        }
        let kind = draw.within(0.0, 1.0);
        let cubic = (0.25..0.55).contains(&kind);
        if kind < 0.25 {
            terms.push(([0, 1], draw.log_within(0.1, 1.0)));
        } else {
            terms.push(([0, 1], draw.within(-1.0, 1.0)));
            if cubic {
                terms.push(([0, 3], draw.log_within(0.2, 1.0)));
                if draw.with(0.25) {
                    terms.push(([0, 2], draw.within(-0.2, 0.2)));
                }
            } else if kind < 0.85 {
                terms.push(([2, 1], draw.log_within(0.2, 1.0)));
            } else {
                terms.push(([2, 1], draw.within(-0.5, 0.5)));
                terms.push(([4, 1], draw.log_within(0.1, 0.5)));
            }
            if draw.with(0.2) {
                terms.push(([1, 1], draw.within(-0.3, 0.3)));
            }
        }
        let intensity = draw.log_within(0.05, 1.0);
        // Noise that grows with the velocity needs damping that grows faster, or the density has power tails.
        let multiplicative = match draw.within(0.0, 1.0) {
            u if u < 0.2 => [draw.within(-0.3, 0.3), 0.0],
            u if u < 0.4 && cubic => [0.0, draw.within(-0.3, 0.3)],
            _ => [0.0, 0.0],
        };
        let interpretation = if draw.with(0.5) { Interpretation::Stratonovich } else { Interpretation::Ito };
        System { terms, intensity, multiplicative, interpretation }
    }
}

impl fmt::Display for System {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "x\"")?;
        for ([i, j], c) in &self.terms {
            let power = |name: &str, power: u32| match power {
                0 => String::new(),
                1 => format!(" {name}"),
                _ => format!(" {name}^{power}"),
            };
            write!(f, " {c:+.3}{}{}", power("x", *i), power("v", *j))?;
        }
        match self.multiplicative {
            [0.0, 0.0] => write!(f, " = xi")?,
            [by_x, by_v] => write!(f, " = (1 {by_x:+.3} x {by_v:+.3} v) xi, {:?}", self.interpretation)?,
        }
        write!(f, ", D = {:.3}", self.intensity)
    }
}

/// The walls of the lattice: offsets, restitutions below 1 (an elastic wall is exact) and the cubic stiffness above them.
const OFFSETS: [f64; 4] = [-0.5, 0.0, 0.2, 0.5];
const RESTITUTIONS: [f64; 5] = [0.98, 0.95, 0.9, 0.7, 0.5];
const CUBIC: [f64; 2] = [0.3, 1.0];

/// A Duffing oscillator above a wall.
#[derive(Clone, Debug)]
pub(crate) struct Walled {
    /// c, k, μ, D.
    parameters: [f64; 4],
    model: VibroImpactDuffing,
}

impl Named for Walled {
    fn problem(&self) -> expoly::Result<Problem> {
        self.model.problem()
    }
}

impl Walled {
    pub(crate) fn random(seed: u64, index: usize) -> expoly::Result<Self> {
        let mut draw = Draw::new(seed, index);
        let [c, k, mu] = [draw.log_within(0.05, 0.6), draw.within(0.3, 2.0), draw.within(0.0, 2.0)];
        let (offset, restitution) = (draw.within(-0.9, 0.7), draw.within(0.5, 1.0));
        Walled::new([c, k, mu, draw.log_within(0.05, 0.6)], offset, restitution)
    }

    /// The walls of [`OFFSETS`] × [`RESTITUTIONS`] × [`CUBIC`], the restitution changing fastest; beyond the last one the
    /// first again.
    pub(crate) fn on_lattice(index: usize) -> expoly::Result<Self> {
        let (rest, r) = (index / RESTITUTIONS.len(), index % RESTITUTIONS.len());
        let (mu, b) = (CUBIC[rest / OFFSETS.len() % CUBIC.len()], OFFSETS[rest % OFFSETS.len()]);
        Walled::new([0.2, 1.0, mu, 0.2], b, RESTITUTIONS[r])
    }

    /// How many walls the lattice has.
    pub(crate) const LATTICE: usize = OFFSETS.len() * RESTITUTIONS.len() * CUBIC.len();

    fn new([c, k, mu, d]: [f64; 4], offset: f64, restitution: f64) -> expoly::Result<Self> {
        let model = VibroImpactDuffing::new(Duffing::new(c, k, mu, d)?, offset, restitution)?;
        Ok(Walled { parameters: [c, k, mu, d], model })
    }
}

impl fmt::Display for Walled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [c, k, mu, d] = self.parameters;
        let (b, r) = (self.model.wall().offset(), self.model.wall().restitution());
        write!(f, "c = {c:.4}, k = {k:.3}, mu = {mu:.3}, D = {d:.4}, b = {b:.3}, r = {r:.3}")
    }
}

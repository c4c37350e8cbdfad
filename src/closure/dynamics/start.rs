//! The moments of a start.

use super::moment_system::MomentSystem;
use crate::checks::require;
use crate::closure::discretisation::nodes;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::error::Result;
use crate::numerics::{Rule, combination, weighted_sum};
use crate::polynomial::Frame;
use crate::states::States;
use crate::transient::Start;
use faer::Mat;

/// The largest mass of a start outside of the domain of the moment equations.
const OUTSIDE: f64 = 1e-3;
/// Gauss nodes along each axis of a normal start in one state and two.
const START_NODES: usize = 40;

/// Points with the masses that a density has there.
#[derive(Debug)]
pub(super) struct Weighted {
    points: States,
    masses: Vec<f64>,
}

/// The means of ψ under a density on the domain, which the equations begin with, that of ψ₀ = 1 first.
///
/// # Errors
/// [`OutOfRange`](crate::Error::OutOfRange) if much of it lies elsewhere.
pub(super) fn beginning(weighted: &Weighted, system: &MomentSystem, domain: &TrustDomain) -> Result<Vec<f64>> {
    let mut inside = Weighted::none(domain.centre.len());
    for (x, mass) in weighted.points.iter().zip(&weighted.masses).filter(|(x, _)| domain.contains(x)) {
        inside.enter(x, *mass);
    }
    let mass: f64 = inside.masses.iter().sum();
    let remedy = "it must lie inside the closure's domain, and not be too narrow for its nodes";
    require((mass - 1.0).abs() <= OUTSIDE, "mass of the start in the domain", mass, remedy)?;
    let sums = weighted_sum(nodes::values(&system.space, &inside.points).as_ref(), &inside.masses);
    let mut means = Mat::from_fn(1, sums.len(), |_, k| sums[k]);
    system.functions.transform(means.as_mut());
    Ok((0..sums.len()).map(|k| means[(0, k)] / means[(0, 0)]).collect())
}

impl Weighted {
    /// No points.
    fn none(states: usize) -> Self {
        Weighted { points: States::new(states), masses: Vec::new() }
    }

    /// Adds a point.
    fn enter(&mut self, x: &[f64], mass: f64) {
        self.points.push(x);
        self.masses.push(mass);
    }

    /// A start: a point by itself, a Gaussian on Gauss nodes of its own, other densities on those of the system.
    pub(super) fn of(start: &Start, system: &MomentSystem) -> Result<Self> {
        let states = system.nodes.points.dimension();
        let mut all = Weighted::none(states);
        // In more states few enough that their product is, and enough for the moments of the highest degree.
        let exact = system.highest_degree() as usize / 2 + 2;
        let nodes = if states > 2 { exact } else { START_NODES };
        match start {
            Start::Point(x) => all.enter(x, 1.0),
            Start::Gaussian(gaussian) => {
                let (frame, rule) = (Frame::new(gaussian)?, Rule::hermite(nodes));
                let mut z = vec![0.0; states];
                for place in 0..rule.nodes.len().pow(states as u32) {
                    let along = |i: usize| place / rule.nodes.len().pow(i as u32) % rule.nodes.len();
                    (0..states).for_each(|i| z[i] = rule.nodes[along(i)]);
                    all.enter(&frame.state(&z), (0..states).map(|i| rule.weights[along(i)]).product());
                }
            }
            Start::Stationary => {
                let values = system.functions.values.get(..system.nodes.len(), ..system.columns(false));
                let ratio = combination(values, &system.stationary(false));
                for ((x, weight), ratio) in system.nodes.points.iter().zip(&system.measure).zip(&ratio) {
                    all.enter(x, weight * ratio);
                }
            }
            Start::Density(density) => {
                for (x, weight) in system.nodes.points.iter().zip(&system.nodes.weights) {
                    all.enter(x, weight * density.log_pdf(x)?.exp());
                }
            }
        }
        Ok(all)
    }
}

//! What a time step costs, for bounds on work.

use crate::problem::Problem;

/// An impulse costs as much as so many time steps of a trajectory.
const ALONE: f64 = 16.0;
/// A drift of more terms than this costs in proportion to them. Five terms more take as long as a step of a Duffing oscillator; with so
/// many, bounds on the work of an oscillator's pilots, which are seconds, are half a minute.
const TERMS: f64 = 160.0;

/// What a time step of a trajectory costs, relative to that of an oscillator under constant noise: noise that depends on the state makes
/// it slower, in proportion to its terms, and so do a drift of many terms and impulses, at each of which a trajectory goes on alone.
pub(crate) fn step_cost(problem: &Problem, step: f64) -> f64 {
    let operator = problem.operator();
    let drift = (operator.drift_terms() as f64 / TERMS).max(1.0);
    drift + operator.varying_noise() as f64 + ALONE * problem.impulse_rate() * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{Duffing, Solved};

    /// All 252 monomials of degree 5 and below in five states, in each of five equations.
    #[test]
    fn many_terms_cost_more() -> Result<()> {
        let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
        assert_eq!(step_cost(&duffing, 0.1), 1.0);
        let states = ["a", "b", "c", "d", "e"];
        let (sum, mut text) = (states.join(" + "), format!("states = {states:?}\n"));
        states.iter().for_each(|state| text += &format!("drift.{state} = '(1 + {sum})^5'\nnoise.w.{state} = '1'\n"));
        assert_eq!(step_cost(&Problem::from_toml(&text)?, 0.1), 1260.0 / 160.0);
        Ok(())
    }
}

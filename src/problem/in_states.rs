//! Problems in other states.

use super::Problem;
use super::definition::PolynomialForm;
use crate::error::Result;
use crate::fokker_planck::Impulse;
use crate::polynomial::{Polynomial, multiplied};
use nalgebra::DMatrix;

impl Problem {
    /// The same problem in a mirror, x → −x, with its walls: a wall below the motion is one above it there.
    pub(crate) fn mirrored(&self) -> Result<Self> {
        let n = self.dimension();
        let turned: Vec<Polynomial> = Polynomial::variables(n).into_iter().map(|x| -x).collect();
        let mirrored = self.in_states(&turned, &-DMatrix::identity(n, n))?;
        self.walls().iter().chain(self.ends()).try_fold(mirrored, |problem, wall| problem.with_wall(wall.mirrored()))
    }

    /// The problem of any z of which the `states` are linear functions, with the matrix L⁻¹ of z: the drift is L⁻¹f, the noise L⁻¹G. It
    /// has the same names, no walls, and no derivatives by parameters.
    pub(crate) fn in_states(&self, states: &[Polynomial], inverse: &DMatrix<f64>) -> Result<Self> {
        let all = |field: &[Polynomial]| -> Vec<Polynomial> {
            multiplied(inverse, &field.iter().map(|p| p.compose(states)).collect::<Vec<_>>())
        };
        let form = PolynomialForm {
            drift: all(self.drift()),
            columns: self.columns().iter().map(|column| all(column)).collect(),
            interpretation: self.interpretation(),
            impulses: self
                .impulses()
                .iter()
                .map(|impulse| Impulse::new(*impulse.process(), all(impulse.field())))
                .collect(),
        };
        Problem::of_polynomials(form, self.states().to_vec(), self.equations.parameters.clone(), None)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::models::DuffingVanDerPol;
    use crate::walls::Wall;

    #[test]
    fn a_mirror_turns_drift_and_walls_and_twice_is_the_problem_itself() {
        let problem = Problem::of(DuffingVanDerPol::van_der_pol(0.5, 0.3).unwrap()).unwrap();
        let problem = problem.with_wall(Wall::above(-0.5, 0.9).unwrap()).unwrap();
        let mirrored = problem.mirrored().unwrap();
        assert_eq!(mirrored.walls(), [Wall::below(0.5, 0.9).unwrap()]);
        // An odd drift is its own image.
        assert_eq!(mirrored.drift(), problem.drift());
        let again = mirrored.mirrored().unwrap();
        assert_eq!((again.walls(), again.columns()), (problem.walls(), problem.columns()));
    }
}

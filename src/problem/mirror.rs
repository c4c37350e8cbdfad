use super::Problem;
use super::definition::PolynomialForm;
use crate::error::Result;
use crate::fokker_planck::Impulse;
use crate::polynomial::{Polynomial, total_degree};

impl Problem {
    /// The same problem in a mirror, x → −x, with its walls: a wall below the motion is one above it there.
    pub(crate) fn mirrored(&self) -> Result<Self> {
        let all = |polynomials: &[Polynomial]| polynomials.iter().map(turned).collect::<Result<Vec<_>>>();
        let impulse = |impulse: &Impulse| Ok(Impulse::new(*impulse.process(), all(impulse.field())?));
        let form = PolynomialForm {
            drift: all(self.drift())?,
            columns: self.columns().iter().map(|column| all(column)).collect::<Result<_>>()?,
            interpretation: self.interpretation(),
            impulses: self.impulses().iter().map(impulse).collect::<Result<_>>()?,
        };
        let parameters = self.equations.parameters.clone();
        let mirrored = Problem::of_polynomials(form, self.states().to_vec(), parameters, None)?;
        self.walls().iter().chain(self.ends()).try_fold(mirrored, |problem, wall| problem.with_wall(wall.mirrored()))
    }
}

/// −p(−x).
fn turned(p: &Polynomial) -> Result<Polynomial> {
    if !p.is_plain() {
        let mirrored: Vec<Polynomial> = Polynomial::variables(p.dimension()).into_iter().map(|x| -x).collect();
        return Ok(-p.compose(&mirrored));
    }
    let sign = |alpha: &[u32]| if total_degree(alpha) % 2 == 1 { 1.0 } else { -1.0 };
    Polynomial::from_terms(p.dimension(), p.terms().map(|(alpha, c)| (alpha, sign(alpha) * c)))
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

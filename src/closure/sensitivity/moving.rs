use crate::error::Result;
use crate::fokker_planck::FokkerPlanck;
use crate::functions::{Corner, GrazingMotion};
use crate::problem::{PlaneMotion, Problem};

/// What of a problem moves with a parameter, in the coordinate in which walls stand still.
pub(super) struct Moving {
    pub(super) operator: FokkerPlanck,
    /// The rate of this coordinate at a fixed parameter, η = [0] + [1] x.
    pub(super) shift: [f64; 2],
    /// The rates of the restitutions of the walls below the motion and above it.
    pub(super) restitution: [f64; 2],
    /// The singular parts of ln p next to the walls.
    pub(super) singular: Vec<GrazingMotion>,
}

impl Moving {
    pub(super) fn new(problem: &Problem, parameter: &str, corners: &[Corner]) -> Result<Self> {
        let moving = Moving::from(problem.motion(parameter)?.on_plane(problem));
        let singular = |corner: &Corner| {
            // As the coordinate stretches, the noise does more.
            let noise = moving.noise_at(corner) + moving.shift[1] * corner.intensity();
            GrazingMotion::new(corner, [moving.restitution_of(corner), noise])
        };
        Ok(Moving { singular: corners.iter().map(singular).collect(), ..moving })
    }

    /// Whether the derivative of an exact density is none of an exponential polynomial of its order.
    pub(super) fn grazes(&self) -> bool {
        self.restitution != [0.0; 2]
    }

    fn restitution_of(&self, corner: &Corner) -> f64 {
        self.restitution[usize::from(!corner.wall().is_above())]
    }

    /// The rate of the noise intensity at a wall.
    fn noise_at(&self, corner: &Corner) -> f64 {
        self.operator.diffusion()[1][1].evaluate(&[corner.wall().offset(), 0.0]) / 2.0
    }
}

impl From<PlaneMotion> for Moving {
    fn from(PlaneMotion { operator, shift, restitution }: PlaneMotion) -> Self {
        Moving { operator, shift, restitution, singular: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::models::{Duffing, Solved};
    use crate::walls::Wall;

    /// Against central differences, which are off by h² = 1e-8 times a third derivative of order 1.
    #[test]
    fn the_singular_part_moves_with_the_restitution() -> Result<()> {
        let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(-0.5, 0.8)?)?;
        let at = |r: f64| Ok::<_, Error>(Corner::new(Wall::above(-0.5, r)?, vec![1], 0.2, [3.0, 4.0]));
        let moving = Moving::new(&problem, "x.above.restitution", &[at(0.8)?])?;
        let (h, x) = (1e-4, [-0.3, 0.6]);
        let slope = (at(0.8 + h)?.singular_value(&x) - at(0.8 - h)?.singular_value(&x)) / (2.0 * h);
        let found = moving.singular[0].value(&x);
        assert!((found - slope).abs() < 1e-6 * slope.abs().max(1.0), "{found} and {slope}");
        Ok(())
    }
}

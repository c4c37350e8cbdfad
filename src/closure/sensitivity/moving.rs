use crate::closure::space::{Corner, GrazingMotion};
use crate::error::Result;
use crate::fokker_planck::FokkerPlanck;
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
        let PlaneMotion { operator, shift, restitution } = problem.motion(parameter)?.on_plane(problem);
        let singular = |corner: &Corner| {
            let rate = restitution[usize::from(!corner.wall().is_above())];
            let noise = operator.diffusion()[1][1].evaluate(&[corner.wall().offset(), 0.0]) / 2.0;
            // As the coordinate stretches, the noise does more.
            GrazingMotion::new(corner, [rate, noise + shift[1] * corner.intensity()])
        };
        let singular = corners.iter().map(singular).collect();
        Ok(Moving { operator, shift, restitution, singular })
    }

    /// Whether the derivative of an exact density is none of an exponential polynomial of its order.
    pub(super) fn grazes(&self) -> bool {
        self.restitution != [0.0; 2]
    }
}

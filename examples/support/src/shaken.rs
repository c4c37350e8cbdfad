//! A linear oscillator whose damping and stiffness are shaken: its moments are known in closed form.

use expoly::{Drift, Interpretation, Scalar};

/// x″ + x′ + x = 0.4 x′ ξ₁ + 0.4 x ξ₂ + ξ₃, all noises of intensity ½.
#[derive(Clone, Copy, Debug)]
pub struct Shaken(pub Interpretation);

impl Drift<2, 3> for Shaken {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -v - x]
    }
    fn noise<S: Scalar>(&self, [x, v]: [S; 2]) -> [[S; 3]; 2] {
        let zero = S::from(0.0);
        [[zero, zero, zero], [v * 0.4, x * 0.4, S::from(1.0)]]
    }
    fn interpretation(&self) -> Interpretation {
        self.0
    }
}

use super::{Duffing, EnergyAveraged, Solved};
use crate::{Barrier, ExpPolynomial, Oscillator, Result, Zhuravlev};

/// The Duffing oscillator above a one-sided wall that need not stand at its rest position:
/// y″ + c y′ + k y + μ y³ = ξ for y > b, and y′₊ = −r y′₋ at y = b.
///
/// For r = 1 the density is Duffing's, cut off at the wall; for r < 1 no closed form is known.
///
/// # Reference
/// H. T. Zhu, Stochastic response of vibro-impact Duffing oscillators under external and parametric Gaussian white
/// noises, Journal of Sound and Vibration 333 (2014) 954-961, for the closure with the wall at the rest position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VibroImpactDuffing {
    oscillator: Duffing,
    barrier: Barrier,
}

impl VibroImpactDuffing {
    /// The oscillator and the wall.
    pub fn new(oscillator: Duffing, barrier: Barrier) -> Self {
        VibroImpactDuffing { oscillator, barrier }
    }

    /// The wall positions b and restitutions r of the standard study, with c = 0.2, k = 1, μ = 0.3, D = 0.2: at the rest
    /// position, above it, and below it.
    pub const STANDARD_WALLS: [[f64; 2]; 4] = [[0.0, 0.98], [0.2, 0.95], [-0.5, 0.95], [-0.5, 0.9]];

    /// The oscillator without the wall.
    pub fn oscillator(&self) -> &Duffing {
        &self.oscillator
    }

    /// The wall.
    pub fn barrier(&self) -> Barrier {
        self.barrier
    }

    /// Zhuravlev's transformation for this wall.
    pub fn transformation(&self) -> Zhuravlev {
        Zhuravlev::new(self.barrier)
    }

    /// The exact density if the wall is elastic, nothing otherwise.
    ///
    /// # Errors
    /// As [`Solved::exact_above`].
    pub fn exact(&self) -> Result<Option<ExpPolynomial<2>>> {
        let elastic = self.barrier.restitution() == 1.0;
        elastic.then(|| self.oscillator.exact_above(self.barrier.offset())).transpose()
    }

    /// The density by averaging over the free orbits, for small damping and nearly elastic impacts.
    ///
    /// # Errors
    /// As [`EnergyAveraged::new`].
    pub fn averaged(&self) -> Result<EnergyAveraged> {
        EnergyAveraged::new(self)
    }

    /// The potential U(y) of the spring.
    pub(super) fn potential(&self, y: f64) -> f64 {
        let [_, k, mu] = self.oscillator.coefficients();
        y * y * (k / 2.0 + mu / 4.0 * y * y)
    }

    pub(super) fn intensity(&self) -> f64 {
        Oscillator::intensity(&self.oscillator).d()
    }
}

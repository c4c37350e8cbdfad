use crate::{Interpretation, PolynomialDrift, Scalar};

/// A system with its noise multiplied by a factor: the intensities by the factor's square.
///
/// The simulation runs every system as one of these, so that its inner loops are compiled once for each, whatever the
/// factor.
#[derive(Debug)]
pub(crate) struct Amplified<'a, T> {
    pub(crate) system: &'a T,
    pub(crate) amplitude: f64,
}

impl<T> Clone for Amplified<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Amplified<'_, T> {}

impl<T: PolynomialDrift<N, M>, const N: usize, const M: usize> PolynomialDrift<N, M> for Amplified<'_, T> {
    const CONSTANT_NOISE: bool = T::CONSTANT_NOISE;

    #[inline(always)]
    fn drift<S: Scalar>(&self, x: [S; N]) -> [S; N] {
        self.system.drift(x)
    }

    #[inline(always)]
    fn noise<S: Scalar>(&self, x: [S; N]) -> [[S; M]; N] {
        self.system.noise(x).map(|row| row.map(|entry| entry * self.amplitude))
    }

    fn interpretation(&self) -> Interpretation {
        self.system.interpretation()
    }
}

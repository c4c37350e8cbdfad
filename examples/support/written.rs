//! One type for all models of two states, so that the methods are compiled once.

use expoly::{Arena, Interpretation, Monomial, PolynomialDrift, Scalar, Symbol};

/// The most noises that a model has.
const NOISES: usize = 3;

/// The polynomials of a system, written down: itself a system, slower to simulate than the one it came from.
#[derive(Clone, Debug)]
pub struct Written {
    drift: [Terms; 2],
    noise: [[Terms; NOISES]; 2],
    interpretation: Interpretation,
}

/// The terms of a polynomial in one row, which is faster to walk along than its tree.
#[derive(Clone, Debug, Default)]
struct Terms(Vec<(Monomial<2>, f64)>);

impl Terms {
    fn of(symbol: Symbol<'_, 2>) -> Self {
        Terms(symbol.polynomial().terms().map(|(monomial, c)| (*monomial, c)).collect())
    }

    fn evaluate<S: Scalar>(&self, x: &[S; 2]) -> S {
        self.0.iter().fold(S::from(0.0), |sum, (monomial, c)| sum + monomial.evaluate(x) * *c)
    }
}

impl Written {
    pub fn of<T: PolynomialDrift<2, M>, const M: usize>(system: &T) -> Self {
        let arena = Arena::new();
        let noise = system.noise(arena.variables());
        let entry = |row: &[Symbol<'_, 2>], k: usize| row.get(k).map_or_else(Terms::default, |g| Terms::of(*g));
        Written {
            drift: system.drift(arena.variables()).map(Terms::of),
            noise: noise.map(|row| std::array::from_fn(|k| entry(&row, k))),
            interpretation: system.interpretation(),
        }
    }
}

// Not inlined: the simulation's loops ask in many places.
impl PolynomialDrift<2, NOISES> for Written {
    #[inline(never)]
    fn drift<S: Scalar>(&self, x: [S; 2]) -> [S; 2] {
        self.drift.each_ref().map(|f| f.evaluate(&x))
    }

    #[inline(never)]
    fn noise<S: Scalar>(&self, x: [S; 2]) -> [[S; NOISES]; 2] {
        self.noise.each_ref().map(|row| row.each_ref().map(|g| g.evaluate(&x)))
    }

    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }
}

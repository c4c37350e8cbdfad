use crate::fokker_planck::{drift_along_noise, ito_drift, noise_induced_drift};
use crate::system::Amplified;
use crate::{Arena, FokkerPlanck, Interpretation, Polynomial, PolynomialDrift, Symbol};

/// One step of weak order 2, by a symmetric splitting: A(h/2) F(h/2) W(h) F(h/2) A(h/2).
///
/// - A moves every displacement straight on, x_i += τ x_j, with its velocity x_j frozen; that is exact, impacts
///   included, and lives in [`Passages`](super::passage::Passages).
/// - F is the flow of all other states under the Stratonovich drift with the displacements frozen, by the explicit
///   midpoint rule.
/// - W is the flow of the noise fields G_k for the increments √h Z_k. Where no field changes along any field, it is the
///   straight line x + G √h Z, exactly; that holds for every oscillator whose noise depends on displacements alone.
///   Elsewhere the fields act one after another, each by one classical Runge-Kutta step in the time √h Z_k, in an order
///   that is reversed with probability one half (S. Ninomiya and N. Victoir, 2008, doi:10.1080/13504860701413958).
///
/// Each part is exact or of third order locally and the composition is symmetric, so that stationary means are off by
/// O(h²). Explicit Euler-Maruyama would be off by O(h), and pumps energy into a weakly damped oscillator.
#[derive(Debug)]
pub(super) struct Scheme<'a, T, const N: usize, const M: usize> {
    system: Amplified<'a, T>,
    /// The time step h.
    pub(super) step: f64,
    /// Whether a step takes the noise of two steps of half its length, so that both follow the same Brownian path.
    pub(super) merged: bool,
    /// The displacements, each with its velocity.
    pub(super) pairs: Vec<(usize, usize)>,
    /// 1 for a state that F moves, 0 for a displacement.
    moves: [f64; N],
    /// Whether no noise field changes along any noise field.
    pub(super) straight: bool,
    /// Whether the drift is an Itô drift that differs from the Stratonovich drift.
    corrected: bool,
}

impl<'a, T: PolynomialDrift<N, M>, const N: usize, const M: usize> Scheme<'a, T, N, M> {
    /// The scheme for `system`, whose structure is read off its polynomials.
    pub(super) fn new(system: Amplified<'a, T>, operator: &FokkerPlanck<N>, step: f64) -> Self {
        let pairs: Vec<(usize, usize)> = (0..N)
            .filter_map(|i| operator.velocity_of(i).map(|j| (i, j)))
            .filter(|&(_, j)| operator.velocity_of(j).is_none())
            .collect();
        let moves: [f64; N] = std::array::from_fn(|i| f64::from(pairs.iter().all(|&(x, _)| x != i)));
        let arena = Arena::new();
        let noise = system.noise(arena.variables()).map(|row| row.map(Symbol::polynomial));
        let induced = noise_induced_drift(&noise);
        Scheme {
            system,
            step,
            merged: false,
            pairs,
            moves,
            straight: unchanged_along_itself(&noise),
            corrected: system.interpretation() == Interpretation::Ito && !induced.iter().all(Polynomial::is_zero),
        }
    }

    /// The Stratonovich drift.
    #[inline(always)]
    fn drift<const STRAIGHT: bool>(&self, x: [f64; N]) -> [f64; N] {
        let mut drift = self.system.drift(x);
        if !STRAIGHT && self.corrected {
            let induced = drift_along_noise(&self.system, x);
            for i in 0..N {
                drift[i] -= induced[i];
            }
        }
        drift
    }

    /// F(h/2). The factor 0 keeps displacements where they are without a branch.
    #[inline(always)]
    fn flow<const STRAIGHT: bool>(&self, x: [f64; N], h: f64) -> [f64; N] {
        let first = self.drift::<STRAIGHT>(x);
        let middle = std::array::from_fn(|i| x[i] + self.moves[i] * (h / 4.0) * first[i]);
        let second = self.drift::<STRAIGHT>(middle);
        std::array::from_fn(|i| x[i] + self.moves[i] * (h / 2.0) * second[i])
    }

    /// F(h/2) W(h) F(h/2) for the increments √h Z = `w`; `reversed` is the order of the fields.
    #[inline(always)]
    pub(super) fn kick<const STRAIGHT: bool>(&self, x: [f64; N], h: f64, w: [f64; M], reversed: bool) -> [f64; N] {
        let mut x = self.flow::<STRAIGHT>(x, h);
        if STRAIGHT {
            let noise = self.system.noise(x);
            for k in 0..M {
                for i in 0..N {
                    x[i] += noise[i][k] * w[k];
                }
            }
        } else {
            for k in 0..M {
                let k = if reversed { M - 1 - k } else { k };
                x = self.along_field(x, k, w[k]);
            }
        }
        self.flow::<STRAIGHT>(x, h)
    }

    /// The flow of the field G_k over the time s, by the classical Runge-Kutta rule.
    #[inline(always)]
    fn along_field(&self, x: [f64; N], k: usize, s: f64) -> [f64; N] {
        let field = |y: [f64; N]| self.system.noise(y).map(|row| row[k]);
        let ahead = |tau: f64, slope: [f64; N]| std::array::from_fn(|i| x[i] + tau * slope[i]);
        let k1 = field(x);
        let k2 = field(ahead(s / 2.0, k1));
        let k3 = field(ahead(s / 2.0, k2));
        let k4 = field(ahead(s, k3));
        std::array::from_fn(|i| x[i] + s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }

    /// The power that noise puts into state `v` and the power that the drift takes from it: ½B_vv and −v f_v, with the
    /// Itô drift f.
    pub(super) fn power(&self, v: usize, x: [f64; N]) -> [f64; 2] {
        let injected: f64 = self.system.noise(x)[v].iter().map(|g| g * g / 2.0).sum();
        [injected, -x[v] * ito_drift(&self.system, x)[v]]
    }
}

/// Whether (G_k·∇)G_l vanishes for all columns k and l of G.
fn unchanged_along_itself<const N: usize, const M: usize>(noise: &[[Polynomial<N>; M]; N]) -> bool {
    let along = |k: usize, entry: &Polynomial<N>| {
        (0..N).fold(Polynomial::zero(), |sum, j| sum + &noise[j][k] * &entry.derivative(j))
    };
    noise.iter().flatten().all(|entry| (0..M).all(|k| along(k, entry).is_zero()))
}

use crate::closure::SOLVED;
use crate::closure::space::sweep::{self, Function, Points, STRETCH, enter_coupled};
use crate::density::escape_direction;
use crate::fokker_planck::Local;
use crate::functions::{Corner, Functions, PlaneOperator, Scratch};
use crate::numerics::{EIGHT, Eight, Number};
use crate::parallel;
use crate::record::Read;
use crate::states::States;
use pulp::{Arch, NullaryFnOnce};
use serde::{Deserialize, Serialize};

/// ln p = Q₀ + c + Σ a_k φ_k.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Exponent {
    /// The walls whose grazing impacts make Q₀, which no function here can follow.
    pub(crate) known: Vec<Corner>,
    /// φ.
    pub(crate) space: Functions,
    /// c.
    pub(crate) constant: f64,
    /// a.
    pub(crate) coefficients: Vec<f64>,
}

impl Exponent {
    /// The value at a state.
    pub(in crate::closure) fn value(&self, x: &[f64]) -> f64 {
        self.at(x, &mut Scratch::default())
    }

    /// The values at many states.
    pub(in crate::closure) fn values(&self, points: &States) -> Vec<f64> {
        sweep::values(self, points)
    }

    /// The gradient at a state.
    pub(in crate::closure) fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let mut scratch = Scratch::default();
        self.space.place(x, &mut scratch);
        self.leave_gradient(x, &mut scratch);
        scratch.gradient
    }

    /// Leaves the gradient at the points placed in `scratch`.
    #[inline(always)]
    fn leave_gradient<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) {
        self.space.gradient(&self.coefficients, scratch);
        for corner in &self.known {
            corner.grazing_jet(x).add_gradient(&corner.forms(), T::everywhere(1.0), &mut scratch.gradient);
        }
    }

    /// Whether Q is a polynomial that falls in every direction.
    pub(in crate::closure) fn is_normalisable(&self) -> bool {
        self.space.polynomials().is_some_and(|polynomials| {
            let q = polynomials.in_powers(&self.coefficients);
            let least = SOLVED * q.max_coefficient();
            escape_direction(&q.filtered(|_, c| c.abs() > least), false, SOLVED).is_none()
        })
    }

    /// The residual of exp(Q) at many states, given the Fokker-Planck operator there.
    pub(in crate::closure) fn residuals<'l>(
        &self,
        points: &States,
        local: impl Fn(usize) -> &'l Local + Sync,
    ) -> Vec<f64> {
        self.swept(points, Some(&local), |_, residual, _| residual)
    }

    /// What `of` makes of each point's number, of the residual there, and of ∇Q.
    pub(in crate::closure) fn linearised<'l, R: Send>(
        &self,
        points: &States,
        local: impl Fn(usize) -> &'l Local + Sync,
        of: impl Fn(usize, f64, &[f64]) -> R + Sync,
    ) -> Vec<R> {
        self.swept(points, Some(&local), of)
    }

    /// What `of` makes of the gradient at each point.
    pub(in crate::closure) fn gradients<R: Send>(
        &self,
        points: &States,
        of: impl Fn(usize, &[f64]) -> R + Sync,
    ) -> Vec<R> {
        self.swept(points, None, |i, _, gradient| of(i, gradient))
    }

    fn swept<R: Send>(
        &self,
        points: &States,
        local: Option<LocalAt<'_, '_>>,
        of: impl Fn(usize, f64, &[f64]) -> R + Sync,
    ) -> Vec<R> {
        let stretch = |run: usize| {
            let mut all = Vec::with_capacity(STRETCH);
            let visit = &mut |i: usize, residual: f64, gradient: &[f64]| all.push(of(i, residual, gradient));
            let points = Points::run(points, run);
            Arch::new().dispatch(ResidualSweep { exponent: self, points, from: run * STRETCH, local, visit });
            all
        };
        let parts: Vec<Vec<R>> = parallel::map(points.len().div_ceil(STRETCH), stretch);
        parts.into_iter().flatten().collect()
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, states: usize) -> Read<Self> {
        let Exponent { known, space, constant, coefficients } = self;
        let space = space.checked(states)?;
        if coefficients.len() != space.len() {
            return Err(format!("there are {} coefficients for {} functions", coefficients.len(), space.len()));
        }
        if let Some(value) = coefficients.iter().chain([&constant]).find(|value| !value.is_finite()) {
            return Err(format!("a coefficient is {value}"));
        }
        let known = known.into_iter().map(|corner| corner.checked(states)).collect::<Read<_>>()?;
        Ok(Exponent { known, space, constant, coefficients })
    }
}

impl Function for Exponent {
    #[inline(always)]
    fn at<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) -> T {
        self.space.place_values(x, scratch);
        self.space.sum(&self.coefficients, scratch) + self.constant + known_value(&self.known, x)
    }
}

/// The Fokker-Planck operator at a point, by the point's number.
type LocalAt<'a, 'l> = &'a (dyn Fn(usize) -> &'l Local + Sync);

/// ∇Q and, given the Fokker-Planck operator, the residual of exp(Q) at a stretch of points: the image of Q under the part of the
/// operator that is linear in Q, and ½ ∇Q·B∇Q.
struct ResidualSweep<'a, 'l> {
    exponent: &'a Exponent,
    points: Points<'a>,
    /// The number of the first of them.
    from: usize,
    local: Option<LocalAt<'a, 'l>>,
    /// Takes the number of a point, the residual and the gradient.
    visit: &'a mut dyn FnMut(usize, f64, &[f64]),
}

impl NullaryFnOnce for ResidualSweep<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Exponent { known, space, coefficients, .. } = self.exponent;
        let n = self.points.states;
        let (mut x, mut backward, mut diffusion) =
            (vec![Eight::ZERO; n], vec![Eight::ZERO; n], vec![Eight::ZERO; n * n]);
        let (mut coupled, mut scratch, mut gradient) = (Vec::with_capacity(n), Scratch::default(), vec![0.0; n]);
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            space.place(&x, &mut scratch);
            let mut residual = Eight::ZERO;
            if let Some(local) = self.local {
                for l in 0..EIGHT {
                    let local = local(self.from + (first + l).min(self.points.len() - 1));
                    backward.iter_mut().enumerate().for_each(|(i, to)| to[l] = local.backward(i));
                    diffusion.iter_mut().zip(&local.diffusion).for_each(|(to, b)| to[l] = *b);
                    residual[l] = local.source();
                }
                enter_coupled(&diffusion, n, &mut coupled);
                space.apply((&backward, &diffusion), &coupled, &mut scratch);
                residual += space.sum_of_images(coefficients, &scratch);
                for corner in known {
                    residual +=
                        PlaneOperator::new(&corner.forms(), &backward, &diffusion).image(&corner.grazing_jet(&x));
                }
            }
            self.exponent.leave_gradient(&x, &mut scratch);
            if self.local.is_some() {
                for (i, slope) in scratch.gradient.iter().enumerate() {
                    for (j, other) in scratch.gradient.iter().enumerate() {
                        residual += diffusion[i * n + j] * 0.5 * *slope * *other;
                    }
                }
            }
            for l in 0..EIGHT.min(self.points.len() - first) {
                gradient.iter_mut().zip(&scratch.gradient).for_each(|(to, from): (&mut f64, &Eight)| *to = from[l]);
                (self.visit)(self.from + first + l, residual[l], &gradient);
            }
        }
    }
}

/// Q₀ at many states.
pub(in crate::closure) fn known_values(known: &[Corner], points: &States) -> Vec<f64> {
    if known.is_empty() { vec![0.0; points.len()] } else { sweep::values(&Known(known), points) }
}

struct Known<'a>(&'a [Corner]);

impl Function for Known<'_> {
    #[inline(always)]
    fn at<T: Number>(&self, x: &[T], _: &mut Scratch<T>) -> T {
        known_value(self.0, x)
    }
}

/// Q₀ at a state.
#[inline(always)]
pub(in crate::closure) fn known_value<T: Number>(known: &[Corner], x: &[T]) -> T {
    let mut sum = T::everywhere(0.0);
    for corner in known {
        sum += corner.singular_value(x);
    }
    sum
}

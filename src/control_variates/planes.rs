//! Functions of planes, (u, w) with two linear forms of the state, at eight points at a time.

use crate::numerics::{EIGHT, PointLane, ZEROS};
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// A state, or a difference of two states, with a sign and without a constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    pub(crate) sign: f64,
    pub(crate) first: usize,
    pub(crate) second: Option<usize>,
}

impl Form {
    /// Its states with their coefficients.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        std::iter::once((self.first, self.sign)).chain(self.second.map(|second| (second, -self.sign)))
    }

    /// The same combination of numbers that belong to the states.
    #[inline(always)]
    pub(crate) fn of(&self, x: &[PointLane]) -> PointLane {
        let mut form = ZEROS;
        for (i, sign) in self.parts() {
            let x = x[i];
            (0..EIGHT).for_each(|l| form[l] += sign * x[l]);
        }
        form
    }

    /// B of this form and another, from B of `n` states by rows.
    #[inline(always)]
    pub(crate) fn diffusion(&self, other: &Form, b: &[PointLane], n: usize) -> PointLane {
        let mut sum = ZEROS;
        for (i, first) in self.parts() {
            for (j, second) in other.parts() {
                let b = b[i * n + j];
                (0..EIGHT).for_each(|l| sum[l] += first * second * b[l]);
            }
        }
        sum
    }
}

/// A value with its derivatives in two variables: f, f_u, f_w, f_uu, f_uw, f_ww.
pub(crate) type PlaneLanes = [PointLane; 6];

/// Functions of one plane.
pub(crate) trait PlaneFunctions: Debug + Send + Sync {
    /// u, up to a constant, and w.
    fn forms(&self) -> [Form; 2];

    /// How many functions.
    fn len(&self) -> usize;

    /// Their values at eight points.
    fn values(&self, x: &[PointLane], functions: &mut [PlaneLanes]);

    /// Their values and derivatives.
    fn jets(&self, x: &[PointLane], functions: &mut [PlaneLanes]);
}

/// The functions of several planes, one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Planes(pub(crate) Vec<Arc<dyn PlaneFunctions>>);

impl Planes {
    /// The number of functions.
    pub(super) fn len(&self) -> usize {
        self.0.iter().map(|plane| plane.len()).sum()
    }

    /// Whether a function changes with a state.
    pub(super) fn changes_with(&self, function: usize, state: usize) -> bool {
        let plane = self.each().find(|(range, _)| range.contains(&function));
        plane.is_some_and(|(_, plane)| plane.forms().iter().any(|form| form.parts().any(|(own, _)| own == state)))
    }

    /// Each plane with the places of its functions.
    fn each(&self) -> impl Iterator<Item = (Range<usize>, &Arc<dyn PlaneFunctions>)> {
        self.0.iter().scan(0, |next, plane| {
            let begin = *next;
            *next += plane.len();
            Some((begin..*next, plane))
        })
    }

    /// Fills values and derivatives.
    #[inline(always)]
    pub(super) fn place(&self, x: &[PointLane], jets: &mut [PlaneLanes]) {
        self.each().for_each(|(range, plane)| plane.jets(x, &mut jets[range]));
    }

    /// Fills the values alone.
    #[inline(always)]
    pub(super) fn place_values(&self, x: &[PointLane], jets: &mut [PlaneLanes]) {
        self.each().for_each(|(range, plane)| plane.values(x, &mut jets[range]));
    }

    /// Fills the images b·∇f + ½ B:∇∇f.
    #[inline(always)]
    pub(super) fn apply(
        &self,
        (b, second): (&[PointLane], &[PointLane]),
        jets: &[PlaneLanes],
        images: &mut [PointLane],
    ) {
        for (range, plane) in self.each() {
            let forms = plane.forms();
            let [b_u, b_w] = [0, 1].map(|form| forms[form].of(b));
            let [uu, uw, ww] = [(0, 0), (0, 1), (1, 1)].map(|(i, j)| forms[i].diffusion(&forms[j], second, b.len()));
            for k in range {
                let [_, u, w, of_uu, of_uw, of_ww] = jets[k];
                images[k] = std::array::from_fn(|l| {
                    let bent = 0.5 * (uu[l] * of_uu[l] + ww[l] * of_ww[l]) + uw[l] * of_uw[l];
                    b_u[l] * u[l] + b_w[l] * w[l] + bent
                });
            }
        }
    }

    /// Enters the derivatives in the states `coupled`, behind those of the constant.
    #[inline(always)]
    pub(super) fn slopes(&self, coupled: &[usize], jets: &[PlaneLanes], slopes: &mut [Vec<PointLane>]) {
        for (range, plane) in self.each() {
            let forms = plane.forms();
            for k in range {
                coupled.iter().for_each(|&c| slopes[c][1 + k] = ZEROS);
                for (form, slope) in forms.iter().zip([jets[k][1], jets[k][2]]) {
                    for (c, sign) in form.parts().filter(|(c, _)| coupled.contains(c)) {
                        let sum = &mut slopes[c][1 + k];
                        (0..EIGHT).for_each(|l| sum[l] += sign * slope[l]);
                    }
                }
            }
        }
    }

    /// Adds Σ s_k ∇f_k, s_k being the `sensitivity` of a sum to function k.
    #[inline(always)]
    pub(super) fn add_gradient(&self, sensitivity: &[PointLane], jets: &[PlaneLanes], gradient: &mut [PointLane]) {
        for (range, plane) in self.each() {
            let forms = plane.forms();
            for k in range {
                let own = sensitivity[k];
                for (form, slope) in forms.iter().zip([jets[k][1], jets[k][2]]) {
                    for (i, sign) in form.parts() {
                        let sum = &mut gradient[i];
                        (0..EIGHT).for_each(|l| sum[l] += sign * own[l] * slope[l]);
                    }
                }
            }
        }
    }
}

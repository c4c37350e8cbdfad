use super::degrees::Degrees;
use super::space::{Polynomials, Space};
use super::symmetry::Symmetry;
use std::sync::Arc;

/// The degree of a reference above that of the closure, where nothing singular is in the way.
const EXCESS: u32 = 8;

/// The nested spaces that an order needs. Each but the last holds the first functions of the next.
pub(super) struct Ladder<const N: usize> {
    /// What the closure's Q is made of.
    pub(super) answer: Arc<dyn Space<N> + Send>,
    /// What the reference's weight is made of; it contains the answer's functions, though not as its first.
    pub(super) weight: Arc<dyn Space<N> + Send>,
    /// What the correction of the weight is made of, and what the moment equations are tested with.
    pub(super) all: Arc<dyn Space<N> + Send>,
    /// The columns, the constant's included, of `all` that hold the answer, the weight, and all but the last degrees.
    pub(super) answer_columns: usize,
    pub(super) weight_columns: usize,
    pub(super) lower_columns: usize,
    /// The columns whose share in the correction tells its error, and the end of what is kept of it: all, or less than that.
    pub(super) whole: Band,
    pub(super) cut: Option<Band>,
}

/// Columns by which a correction is judged, and where it ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    pub(super) judged: usize,
    pub(super) end: usize,
}

impl<const N: usize> Ladder<N> {
    /// The ladder of the answer's space, the weight's, all functions but those of the last degrees, and all.
    pub(super) fn new([answer, weight, lower, all]: [Arc<impl Space<N> + Send + 'static>; 4]) -> Self {
        Ladder {
            answer_columns: answer.len() + 1,
            weight_columns: weight.len() + 1,
            lower_columns: lower.len() + 1,
            whole: Band { judged: lower.len() + 1, end: all.len() + 1 },
            cut: None,
            answer,
            weight,
            all,
        }
    }
}

/// The highest degrees, where the edge of the domain shows as ripples; a correction may be cut off below them.
const BUFFER: u32 = 4;

/// The spaces of all orders for one system.
pub(super) trait Family<const N: usize>: Send + Sync {
    fn ladder(&self, order: u32) -> Ladder<N>;
}

/// Complete polynomials with the system's symmetry.
#[derive(Clone, Debug)]
pub(super) struct Smooth<const N: usize> {
    pub(super) degrees: Degrees<N>,
    pub(super) symmetry: Symmetry<N>,
    pub(super) centre: [f64; N],
    pub(super) half_width: [f64; N],
}

impl<const N: usize> Smooth<N> {
    pub(super) fn polynomials(&self, degree: u32) -> Polynomials<N> {
        let exponents = self.degrees.exponents(degree, |alpha| self.symmetry.keeps(alpha));
        Polynomials::new(self.centre, self.half_width, exponents)
    }
}

impl<const N: usize> Family<N> for Smooth<N> {
    fn ladder(&self, order: u32) -> Ladder<N> {
        let degree = order + EXCESS;
        // A weight of low degree serves a low order, and is faster.
        let weight = order.max(if order < 6 { 8 } else { 12 });
        let [answer, weight, lower, all] = [order, weight, degree - 2, degree].map(|d| Arc::new(self.polynomials(d)));
        let [judged, end] = [BUFFER + 2, BUFFER].map(|less| self.polynomials(degree - less).len() + 1);
        Ladder { cut: Some(Band { judged, end }), ..Ladder::new([answer, weight, lower, all]) }
    }
}

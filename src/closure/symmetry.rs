use crate::{FokkerPlanck, Monomial, Polynomial};

/// The most states whose sign changes are searched one by one; beyond, only that of all states together.
const SEARCHED: usize = 12;

/// The sign changes of states that leave the Fokker-Planck equation as it is, x_i → s_i x_i.
///
/// A unique stationary density has the symmetries of its equation: only functions that share them are needed, and every
/// state of a simulation stands for its mirror images too.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Symmetry<const N: usize> {
    /// Which states each change flips; never empty, the first flips none.
    changes: Vec<[bool; N]>,
}

impl<const N: usize> Symmetry<N> {
    /// No symmetry at all.
    pub(super) fn none() -> Self {
        Symmetry { changes: vec![[false; N]] }
    }

    /// The symmetries of an operator: f_i(s x) = s_i f_i(x) and B_ij(s x) = s_i s_j B_ij(x), term by term.
    pub(super) fn of(operator: &FokkerPlanck<N>) -> Self {
        let all: Vec<[bool; N]> = if N <= SEARCHED {
            (0..1_u32 << N).map(|bits| std::array::from_fn(|i| bits >> i & 1 == 1)).collect()
        } else {
            vec![[false; N], [true; N]]
        };
        let odd = |flip: &[bool; N], m: &Monomial<N>| (0..N).filter(|&i| flip[i] && m.0[i] % 2 == 1).count() % 2 == 1;
        let turns = |p: &Polynomial<N>, flip: &[bool; N], sign: bool| p.terms().all(|(m, _)| odd(flip, m) == sign);
        let kept = |flip: &[bool; N]| {
            (0..N).all(|i| {
                turns(&operator.drift()[i], flip, flip[i])
                    && (0..N).all(|j| turns(&operator.diffusion()[i][j], flip, flip[i] != flip[j]))
            })
        };
        Symmetry { changes: all.into_iter().filter(kept).collect() }
    }

    /// Whether a monomial is the same at all mirror images.
    pub(super) fn keeps(&self, exponents: &[u32; N]) -> bool {
        self.changes.iter().all(|flip| (0..N).filter(|&i| flip[i] && exponents[i] % 2 == 1).count() % 2 == 0)
    }

    /// Whether some change flips this state, so that its mean is zero.
    pub(super) fn flips(&self, state: usize) -> bool {
        self.changes.iter().any(|flip| flip[state])
    }

    /// A state and its mirror images.
    pub(super) fn images(&self, x: [f64; N]) -> impl Iterator<Item = [f64; N]> + '_ {
        self.changes.iter().map(move |flip| std::array::from_fn(|i| if flip[i] { -x[i] } else { x[i] }))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::models::{Duffing, DuffingChain};

    #[test]
    fn oscillators_are_odd_and_uncoupled_ones_twice() {
        let duffing = FokkerPlanck::new(&Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap()).unwrap();
        let symmetry = Symmetry::of(&duffing);
        assert_eq!(symmetry.changes, [[false; 2], [true; 2]]);
        assert!(symmetry.keeps(&[1, 1]) && symmetry.keeps(&[0, 4]) && !symmetry.keeps(&[2, 1]));
        let _ = DuffingChain::<2>::new;
    }
}

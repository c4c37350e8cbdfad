use crate::elementary::Parity;
use crate::fokker_planck::{FokkerPlanck, ImpulseTerm};
use crate::polynomial::{Polynomial, odd};
use nalgebra::DMatrix;

/// The most states whose sign changes are searched one by one; beyond, only that of all states together.
const SEARCHED: usize = 12;

/// The sign changes of states that leave the Fokker-Planck equation as it is, x_i → s_i x_i.
///
/// A unique stationary density has the symmetries of its equation: only functions that share them are needed, and every
/// state of a simulation stands for its mirror images too.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Symmetry {
    /// Which states each change flips; never empty, the first flips none.
    changes: Vec<Vec<bool>>,
}

impl Symmetry {
    /// No symmetry at all.
    pub(crate) fn none(states: usize) -> Self {
        Symmetry { changes: vec![vec![false; states]] }
    }

    /// The symmetries of an operator: f_i(s x) = s_i f_i(x) and B_ij(s x) = s_i s_j B_ij(x), term by term, and H_i(s x) = s_i H_i(x)
    /// for impulses, or −s_i H_i(x) where −Y has the law of Y.
    pub(super) fn of(operator: &FokkerPlanck) -> Self {
        let n = operator.dimension();
        let all: Vec<Vec<bool>> = if n <= SEARCHED {
            (0..1_u32 << n).map(|bits| (0..n).map(|i| bits >> i & 1 == 1).collect()).collect()
        } else {
            vec![vec![false; n], vec![true; n]]
        };
        Symmetry { changes: all }.and_of(operator)
    }

    /// Those that leave another operator as it is, too.
    pub(crate) fn and_of(mut self, operator: &FokkerPlanck) -> Self {
        let n = operator.dimension();
        let terms = operator.impulse_terms();
        let struck = |flip: &[bool], term: &ImpulseTerm| {
            let all = |turned: bool| term.fields().all(|(i, h)| turns(h, flip, flip[i] != turned));
            all(false) || term.is_symmetric() && all(true)
        };
        self.changes.retain(|flip| {
            terms.iter().all(|term| struck(flip, term))
                && (0..n).all(|i| {
                    turns(&operator.drift()[i], flip, flip[i])
                        && (0..n).all(|j| turns(&operator.diffusion()[i][j], flip, flip[i] != flip[j]))
                })
        });
        self
    }

    /// Those that flip none of these states.
    pub(crate) fn without_flips_of(mut self, states: impl Iterator<Item = usize>) -> Self {
        states.for_each(|state| self.changes.retain(|flip| !flip[state]));
        self
    }

    /// The same for all states but one.
    pub(crate) fn without(&self, state: usize) -> Self {
        let mut changes = self.changes.clone();
        for flip in &mut changes {
            flip.remove(state);
        }
        Symmetry { changes }
    }

    /// The changes, the first of which flips none: whether each flips a state.
    pub(crate) fn changes(&self) -> &[Vec<bool>] {
        &self.changes
    }

    /// The number of states.
    pub(crate) fn dimension(&self) -> usize {
        self.changes.first().map_or(0, Vec::len)
    }

    /// Whether a monomial is the same at all mirror images.
    pub(crate) fn keeps(&self, alpha: &[u32]) -> bool {
        self.changes.iter().all(|flip| !odd(flip, alpha))
    }

    /// The fewest changes of which all are made. The changes are a group in the order of binary numbers, where these are number 1, 2,
    /// 4 and so on.
    pub(crate) fn generators(&self) -> Vec<Vec<bool>> {
        let places = std::iter::successors(Some(1), |place| Some(2 * place));
        places.map_while(|place: usize| self.changes.get(place).cloned()).collect()
    }

    /// Mean products of two states each, made those of all mirror images together: some are zero.
    pub(crate) fn average(&self, products: &mut DMatrix<f64>) {
        for flip in &self.changes {
            for (i, j) in (0..flip.len()).flat_map(|i| (0..flip.len()).map(move |j| (i, j))) {
                if flip[i] != flip[j] {
                    products[(i, j)] = 0.0;
                }
            }
        }
    }

    /// The number of mirror images of a state that differ, itself included. None unless it is the first of them in the order of
    /// numbers, which stands for all.
    pub(crate) fn stands_for(&self, x: &[f64]) -> Option<usize> {
        let mut same = 0;
        for flip in &self.changes {
            match x.iter().zip(flip).find(|(x, flipped)| **flipped && **x != 0.0) {
                Some((x, _)) if *x > 0.0 => return None,
                Some(_) => {}
                None => same += 1,
            }
        }
        Some(self.changes.len() / same)
    }

    /// Whether some change flips this state, so that its mean is zero.
    pub(crate) fn flips(&self, state: usize) -> bool {
        self.changes.iter().any(|flip| flip[state])
    }

    /// The number of mirror images of a state, itself included.
    pub(crate) fn count(&self) -> usize {
        self.changes.len()
    }

    /// Mirror image `k` of a state, of which number 0 is the state itself.
    pub(crate) fn reflect(&self, k: usize, x: &[f64], image: &mut [f64]) {
        for ((image, x), flipped) in image.iter_mut().zip(x).zip(&self.changes[k]) {
            *image = if *flipped { -x } else { *x };
        }
    }

    /// A state and its mirror images.
    pub(crate) fn images(&self, x: &[f64]) -> impl Iterator<Item = Vec<f64>> {
        (0..self.count()).map(move |k| {
            let mut image = vec![0.0; x.len()];
            self.reflect(k, x, &mut image);
            image
        })
    }
}

/// Whether a polynomial changes its sign where these states do, or does not, by `sign`.
fn turns(p: &Polynomial, flip: &[bool], sign: bool) -> bool {
    p.is_zero() || p.parity(flip) == if sign { Parity::Odd } else { Parity::Even }
}

#[cfg(test)]
mod tests {
    use crate::models::{Duffing, DuffingChain};
    use crate::problem::Problem;

    /// Each of two uncoupled oscillators may be turned on its own, coupled ones only together.
    #[test]
    fn oscillators_are_odd_and_uncoupled_ones_twice() {
        let duffing = Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap()).unwrap().symmetry();
        assert_eq!(duffing.changes, [[false; 2], [true; 2]]);
        assert!(duffing.keeps(&[1, 1]) && duffing.keeps(&[0, 4]) && !duffing.keeps(&[2, 1]));
        let chain = |coupling: f64| {
            let chain = DuffingChain::new(&[0.2, 0.3], 1.0, 0.3, coupling, 1.0).unwrap();
            Problem::of(chain).unwrap().symmetry()
        };
        assert_eq!(chain(0.5).changes, [[false; 4], [true; 4]]);
        assert_eq!(chain(0.0).count(), 4);
        assert!(chain(0.0).flips(0) && !chain(0.0).keeps(&[1, 0, 1, 0]) && chain(0.5).keeps(&[1, 0, 1, 0]));
        assert_eq!(duffing.images(&[1.0, -2.0]).collect::<Vec<_>>(), [[1.0, -2.0], [-1.0, 2.0]]);
        assert_eq!(chain(0.0).generators().len(), 2);
        let stands = |x: &[f64]| chain(0.0).stands_for(x);
        assert_eq!([stands(&[-1.0, 2.0, 0.0, 0.0]), stands(&[0.0, -1.0, 0.0, -2.0])], [Some(2), Some(4)]);
        assert_eq!([stands(&[-1.0, 2.0, 0.0, 1.0]), stands(&[0.0; 4])], [None, Some(1)]);
    }
}

//! Systems whose moment equations close degree by degree.

use expoly::{Polynomial, Problem};
use nalgebra::{DMatrix, DVector};

/// The exact moment of a linear system with impulses and noise that do not depend on the state: E\[𝓖ψ\] = 0 for all monomials ψ up to
/// its degree.
pub(crate) fn moments_of_linear(problem: &Problem, powers: &[u32]) -> f64 {
    let (n, degree) = (problem.dimension(), powers.iter().sum::<u32>());
    let mut all: Vec<Vec<u32>> = vec![Vec::new()];
    for _ in 0..n {
        let longer =
            |alpha: &Vec<u32>| (0..=degree).map(|power| [alpha.as_slice(), &[power]].concat()).collect::<Vec<_>>();
        all = all.iter().flat_map(longer).filter(|alpha| alpha.iter().sum::<u32>() <= degree).collect();
    }
    all.retain(|alpha| alpha.iter().any(|power| *power > 0));
    let place = |alpha: &[u32]| all.iter().position(|other| other == alpha);
    let (mut matrix, mut right) = (DMatrix::zeros(all.len(), all.len()), DVector::zeros(all.len()));
    for (row, alpha) in all.iter().enumerate() {
        let statistic = Polynomial::from_terms(n, [(alpha.as_slice(), 1.0)]).unwrap();
        for (beta, c) in problem.operator().generator(&statistic).terms() {
            match place(beta) {
                Some(column) => matrix[(row, column)] += c,
                None => right[row] -= c,
            }
        }
    }
    matrix.lu().solve(&right).unwrap()[place(powers).unwrap()]
}

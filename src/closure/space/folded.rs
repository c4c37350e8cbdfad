//! Products of polynomials with functions that have a kink where the drift has a kink or a jump.

use super::degrees::Degrees;
use crate::functions::Fold;
use crate::numerics::sort_by_number;
use crate::problem::{Surface, Symmetry};

/// The folds that ln p has at some surfaces, and the part of a symmetry that they have as well.
pub(in crate::closure) fn at(surfaces: &[Surface], symmetry: &Symmetry) -> (Vec<Fold>, Symmetry) {
    let fold = |&Surface { state, place, power, .. }: &Surface| Fold { state, place, power };
    let folds: Vec<Fold> = surfaces.iter().map(fold).collect();
    // The image of a fold at another place than 0 is elsewhere.
    let turned = folds.iter().filter(|fold| fold.place != 0.0 || fold.is_odd().is_none()).map(|fold| fold.state);
    (folds.clone(), symmetry.clone().without_flips_of(turned))
}

/// The exponents up to a degree, and those of products with folds, which count by their powers: those of a smaller degree come first.
pub(in crate::closure) fn exponents(
    degrees: &Degrees,
    degree: u32,
    symmetry: &Symmetry,
    folds: &[Fold],
) -> Vec<Vec<u32>> {
    let mut all = degrees.exponents(symmetry.dimension(), degree, |alpha| symmetry.keeps(alpha));
    if !folds.is_empty() {
        all.extend(products(degrees, symmetry, folds, |fold| degree.checked_sub(fold.degree())));
        sort_by_number(&mut all, |alpha| f64::from(Fold::degree_of(alpha, folds)));
    }
    all
}

/// Those of products of folds with polynomials up to a degree, none where there is none.
pub(in crate::closure) fn products(
    degrees: &Degrees,
    symmetry: &Symmetry,
    folds: &[Fold],
    degree: impl Fn(&Fold) -> Option<u32>,
) -> Vec<Vec<u32>> {
    let states = symmetry.dimension();
    let with = |(number, fold): (usize, &Fold)| -> Vec<Vec<u32>> {
        let Some(degree) = degree(fold) else { return Vec::new() };
        // An odd fold has the parity of the first power.
        let odd = u32::from(fold.is_odd() == Some(true));
        let keeps = |alpha: &[u32]| {
            let parity = |i: usize| if i == fold.state { alpha[i] + odd } else { alpha[i] };
            symmetry.keeps(&(0..states).map(parity).collect::<Vec<_>>())
        };
        let constant = Some(vec![0; states]).filter(|alpha| keeps(alpha));
        let all = constant.into_iter().chain(degrees.exponents(states, degree, keeps));
        all.map(|mut alpha| {
            alpha[fold.state] = Fold::code(number, alpha[fold.state]);
            alpha
        })
        .collect()
    };
    folds.iter().enumerate().flat_map(with).collect()
}

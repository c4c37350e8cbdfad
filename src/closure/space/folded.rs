//! Products of polynomials with functions that have a kink where the drift has a kink or a jump.

use super::degrees::Degrees;
use crate::functions::{Curve, Fold};
use crate::numerics::sort_by_number;
use crate::polynomial::Polynomial;
use crate::problem::{Problem, Surface, Symmetry};

/// The folds that ln p has at some surfaces, and the part of a symmetry that they have as well.
pub(in crate::closure) fn at(surfaces: &[Surface], symmetry: &Symmetry) -> (Vec<Fold>, Symmetry) {
    let fold = |&Surface { state, place, power, .. }: &Surface| Fold { state, place, power, curve: None };
    let folds: Vec<Fold> = surfaces.iter().map(fold).collect();
    // The image of a fold at another place than 0 is elsewhere.
    let turned = folds.iter().filter(|fold| fold.place != 0.0 || fold.is_odd().is_none()).map(|fold| fold.state);
    (folds.clone(), symmetry.clone().without_flips_of(turned))
}

/// The potential U(x) = ∫ h(x, 0) dx of an oscillator x″ + h(x, x′) = ξ, and the integral of its friction ∫ h(0, v) dv, where these are no
/// polynomials, on a box; of one state the exponent ∫ 2f/B dx. Where damping is linear exp(−(c/D)(v²/2 + U)) is the density.
pub(in crate::closure) fn potentials(problem: &Problem, bounds: &[[f64; 2]]) -> Vec<Fold> {
    let operator = problem.operator();
    let curve = |state: usize, degree: f64, slope: &dyn Fn(f64) -> f64| {
        let curve = Curve::integral(slope, bounds[state])?;
        Some(Fold { state, place: 0.0, power: degree, curve: Some(curve) })
    };
    let depends = |f: &Polynomial, i: usize| f.all_functions().iter().any(|of| of.argument.contains(i));
    match (problem.dimension(), problem.displacements()) {
        (1, _) if !operator.is_polynomial() => {
            let (f, b) = (&operator.drift()[0], &operator.diffusion()[0][0]);
            curve(0, 1.0, &|x| f.evaluate(&[x]) / b.evaluate(&[x])).into_iter().collect()
        }
        (2, [(x, v)]) => {
            let f = &operator.drift()[*v];
            let at = |state: usize, value: f64| {
                let mut place = [0.0; 2];
                place[state] = value;
                f.evaluate(&place)
            };
            let potential = depends(f, *x).then(|| curve(*x, 2.0, &|value| at(*x, value))).flatten();
            let rest = at(*v, 0.0);
            let friction = depends(f, *v).then(|| curve(*v, 1.0, &|value| at(*v, value) - rest)).flatten();
            potential.into_iter().chain(friction).collect()
        }
        _ => Vec::new(),
    }
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

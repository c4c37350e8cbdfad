//! Products of polynomials with functions that have a kink where the drift has a kink or a jump.

use super::degrees::Degrees;
use super::sweep;
use crate::functions::{Curve, Fold, Functions, Polynomials};
use crate::numerics::{sort_by_number, triangle};
use crate::polynomial::Polynomial;
use crate::problem::{Problem, Surface, Symmetry};
use crate::states::States;
use faer::{Col, Mat, Scale};

/// A product with a curve of which no more than this share is no combination of other functions is one of them: tables are right to
/// 1e-14 of their range, and next to a kink like that of a force of the power 1.5 to 1e-8.
const DEPENDENT: f64 = 1e-7;

/// The interval on which a function of a state with a slope is tabulated.
pub(in crate::closure) type Known<'a> = &'a dyn Fn(usize, &dyn Fn(f64) -> f64) -> [f64; 2];

/// The folds that ln p has at some surfaces, and the part of a symmetry that they have as well.
pub(in crate::closure) fn at(surfaces: &[Surface], symmetry: &Symmetry) -> (Vec<Fold>, Symmetry) {
    let fold = |&Surface { state, place, power, .. }: &Surface| Fold { state, place, power, curve: None };
    let folds: Vec<Fold> = surfaces.iter().map(fold).collect();
    // The image of a fold at another place than 0 is elsewhere.
    let turned = folds.iter().filter(|fold| fold.place != 0.0 || fold.is_odd().is_none()).map(|fold| fold.state);
    (folds.clone(), symmetry.clone().without_flips_of(turned))
}

/// The potential U(x) = ∫ h(x, 0) dx of an oscillator x″ + h(x, x′) = ξ, and the integral of its friction ∫ h(0, v) dv, where these are no
/// polynomials, on the interval that `known` gives for a state and the slope; of one state −ln p = ∫ (B′ − 2f)/B dx itself. Where damping is
/// linear exp(−(c/D)(v²/2 + U)) is the density.
pub(in crate::closure) fn potentials(problem: &Problem, known: Known<'_>) -> Vec<Fold> {
    let operator = problem.operator();
    let curve = |state: usize, degree: f64, slope: &dyn Fn(f64) -> f64| {
        let own = problem.surfaces().iter().filter(|surface| surface.state == state);
        let places: Vec<f64> = own.map(|surface| surface.place).collect();
        let curve = Curve::integral(slope, known(state, slope), &places)?;
        Some(Fold { state, place: 0.0, power: degree, curve: Some(curve) })
    };
    let depends = |f: &Polynomial, i: usize| f.all_functions().iter().any(|of| of.argument.contains(i));
    match (problem.dimension(), problem.displacements()) {
        (1, _) if !operator.is_polynomial() => {
            let (f, b) = (&operator.drift()[0], &operator.diffusion()[0][0]);
            let spread = b.derivative(0);
            let slope = |x: f64| (spread.evaluate(&[x]) - 2.0 * f.evaluate(&[x])) / b.evaluate(&[x]);
            curve(0, 1.0, &slope).into_iter().collect()
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

/// The same without products with a curve that are combinations of the other functions at some points. A force that is no polynomial may
/// be one where the other state is 0: Q has its potential then already, but not the products of this with that state.
pub(in crate::closure) fn independent(space: Functions, points: &States) -> Functions {
    let Some(all) = space.on_one_box().filter(|all| all.folds().iter().any(|fold| fold.curve.is_some())) else {
        return space;
    };
    let mut values = Mat::zeros(points.len(), space.len() + 1);
    sweep::tabulate(&space, points, values.as_mut());
    // Its columns have the products of the functions' values with each other.
    let columns = triangle(values.as_ref(), &vec![1.0; points.len()]);
    let is_of_curve = |alpha: &[u32]| {
        let fold = alpha.iter().find_map(|&exponent| Fold::decoded(exponent).0);
        fold.is_some_and(|fold| all.folds()[fold].curve.is_some())
    };
    let (products, others): (Vec<usize>, Vec<usize>) =
        (0..space.len()).partition(|k| is_of_curve(&all.exponents()[*k]));
    let mut basis: Vec<Col<f64>> = Vec::new();
    // Twice, as once leaves rounding.
    let rest_of = |basis: &[Col<f64>], column: usize| {
        let column = columns.col(column).to_owned();
        let less = |rest: Col<f64>, part: &Col<f64>| &rest - Scale(part.transpose() * &rest) * part;
        let rest = (0..2).fold(column.clone(), |rest, _| basis.iter().fold(rest, less));
        (rest.norm_l2() / column.norm_l2(), rest)
    };
    let mut kept = Vec::new();
    for column in std::iter::once(0).chain(others.into_iter().chain(products).map(|k| k + 1)) {
        let (share, rest) = rest_of(&basis, column);
        if share > DEPENDENT {
            basis.push(&rest * Scale(rest.norm_l2().recip()));
            kept.push(column);
        }
    }
    let exponents: Vec<Vec<u32>> =
        (0..space.len()).filter(|k| kept.contains(&(k + 1))).map(|k| all.exponents()[k].clone()).collect();
    let used = exponents.iter().flatten().filter_map(|&exponent| Fold::decoded(exponent).0).max();
    let folds = all.folds()[..used.map_or(0, |last| last + 1)].to_vec();
    let (centre, half_width) = (all.centre().to_vec(), all.half_width().to_vec());
    Polynomials::new(centre, half_width, exponents).folded(folds).into()
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

//! Integrals over the planes and lines in which states that the mesh's axes are not have a value.
//!
//! Where x = S y, the plane x_i = c cuts cells obliquely. One of the axes is eliminated for each state that has a value: what is left of
//! a cell is a polygon, or an interval, on which p is a polynomial.

use super::along::Along;
use super::field::GridField;
use super::shape::{MOST, Place};
use super::shear::Shear;
use crate::numerics::{Rule, sort_by_number};
use crate::parallel;

/// Nodes along a piece beyond those that a polynomial of a cell's degree takes: on a plane its degree in a direction is up to three
/// times that, of which little is left where a cell resolves the density.
const MORE: usize = 2;

/// ∫ Π g_i(x_i) p dx with x = S y, where p is a function of y and some states have a value.
///
/// A range without a value, of one state alone, is the integral of its density.
pub(super) fn integral(field: &GridField, shear: &Shear, factors: &[Along<'_>]) -> f64 {
    let with_value = factors.iter().any(|factor| matches!(factor, Along::At(_)));
    let ranged = factors.iter().position(|factor| matches!(factor, Along::Function(_, _, range) if bounded(*range)));
    match ranged.filter(|_| !with_value) {
        Some(state) => over_range(field, shear, factors, state),
        None if with_value => Section::new(field, shear, factors).map_or(0.0, |section| section.integral()),
        None => over_nodes(field, shear, factors),
    }
}

fn bounded(range: [f64; 2]) -> bool {
    range.iter().any(|limit| limit.is_finite())
}

/// Everywhere: at nodes of the cells.
fn over_nodes(field: &GridField, shear: &Shear, factors: &[Along<'_>]) -> f64 {
    let degree = |factor: &Along<'_>| if let Along::Function(_, degree, _) = factor { *degree } else { 0 };
    let rule = field.shape.rule(factors.iter().map(degree).sum());
    field.sum_over_nodes(&rule, |y, p| {
        let x = shear.state(y);
        let value = |(factor, x): (&Along<'_>, f64)| if let Along::Function(g, ..) = factor { g(x) } else { 1.0 };
        p * factors.iter().zip(x).map(value).product::<f64>()
    })
}

/// Over a range of a state: between the places at which its planes pass a corner of a cell the cell's part is a polynomial.
fn over_range(field: &GridField, shear: &Shear, factors: &[Along<'_>], state: usize) -> f64 {
    let Along::Function(g, degree, [low, high]) = factors[state] else { return 0.0 };
    let row = shear.row(state);
    let part = |number: usize| {
        let cell = &field.mesh.cells[number];
        let corner = |k: usize| -> f64 {
            let end = |axis: usize| if k >> axis & 1 == 0 { cell.lower[axis] } else { cell.upper(axis) };
            (0..MOST).map(|axis| row[axis] * (field.mesh.origin[axis] + end(axis))).sum()
        };
        let mut ends: Vec<f64> = (0..1 << MOST).map(|k| corner(k).clamp(low, high)).collect();
        sort_by_number(&mut ends, |end| *end);
        ends.dedup();
        let rule = field.shape.rule(degree + 2 * MORE);
        let mut sum = 0.0;
        for ends in ends.windows(2) {
            for (place, weight) in rule.on(ends[0], ends[1]).iter() {
                let at: Vec<Along<'_>> = (0..MOST)
                    .map(|i| match &factors[i] {
                        _ if i == state => Along::At(place),
                        Along::Function(g, degree, range) => Along::Function(*g, *degree, *range),
                        _ => Along::All,
                    })
                    .collect();
                let section = Section::new(field, shear, &at);
                sum += weight * g(place) * section.map_or(0.0, |section| section.of_cell(number));
            }
        }
        sum
    };
    parallel::map(field.mesh.cells.len(), part).iter().sum()
}

/// An affine function of y, or of what is left free: constant and factors.
#[derive(Clone, Copy, Debug)]
struct Affine {
    constant: f64,
    factors: Place,
}

impl Affine {
    fn at(&self, y: &Place) -> f64 {
        self.constant + (0..MOST).map(|axis| self.factors[axis] * y[axis]).sum::<f64>()
    }

    /// With another function in the place of an axis.
    fn with(&self, axis: usize, other: &Affine) -> Self {
        let factor = self.factors[axis];
        let mut factors = self.factors;
        factors[axis] = 0.0;
        (0..MOST).for_each(|k| factors[k] += factor * other.factors[k]);
        Affine { constant: self.constant + factor * other.constant, factors }
    }
}

/// The plane or the line on which states have values, with what is integrated there.
struct Section<'a> {
    field: &'a GridField,
    factors: &'a [Along<'a>],
    /// Each state as a function of the free axes.
    states: [Affine; MOST],
    /// Each eliminated axis as the same.
    eliminated: Vec<(usize, Affine)>,
    free: Vec<usize>,
    /// The volume of y for that of the free axes and the values.
    volume: f64,
    rule: Rule,
}

impl<'a> Section<'a> {
    /// None where the values are those of no state.
    fn new(field: &'a GridField, shear: &Shear, factors: &'a [Along<'a>]) -> Option<Self> {
        let root = field.mesh.tree.root();
        let mut states: [Affine; MOST] =
            std::array::from_fn(|state| Affine { constant: 0.0, factors: shear.row(state) });
        let (mut eliminated, mut free) = (Vec::<(usize, Affine)>::new(), (0..MOST).collect::<Vec<_>>());
        let mut volume = 1.0;
        for state in 0..MOST {
            let Along::At(place) = factors[state] else { continue };
            let own = states[state];
            // The axis along which the state changes most within the domain.
            let change = |axis: usize| (own.factors[axis] * root.width[axis]).abs();
            let axis = free.iter().copied().max_by(|a, b| change(*a).total_cmp(&change(*b)))?;
            let factor = own.factors[axis];
            if factor == 0.0 {
                return None;
            }
            free.retain(|other| *other != axis);
            volume /= factor.abs();
            let mut solved = Affine { constant: (place - own.constant) / factor, factors: [0.0; MOST] };
            free.iter().for_each(|other| solved.factors[*other] = -own.factors[*other] / factor);
            states = states.map(|affine| affine.with(axis, &solved));
            eliminated.iter_mut().for_each(|(_, affine)| *affine = affine.with(axis, &solved));
            eliminated.push((axis, solved));
        }
        let degree = |factor: &Along<'_>| if let Along::Function(_, degree, _) = factor { *degree } else { 0 };
        let rule = field.shape.rule(2 * MORE + factors.iter().map(degree).sum::<usize>());
        Some(Section { field, factors, states, eliminated, free, volume, rule })
    }

    fn integral(&self) -> f64 {
        parallel::map(self.field.mesh.cells.len(), |cell| self.of_cell(cell)).iter().sum()
    }

    /// What a cell has of it.
    fn of_cell(&self, number: usize) -> f64 {
        let cell = &self.field.mesh.cells[number];
        let limits = |axis: usize| [cell.lower[axis], cell.upper(axis)].map(|u| self.field.mesh.origin[axis] + u);
        let free: Vec<[f64; 2]> = self.free.iter().map(|axis| limits(*axis)).collect();
        // Of two cells that meet on the section the upper one has it.
        let mut halves: Vec<(Affine, f64, bool)> = Vec::new();
        for (axis, affine) in &self.eliminated {
            let [low, high] = limits(*axis);
            halves.extend([(*affine, low, true), (*affine, high, false)]);
        }
        for (affine, factor) in self.states.iter().zip(self.factors) {
            if let Along::Function(_, _, [low, high]) = factor {
                let ends = [(*affine, *low, true), (*affine, *high, false)];
                halves.extend(ends.into_iter().filter(|(_, limit, _)| limit.is_finite()));
            }
        }
        let mut corners = match free.as_slice() {
            [] => vec![[0.0; 2]],
            [one] => one.map(|place| [place, 0.0]).to_vec(),
            [one, two, ..] => vec![[one[0], two[0]], [one[1], two[0]], [one[1], two[1]], [one[0], two[1]]],
        };
        for (affine, limit, above) in halves {
            let sign = if above { 1.0 } else { -1.0 };
            if self.free.iter().all(|axis| affine.factors[*axis] == 0.0) {
                let inside = if above { affine.constant >= limit } else { affine.constant < limit };
                if !inside {
                    return 0.0;
                }
                continue;
            }
            corners = clipped(&corners, |z| sign * (affine.at(&self.place(z)) - limit));
            if corners.is_empty() {
                return 0.0;
            }
        }
        self.volume * self.over(&corners, number)
    }

    /// A point of the free axes.
    fn place(&self, z: &[f64; 2]) -> Place {
        let mut y = [0.0; MOST];
        self.free.iter().zip(z).for_each(|(axis, z)| y[*axis] = *z);
        y
    }

    /// The integral over an interval or a polygon in a cell.
    fn over(&self, corners: &[[f64; 2]], number: usize) -> f64 {
        match (self.free.len(), corners) {
            (0, [z, ..]) => self.value(z, number),
            (1, [a, b, ..]) => {
                let rule = self.rule.on(a[0].min(b[0]), a[0].max(b[0]));
                rule.iter().map(|(z, weight)| weight * self.value(&[z, 0.0], number)).sum()
            }
            (2, [first, rest @ ..]) => {
                let mut sum = 0.0;
                let unit = self.rule.on(0.0, 1.0);
                for sides in rest.windows(2) {
                    let [a, b] = [0, 1].map(|k| [0, 1].map(|i| sides[k][i] - first[i]));
                    let area = (a[0] * b[1] - a[1] * b[0]).abs();
                    // The triangle as a square with one side at the first corner.
                    for (s, along) in unit.iter() {
                        for (t, across) in unit.iter() {
                            let z = [0, 1].map(|i| first[i] + s * ((1.0 - t) * a[i] + t * b[i]));
                            sum += area * s * along * across * self.value(&z, number);
                        }
                    }
                }
                sum
            }
            _ => 0.0,
        }
    }

    /// Π g_i(x_i) p at a point of the free axes.
    fn value(&self, z: &[f64; 2], number: usize) -> f64 {
        let mut y = self.place(z);
        for (axis, affine) in &self.eliminated {
            y[*axis] = affine.at(&y);
        }
        let p = self.field.value_in(number, &y);
        let factors = self.states.iter().zip(self.factors);
        factors.fold(p, |product, (affine, factor)| match factor {
            Along::Function(g, ..) => product * g(affine.at(&y)),
            _ => product,
        })
    }
}

/// The part of an interval or a convex polygon on which a linear function is not below zero (I. E. Sutherland and G. W. Hodgman, 1974,
/// doi:10.1145/360767.360802).
fn clipped(corners: &[[f64; 2]], function: impl Fn(&[f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let count = corners.len();
    let mut kept = Vec::with_capacity(count + 1);
    for (k, corner) in corners.iter().enumerate() {
        let next = &corners[(k + 1) % count];
        let [here, there] = [corner, next].map(&function);
        if here >= 0.0 {
            kept.push(*corner);
        }
        if (here < 0.0) != (there < 0.0) && (count > 2 || k == 0) {
            let share = here / (here - there);
            kept.push([0, 1].map(|i| corner[i] + share * (next[i] - corner[i])));
        }
    }
    if kept.len() < count.min(3) { Vec::new() } else { kept }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::grid::{
        along::EVERYWHERE,
        mesh::{Mesh, Side},
        pilot::GridPilot,
        tree::Tree,
    };
    use crate::problem::Problem;
    use crate::states::States;
    use nalgebra::{DMatrix, Matrix3};
    use std::f64::consts::TAU;
    use std::sync::Arc;

    /// A standard normal density of y has the covariance S Sᵀ in x. Cells of one deviation and degree 7 hold it, its marginals, a flux
    /// and a range to better than 1e-7.
    #[test]
    fn sections_of_a_normal_density_are_normal() {
        let problem = Problem::from_toml(
            "states = ['x', 'v', 'y']\ndrift = { x = 'v', v = '-v - x', y = 'v - y' }\nnoise.w.v = '1'",
        );
        // Columns of S, of which y₁ is narrow beside what it follows.
        let mut states = States::new(3);
        for k in 0..8 {
            let [a, b, c] = [0, 1, 2].map(|bit| if k >> bit & 1 == 0 { -1.0 } else { 1.0 });
            states.push(&[a, 0.2 * b + 0.9 * c + 0.7 * a, c - 0.4 * a]);
        }
        let shear = Shear::of(&problem.unwrap(), &GridPilot { states, settles: true }).unwrap();
        let matrix = Matrix3::from_fn(|i, j| shear.row(i)[j]);
        // The regression of y on x, then that of v, on which the noise is, on x and on what is left of y.
        let regressions = [(2, 0, -0.4), (1, 0, 0.7), (1, 2, 0.9)];
        assert!(regressions.iter().all(|(i, j, slope)| (matrix[(*i, *j)] - slope).abs() < 1e-12), "{matrix}");
        let lines = || (0..=12).map(|k| f64::from(k) - 6.0).collect::<Vec<f64>>();
        let mesh = Arc::new(Mesh::new([0.0; 3], Tree::new(&[lines(), lines(), lines()]), [Side::Open; 2]));
        let shape = crate::grid::shape::Shape { states: 3, degree: 7 };
        let density = |y: &[f64]| (-y.iter().map(|y| y * y).sum::<f64>() / 2.0).exp() / TAU.powf(1.5);
        let field = GridField::projected(&mesh, shape, density);
        let covariance = matrix * matrix.transpose();
        let normal = |states: &[usize], x: &[f64]| {
            let own = DMatrix::from_fn(states.len(), states.len(), |i, j| covariance[(states[i], states[j])]);
            let x = nalgebra::DVector::from_column_slice(x);
            let square = (x.transpose() * own.clone().try_inverse().unwrap() * &x)[(0, 0)];
            (-square / 2.0).exp() / (TAU.powi(states.len() as i32) * own.determinant()).sqrt()
        };
        let at = |placed: &[(usize, f64)]| -> Vec<Along<'_>> {
            let of = |i: usize| placed.iter().find(|(state, _)| *state == i).map_or(Along::All, |(_, x)| Along::At(*x));
            (0..3).map(of).collect()
        };
        for state in 0..3 {
            for x in [0.0, 0.8, -1.3] {
                let found = integral(&field, &shear, &at(&[(state, x)]));
                assert!((found - normal(&[state], &[x])).abs() < 1e-7, "{state} {x}: {found}");
            }
        }
        for states in [[0, 1], [0, 2], [1, 2]] {
            let x = [0.3, -0.5];
            let found = integral(&field, &shear, &at(&[(states[0], x[0]), (states[1], x[1])]));
            assert!((found - normal(&states, &x)).abs() < 1e-7, "{states:?}: {found}");
        }
        // Rice's rate, with v of x = 0.6 normal as well: ∫ v p(0.6, v) dv over v > 0.
        let v = |v: f64| v;
        let factors = [Along::At(0.6), Along::Function(&v, 1, [0.0, f64::INFINITY]), Along::All];
        let slope = covariance[(0, 1)] / covariance[(0, 0)];
        let (mean, variance) = (0.6 * slope, covariance[(1, 1)] - slope * covariance[(0, 1)]);
        let over = Rule::legendre(200);
        let rice: f64 = over
            .on(0.0, 12.0)
            .iter()
            .map(|(v, w)| w * v * (-(v - mean).powi(2) / (2.0 * variance)).exp() / (TAU * variance).sqrt())
            .sum();
        let found = integral(&field, &shear, &factors);
        assert!((found - rice * normal(&[0], &[0.6])).abs() < 1e-7, "{found}");
        // Beyond a level, and a moment.
        let one = |_: f64| 1.0;
        let above = [Along::All, Along::Function(&one, 0, [0.5, f64::INFINITY]), Along::All];
        let tail: f64 = over.on(0.5, 12.0).iter().map(|(x, w)| w * normal(&[1], &[x])).sum();
        let found = integral(&field, &shear, &above);
        assert!((found - tail).abs() < 1e-7, "{found} {tail}");
        let square = |x: f64| x * x;
        let moment = [Along::All, Along::Function(&square, 2, EVERYWHERE), Along::Function(&v, 1, EVERYWHERE)];
        assert!(integral(&field, &shear, &moment).abs() < 1e-7);
        let second = [Along::All, Along::Function(&square, 2, EVERYWHERE), Along::All];
        assert!((integral(&field, &shear, &second) - covariance[(1, 1)]).abs() < 1e-6);
    }
}

//! Products of Legendre polynomials of one degree along each state, and how they are numbered.

use super::legendre::LegendreTable;
use crate::numerics::Rule;

/// The most states of a mesh. With fewer, the axes beyond them have one function, one cell and no faces.
pub(super) const MOST: usize = 3;

/// A number for each axis.
pub(super) type Place = [f64; MOST];

/// The functions of a cell: all products of Legendre polynomials up to one degree, the last state's degree running fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) states: usize,
    pub(super) degree: usize,
}

impl Shape {
    /// Functions along an axis.
    pub(super) fn modes(&self, axis: usize) -> usize {
        if axis < self.states { self.degree + 1 } else { 1 }
    }

    /// Functions of a cell.
    pub(super) fn block(&self) -> usize {
        (self.degree + 1).pow(self.states as u32)
    }

    /// Functions of a face.
    pub(super) fn face(&self) -> usize {
        self.block() / (self.degree + 1)
    }

    /// The distance between functions whose degrees along `axis` differ by one.
    pub(super) fn stride(&self, axis: usize) -> usize {
        (axis + 1..self.states).map(|_| self.degree + 1).product()
    }

    /// The degrees of a function.
    pub(super) fn degrees(&self, function: usize) -> [usize; MOST] {
        std::array::from_fn(|axis| function / self.stride(axis) % self.modes(axis))
    }

    /// The numbers of the functions of degree 0 along `axis`: those of the functions of a face across it.
    pub(super) fn along(&self, axis: usize) -> Vec<usize> {
        (0..self.block()).filter(|function| self.degrees(*function)[axis] == 0).collect()
    }

    /// The axes of a face across `axis`.
    pub(super) fn others(&self, axis: usize) -> impl Iterator<Item = usize> + use<> {
        (0..self.states).filter(move |other| *other != axis)
    }

    /// Rules along the axes that integrate a product of two functions and a polynomial of degree `extra` exactly.
    pub(super) fn rule(&self, extra: usize) -> Rule {
        Rule::legendre(self.degree + 1 + extra.div_ceil(2))
    }

    /// A table for each axis: `rule` along the states, one node beyond them.
    pub(super) fn tables(&self, rule: &Rule) -> [LegendreTable; MOST] {
        std::array::from_fn(|axis| {
            if axis < self.states {
                LegendreTable::new(self.degree, rule.clone())
            } else {
                LegendreTable::new(0, Rule { nodes: vec![0.0], weights: vec![2.0] })
            }
        })
    }
}

/// Numbers on a tensor grid, the last axis running fastest, with the axis `axis` transformed: Σ_k `rows`[node][k] v[.., k, ..].
pub(super) fn transformed(v: &[f64], sizes: &mut [usize; MOST], axis: usize, rows: &[Vec<f64>]) -> Vec<f64> {
    let (old, inner) = (sizes[axis], sizes[axis + 1..].iter().product::<usize>());
    sizes[axis] = rows.len();
    let mut out = Vec::with_capacity(v.len() / old * rows.len());
    for outer in v.chunks_exact(old * inner) {
        for row in rows {
            let from = out.len();
            out.resize(from + inner, 0.0);
            for (factor, values) in row.iter().zip(outer.chunks_exact(inner)) {
                out[from..].iter_mut().zip(values).for_each(|(o, v)| *o += factor * v);
            }
        }
    }
    out
}

/// Σ v Π_axis f_axis over all products.
pub(super) fn contracted(v: &[f64], factors: &[&[f64]]) -> f64 {
    match factors {
        [] => v[0],
        // The first axis of several at once, all numbers along the others together.
        [first, _, _] => {
            let inner = v.len() / first.len();
            let mut sum = vec![0.0; inner];
            for (f, values) in first.iter().zip(v.chunks_exact(inner)) {
                sum.iter_mut().zip(values).for_each(|(s, v)| *s += f * v);
            }
            contracted(&sum, &factors[1..])
        }
        [first, rest @ ..] => {
            let inner = v.len() / first.len();
            first.iter().zip(v.chunks_exact(inner)).map(|(f, v)| f * contracted(v, rest)).sum()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_numbered_by_their_degrees() {
        let plane = Shape { states: 2, degree: 3 };
        assert_eq!((plane.block(), plane.face(), plane.stride(0), plane.stride(1)), (16, 4, 4, 1));
        assert_eq!(
            (plane.degrees(7), plane.along(0), plane.along(1)),
            ([1, 3, 0], vec![0, 1, 2, 3], vec![0, 4, 8, 12])
        );
        let space = Shape { states: 3, degree: 2 };
        assert_eq!((space.block(), space.face(), space.degrees(14)), (27, 9, [1, 1, 2]));
        assert_eq!(space.along(1), [0, 1, 2, 9, 10, 11, 18, 19, 20]);
        let line = Shape { states: 1, degree: 3 };
        assert_eq!((line.block(), line.face(), line.degrees(2), line.along(0)), (4, 1, [2, 0, 0], vec![0]));
    }

    #[test]
    fn transforms_and_contractions_are_sums() {
        let v: Vec<f64> = (0..6).map(f64::from).collect();
        let mut sizes = [2, 3, 1];
        let rows = vec![vec![1.0, 1.0, 1.0], vec![0.0, 0.0, 2.0]];
        let out = transformed(&v, &mut sizes, 1, &rows);
        assert_eq!((out.as_slice(), sizes), (&[3.0, 4.0, 12.0, 10.0][..], [2, 2, 1]));
        assert_eq!(transformed(&out, &mut sizes, 0, &[vec![1.0, -1.0]]), [-9.0, -6.0]);
        assert_eq!(contracted(&v, &[&[1.0, -1.0], &[1.0, 1.0, 1.0]]), -9.0);
    }
}

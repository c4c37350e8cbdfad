//! The discontinuous Galerkin matrix of a Fokker-Planck operator.
//!
//! The equation is a balance of fluxes, 0 = ∇·J with J = (f − ½∇·B) p − ½B∇p. With a test function φ of each element,
//!
//! (K p)_φ = −∫ J·∇φ dx + ∮ Ĵ·n φ ds,
//!
//! where the flux Ĵ through a face takes the advected p from upwind, point by point, and the diffused one by the symmetric
//! interior penalty: mean of ½B∇p, its adjoint, and a penalty on the jump (D. N. Arnold, F. Brezzi, B. Cockburn and L. D.
//! Marini, 2002, doi:10.1137/S0036142901384162). Every integral of a polynomial is exact. The basis is orthonormal, so that
//! the mass matrix is the identity: ∂p/∂t = −K p.

use super::face::Face;
use super::space::{Side, Space};
use super::sparse::SparseMatrix;
use super::wall;
use crate::{FokkerPlanck, Polynomial};
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// The operator in the distances (u₀, u₁) from the axes' origins.
#[derive(Clone, Debug)]
pub(super) struct LocalFlux {
    /// F = f − ½∇·B.
    pub(super) advection: [Polynomial<2>; 2],
    /// ½B.
    pub(super) diffusion: [[Polynomial<2>; 2]; 2],
}

impl LocalFlux {
    pub(super) fn new(operator: &FokkerPlanck<2>, origin: [f64; 2]) -> Self {
        let [u, w] = Polynomial::variables();
        let moved = [u + origin[0], w + origin[1]];
        let spread = operator.diffusion_divergence();
        LocalFlux {
            advection: std::array::from_fn(|i| (&operator.drift()[i] - &(&spread[i] * 0.5)).compose(&moved)),
            diffusion: operator.diffusion().each_ref().map(|row| row.each_ref().map(|b| (b * 0.5).compose(&moved))),
        }
    }

    fn degree(&self) -> usize {
        self.advection.iter().chain(self.diffusion.iter().flatten()).map(Polynomial::degree).max().unwrap_or(0) as usize
    }
}

/// Blocks of the matrix by (column element, row element), so that they come in the order of a matrix by columns.
#[derive(Debug, Default)]
pub(super) struct Blocks(BTreeMap<(usize, usize), DMatrix<f64>>);

impl Blocks {
    /// Adds `factor`·(A ⊗ B), A acting on state 0.
    pub(super) fn add(&mut self, row: usize, column: usize, factor: f64, a: &DMatrix<f64>, b: &DMatrix<f64>) {
        let (n, m) = (a.nrows(), b.nrows());
        let block = self.0.entry((column, row)).or_insert_with(|| DMatrix::zeros(n * m, n * m));
        for j in 0..n {
            for i in 0..n {
                let outer = factor * a[(i, j)];
                if outer != 0.0 {
                    let mut target = block.view_mut((i * m, j * m), (m, m));
                    target.zip_apply(b, |t, b| *t += outer * b);
                }
            }
        }
    }

    fn into_matrix(self, block: usize, elements: usize) -> SparseMatrix {
        let mut matrix = SparseMatrix { size: block * elements, columns: vec![0], rows: vec![], values: vec![] };
        let mut blocks = self.0.into_iter().peekable();
        for element in 0..elements {
            let mut column = Vec::new();
            while let Some(((_, row), entries)) = blocks.next_if(|((c, _), _)| *c == element) {
                column.push((row, entries));
            }
            for j in 0..block {
                for (row, entries) in &column {
                    for i in 0..block {
                        let value = entries[(i, j)];
                        if value != 0.0 || (*row == element && i == j) {
                            matrix.rows.push(row * block + i);
                            matrix.values.push(value);
                        }
                    }
                }
                matrix.columns.push(matrix.rows.len());
            }
        }
        matrix
    }
}

/// The matrix K on `space`.
pub(super) fn assemble(operator: &FokkerPlanck<2>, space: &Space) -> SparseMatrix {
    let flux = LocalFlux::new(operator, space.axes.each_ref().map(|axis| axis.origin));
    let mut blocks = Blocks::default();
    volume(&mut blocks, &flux, space);
    let rule = space.rule(flux.degree());
    for direction in 0..2 {
        let other = 1 - direction;
        for line in 0..=space.axes[direction].cells() {
            for along in 0..space.axes[other].cells() {
                let face = Face::new(space, &flux, &rule, direction, line, along);
                face.advect(&mut blocks);
                face.diffuse(&mut blocks);
            }
        }
    }
    for (upper, side) in space.sides.iter().enumerate() {
        if let Side::Wall(restitution) = *side {
            wall::rebound(&mut blocks, space, upper == 1, restitution);
        }
    }
    blocks.into_matrix(space.block(), space.elements())
}

/// −∫ J·∇φ over every element.
fn volume(blocks: &mut Blocks, flux: &LocalFlux, space: &Space) {
    let tables = [0, 1].map(|state| Powers::new(space, state, flux.degree()));
    for i in 0..space.axes[0].cells() {
        for j in 0..space.axes[1].cells() {
            let element = space.element(i, j);
            let mut term = |p: &Polynomial<2>, sign: f64, tested: usize, differentiated: Option<usize>| {
                for (monomial, c) in p.terms() {
                    let [a, b] = [(0, i), (1, j)].map(|(state, cell)| {
                        tables[state].get(cell, monomial.0[state], tested == state, differentiated == Some(state))
                    });
                    blocks.add(element, element, sign * c, a, b);
                }
            };
            for s in 0..2 {
                term(&flux.advection[s], -1.0, s, None);
                for t in 0..2 {
                    term(&flux.diffusion[s][t], 1.0, s, Some(t));
                }
            }
        }
    }
}

/// The matrices ∫ u^a φ_k^(′) φ_l^(′) du of each cell of one axis.
struct Powers {
    /// By cell, power, and which of the two is differentiated.
    matrices: Vec<Vec<[[DMatrix<f64>; 2]; 2]>>,
}

impl Powers {
    fn new(space: &Space, state: usize, highest: usize) -> Self {
        let axis = &space.axes[state];
        let rule = space.rule(highest);
        let of_cell = |cell: usize| {
            let nodes: Vec<_> = rule.on(axis.lines[cell], axis.lines[cell + 1]).iter().collect();
            let bases: Vec<_> = nodes.iter().map(|(u, _)| axis.basis(cell, space.degree, *u)).collect();
            let of_power = |power: i32| {
                let matrix = |test_slope: bool, trial_slope: bool| {
                    let pick = |(p, s): &(Vec<f64>, Vec<f64>), slope: bool, k: usize| if slope { s[k] } else { p[k] };
                    let entries = DMatrix::from_fn(space.modes(), space.modes(), |k, l| {
                        let terms = nodes.iter().zip(&bases);
                        terms
                            .map(|((u, w), basis)| {
                                w * u.powi(power) * pick(basis, test_slope, k) * pick(basis, trial_slope, l)
                            })
                            .sum()
                    });
                    without_rounding(entries)
                };
                [false, true].map(|test| [false, true].map(|trial| matrix(test, trial)))
            };
            (0..=highest as i32).map(of_power).collect()
        };
        Powers { matrices: (0..axis.cells()).map(of_cell).collect() }
    }

    fn get(&self, cell: usize, power: u32, test_slope: bool, trial_slope: bool) -> &DMatrix<f64> {
        &self.matrices[cell][power as usize][usize::from(test_slope)][usize::from(trial_slope)]
    }
}

/// Sets to zero what is zero but for rounding: products of Legendre polynomials are orthogonal to those of higher degree,
/// and a matrix that knows it is several times sparser.
pub(super) fn without_rounding(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    let least = 64.0 * f64::EPSILON * matrix.amax();
    matrix.apply(|entry| {
        if entry.abs() <= least {
            *entry = 0.0;
        }
    });
    matrix
}

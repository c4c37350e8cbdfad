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

use super::blocks::{Blocks, NEIGHBOURS, without_rounding};
use super::condensation::{Condensation, Factors};
use super::face::Face;
use super::flux::{Flux, Part};
use super::legendre::Table;
use super::space::{Side, Space};
use super::sparse::{SparseMatrix, united};
use super::wall::Rebound;
use crate::envelope::Envelope;
use crate::error::Result;
use crate::memory::MemoryLimit;
use crate::numerics::Rule;
use crate::problem::{PlaneMotion, Problem};
use nalgebra::DMatrix;

/// The numbers that an entry of a matrix by columns takes: itself and its row.
const BY_COLUMNS: f64 = 2.0;

const FEWER: &str = "take fewer cells or a lower degree, or raise `memory_limit`";

/// A problem's operator on a mesh, ∂p/∂t = −K p. The basis is orthonormal, so that the mass matrix is the identity.
#[derive(Debug)]
pub(super) struct Discretisation {
    /// K.
    pub(super) matrix: SparseMatrix,
    /// For the factors of every matrix with the pattern of K.
    pub(super) condensation: Condensation,
}

impl Discretisation {
    /// # Errors
    /// [`Error::TooMuchMemory`](crate::Error::TooMuchMemory) if the matrix or its factors would not keep to the limit.
    pub(super) fn new(problem: &Problem, space: &Space, memory: MemoryLimit) -> Result<Self> {
        memory.holds("the matrix of the grid", entries(space), FEWER)?;
        Self::of(problem, assemble(problem, space, Part::Whole), 2.0, space, memory)
    }

    /// The part of the operator that is there without noise, with the noise's.
    ///
    /// # Errors
    /// As [`Discretisation::new`].
    pub(super) fn modulated<'e>(
        problem: &Problem,
        space: &Space,
        envelope: &'e Envelope,
        memory: MemoryLimit,
    ) -> Result<(Self, Modulation<'e>)> {
        memory.holds("the matrix of the grid", 2.0 * entries(space), FEWER)?;
        let parts = [Part::Drift, Part::Noise].map(|part| assemble(problem, space, part));
        let [drift, noise] = united(parts);
        Ok((Self::of(problem, drift, 3.0, space, memory)?, Modulation { noise, envelope }))
    }

    /// With so many matrices of its pattern in memory as it is factored: itself, the shifted one, and modulated noise.
    fn of(problem: &Problem, matrix: SparseMatrix, matrices: f64, space: &Space, memory: MemoryLimit) -> Result<Self> {
        let diffusion = problem.operator().diffusion();
        let condensation = Condensation::new(space, &matrix, [0, 1].map(|state| !diffusion[state][state].is_zero()));
        let entries = matrices * BY_COLUMNS * matrix.values.len() as f64;
        memory.holds("the factors of the grid's matrix", entries + condensation.numbers(space.elements()), FEWER)?;
        Ok(Discretisation { matrix, condensation })
    }

    /// The factors of K + `shift`·I.
    pub(super) fn shifted(&self, shift: f64) -> Factors<'_> {
        self.condensation.factorise(&self.matrix.shifted(shift))
    }
}

/// Noise that is modulated: the part of K that is in proportion to its intensity, on the pattern of the whole.
#[derive(Debug)]
pub(super) struct Modulation<'a> {
    pub(super) noise: SparseMatrix,
    pub(super) envelope: &'a Envelope,
}

/// The derivative of K on a mesh that stands still, or moves with the walls.
pub(super) fn derivative(problem: &Problem, space: &Space, motion: &PlaneMotion) -> SparseMatrix {
    assemble(problem, space, Part::Moved(motion))
}

/// The numbers that the matrix takes at most while it is made of dense blocks.
fn entries(space: &Space) -> f64 {
    (1.0 + BY_COLUMNS) * (space.elements() * NEIGHBOURS) as f64 * (space.block() as f64).powi(2)
}

/// The matrix K on `space`, or a part of it.
fn assemble(problem: &Problem, space: &Space, part: Part<'_>) -> SparseMatrix {
    let mut flux = Flux::new(problem, space.axes.each_ref().map(|axis| axis.origin), part);
    let mut blocks = Blocks::default();
    volume(&mut blocks, &mut flux, space);
    let table = Table::new(space.degree, space.rule(flux.degree));
    for direction in 0..2 {
        let other = 1 - direction;
        for line in 0..=space.axes[direction].cells() {
            for along in 0..space.axes[other].cells() {
                let face = Face::new(space, &mut flux, &table, direction, line, along);
                face.advect(&mut blocks);
                face.diffuse(&mut blocks);
            }
        }
    }
    for (upper, side) in space.sides.iter().enumerate() {
        let Side::Wall(restitution) = *side else { continue };
        let wall = Rebound { space, upper: upper == 1, restitution };
        match part {
            Part::Whole | Part::Drift => wall.add(&mut blocks, 1.0),
            Part::Noise => {}
            Part::Moved(motion) => {
                // In the coordinate that moves, the velocity is v over dx/dξ.
                wall.add(&mut blocks, -motion.shift[1]);
                wall.add_derivative(&mut blocks, motion.restitution[upper]);
            }
        }
    }
    blocks.into_matrix(space.block(), space.elements())
}

/// −∫ J·∇φ over every element. The functions in J are polynomials: as many Gauss nodes as they have coefficients along
/// each state give their Legendre series on the element, and the integrals of three Legendre polynomials are the same on
/// all elements.
fn volume(blocks: &mut Blocks, flux: &mut Flux<'_>, space: &Space) {
    let products = Products::new(space, flux.degree);
    let table = Table::new(flux.degree, Rule::legendre(flux.degree + 1));
    let mut values = Vec::with_capacity(table.len() * table.len());
    for i in 0..space.axes[0].cells() {
        for j in 0..space.axes[1].cells() {
            let element = space.element(i, j);
            values.clear();
            for &first in &table.nodes {
                for &second in &table.nodes {
                    values.push(flux.at([space.axes[0].place(i, first), space.axes[1].place(j, second)]));
                }
            }
            let slope = [2.0 / space.axes[0].width(i), 2.0 / space.axes[1].width(j)];
            for term in &flux.terms {
                let sign = if term.differentiated.is_none() { -1.0 } else { 1.0 };
                let scale = sign * slope[term.tested] * term.differentiated.map_or(1.0, |state| slope[state]);
                for &[a, b] in &term.degrees {
                    let rows = values.chunks_exact(table.len()).enumerate();
                    let coefficient: f64 = rows
                        .map(|(k, row)| {
                            let along = row.iter().enumerate().map(|(l, v)| table.weighted(l, b) * term.of(v));
                            table.weighted(k, a) * along.sum::<f64>()
                        })
                        .sum();
                    let [a, b] = [(a, 0), (b, 1)]
                        .map(|(degree, s)| products.get(degree, term.tested == s, term.differentiated == Some(s)));
                    blocks.add(element, element, scale * coefficient, a, b);
                }
            }
        }
    }
}

/// The matrices ∫ P_a φ_k^(′) φ_l^(′) on the reference interval.
struct Products {
    /// By a, and by which of the two, test and trial, is differentiated.
    matrices: Vec<[[DMatrix<f64>; 2]; 2]>,
}

impl Products {
    fn new(space: &Space, highest: usize) -> Self {
        let table = Table::new(space.degree.max(highest), space.rule(highest));
        let matrix = |a: usize, test_slope: bool, trial_slope: bool| {
            let pick = |node: usize, slope: bool| if slope { &table.slopes[node] } else { &table.values[node] };
            without_rounding(DMatrix::from_fn(space.modes(), space.modes(), |k, l| {
                let term = |n: usize| table.weighted(n, a) * pick(n, test_slope)[k] * pick(n, trial_slope)[l];
                (0..table.len()).map(term).sum()
            }))
        };
        let of_degree = |a: usize| [false, true].map(|test| [false, true].map(|trial| matrix(a, test, trial)));
        Products { matrices: (0..=highest).map(of_degree).collect() }
    }

    fn get(&self, a: usize, test_slope: bool, trial_slope: bool) -> &DMatrix<f64> {
        &self.matrices[a][usize::from(test_slope)][usize::from(trial_slope)]
    }
}

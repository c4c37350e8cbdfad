//! The matrices of a cell: hybridised discontinuous Galerkin forms of a Fokker-Planck operator.
//!
//! The equation is a balance of fluxes, 0 = ∇·J with J = F p − A∇p, F = f − ½∇·B and A = ½B. A cell has a polynomial u, and each face
//! a polynomial λ, the only one that cells on both sides share (B. Cockburn, J. Gopalakrishnan and R. Lazarov, 2009,
//! doi:10.1137/070706616). For all tests w of a cell and μ of a face,
//!
//! −∫ (F u − A∇u)·∇w + Σ_faces ∫ [(F·n)⁺ u + (F·n)⁻ λ − n·A∇u + τ(u − λ)] w − ∫ (n·A∇w)(u − λ) = 0,
//!
//! −Σ_sides ∫ [(F·n)⁺ u + (F·n)⁻ λ − n·A∇u + τ(u − λ)] μ = 0,
//!
//! with (·)⁺ and (·)⁻ the positive and the negative part at each node, and τ = 2(p+1)² (n·A n)/h, h the cell's own width across the
//! face. Where nothing diffuses across a face λ is what comes from upwind. An open side lets out (F·n)⁺ u and no diffusive flux; at a
//! level λ = 0. Every integral of a polynomial is exact, and the bases are orthonormal: with the flux of λ's equation inserted,
//! ∂p/∂t = −K p.

use super::columns::add_matrix;
use super::flux::{Flux, FluxTerm, Part, Value};
use super::legendre::LegendreTable;
use super::mesh::Mesh;
use super::shape::{MOST, Place, Shape};
use super::sides::{Across, Boundary, Fluxes};
use crate::fokker_planck::Local;
use crate::numerics::Rule;
use crate::problem::{PlaneMotion, Problem};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// The matrices of a cell and its faces, which follow each other in the order of the cell's segments.
#[derive(Clone, Debug)]
pub(super) struct Matrices {
    /// Tests in rows and trial functions in columns: w by u,
    pub(super) inner: Mat<f64>,
    /// w by λ,
    pub(super) inflow: Mat<f64>,
    /// μ by u,
    pub(super) outflow: Mat<f64>,
    /// and μ by λ: this side's part of one block for each face.
    pub(super) faces: Vec<Mat<f64>>,
}

impl Matrices {
    /// Adds `factor` times those of another part of the operator.
    pub(super) fn add(&mut self, factor: f64, other: &Self) {
        add_matrix(&mut self.inner, factor, &other.inner);
        add_matrix(&mut self.inflow, factor, &other.inflow);
        add_matrix(&mut self.outflow, factor, &other.outflow);
        self.faces.iter_mut().zip(&other.faces).for_each(|(a, b)| add_matrix(a, factor, b));
    }

    /// The numbers in them.
    pub(super) fn numbers(&self) -> f64 {
        let of = |m: &Mat<f64>| (m.nrows() * m.ncols()) as f64;
        of(&self.inner) + of(&self.inflow) + of(&self.outflow) + self.faces.iter().map(of).sum::<f64>()
    }
}

/// What the matrices of all cells of one degree have in common.
pub(super) struct Forms<'a> {
    shape: Shape,
    flux: Flux<'a>,
    /// What a wall's fluxes are multiplied by.
    at_walls: f64,
    products: Vec<Product>,
    /// The functions of a cell at the nodes of those in J that are no polynomials, where there are some.
    quadrature: Option<Quadrature>,
    /// Nodes of the functions in J.
    series: LegendreTable,
    /// Nodes of a face along one axis, and the basis of the face there.
    face: LegendreTable,
    along: [Vec<usize>; MOST],
}

/// The integral of one of the functions in J, a product of Legendre polynomials, with all pairs of functions of a cell.
struct Product {
    /// The term among those of the flux.
    term: usize,
    degrees: [usize; MOST],
    /// Those that do not vanish, by their places in a matrix by columns.
    entries: Vec<(u32, f64)>,
}

impl<'a> Forms<'a> {
    pub(super) fn new(problem: &'a Problem, origin: Place, shape: Shape, part: Part<'a>) -> Self {
        let flux = Flux::new(problem, origin, part);
        let at_walls = match part {
            Part::Whole | Part::Drift => 1.0,
            Part::Noise => 0.0,
            // In the coordinate that moves, the velocity is v over dx/dξ.
            Part::Moved(PlaneMotion { shift, .. }) => -shift[1],
        };
        let plain = flux.terms.iter().all(|term| term.degrees.is_some());
        let rule = if plain { Rule::legendre(flux.degree + 1) } else { shape.rule(flux.degree) };
        let series = LegendreTable::new(flux.degree.max(shape.degree), rule);
        let quadrature = (!plain).then(|| Quadrature::new(shape, &series));
        let face = LegendreTable::new(shape.degree, shape.rule(flux.degree));
        let along = std::array::from_fn(|axis| if axis < shape.states { shape.along(axis) } else { Vec::new() });
        let products = products(shape, &flux);
        Forms { shape, flux, at_walls, products, quadrature, series, face, along }
    }

    /// The matrices of one cell.
    pub(super) fn matrices(&self, mesh: &Mesh, cell: usize) -> Matrices {
        let segments = &mesh.segments[cell];
        let (block, face) = (self.shape.block(), self.shape.face());
        let faces = segments.iter().filter(|segment| segment.face.is_some()).count();
        let [inflow, outflow] = [[block, faces * face], [faces * face, block]].map(|[m, n]| Mat::zeros(m, n));
        let mut matrices =
            Matrices { inner: Mat::zeros(block, block), inflow, outflow, faces: Vec::with_capacity(faces) };
        let mut local = self.flux.local();
        self.volume(mesh, cell, &mut local, &mut matrices.inner);
        let cell = mesh.cells[cell];
        let Forms { shape, flux, at_walls, face, .. } = self;
        let boundary = Boundary { shape: *shape, flux, at_walls: *at_walls, face };
        let sides = (0..self.shape.states).flat_map(|axis| [false, true].map(|upper| (axis, upper)));
        let mut sides: Vec<Across> = sides.map(|(axis, upper)| Across::new(self.shape, &cell, axis, upper)).collect();
        for segment in segments {
            let at = Fluxes::new(&boundary, &cell, segment, &mut local);
            let side = &mut sides[2 * segment.axis + usize::from(segment.upper)];
            at.add_to(&mut side.own);
            if segment.face.is_some() {
                self.exchange(&at, side, &mut matrices);
            }
        }
        for axis in sides.chunks_exact(2) {
            self.add_own(&axis[0], &axis[1], &mut matrices.inner);
        }
        matrices
    }

    /// −∫ J·∇w. Of the functions in J that are polynomials as many Gauss nodes as they have coefficients along each state give the
    /// Legendre series on the cell, and the integrals of three Legendre polynomials are the same on all cells. Others are integrated
    /// by Gauss' rule.
    fn volume(&self, mesh: &Mesh, number: usize, local: &mut Local, inner: &mut Mat<f64>) {
        let (cell, states) = (mesh.cells[number], self.shape.states);
        let nodes = self.series.len();
        let count = nodes.pow(states as u32);
        let node = |k: usize, axis: usize| k / nodes.pow((states - 1 - axis) as u32) % nodes;
        let values: Vec<Value> = (0..count)
            .map(|k| {
                let u = std::array::from_fn(|axis| {
                    if axis < states { cell.at(axis, self.series.nodes[node(k, axis)]) } else { 0.0 }
                });
                self.flux.at(u, local)
            })
            .collect();
        let factor = |term: &FluxTerm| {
            let slope = |axis: usize| 2.0 / cell.width[axis];
            match term.differentiated {
                None => -slope(term.tested),
                Some(state) => slope(term.tested) * slope(state),
            }
        };
        if let Some(quadrature) = &self.quadrature {
            for term in self.flux.terms.iter().filter(|term| term.degrees.is_none()) {
                let weighted = |k: usize| -> f64 {
                    let weights = (0..states).map(|axis| self.series.weights[node(k, axis)]);
                    factor(term) * weights.product::<f64>() * term.of(&values[k])
                };
                quadrature.add(term, &weighted, inner);
            }
        }
        for Product { term, degrees, entries } in &self.products {
            let term = &self.flux.terms[*term];
            let weighted = |k: usize| -> f64 {
                (0..states).map(|axis| self.series.weighted(node(k, axis), degrees[axis])).product()
            };
            let coefficient: f64 = values.iter().enumerate().map(|(k, value)| weighted(k) * term.of(value)).sum();
            let factor = factor(term) * coefficient;
            if factor != 0.0 {
                let block = self.shape.block();
                for column in entries.chunk_by(|a, b| a.0 as usize / block == b.0 as usize / block) {
                    let first = column[0].0 as usize / block;
                    let target = inner.col_as_slice_mut(first);
                    column.iter().for_each(|(place, value)| target[*place as usize - first * block] += factor * value);
                }
            }
        }
    }

    /// w by u at both sides of an axis. Legendre polynomials are even or odd: values and outward slopes at the lower side are (−1)^i
    /// times those at the upper one.
    fn add_own(&self, lower: &Across, upper: &Across, inner: &mut Mat<f64>) {
        let Across { axis, values, slopes, .. } = upper;
        let (modes, stride) = (values.len(), self.shape.stride(*axis));
        let even = [0, 1].map(|part| &upper.own[part] + &lower.own[part]);
        let odd = [0, 1].map(|part| &upper.own[part] - &lower.own[part]);
        let diffuses = even[1].norm_max() != 0.0 || odd[1].norm_max() != 0.0;
        for (l, first) in self.along[*axis].iter().enumerate() {
            let [even, odd] = [&even, &odd].map(|parts| parts.each_ref().map(|part| part.col_as_slice(l)));
            for k in 0..modes {
                let target = inner.col_as_slice_mut(first + k * stride);
                // Rows whose degrees along the other axes are alike follow each other in groups of `stride`.
                for (group, rows) in target.chunks_exact_mut(modes * stride).enumerate() {
                    let own = group * stride..(group + 1) * stride;
                    for (i, rows) in rows.chunks_exact_mut(stride).enumerate() {
                        let [taken, normal] = if (i + k) % 2 == 0 { even } else { odd };
                        let both = values[i] * values[k];
                        let crossed = values[i] * slopes[k] + slopes[i] * values[k];
                        rows.iter_mut().zip(&taken[own.clone()]).for_each(|(row, taken)| *row += both * taken);
                        if diffuses {
                            rows.iter_mut()
                                .zip(&normal[own.clone()])
                                .for_each(|(row, normal)| *row -= crossed * normal);
                        }
                    }
                }
            }
        }
    }

    /// w by λ, μ by u and μ by λ of a segment.
    fn exchange(&self, at: &Fluxes, Across { axis, values, slopes, .. }: &Across, matrices: &mut Matrices) {
        let (own, shared, penalty) = (&at.along.own, &at.along.shared, at.penalty);
        let functions = self.along[*axis].len();
        let first = matrices.faces.len() * functions;
        let entering = at.sum(|at| at.enters - penalty * at.normal, own, shared);
        let leaving = at.sum(|at| at.out + penalty * at.normal, own, shared);
        let normal = at.sum(|at| at.normal, own, shared);
        let mut slanted = Mat::<f64>::zeros(functions, functions);
        for other in at.skewed() {
            slanted += at.sum(|at| at.tangential[other], &at.along.slopes[other], shared);
        }
        let stride = self.shape.stride(*axis);
        for (i, (value, slope)) in values.iter().zip(slopes).enumerate() {
            for (j, place) in self.along[*axis].iter().map(|place| place + i * stride).enumerate() {
                let outflow = &mut matrices.outflow.col_as_slice_mut(place)[first..][..functions];
                for (l, outflow) in outflow.iter_mut().enumerate() {
                    let diffused = slope * normal[(j, l)] + value * slanted[(j, l)];
                    *outflow = diffused - value * leaving[(j, l)];
                    matrices.inflow.col_as_slice_mut(first + l)[place] = value * entering[(j, l)] + diffused;
                }
            }
        }
        matrices.faces.push(at.sum(|at| penalty * at.normal - at.enters, shared, shared));
    }
}

/// The functions of a cell at the nodes of a product rule, by node and function: values, and slopes along each state.
struct Quadrature {
    values: Mat<f64>,
    slopes: Vec<Mat<f64>>,
}

impl Quadrature {
    fn new(shape: Shape, table: &LegendreTable) -> Self {
        let (nodes, states) = (table.len(), shape.states);
        let at = |sloped: Option<usize>| {
            Mat::from_fn(nodes.pow(states as u32), shape.block(), |k, function| {
                let degrees = shape.degrees(function);
                let along = |axis: usize| {
                    let node = k / nodes.pow((states - 1 - axis) as u32) % nodes;
                    let of = if sloped == Some(axis) { &table.slopes } else { &table.values };
                    of[node][degrees[axis]]
                };
                (0..states).map(along).product()
            })
        };
        Quadrature { values: at(None), slopes: (0..states).map(|axis| at(Some(axis))).collect() }
    }

    /// Adds Σ_k w_k times the products of tests and trial functions of a term.
    fn add(&self, term: &FluxTerm, weighted: &dyn Fn(usize) -> f64, inner: &mut Mat<f64>) {
        let tests = &self.slopes[term.tested];
        let mut trial = term.differentiated.map_or(&self.values, |axis| &self.slopes[axis]).clone();
        let weights: Vec<f64> = (0..trial.nrows()).map(weighted).collect();
        for column in 0..trial.ncols() {
            trial.col_as_slice_mut(column).iter_mut().zip(&weights).for_each(|(value, weight)| *value *= weight);
        }
        matmul(inner.as_mut(), Accum::Add, tests.transpose(), &trial, 1.0, Par::Seq);
    }
}

/// The integrals of all products of Legendre polynomials that occur in the flux, ∫ Π P_a φ^(′) φ^(′) on the reference cell.
fn products(shape: Shape, flux: &Flux<'_>) -> Vec<Product> {
    let (degree, highest) = (shape.degree, flux.degree);
    let table = LegendreTable::new(degree.max(highest), shape.rule(highest));
    let matrix = |a: usize, test_slope: bool, trial_slope: bool| {
        let pick = |node: usize, slope: bool| if slope { &table.slopes[node] } else { &table.values[node] };
        let mut matrix = Mat::from_fn(degree + 1, degree + 1, |k, l| -> f64 {
            let term = |n: usize| table.weighted(n, a) * pick(n, test_slope)[k] * pick(n, trial_slope)[l];
            (0..table.len()).map(term).sum()
        });
        // Products of Legendre polynomials are orthogonal to those of higher degree; what is left is rounding.
        let least = 64.0 * f64::EPSILON * matrix.norm_max();
        for l in 0..=degree {
            for entry in matrix.col_as_slice_mut(l).iter_mut().filter(|entry| entry.abs() <= least) {
                *entry = 0.0;
            }
        }
        matrix
    };
    let of_degree = |a: usize| [false, true].map(|test| [false, true].map(|trial| matrix(a, test, trial)));
    let matrices: Vec<[[Mat<f64>; 2]; 2]> = (0..=highest).map(of_degree).collect();
    let block = shape.block();
    let product = |term: usize, degrees: [usize; MOST]| {
        let flux = &flux.terms[term];
        let along = |axis: usize| {
            let [test, trial] = [flux.tested == axis, flux.differentiated == Some(axis)].map(usize::from);
            &matrices[degrees[axis]][test][trial]
        };
        let mut entries = Vec::new();
        for column in 0..block {
            let trial = shape.degrees(column);
            for row in 0..block {
                let test = shape.degrees(row);
                let value: f64 = (0..shape.states).map(|axis| along(axis)[(test[axis], trial[axis])]).product();
                if value != 0.0 {
                    entries.push(((column * block + row) as u32, value));
                }
            }
        }
        Product { term, degrees, entries }
    };
    let all = flux
        .terms
        .iter()
        .enumerate()
        .flat_map(|(term, of)| of.degrees.iter().flatten().map(move |degrees| (term, *degrees)));
    all.map(|(term, degrees)| product(term, degrees)).collect()
}

//! The flux J = F p − ½B∇p with F = f − ½∇·B, by dual numbers from the system's own definition.

use super::shape::{MOST, Place};
use crate::fokker_planck::Local;
use crate::polynomial::{Polynomial, monomials};
use crate::problem::{PlaneMotion, Problem};

/// The degree, beyond those of trial and test functions, up to which a product with a function that is no polynomial is integrated
/// exactly: with nodes for 10 degrees more than of a polynomial of degree 0, what the integrals leave is below what cells of these
/// degrees leave.
const BEYOND: usize = 10;
/// A face is on a surface where it is as close to it as this part of the cell's width, which is rounding; and the distance at which
/// the functions beside it are taken.
const ON_SURFACE: f64 = 1e-10;
const BESIDE: f64 = 1e-8;

/// The part of an operator that a flux belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part<'a> {
    Whole,
    /// What is there without noise.
    Drift,
    /// What the noise adds, in proportion to its intensity.
    Noise,
    /// The derivative of the whole.
    Moved(&'a PlaneMotion),
}

/// The coefficients of the flux at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Value {
    /// F = f − ½∇·B.
    pub(super) advection: Place,
    /// The advection that carries p, by whose sign the side is chosen which p is taken from: F itself, but for a derivative's.
    pub(super) carrying: Place,
    /// ½B.
    pub(super) diffusion: [Place; MOST],
}

/// One of the functions F_i and ½B_ij in −∫ J·∇φ dx.
#[derive(Debug)]
pub(super) struct FluxTerm {
    /// The state i in which the test function is differentiated.
    pub(super) tested: usize,
    /// The state j in which p is differentiated; none for F_i.
    pub(super) differentiated: Option<usize>,
    /// The degrees in the states of the Legendre polynomials that the function is made of, on any element. None where it is no
    /// polynomial.
    pub(super) degrees: Option<Vec<[usize; MOST]>>,
}

impl FluxTerm {
    fn new(tested: usize, differentiated: Option<usize>, function: &Polynomial) -> Self {
        if !function.is_plain() {
            return FluxTerm { tested, differentiated, degrees: None };
        }
        let largest: Vec<&[u32]> = function.terms().map(|(powers, _)| powers).collect();
        let occurs = |powers: &[u32]| largest.iter().any(|largest| powers.iter().zip(*largest).all(|(p, l)| p <= l));
        let all = if function.is_zero() { Vec::new() } else { monomials(function.dimension(), function.degree()) };
        let degrees = all
            .iter()
            .filter(|powers| occurs(powers))
            .map(|powers| std::array::from_fn(|axis| powers.get(axis).map_or(0, |power| *power as usize)));
        FluxTerm { tested, differentiated, degrees: Some(degrees.collect()) }
    }

    /// The function's own value.
    pub(super) fn of(&self, value: &Value) -> f64 {
        match self.differentiated {
            None => value.advection[self.tested],
            Some(j) => value.diffusion[self.tested][j],
        }
    }
}

/// The flux in the distances from the mesh's origin.
#[derive(Debug)]
pub(super) struct Flux<'a> {
    problem: &'a Problem,
    origin: Place,
    part: Part<'a>,
    /// The drift that the noise induces.
    induced: Vec<Polynomial>,
    /// F and ½B of a derivative.
    moved: Option<(Vec<Polynomial>, Vec<Vec<Polynomial>>)>,
    pub(super) terms: Vec<FluxTerm>,
    /// The highest total degree of all functions.
    pub(super) degree: usize,
    /// Where they have kinks or jumps along each axis.
    surfaces: [Vec<f64>; MOST],
}

impl<'a> Flux<'a> {
    pub(super) fn new(problem: &'a Problem, origin: Place, part: Part<'a>) -> Self {
        let own = problem.operator();
        let operator = if let Part::Moved(motion) = part { &motion.operator } else { own };
        let states = operator.dimension();
        let induced = problem.induced_drift();
        let spread = operator.diffusion_divergence();
        let mut terms = Vec::new();
        // A derivative is tested at the nodes of the whole, so that it is that of the same matrix.
        let mut degree = if let Part::Moved(_) = part { Flux::new(problem, origin, Part::Whole).degree } else { 0 };
        for i in 0..states {
            let (drift, spread) = (&operator.drift()[i], &spread[i] * 0.5);
            let advection = match part {
                Part::Whole | Part::Moved(_) => drift - &spread,
                Part::Drift => drift - &induced[i],
                Part::Noise => &induced[i] - &spread,
            };
            let mut functions = vec![(None, &advection)];
            if !matches!(part, Part::Drift) {
                functions.extend((0..states).map(|j| (Some(j), &operator.diffusion()[i][j])));
            }
            for (differentiated, function) in functions {
                degree = degree.max(if function.is_plain() { function.degree() as usize } else { BEYOND });
                terms.push(FluxTerm::new(i, differentiated, function));
            }
        }
        terms.retain(|term| term.degrees.as_ref().is_none_or(|degrees| !degrees.is_empty()));
        let moved = matches!(part, Part::Moved(_)).then(|| {
            let half = |p: &Polynomial| p * 0.5;
            let advection = (0..states).map(|i| &operator.drift()[i] - &half(&spread[i])).collect();
            (advection, operator.diffusion().iter().map(|row| row.iter().map(half).collect()).collect())
        });
        let surfaces = std::array::from_fn(|axis| {
            let own = problem.surfaces().iter().filter(|surface| surface.state == axis);
            own.map(|surface| surface.place - origin[axis]).collect()
        });
        Flux { problem, origin, part, induced, moved, terms, degree, surfaces }
    }

    /// F and ½B at a point of a face across `axis`: where they jump, the mean of both sides (the flux of p is continuous), which are
    /// taken at a small part of the cell's width.
    pub(super) fn across(&self, axis: usize, u: Place, width: f64, local: &mut Local) -> Value {
        let near = |surface: &f64| (surface - u[axis]).abs() <= ON_SURFACE * width;
        if !self.surfaces[axis].iter().any(near) {
            return self.at(u, local);
        }
        let [below, above] = [-1.0, 1.0].map(|side| {
            let mut beside = u;
            beside[axis] += side * BESIDE * width;
            self.at(beside, local)
        });
        let mean = |a: Place, b: Place| std::array::from_fn(|i| f64::midpoint(a[i], b[i]));
        Value {
            advection: mean(below.advection, above.advection),
            carrying: mean(below.carrying, above.carrying),
            diffusion: std::array::from_fn(|i| mean(below.diffusion[i], above.diffusion[i])),
        }
    }

    /// What [`Flux::at`] works on.
    pub(super) fn local(&self) -> Local {
        Local::new(self.problem.dimension())
    }

    /// F and ½B of the part at a point.
    pub(super) fn at(&self, u: Place, local: &mut Local) -> Value {
        let states = self.problem.dimension();
        let all: Place = std::array::from_fn(|i| self.origin[i] + u[i]);
        let x = &all[..states];
        self.problem.local(x, local);
        let Local { drift, diffusion, diffusion_divergence, .. } = local;
        let axes = |value: &dyn Fn(usize) -> f64| -> Place {
            std::array::from_fn(|i| if i < states { value(i) } else { 0.0 })
        };
        let whole = axes(&|i| drift[i] - 0.5 * diffusion_divergence[i]);
        if let Some((advection, diffusion)) = &self.moved {
            let diffusion =
                std::array::from_fn(|i| axes(&|j| if i < states { diffusion[i][j].evaluate(x) } else { 0.0 }));
            return Value { advection: axes(&|i| advection[i].evaluate(x)), carrying: whole, diffusion };
        }
        let advection = axes(&|i| match self.part {
            Part::Whole | Part::Moved(_) => whole[i],
            Part::Drift => drift[i] - self.induced[i].evaluate(x),
            Part::Noise => self.induced[i].evaluate(x) - 0.5 * diffusion_divergence[i],
        });
        let share = if matches!(self.part, Part::Drift) { 0.0 } else { 0.5 };
        let diffusion =
            std::array::from_fn(|i| axes(&|j| if i < states { share * diffusion[i * states + j] } else { 0.0 }));
        Value { advection, carrying: advection, diffusion }
    }
}

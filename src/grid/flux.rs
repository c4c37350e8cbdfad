//! The flux J = F p − ½B∇p with F = f − ½∇·B, by dual numbers from the system's own definition.

use crate::fokker_planck::Local;
use crate::polynomial::Polynomial;
use crate::problem::{PlaneMotion, Problem};

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
    pub(super) advection: [f64; 2],
    /// The advection that carries p, by whose sign the side is chosen which p is taken from: F itself, but for a derivative's.
    pub(super) carrying: [f64; 2],
    /// ½B.
    pub(super) diffusion: [[f64; 2]; 2],
}

/// One of the functions F_i and ½B_ij in −∫ J·∇φ dx.
#[derive(Debug)]
pub(super) struct Term {
    /// The state i in which the test function is differentiated.
    pub(super) tested: usize,
    /// The state j in which p is differentiated; none for F_i.
    pub(super) differentiated: Option<usize>,
    /// The degrees in the two states of the Legendre polynomials that the function is made of, on any element.
    pub(super) degrees: Vec<[usize; 2]>,
}

impl Term {
    fn new(tested: usize, differentiated: Option<usize>, function: &Polynomial) -> Self {
        let largest: Vec<&[u32]> = function.terms().map(|(powers, _)| powers).collect();
        let highest = function.degree();
        let occurs = |a: u32, b: u32| largest.iter().any(|powers| a <= powers[0] && b <= powers[1]);
        let all = (0..=highest).flat_map(|a| (0..=highest - a).map(move |b| [a, b]));
        let degrees = all.filter(|[a, b]| occurs(*a, *b)).map(|pair| pair.map(|d| d as usize)).collect();
        Term { tested, differentiated, degrees }
    }

    /// The function's own value.
    pub(super) fn of(&self, value: &Value) -> f64 {
        match self.differentiated {
            None => value.advection[self.tested],
            Some(j) => value.diffusion[self.tested][j],
        }
    }
}

/// The flux in the distances (u₀, u₁) from the axes' origins.
#[derive(Debug)]
pub(super) struct Flux<'a> {
    problem: &'a Problem,
    origin: [f64; 2],
    local: Local,
    part: Part<'a>,
    /// The drift that the noise induces.
    induced: Vec<Polynomial>,
    /// F and ½B of a derivative.
    moved: Option<([Polynomial; 2], [[Polynomial; 2]; 2])>,
    pub(super) terms: Vec<Term>,
    /// The highest total degree of all functions.
    pub(super) degree: usize,
}

impl<'a> Flux<'a> {
    pub(super) fn new(problem: &'a Problem, origin: [f64; 2], part: Part<'a>) -> Self {
        let own = problem.operator();
        let operator = if let Part::Moved(motion) = part { &motion.operator } else { own };
        let induced = problem.induced_drift();
        let spread = operator.diffusion_divergence();
        let mut terms = Vec::new();
        // A derivative is tested at the nodes of the whole, so that it is that of the same matrix.
        let mut degree = if let Part::Moved(_) = part { Flux::new(problem, origin, Part::Whole).degree } else { 0 };
        for i in 0..2 {
            let (drift, spread) = (&operator.drift()[i], &spread[i] * 0.5);
            let advection = match part {
                Part::Whole | Part::Moved(_) => drift - &spread,
                Part::Drift => drift - &induced[i],
                Part::Noise => &induced[i] - &spread,
            };
            let mut functions = vec![(None, &advection)];
            if !matches!(part, Part::Drift) {
                functions.extend([0, 1].map(|j| (Some(j), &operator.diffusion()[i][j])));
            }
            for (differentiated, function) in functions {
                degree = degree.max(function.degree() as usize);
                terms.push(Term::new(i, differentiated, function));
            }
        }
        terms.retain(|term| !term.degrees.is_empty());
        let moved = matches!(part, Part::Moved(_)).then(|| {
            let advection = [0, 1].map(|i| &operator.drift()[i] - &(&spread[i] * 0.5));
            (advection, [0, 1].map(|i| [0, 1].map(|j| &operator.diffusion()[i][j] * 0.5)))
        });
        Flux { problem, origin, local: Local::new(2), part, induced, moved, terms, degree }
    }

    /// F and ½B of the part at a point.
    pub(super) fn at(&mut self, u: [f64; 2]) -> Value {
        let x = [self.origin[0] + u[0], self.origin[1] + u[1]];
        self.problem.local(&x, &mut self.local);
        let Local { drift, diffusion, diffusion_divergence, .. } = &self.local;
        let whole = [0, 1].map(|i| drift[i] - 0.5 * diffusion_divergence[i]);
        if let Some((advection, diffusion)) = &self.moved {
            let at = |p: &Polynomial| p.evaluate(&x);
            let diffusion = diffusion.each_ref().map(|row| row.each_ref().map(at));
            return Value { advection: advection.each_ref().map(at), carrying: whole, diffusion };
        }
        let advection = [0, 1].map(|i| match self.part {
            Part::Whole | Part::Moved(_) => whole[i],
            Part::Drift => drift[i] - self.induced[i].evaluate(&x),
            Part::Noise => self.induced[i].evaluate(&x) - 0.5 * diffusion_divergence[i],
        });
        let share = if matches!(self.part, Part::Drift) { 0.0 } else { 0.5 };
        Value {
            advection,
            carrying: advection,
            diffusion: [[0, 1], [2, 3]].map(|row| row.map(|k: usize| share * diffusion[k])),
        }
    }
}

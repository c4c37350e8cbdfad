use crate::{
    ClosedDensity, Crossing, Density, Estimate, ExpPolynomial, GridDensity, Result, SimulatedDensity, compare,
};

/// How far below its peak the truth is compared.
const LEVEL: f64 = 1e-5;

/// What the answers of one system are compared with.
pub struct Truth<const N: usize> {
    density: Box<dyn Density<N> + Send + Sync>,
    l1: Distance<N>,
    /// Whether ln p is known between samples.
    smooth: bool,
    /// What it is, in a few words.
    text: String,
}

/// The distance ∫ |p − q| of an answer, and what the truth's own error makes of it.
type Distance<const N: usize> = Box<dyn Fn(&ClosedDensity<N>) -> Result<Estimate> + Send + Sync>;

/// The errors of one answer against the truth. What cannot be compared is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Errors {
    pub(super) l1: Option<Estimate>,
    pub(super) tail: Option<f64>,
    /// Relative, of E x₁² and E x₂².
    pub(super) mean_squares: [Option<f64>; 2],
    /// Relative, of the rate of up-crossings of the mean.
    pub(super) rate: Option<f64>,
}

impl<const N: usize> std::fmt::Debug for Truth<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Truth").field("text", &self.text).finish_non_exhaustive()
    }
}

impl<const N: usize> Truth<N> {
    /// A density in closed form.
    pub fn exact(density: impl Density<N> + Clone + Send + 'static) -> Self {
        let exact = density.clone();
        let l1 = move |answer: &ClosedDensity<N>| Ok(compare::l1(answer, &exact));
        Truth { density: Box::new(density), l1: Box::new(l1), smooth: true, text: String::from("exact density") }
    }

    /// A simulation: the distance is that of the first state's marginal from the histogram, whose noise is in it.
    pub fn simulation(density: SimulatedDensity<N>) -> Self {
        let simulated = density.clone();
        let l1 = move |answer: &ClosedDensity<N>| {
            let distance = compare::with_histogram(answer, 0, simulated.histogram(0)?)?;
            Ok(Estimate::new(distance.l1, distance.noise))
        };
        let provenance = density.provenance();
        let text = format!(
            "simulation of {} samples, seed {}, time step {}",
            provenance.samples, provenance.seed, provenance.time_step
        );
        Truth { density: Box::new(density), l1: Box::new(l1), smooth: false, text }
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    pub(super) fn errors(&self, answer: &ClosedDensity<N>) -> Result<Errors> {
        let square = |state: usize| std::array::from_fn(|i| if i == state { 2 } else { 0 });
        let relative = |p: f64, q: f64| Some(p / q - 1.0).filter(|error| error.is_finite());
        let mean_square = |state: usize| {
            let compared = || relative(answer.moment(square(state)).value, self.density.moment(square(state)).value);
            (state < N).then(compared).flatten()
        };
        // A simulation has counted only the levels that it was asked to.
        let mean = self.density.moment(std::array::from_fn(|i| u32::from(i == 0))).value;
        let mean = if self.smooth { mean } else { 0.0 };
        let rate = |density: &dyn Density<N>| density.flux(Crossing::upward(mean), 1).ok().map(|rate| rate.value);
        let tail =
            || Some(compare::log_ratio(answer, &*self.density, LEVEL).ok()?.value).filter(|tail| tail.is_finite());
        Ok(Errors {
            l1: Some((self.l1)(answer)?).filter(|l1| l1.value.is_finite()),
            tail: if self.smooth && N <= 2 { tail() } else { None },
            mean_squares: [0, 1].map(mean_square),
            rate: rate(&*self.density).zip(rate(answer)).and_then(|(truth, found)| relative(found, truth)),
        })
    }
}

impl Truth<2> {
    /// A solution of the Fokker-Planck equation.
    pub fn grid(density: GridDensity) -> Self {
        let provenance = density.provenance();
        let error = provenance.l1_error;
        let text =
            format!("grid of {} unknowns, degree {}, L1 error {error:.1e}", provenance.unknowns, provenance.degree);
        let grid = density.clone();
        let l1 = move |answer: &ClosedDensity<2>| Ok(Estimate::new(grid.l1_distance(answer).value, error));
        Truth { density: Box::new(density), l1: Box::new(l1), smooth: true, text }
    }
}

impl<const N: usize> From<ExpPolynomial<N>> for Truth<N> {
    fn from(density: ExpPolynomial<N>) -> Self {
        Truth::exact(density)
    }
}

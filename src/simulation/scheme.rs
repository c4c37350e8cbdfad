use crate::fokker_planck::noise_induced_drift;
use crate::problem::{Field, LANES, Lane, Problem};
use crate::{polynomial::Polynomial, system::Interpretation};
use pulp::Arch;

/// One step of weak order 2, by a symmetric splitting: A(h/2) F(h/2) W(h) F(h/2) A(h/2).
///
/// - A moves every displacement straight on, x_i += τ x_j, with its velocity x_j frozen; that is exact, impacts
///   included, and lives in [`Passages`](super::passage::Passages).
/// - F is the flow of all other states under the Stratonovich drift with the displacements frozen, by the explicit
///   midpoint rule.
/// - W is the flow of the noise fields G_k for the increments √h Z_k. Where no field changes along any field, it is the
///   straight line x + G √h Z, exactly; that holds for every oscillator whose noise depends on displacements alone.
///   Elsewhere the fields act one after another, each by one classical Runge-Kutta step in the time √h Z_k, in an order
///   that is reversed with probability one half (S. Ninomiya and N. Victoir, 2008, doi:10.1080/13504860701413958).
///
/// Each part is exact or of third order locally and the composition is symmetric, so that stationary means are off by
/// O(h²). Explicit Euler-Maruyama would be off by O(h), and pumps energy into a weakly damped oscillator.
pub(super) struct Scheme<'a> {
    field: &'a dyn Field,
    /// The registers that the steps are taken in. Their width changes nothing but the speed.
    pub(super) arch: Arch,
    /// The time step h.
    pub(super) step: f64,
    /// Whether a step takes the noise of two steps of half its length, so that both follow the same Brownian path.
    pub(super) merged: bool,
    /// The displacements, each with its velocity.
    pub(super) pairs: &'a [(usize, usize)],
    /// The states that F moves: all but the displacements.
    moved: Vec<usize>,
    /// The number of states.
    pub(super) states: usize,
    /// The number of Wiener processes.
    pub(super) processes: usize,
    /// A factor of all noises.
    amplitude: f64,
    noise: Noise,
    /// How many times the noise-induced drift makes the Stratonovich drift, and the Itô drift, of the drift as written.
    induced: [f64; 2],
}

/// How the noise acts.
enum Noise {
    /// G is the same everywhere: process, state and value of its entries that are not zero, process by process.
    Constant(Vec<(usize, usize, f64)>),
    /// No field changes along any field.
    Straight,
    /// The order of the fields matters.
    Curved,
}

/// Lanes that a step works on, made once for many of them.
pub(super) struct Scratch {
    slope: Vec<Lane>,
    middle: Vec<Lane>,
    /// What only noise needs whose fields change along one another.
    extra: [Vec<Lane>; 5],
}

impl<'a> Scheme<'a> {
    /// The scheme for `problem`, its noises `amplitude` times as strong.
    pub(super) fn new(problem: &'a Problem, amplitude: f64, step: f64) -> Self {
        let states = problem.dimension();
        let pairs = problem.displacements();
        let field = problem.field();
        let arch = Arch::new();
        let noise = if problem.constant_noise() {
            let (origin, mut column) = (vec![[0.0; LANES]; states], vec![[0.0; LANES]; states]);
            let mut entries = Vec::new();
            for k in 0..problem.noise().len() {
                field.noise(arch, k, &origin, &mut column);
                let columns = column.iter().enumerate().map(|(i, g)| (k, i, g[0] * amplitude));
                entries.extend(columns.filter(|&(.., g)| g != 0.0));
            }
            Noise::Constant(entries)
        } else if unchanged_along_itself(problem.noise()) {
            Noise::Straight
        } else {
            Noise::Curved
        };
        let induced = if noise_induced_drift(problem.noise(), states).iter().all(Polynomial::is_zero) {
            [0.0; 2]
        } else {
            let square = amplitude * amplitude;
            match problem.interpretation() {
                Interpretation::Ito => [-square, 0.0],
                Interpretation::Stratonovich => [0.0, square],
            }
        };
        Scheme {
            field,
            arch,
            step,
            merged: false,
            moved: (0..states).filter(|i| pairs.iter().all(|(x, _)| x != i)).collect(),
            pairs,
            states,
            processes: problem.noise().len(),
            amplitude,
            noise,
            induced,
        }
    }

    /// Whether the order of the noise fields matters, which a coin then decides at every step.
    #[inline(always)]
    pub(super) fn curved(&self) -> bool {
        matches!(self.noise, Noise::Curved)
    }

    pub(super) fn scratch(&self) -> Scratch {
        let lanes = || vec![[0.0; LANES]; self.states];
        let extra = if self.curved() { [(); 5].map(|()| lanes()) } else { Default::default() };
        Scratch { slope: lanes(), middle: lanes(), extra }
    }

    /// The drift as written and so many times the noise-induced one.
    #[inline(always)]
    fn drift(&self, x: &[Lane], times: f64, drift: &mut [Lane], induced: &mut [Lane]) {
        self.field.drift(self.arch, x, drift);
        if times != 0.0 {
            self.field.induced(self.arch, x, induced);
            for (f, more) in drift.iter_mut().zip(induced) {
                *f = ahead(f, times, more);
            }
        }
    }

    /// F(h/2).
    #[inline(always)]
    fn flow(&self, x: &mut [Lane], h: f64, Scratch { slope, middle, extra: [induced, ..] }: &mut Scratch) {
        self.drift(x, self.induced[0], slope, induced);
        middle.copy_from_slice(x);
        for &i in &self.moved {
            middle[i] = ahead(&x[i], h / 4.0, &slope[i]);
        }
        self.drift(middle, self.induced[0], slope, induced);
        for &i in &self.moved {
            x[i] = ahead(&x[i], h / 2.0, &slope[i]);
        }
    }

    /// F(h/2) W(h) F(h/2) for the increments √h Z = `w` of each process; `reversed` is the order of the fields.
    #[inline(always)]
    pub(super) fn kick(&self, x: &mut [Lane], h: f64, w: &[Lane], reversed: &[bool; LANES], scratch: &mut Scratch) {
        self.flow(x, h, scratch);
        match &self.noise {
            Noise::Constant(entries) => {
                for &(k, i, g) in entries {
                    x[i] = ahead(&x[i], g, &w[k]);
                }
            }
            Noise::Straight => {
                scratch.middle.copy_from_slice(x);
                for (k, w) in w.iter().enumerate() {
                    self.column(k, &scratch.middle, &mut scratch.slope);
                    for (x, g) in x.iter_mut().zip(&scratch.slope) {
                        for l in 0..LANES {
                            x[l] += g[l] * w[l];
                        }
                    }
                }
            }
            Noise::Curved => self.along_fields(x, w, reversed, scratch),
        }
        self.flow(x, h, scratch);
    }

    /// The flow of all fields, one after another, from the first to the last or the other way round.
    #[inline(always)]
    fn along_fields(&self, x: &mut [Lane], w: &[Lane], reversed: &[bool; LANES], scratch: &mut Scratch) {
        let Scratch { slope: to, middle, extra: [other, stages @ ..] } = scratch;
        let [any, all] = [reversed.contains(&true), !reversed.contains(&false)];
        for k in 0..w.len() {
            let back = w.len() - 1 - k;
            let first = if all { back } else { k };
            self.along_field(x, first, &w[first], middle, stages, to);
            if any && !all && k != back {
                self.along_field(x, back, &w[back], middle, stages, other);
                for (to, other) in to.iter_mut().zip(&*other) {
                    for l in 0..LANES {
                        to[l] = if reversed[l] { other[l] } else { to[l] };
                    }
                }
            }
            x.copy_from_slice(to);
        }
    }

    /// The flow of the field G_k over the times `s`, by the classical Runge-Kutta rule.
    #[inline(always)]
    fn along_field(
        &self,
        x: &[Lane],
        k: usize,
        s: &Lane,
        at: &mut [Lane],
        [k1, k2, k3, k4]: &mut [Vec<Lane>; 4],
        to: &mut [Lane],
    ) {
        self.column(k, x, k1);
        stage(x, s, 0.5, k1, at);
        self.column(k, at, k2);
        stage(x, s, 0.5, k2, at);
        self.column(k, at, k3);
        stage(x, s, 1.0, k3, at);
        self.column(k, at, k4);
        for i in 0..x.len() {
            for l in 0..LANES {
                to[i][l] = x[i][l] + s[l] / 6.0 * (k1[i][l] + 2.0 * (k2[i][l] + k3[i][l]) + k4[i][l]);
            }
        }
    }

    /// Column k of G.
    #[inline(always)]
    fn column(&self, k: usize, x: &[Lane], column: &mut [Lane]) {
        self.field.noise(self.arch, k, x, column);
        for g in column {
            *g = g.map(|g| g * self.amplitude);
        }
    }

    /// The power that noise puts into state `v` and the power that the drift takes from it: ½B_vv and −v f_v, with the
    /// Itô drift f.
    pub(super) fn power(&self, v: usize, x: &[Lane], scratch: &mut Scratch) -> [Lane; 2] {
        let Scratch { slope, extra: [induced, ..], .. } = scratch;
        self.drift(x, self.induced[1], slope, induced);
        let taken = std::array::from_fn(|l| -x[v][l] * slope[v][l]);
        let mut injected = [0.0; LANES];
        if let Noise::Constant(entries) = &self.noise {
            let given: f64 = entries.iter().filter(|&&(_, i, _)| i == v).map(|(.., g)| g * g / 2.0).sum();
            injected = [given; LANES];
        } else {
            for k in 0..self.processes {
                self.column(k, x, slope);
                for (sum, g) in injected.iter_mut().zip(&slope[v]) {
                    *sum += g * g / 2.0;
                }
            }
        }
        [injected, taken]
    }
}

/// x + τ × slope.
#[inline(always)]
fn ahead(x: &Lane, tau: f64, slope: &Lane) -> Lane {
    let mut y = *x;
    for l in 0..LANES {
        y[l] += tau * slope[l];
    }
    y
}

/// x + part × s × slope, to where a stage of the Runge-Kutta rule is taken.
#[inline(always)]
fn stage(x: &[Lane], s: &Lane, part: f64, slope: &[Lane], at: &mut [Lane]) {
    for ((at, x), slope) in at.iter_mut().zip(x).zip(slope) {
        for l in 0..LANES {
            at[l] = x[l] + s[l] * part * slope[l];
        }
    }
}

/// Whether (G_k·∇)G_l vanishes for all columns k and l of G.
fn unchanged_along_itself(columns: &[Vec<Polynomial>]) -> bool {
    let along = |field: &[Polynomial], entry: &Polynomial| {
        let rates = field.iter().enumerate().map(|(j, g)| g * &entry.derivative(j));
        rates.fold(Polynomial::zero(field.len()), |sum, rate| sum + rate).is_zero()
    };
    columns.iter().all(|field| columns.iter().flatten().all(|entry| along(field, entry)))
}

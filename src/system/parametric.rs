use num_dual::DualNum;

/// The numbers that parameters are: `f64`, and dual numbers where answers are differentiated by them. They have all functions of
/// [`num_dual::DualNum`]; unlike states, of which a drift is a polynomial, also roots and sines.
#[diagnostic::on_unimplemented(
    message = "a parameter cannot be of the type `{Self}`",
    note = "parameters are `f64`, or fixed-size numbers of num-dual over `f64`"
)]
pub trait Parameter: DualNum<Primitive = f64> + Copy + Send + Sync {
    /// The root.
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }

    /// The exponential.
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }

    /// The sine.
    fn sin(self) -> Self {
        DualNum::sin(&self)
    }

    /// The cosine.
    fn cos(self) -> Self {
        DualNum::cos(&self)
    }
}

impl<P: DualNum<Primitive = f64> + Copy + Send + Sync> Parameter for P {}

/// A system whose parameters have names, other values, and derivatives.
///
/// It is generic over the type of its parameters. One function names them all, and everything else follows: the values, the same
/// system at other values, and by dual numbers the derivatives of its equations ([`Problem::derivative`](crate::Problem::derivative)).
///
/// ```
/// use expoly::{Intensity, Oscillator, Parameter, Parametric, Problem, Scalar};
///
/// struct Hardening<P = f64> { damping: P, frequency: P, intensity: P }
///
/// impl<P: Parameter> Oscillator<P> for Hardening<P> {
///     fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
///         v * self.damping + (x + x.powi(3) * 0.3) * self.frequency.powi(2)
///     }
///     fn intensity(&self) -> Intensity<P> {
///         Intensity::of(self.intensity)
///     }
/// }
///
/// impl Parametric for Hardening {
///     type With<P: Parameter> = Hardening<P>;
///     fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> Hardening<P> {
///         let (damping, frequency) = (of("c", self.damping), of("omega", self.frequency));
///         Hardening { damping, frequency, intensity: of("D", self.intensity) }
///     }
/// }
///
/// let problem = Problem::parametric(Hardening { damping: 0.2, frequency: 2.0, intensity: 0.1 })?;
/// assert_eq!(problem.parameters()[1], ("omega".into(), 2.0));
/// let by_frequency = problem.derivative("omega")?;
/// assert_eq!(by_frequency.drift()[1].text(problem.states()).to_string(), "- 4 x - 1.2 x^3");
/// assert_eq!(problem.with_parameter("omega", 1.0)?.drift()[1].text(problem.states()).to_string(), "- x - 0.2 v - 0.3 x^3");
/// # Ok::<(), expoly::Error>(())
/// ```
pub trait Parametric: Sized {
    /// The system with parameters of another type.
    type With<P: Parameter>;

    /// The system with `of(name, value)` in the place of each parameter.
    fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> Self::With<P>;
}

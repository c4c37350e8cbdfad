use super::Intensity;
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
/// It is generic over the type of its parameters. [`parametric!`](crate::parametric) names them all in a line, and everything else
/// follows: the values, the same system at other values, and by dual numbers the derivatives of its equations
/// ([`Problem::derivative`](crate::Problem::derivative)).
///
/// ```
/// use expoly::{Intensity, Oscillator, Parameter, Problem, Scalar, parametric};
///
/// struct Hardening<P = f64> { damping: P, frequency: P, intensity: Intensity<P> }
///
/// impl<P: Parameter> Oscillator<P> for Hardening<P> {
///     fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
///         v * self.damping + (x + x.powi(3) * 0.3) * self.frequency.powi(2)
///     }
///     fn intensity(&self) -> Intensity<P> {
///         self.intensity
///     }
/// }
///
/// parametric!(Hardening { damping: "c", frequency: "omega", intensity: "D" });
///
/// let problem = Problem::parametric(Hardening { damping: 0.2, frequency: 2.0, intensity: Intensity::new(0.1)? })?;
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

/// What a field of a [`Parametric`] system may be that has a name: a number; an [`Intensity`], by its D; a list of numbers, whose
/// names are numbered from 1.
pub trait Parameters {
    /// The same with parameters of another type.
    type With<P: Parameter>;

    /// The same with `of(name, value)` in the place of each number.
    fn with<P: Parameter>(&self, name: &str, of: &mut dyn FnMut(&str, f64) -> P) -> Self::With<P>;
}

impl Parameters for f64 {
    type With<P: Parameter> = P;

    fn with<P: Parameter>(&self, name: &str, of: &mut dyn FnMut(&str, f64) -> P) -> P {
        of(name, *self)
    }
}

impl Parameters for Intensity {
    type With<P: Parameter> = Intensity<P>;

    fn with<P: Parameter>(&self, name: &str, of: &mut dyn FnMut(&str, f64) -> P) -> Intensity<P> {
        Intensity::of(of(name, self.d()))
    }
}

impl Parameters for Vec<f64> {
    type With<P: Parameter> = Vec<P>;

    fn with<P: Parameter>(&self, name: &str, of: &mut dyn FnMut(&str, f64) -> P) -> Vec<P> {
        self.iter().zip(1..).map(|(value, i)| of(&format!("{name}{i}"), *value)).collect()
    }
}

impl<const K: usize> Parameters for [f64; K] {
    type With<P: Parameter> = [P; K];

    fn with<P: Parameter>(&self, name: &str, of: &mut dyn FnMut(&str, f64) -> P) -> [P; K] {
        std::array::from_fn(|i| of(&format!("{name}{}", i + 1), self[i]))
    }
}

/// Names the parameters of a system, which is [`Parametric`] by it: `parametric!(Hardening { damping: "c", intensity: "D" })` for a
/// `struct Hardening<P = f64>`.
///
/// Every field is in the list: a number, an [`Intensity`] or a list of numbers with its name, a part that is parametric itself
/// without one.
///
/// ```
/// use expoly::{Intensity, Oscillator, Parameter, Problem, Scalar, parametric};
///
/// struct Spring<P = f64> { stiffness: P, powers: [P; 2] }
///
/// struct Softening<P = f64> { spring: Spring<P>, damping: P }
///
/// impl<P: Parameter> Oscillator<P> for Softening<P> {
///     fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
///         let Spring { stiffness, powers } = &self.spring;
///         v * self.damping + x * *stiffness + x.powi(3) * powers[0] + x.powi(5) * powers[1]
///     }
///     fn intensity(&self) -> Intensity<P> {
///         Intensity::of(P::from(0.1))
///     }
/// }
///
/// parametric!(Spring { stiffness: "k", powers: "mu" });
/// parametric!(Softening { spring, damping: "c" });
///
/// let spring = Spring { stiffness: 1.0, powers: [-0.3, 0.1] };
/// let problem = Problem::parametric(Softening { spring, damping: 0.2 })?;
/// let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| &name[..]).collect();
/// assert_eq!(names, ["k", "mu1", "mu2", "c"]);
/// # Ok::<(), expoly::Error>(())
/// ```
#[macro_export]
macro_rules! parametric {
    ($system:ident { $($field:ident $(: $name:literal)?),+ $(,)? }) => {
        impl $crate::Parametric for $system {
            type With<P: $crate::Parameter> = $system<P>;

            fn with<P: $crate::Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> $system<P> {
                $system { $($field: $crate::parametric!(@ &self.$field, of $(, $name)?)),+ }
            }
        }
    };
    (@ $part:expr, $of:ident) => {
        $crate::Parametric::with($part, $of)
    };
    (@ $field:expr, $of:ident, $name:literal) => {
        $crate::Parameters::with($field, $name, $of)
    };
}

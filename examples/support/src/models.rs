//! The models with the parameters that the examples give them, and their exact densities, where these are known.

use expoly::models::{
    Clearance, CubicDamping, DisplacementNoise, DryFriction, Duffing, DuffingChain, DuffingVanDerPol, EnergyDamping,
    HertzContact, Linear, ParametricLinear, PowerLaw, QuinticDuffing, ShipRoll, SmoothAndDiscontinuous, Solved, Swing,
    VanDerPolRayleigh, VelocityNoise, VibroImpactDuffing,
};
use expoly::{Density, ExpPolynomial, Method, Problem, Result};

/// One model.
#[derive(Clone, Debug)]
pub struct Model {
    /// Its names.
    pub about: About,
    /// The system with its walls.
    pub problem: Problem,
    /// The lowest order that contains the density, or 8 where none does.
    pub order: u32,
    /// None where no closed form is known.
    pub exact: Option<Exact>,
}

/// The names of a model: as a word to type, and as a heading.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// The word to type.
    pub name: &'static str,
    /// The heading.
    pub title: &'static str,
    /// The equation of motion.
    pub equation: &'static str,
    /// The parameters.
    pub parameters: &'static str,
}

/// A density in closed form.
#[derive(Clone, Debug)]
pub enum Exact {
    /// exp of a polynomial.
    ExpPolynomial(Box<ExpPolynomial>),
    /// A power law.
    PowerLaw(PowerLaw),
}

impl Exact {
    /// The density itself.
    pub fn known(&self) -> &dyn Density {
        match self {
            Exact::ExpPolynomial(density) => &**density,
            Exact::PowerLaw(density) => density,
        }
    }
}

/// The method of a problem that has it.
impl Method for Exact {
    fn density(&self, _: &Problem) -> Result<Box<dyn Density>> {
        Ok(match self.clone() {
            Exact::ExpPolynomial(density) => density,
            Exact::PowerLaw(density) => Box::new(density),
        })
    }
}

fn about([name, title, equation, parameters]: [&'static str; 4]) -> About {
    About { name, title, equation, parameters }
}

fn solved(text: [&'static str; 4], order: u32, model: impl Solved) -> Result<Model> {
    let exact = Some(Exact::ExpPolynomial(Box::new(model.exact()?)));
    Ok(Model { about: about(text), problem: model.problem()?, order, exact })
}

fn unsolved(text: [&'static str; 4], problem: Problem) -> Model {
    Model { about: about(text), problem, order: 8, exact: None }
}

/// Those of two states with polynomial forces, in the order of the library's table, and two degrees of freedom.
///
/// # Errors
/// None; the parameters are those of stationary systems.
pub fn models() -> Result<Vec<Model>> {
    let duffing = "x″ + c x′ + k x + μ x³ = ξ";
    let cubic_damping = "x″ + α x′ + γ x′³ + k x + μ x³ = ξ";
    let duffing_van_der_pol = "x″ + (α + β x²) x′ + k x + μ x³ = ξ";
    let parametric = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?;
    Ok(vec![
        solved(["linear", "Linear", "x″ + c x′ + k x = ξ", "c = 0.2, k = 1, D = 0.2"], 2, Linear::new(0.2, 1.0, 0.2)?)?,
        solved(
            ["duffing", "Duffing", duffing, "c = 0.2, k = 1, μ = 0.3, D = 0.2"],
            4,
            Duffing::new(0.2, 1.0, 0.3, 0.2)?,
        )?,
        solved(
            ["bistable", "Duffing, two wells", duffing, "c = 1, k = −1, μ = 1, D = 0.3"],
            4,
            Duffing::new(1.0, -1.0, 1.0, 0.3)?,
        )?,
        solved(
            [
                "three_wells",
                "QuinticDuffing",
                "x″ + c x′ + k x + μ x³ + ν x⁵ = ξ",
                "c = k = 1, μ = −1.8, ν = 0.6, D = 0.3",
            ],
            6,
            QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3)?,
        )?,
        solved(
            ["van_der_pol_rayleigh", "VanDerPolRayleigh", "x″ + ε (x² + x′² − 1) x′ + x = ξ", "ε = 1, D = 0.15"],
            4,
            VanDerPolRayleigh::new(1.0, 0.15)?,
        )?,
        solved(
            ["energy_damping", "EnergyDamping", "x″ + (βH − α) x′ + x + μ x³ = ξ", "α = 0.2, β = μ = 0.3, D = 0.2"],
            8,
            EnergyDamping::new(0.2, 0.3, 0.3, 0.2)?,
        )?,
        Model {
            about: about([
                "parametric_linear",
                "ParametricLinear",
                "x″ + 2α x′ (1 + η) + Ω² x (1 + ζ) = ξ, Stratonovich",
                "α = 0.1, Ω = 1, D_η = 0.5, D = 0.2",
            ]),
            problem: Problem::of(parametric)?,
            order: 8,
            exact: Some(Exact::PowerLaw(parametric.exact())),
        },
        solved(
            [
                "displacement_noise",
                "DisplacementNoise",
                "x″ + c (1 + g x²) x′ + k x + μ x³ = ξ₁ + √g x ξ₂",
                "c = D = 0.5, k = 1, μ = 0.4, g = 0.7",
            ],
            4,
            DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?,
        )?,
        solved(
            [
                "velocity_noise",
                "VelocityNoise",
                "x″ + d(x, x′) + k x + μ x³ = (g₀ + g₁ x′) ξ, Stratonovich",
                "g₀ = 0.7, g₁ = 0.3, φ = 0.8 H, k = 1, μ = 0.4, D = 1",
            ],
            4,
            VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4)?,
        )?,
        unsolved(
            ["van_der_pol", "Van der Pol", "x″ − ε (1 − x²) x′ + x = ξ", "ε = 0.5, D = 0.3"],
            Problem::of(DuffingVanDerPol::van_der_pol(0.5, 0.3)?)?,
        ),
        unsolved(
            ["duffing_van_der_pol", "DuffingVanDerPol", duffing_van_der_pol, "α = −0.5, β = 1, k = μ = 1, D = 0.5"],
            Problem::of(DuffingVanDerPol::new([-0.5, 1.0], 1.0, 1.0, 0.5)?)?,
        ),
        unsolved(
            [
                "bistable_damping",
                "DuffingVanDerPol, two wells",
                duffing_van_der_pol,
                "α = β = 0.3, k = −1, μ = 1, D = 0.3",
            ],
            Problem::of(DuffingVanDerPol::new([0.3, 0.3], -1.0, 1.0, 0.3)?)?,
        ),
        unsolved(
            ["rayleigh", "Rayleigh", "x″ − ε (1 − x′²) x′ + x = ξ", "ε = 1, D = 0.2"],
            Problem::of(CubicDamping::rayleigh(1.0, 0.2)?)?,
        ),
        unsolved(
            ["cubic_damping_duffing", "CubicDamping", cubic_damping, "α = 0.1, γ = 0.3, k = μ = 1, D = 0.5"],
            Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?,
        ),
        unsolved(
            [
                "vibro_impact",
                "VibroImpactDuffing",
                "x″ + c x′ + k x + μ x³ = ξ for x > b; x′₊ = −r x′₋ at x = b",
                "c = 0.2, k = 1, μ = 0.3, D = 0.2, b = −0.5, r = 0.9",
            ],
            VibroImpactDuffing::standard([-0.5, 0.9])?.problem()?,
        ),
        solved(
            [
                "two_degrees_of_freedom",
                "DuffingChain",
                "x_i″ + c_i x_i′ + k x_i + μ x_i³ + κ (x_i − x_j) = ξ_i, i = 1, 2: four states",
                "c₁ = 0.2, c₂ = 0.4, k = 1, μ = 0.3, κ = 0.5, D_i = 0.8 c_i",
            ],
            4,
            DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?,
        )?,
    ])
}

/// Those of two states whose forces are no polynomials. With linear damping their density is exp(-c H/D), which is no exponential
/// polynomial, but which the closure has with the potential and its kinks in Q.
///
/// # Errors
/// None; the parameters are those of stationary systems.
pub fn with_functions() -> Result<Vec<Model>> {
    let of = |text, order, problem: Result<Problem>| -> Result<Model> {
        Ok(Model { about: about(text), problem: problem?, order, exact: None })
    };
    Ok(vec![
        of(
            [
                "clearance",
                "Clearance",
                "x″ + c x′ + k x + κ max(|x| − a, 0) sgn x = ξ",
                "c = 0.2, k = 0.1, κ = 4, a = 1, D = 0.2",
            ],
            4,
            Clearance::new([0.2, 0.1, 4.0, 1.0], 0.2)?.problem(),
        )?,
        of(
            [
                "hertz_contact",
                "HertzContact",
                "x″ + c x′ + k x + κ max(x − a, 0)^{3/2} = ξ",
                "c = 0.2, k = 1, κ = 4, a = 0, D = 0.2",
            ],
            4,
            HertzContact::new([0.2, 1.0, 4.0, 0.0], 0.2)?.problem(),
        )?,
        of(
            [
                "smooth_and_discontinuous",
                "SmoothAndDiscontinuous",
                "x″ + c x′ + x (1 − 1/√(x² + α²)) = ξ",
                "c = 0.2, α = 0.5, D = 0.05",
            ],
            4,
            SmoothAndDiscontinuous::new([0.2, 0.5], 0.05)?.problem(),
        )?,
        of(
            ["swing", "Swing", "x″ + c x′ + κ x + k sin x = P + ξ", "c = κ = D = 0.3, k = 1, P = 0.2"],
            4,
            Swing::new([0.3, 0.3, 1.0, 0.2], 0.3)?.problem(),
        )?,
        of(
            [
                "dry_friction",
                "DryFriction",
                "x″ + c x′ + μ sgn x′ + k x + β x³ = ξ",
                "c = 0.1, μ = D = 0.2, k = 1, β = 0.3",
            ],
            8,
            Problem::of(DryFriction::new([0.1, 0.2, 1.0, 0.3], 0.2)?),
        )?,
        of(
            [
                "ship_roll",
                "ShipRoll",
                "x″ + (c + b |x′|) x′ + k x + μ x³ + ν x⁵ = ξ",
                "c = 0.05, b = D = 0.2, k = 1, μ = 0.1, ν = 0",
            ],
            8,
            Problem::of(ShipRoll::new([0.05, 0.2, 1.0, 0.1, 0.0], 0.2)?),
        )?,
    ])
}

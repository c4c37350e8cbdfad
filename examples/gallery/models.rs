//! The models with the parameters that are drawn, and the lowest order that contains their density where one does.

use crate::written::Written;
use expoly::models::{
    CubicDamping, DisplacementNoise, Duffing, DuffingVanDerPol, EnergyDamping, Linear, ParametricLinear,
    QuinticDuffing, Solved, VanDerPolRayleigh, VelocityNoise, VibroImpactDuffing,
};
use expoly::{Barrier, Density, Result};

/// One model of two states.
pub(crate) struct Model {
    pub(crate) name: &'static str,
    pub(crate) equation: &'static str,
    pub(crate) parameters: &'static str,
    pub(crate) system: Written,
    pub(crate) barrier: Option<Barrier>,
    pub(crate) order: u32,
    /// None where no closed form is known.
    pub(crate) exact: Option<Box<dyn Density<2>>>,
}

/// Name, equation, parameters.
type Text = [&'static str; 3];

fn solved<T: Solved<2, M>, const M: usize>([name, equation, parameters]: Text, order: u32, model: T) -> Result<Model> {
    let exact: Option<Box<dyn Density<2>>> = Some(Box::new(model.exact()?));
    Ok(Model { name, equation, parameters, system: Written::of(&model), barrier: None, order, exact })
}

fn unsolved([name, equation, parameters]: Text, system: Written, barrier: Option<Barrier>) -> Model {
    Model { name, equation, parameters, system, barrier, order: 8, exact: None }
}

/// All of two states, in the order of the library's table.
pub(crate) fn models() -> Result<Vec<Model>> {
    let duffing = "x″ + c x′ + k x + μ x³ = ξ";
    let parametric = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?;
    let wall = VibroImpactDuffing::new(Duffing::new(0.2, 1.0, 0.3, 0.2)?, Barrier::new(-0.5, 0.9)?);
    Ok(vec![
        solved(["Linear", "x″ + c x′ + k x = ξ", "c = 0.2, k = 1, D = 0.2"], 2, Linear::new(0.2, 1.0, 0.2)?)?,
        solved(["Duffing", duffing, "c = 0.2, k = 1, μ = 0.3, D = 0.2"], 4, Duffing::new(0.2, 1.0, 0.3, 0.2)?)?,
        solved(
            ["Duffing, two wells", duffing, "c = 1, k = −1, μ = 1, D = 0.3"],
            4,
            Duffing::new(1.0, -1.0, 1.0, 0.3)?,
        )?,
        solved(
            ["QuinticDuffing", "x″ + c x′ + k x + μ x³ + ν x⁵ = ξ", "c = k = 1, μ = −1.8, ν = 0.6, D = 0.3"],
            6,
            QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3)?,
        )?,
        solved(
            ["VanDerPolRayleigh", "x″ + ε (x² + x′² − 1) x′ + x = ξ", "ε = 1, D = 0.15"],
            4,
            VanDerPolRayleigh::new(1.0, 0.15)?,
        )?,
        solved(
            ["EnergyDamping", "x″ + (βH − α) x′ + x + μ x³ = ξ", "α = 0.2, β = μ = 0.3, D = 0.2"],
            8,
            EnergyDamping::new(0.2, 0.3, 0.3, 0.2)?,
        )?,
        Model {
            name: "ParametricLinear",
            equation: "x″ + 2α x′ (1 + η) + Ω² x (1 + ζ) = ξ, Stratonovich",
            parameters: "α = 0.1, Ω = 1, D_η = 0.5, D = 0.2",
            system: Written::of(&parametric),
            barrier: None,
            order: 8,
            exact: Some(Box::new(parametric.exact())),
        },
        solved(
            [
                "DisplacementNoise",
                "x″ + c (1 + g x²) x′ + k x + μ x³ = ξ₁ + √g x ξ₂",
                "c = D = 0.5, k = 1, μ = 0.4, g = 0.7",
            ],
            4,
            DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?,
        )?,
        solved(
            [
                "VelocityNoise",
                "x″ + d(x, x′) + k x + μ x³ = (g₀ + g₁ x′) ξ, Stratonovich",
                "g₀ = 0.7, g₁ = 0.3, φ = 0.8 H, k = 1, μ = 0.4, D = 1",
            ],
            4,
            VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4)?,
        )?,
        unsolved(
            ["DuffingVanDerPol", "x″ + (α + β x²) x′ + k x + μ x³ = ξ", "α = −0.5, β = 1, k = μ = 1, D = 0.5"],
            Written::of(&DuffingVanDerPol::new([-0.5, 1.0], 1.0, 1.0, 0.5)?),
            None,
        ),
        unsolved(
            ["CubicDamping", "x″ + α x′ + γ x′³ + k x + μ x³ = ξ", "α = 0.1, γ = 0.3, k = μ = 1, D = 0.5"],
            Written::of(&CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?),
            None,
        ),
        unsolved(
            [
                "VibroImpactDuffing",
                "x″ + c x′ + k x + μ x³ = ξ for x > b; x′₊ = −r x′₋ at x = b",
                "c = 0.2, k = 1, μ = 0.3, D = 0.2, b = −0.5, r = 0.9",
            ],
            Written::of(wall.oscillator()),
            Some(wall.barrier()),
        ),
    ])
}

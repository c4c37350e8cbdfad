//! The library's models by name, with the parameters of the literature's usual cases.

use crate::plan::Plan;
use crate::rows::Study;
use expoly::models::{
    CubicDamping, DisplacementNoise, Duffing, DuffingChain, DuffingVanDerPol, EnergyDamping, Linear, ParametricLinear,
    QuinticDuffing, Solved, VanDerPolRayleigh, VelocityNoise,
};

const NAMES: &str = "linear, duffing, bistable, three_wells, van_der_pol_rayleigh, energy_damping, displacement_noise, \
    velocity_noise, two_degrees_of_freedom, parametric_linear, cubic_damping_duffing, van_der_pol, bistable_damping, \
    rayleigh, duffing_van_der_pol";

/// Studies the model of the plan's name.
pub(crate) fn study(plan: &Plan<'_>) -> Result<Study, Box<dyn std::error::Error>> {
    let name = plan.0.model.as_str();
    Ok(match name {
        "linear" => plan.solved("x'' + 0.2 x' + x, D = 0.2", &Linear::new(0.2, 1.0, 0.2)?)?,
        "duffing" => plan.solved("x'' + 0.2 x' + x + 0.3 x^3, D = 0.2", &Duffing::new(0.2, 1.0, 0.3, 0.2)?)?,
        "bistable" => plan.solved("x'' + x' - x + x^3, D = 0.3", &Duffing::new(1.0, -1.0, 1.0, 0.3)?)?,
        "three_wells" => {
            let model = QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3)?;
            plan.solved("x'' + x' + x - 1.8 x^3 + 0.6 x^5, D = 0.3", &model)?
        }
        "van_der_pol_rayleigh" => {
            let model = VanDerPolRayleigh::new(1.0, 0.15)?;
            plan.solved("x'' + (x^2 + x'^2 - 1) x' + x, D = 0.15", &model)?
        }
        "energy_damping" => {
            let model = EnergyDamping::new(0.2, 0.3, 0.3, 0.2)?;
            plan.solved("x'' + (0.3 H - 0.2) x' + x + 0.3 x^3, D = 0.2", &model)?
        }
        "displacement_noise" => {
            let model = DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?;
            plan.solved("x'' + 0.5 (1 + 0.7 x^2) x' + x + 0.4 x^3, D = 0.5 (1 + 0.7 x^2)", &model)?
        }
        "velocity_noise" => {
            let model = VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4)?;
            plan.solved("x'' + d(x') + x + 0.4 x^3 with noise (0.7 + 0.3 x') xi, D = 1", &model)?
        }
        "two_degrees_of_freedom" => {
            let model = DuffingChain::new([0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?;
            plan.many_states("two coupled Duffing oscillators, T = 0.8", &model, &model.exact()?)?
        }
        "parametric_linear" => {
            let model = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?;
            let equation = "x'' + 0.2 x' (1 + eta) + x (1 + zeta), D = 0.2, D_eta = 0.5";
            plan.two_states(equation, &model, Some(&model.exact()))?
        }
        "cubic_damping_duffing" => {
            plan.unsolved("x'' + 0.1 x' + 0.3 x'^3 + x + x^3, D = 0.5", CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?
        }
        "van_der_pol" => {
            plan.unsolved("x'' - 0.5 (1 - x^2) x' + x, D = 0.3", DuffingVanDerPol::van_der_pol(0.5, 0.3)?)?
        }
        "bistable_damping" => plan.unsolved(
            "x'' + 0.3 (1 + x^2) x' - x + x^3, D = 0.3",
            DuffingVanDerPol::new([0.3, 0.3], -1.0, 1.0, 0.3)?,
        )?,
        "rayleigh" => plan.unsolved("x'' - (1 - x'^2) x' + x, D = 0.2", CubicDamping::rayleigh(1.0, 0.2)?)?,
        "duffing_van_der_pol" => plan
            .unsolved("x'' - (0.5 - x^2) x' + x + x^3, D = 0.5", DuffingVanDerPol::new([-0.5, 1.0], 1.0, 1.0, 0.5)?)?,
        _ => return Err(format!("--model {name}: no such model; there are {NAMES}").into()),
    })
}

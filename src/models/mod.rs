//! The literature's oscillators, each with its source and, where there is one, its exact density.
//!
//! | model | equation | exact density |
//! |---|---|---|
//! | [`Linear`] | x″ + c x′ + k x = ξ | normal |
//! | [`Duffing`] | x″ + c x′ + k x + μ x³ = ξ, two wells for k < 0 | exp(−c H/D) |
//! | [`QuinticDuffing`] | x″ + c x′ + k x + μ x³ + ν x⁵ = ξ, up to three wells | exp(−c H/D) |
//! | [`VanDerPolRayleigh`] | x″ + ε (x² + x′² − 1) x′ + x = ξ | exp of a quartic in x² + x′² |
//! | [`EnergyDamping`] | x″ + (βH − α) x′ + x + μ x³ = ξ | exp of a quadratic in H |
//! | [`ParametricLinear`] | x″ + 2α x′ (1 + η) + Ω² x (1 + ζ) = ξ | power law |
//! | [`DisplacementNoise`] | x″ + c (1 + g x²) x′ + k x + μ x³ = ξ₁ + √g x ξ₂ | exp(−c H/D) |
//! | [`VelocityNoise`] | noise (g₀ + g₁ x′) ξ, damping to suit | exp(−φ(H)) |
//! | [`DuffingChain`] | coupled Duffing oscillators at one temperature | exp(−energy/T) |
//! | [`Clearance`] | x″ + c x′ + k x + κ max(\|x\| − a, 0) sgn x = ξ | exp(−c H/D) |
//! | [`HertzContact`] | x″ + c x′ + k x + κ max(x − a, 0)^{3/2} = ξ | exp(−c H/D) |
//! | [`SmoothAndDiscontinuous`] | x″ + c x′ + x (1 − 1/√(x² + α²)) = ξ | exp(−c H/D) |
//! | [`Swing`] | x″ + c x′ + κ x + k sin x = P + ξ | exp(−c H/D) |
//! | [`DryFriction`] | x″ + c x′ + μ sgn x′ + k x + β x³ = ξ | none |
//! | [`ShipRoll`] | x″ + (c + b \|x′\|) x′ + k x + μ x³ + ν x⁵ = ξ | none |
//! | [`BoucWen`] | x″ + c x′ + α x + (1 − α) z = ξ, z′ = x′ − β \|x′\| \|z\|ⁿ⁻¹ z − γ x′ \|z\|ⁿ | none |
//! | [`DuffingVanDerPol`] | x″ + (α + β x²) x′ + k x + μ x³ = ξ | none |
//! | [`CubicDamping`] | x″ + α x′ + γ x′³ + k x + μ x³ = ξ | none |
//! | [`BistableHarvester`] | x″ + c x′ + k x + μ x³ + κ₁ V = ξ, V′ = κ₂ x′ − λ V | none |
//! | [`ViscoelasticIsolator`] | x″ + c x′ + k x + μ x³ + f = ξ, f′ = k₁ x′ − f/τ | none |
//! | [`TunedAbsorber`] | x″ + c x′ + k x + μ x³ + s = ξ, m y″ = s = κ (x − y) + γ (x′ − y′) | none |
//! | [`NonlinearEnergySink`] | the same with s = ν (x − y)³ + γ (x′ − y′) | none |
//! | [`FilteredDuffing`] | Duffing under z, z′ = a (ξ − z) or z″ + 2ζω z′ + ω² z = ω² ξ | none |
//! | [`VibroImpactDuffing`] | Duffing above a wall that need not stand at the rest position | for r = 1 |
//! | [`ColouredVibroImpact`] | the same under z + ξ₀ with z′ = a (ξ − z) | none |
//! | [`ImpactAbsorber`] | a structure with an absorber between two stops | none |
//!
//! Every D is an intensity as in [`Intensity`](crate::Intensity); H = x′²/2 + G(x) is the energy per unit mass, G′ the restoring force.

mod attachment;
mod bistable_harvester;
mod bouc_wen;
mod chain;
mod clearance;
mod coloured_vibro_impact;
mod cubic_damping;
mod displacement_noise;
mod dry_friction;
mod duffing;
mod duffing_van_der_pol;
mod energy_damping;
mod filtered_duffing;
mod follower;
mod hertz_contact;
mod impact_absorber;
mod linear;
mod nonlinear_energy_sink;
mod parametric_linear;
mod quintic_duffing;
mod ship_roll;
mod smooth_and_discontinuous;
mod swing;
mod tuned_absorber;
mod van_der_pol_rayleigh;
mod velocity_noise;
mod vibro_impact;
mod viscoelastic_isolator;

pub use bistable_harvester::BistableHarvester;
pub use bouc_wen::BoucWen;
pub use chain::DuffingChain;
pub use clearance::Clearance;
pub use coloured_vibro_impact::ColouredVibroImpact;
pub use cubic_damping::CubicDamping;
pub use displacement_noise::DisplacementNoise;
pub use dry_friction::DryFriction;
pub use duffing::Duffing;
pub use duffing_van_der_pol::DuffingVanDerPol;
pub use energy_damping::EnergyDamping;
pub use filtered_duffing::FilteredDuffing;
pub use hertz_contact::HertzContact;
pub use impact_absorber::ImpactAbsorber;
pub use linear::Linear;
pub use nonlinear_energy_sink::NonlinearEnergySink;
pub use parametric_linear::{ParametricLinear, PowerLaw};
pub use quintic_duffing::QuinticDuffing;
pub use ship_roll::ShipRoll;
pub use smooth_and_discontinuous::SmoothAndDiscontinuous;
pub use swing::Swing;
pub use tuned_absorber::TunedAbsorber;
pub use van_der_pol_rayleigh::VanDerPolRayleigh;
pub use velocity_noise::VelocityNoise;
pub use vibro_impact::VibroImpactDuffing;
pub use viscoelastic_isolator::ViscoelasticIsolator;

use crate::density::{ExpPolynomial, Support};
use crate::error::Result;
use crate::polynomial::{Arena, Polynomial};
use crate::problem::Problem;
use crate::scalar::Scalar;

/// A system whose stationary density is known as exp of a polynomial, or of one in functions of the states.
pub trait Solved {
    /// The system as a problem.
    ///
    /// # Errors
    /// As [`Problem::of`].
    fn problem(&self) -> Result<Problem>;

    /// ln p up to its constant, generically, like the drift.
    fn log_density<S: Scalar>(&self, x: &[S]) -> S;

    /// The polynomial of [`Solved::log_density`].
    ///
    /// # Errors
    /// As [`Solved::problem`].
    fn log_polynomial(&self) -> Result<Polynomial> {
        let states = self.problem()?.dimension();
        let arena = Arena::new(states);
        Ok(self.log_density(&arena.variables()).polynomial(states))
    }

    /// The exact stationary density.
    ///
    /// # Errors
    /// [`Error::NotNormalisable`](crate::Error::NotNormalisable), and as [`Problem::gaussian`], where the parameters
    /// leave no stationary density; [`Error::NotServed`](crate::Error::NotServed) where ln p has functions of the states: take
    /// [`Solved::log_density`], or the grid's density.
    fn exact(&self) -> Result<ExpPolynomial> {
        self.problem()?.operator().require_polynomial("exact density")?;
        let scale = self.problem()?.gaussian()?;
        Ok(ExpPolynomial::from_states(&self.log_polynomial()?, &scale, Support::WholeSpace)?.known())
    }

    /// The exact density above an elastic wall at `bound`, r = 1: the density without a wall, cut off and normalised
    /// again.
    ///
    /// # Errors
    /// As [`Solved::exact`]; [`Error::OutOfRange`](crate::Error::OutOfRange) for a bound that is not finite,
    /// [`Error::NotServed`](crate::Error::NotServed) from six states on, where the box has too many nodes to be searched.
    fn exact_above(&self, bound: f64) -> Result<ExpPolynomial> {
        self.problem()?.operator().require_polynomial("exact density")?;
        let scale = self.problem()?.gaussian()?;
        Ok(ExpPolynomial::from_states(&self.log_polynomial()?, &scale, Support::Above(bound))?.known())
    }
}

//! Models as cases of a study of orders, with the options of the command line.

use crate::models::{About, Exact, Model, models};
use clap::{Args, ValueEnum};
use expoly::study::Case;
use expoly::{Basis, Closure, Density, Grid, Problem, Simulation, Weight};

/// By which methods models are closed, and what they are compared with.
#[derive(Clone, Debug, Args)]
pub struct Setup {
    /// The closure that gives a density at every order, the literature's, or both
    #[arg(long, value_enum, default_value = "both")]
    pub method: Method,
    /// The weight of the robust closure's fit: auto, density, or the share of the tails between 0 and 1
    #[arg(long, default_value = "auto", value_parser = weight, allow_negative_numbers = true)]
    pub weight: Weight,
    /// What the robust closure is closest to
    #[arg(long, value_enum, default_value = "auto")]
    pub closest_to: ClosestTo,
    /// What the orders are compared with [default: the exact density where one is known, else the grid]
    #[arg(long, value_enum)]
    pub reference: Option<Reference>,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-6")]
    pub accuracy: f64,
    /// Samples of the simulation
    #[arg(long, default_value_t = 4_000_000)]
    pub samples: usize,
    /// Seed of the simulation and of the robust closure's pilot
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// The methods of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The closure that gives a density at every order
    Robust,
    /// The literature's closure
    Classical,
    /// Both
    Both,
}

/// What is taken for the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Reference {
    /// The density in closed form
    Exact,
    /// The solution on a grid
    Grid,
    /// A simulation
    Simulation,
}

/// What the robust closure is closest to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClosestTo {
    /// The moment equations' solution or the grid's in two states, the pilot's states in more
    Auto,
    /// The solution of the moment equations
    Equations,
    /// The density of a grid
    Grid,
    /// The pilot's states
    States,
}

impl Setup {
    /// The models of these names as cases of a study.
    ///
    /// # Errors
    /// For a name that no model has, and a reference that is not available.
    pub fn cases(&self, names: &[String]) -> Result<Vec<(About, Case<'_>)>, Box<dyn std::error::Error>> {
        let models = models()?;
        let known: Vec<&str> = models.iter().map(|model| model.about.name).collect();
        let refused = |name: &str| format!("--model {name}: no such model; there are {}", known.join(", "));
        let places = names.iter().map(|name| known.iter().position(|known| known == name).ok_or_else(|| refused(name)));
        let places = places.collect::<Result<Vec<_>, _>>()?;
        places.into_iter().map(|place| Ok((models[place].about, self.case(&models[place])?))).collect()
    }

    fn case(&self, model: &Model) -> Result<Case<'_>, Box<dyn std::error::Error>> {
        let Model { about, problem, exact, .. } = model;
        if exact.is_none() && self.reference == Some(Reference::Exact) {
            return Err(format!("--model {}: no exact density is known", about.name).into());
        }
        if problem.dimension() > 2 && self.reference.is_some_and(|reference| reference != Reference::Exact) {
            let remedy = "it is compared with its exact density; leave --reference out";
            return Err(format!("--model {}: {remedy}", about.name).into());
        }
        let mut case = Case::new(about.name, problem.clone(), Truth { setup: self, exact: exact.clone() });
        // A method may be added to a table, but all rows of it are of the same other options.
        case = case.settings(&format!("{:?}", Setup { method: Method::Both, ..self.clone() }));
        if self.method != Method::Classical {
            case = case.method("robust", |order| {
                let reference = match self.closest_to {
                    ClosestTo::Auto => expoly::Reference::Automatic,
                    ClosestTo::Equations => expoly::Reference::Equations,
                    ClosestTo::Grid => expoly::Reference::Grid,
                    ClosestTo::States => expoly::Reference::States,
                };
                Closure::new(order).weight(self.weight).seed(self.seed).reference(reference)
            });
        }
        if self.method != Method::Robust {
            case = case.method("classical", Closure::classical);
        }
        Ok(case)
    }
}

/// The truth by the options, the exact density where it is known.
struct Truth<'a> {
    setup: &'a Setup,
    exact: Option<Exact>,
}

impl expoly::Method for Truth<'_> {
    fn density(&self, problem: &Problem) -> expoly::Result<Box<dyn Density>> {
        let Setup { reference, samples, seed, accuracy, .. } = self.setup;
        match (reference, &self.exact) {
            (None | Some(Reference::Exact), Some(exact)) => exact.density(problem),
            (Some(Reference::Simulation), _) => {
                Ok(Box::new(Simulation::new().samples(*samples).seed(*seed).run(problem)?))
            }
            _ => Grid::new().accuracy(*accuracy).density(problem),
        }
    }
}

/// The weight of the fit as an option.
///
/// # Errors
/// For a word that is none of these.
pub fn weight(text: &str) -> Result<Weight, String> {
    match text {
        "auto" => Ok(Weight::Automatic),
        "density" => Ok(Weight::Density),
        share => share.parse().map(Weight::Tails).map_err(|_| String::from("give auto, density or the tails' share")),
    }
}

/// The basis of the classical closure as an option.
///
/// # Errors
/// For a word that is none of these.
pub fn basis(text: &str) -> Result<Basis, String> {
    match text {
        "classical" => Ok(Basis::Classical),
        "folded" => Ok(Basis::Folded),
        _ => Err(String::from("give classical or folded")),
    }
}

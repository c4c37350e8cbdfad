//! Models as cases of a study of orders, as the command line asks for it.

use super::models::{About, Model, models};
use super::written::Written;
use clap::{Args, ValueEnum};
use expoly::models::{DuffingChain, Solved};
use expoly::study::{Case, StudyCase, Truth};
use expoly::{Closure, Grid, NodeKind, Simulation, Weight};

/// By which methods models are closed, and what they are compared with.
#[derive(Clone, Debug, Args)]
pub struct Setup {
    /// The closure that gives a density at every order, the literature's, or both
    #[arg(long, value_enum, default_value = "both")]
    pub method: Method,
    /// The weight of the robust closure's fit: auto, density, or the share of the tails between 0 and 1
    #[arg(long, default_value = "auto", value_parser = weight, allow_negative_numbers = true)]
    pub weight: Weight,
    /// The robust closure's nodes
    #[arg(long, value_enum, default_value = "auto")]
    pub nodes: Nodes,
    /// What the orders are compared with [default: the exact density where one is known, else the grid]
    #[arg(long, value_enum)]
    pub reference: Option<Reference>,
    /// Degree of the grid [default: the library's]
    #[arg(long)]
    pub degree: Option<usize>,
    /// Samples of the simulation
    #[arg(long, default_value_t = 4_000_000)]
    pub samples: usize,
    /// Seed of the simulation and of the robust closure's pilot
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    Robust,
    Classical,
    Both,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Reference {
    Exact,
    Grid,
    Simulation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Nodes {
    /// Gauss nodes in two states, samples in more
    Auto,
    /// Gauss nodes
    Tensor,
    /// The pilot's states
    Samples,
}

impl From<Nodes> for NodeKind {
    fn from(nodes: Nodes) -> Self {
        match nodes {
            Nodes::Auto => NodeKind::Automatic,
            Nodes::Tensor => NodeKind::Tensor,
            Nodes::Samples => NodeKind::Samples,
        }
    }
}

/// A case of a study, and what it is.
pub type Chosen<'a> = (About, Box<dyn StudyCase + 'a>);

/// The model of more than two states.
const CHAIN: About = About {
    name: "two_degrees_of_freedom",
    title: "DuffingChain",
    equation: "x_i″ + c_i x_i′ + k x_i + μ x_i³ + κ (x_i − x_j) = ξ_i, i = 1, 2",
    parameters: "c₁ = 0.2, c₂ = 0.4, k = 1, μ = 0.3, κ = 0.5, D_i = 0.8 c_i",
};

impl Setup {
    /// The models of these names as cases of a study.
    pub fn cases(&self, names: &[String]) -> Result<Vec<Chosen<'_>>, Box<dyn std::error::Error>> {
        let mut models = models()?;
        let known: Vec<&str> = models.iter().map(|model| model.about.name).chain([CHAIN.name]).collect();
        let refused = |name: &str| format!("--model {name}: no such model; there are {}", known.join(", "));
        let unknown = names.iter().find(|name| !known.contains(&name.as_str()));
        unknown.map_or(Ok(()), |name| Err(refused(name)))?;
        let case = |name: &String| match models.iter().position(|model| model.about.name == name) {
            Some(k) => self.plane(models.swap_remove(k)),
            None => self.chain(),
        };
        names.iter().map(case).collect()
    }

    fn closure(&self, order: u32) -> Closure {
        Closure::new(order).weight(self.weight).nodes(self.nodes.into()).seed(self.seed)
    }

    fn plane(&self, model: Model) -> Result<Chosen<'_>, Box<dyn std::error::Error>> {
        let Model { about, system, barrier, exact, .. } = model;
        if exact.is_none() && self.reference == Some(Reference::Exact) {
            return Err(format!("--model {}: no exact density is known", about.name).into());
        }
        let truth = move |system: &Written| {
            Ok(match (self.reference, &exact) {
                (None | Some(Reference::Exact), Some(exact)) => exact.truth(),
                (Some(Reference::Simulation), _) => {
                    let simulation = Simulation::new(system).samples(self.samples).seed(self.seed);
                    Truth::simulation(match barrier {
                        None => simulation.run()?,
                        Some(barrier) => simulation.barrier(barrier).run()?,
                    })
                }
                _ => {
                    let grid = self.degree.map_or(Grid::new(), |degree| Grid::new().degree(degree));
                    Truth::grid(match barrier {
                        None => grid.solve(system)?,
                        Some(barrier) => grid.solve_with_wall(system, barrier)?,
                    })
                }
            })
        };
        let mut case = Case::new(about.name, system, truth);
        if let Some(barrier) = barrier {
            case = case.above(barrier);
        }
        if self.method != Method::Classical {
            case = case.method("robust", move |system, order| {
                let closure = self.closure(order);
                Ok(match barrier {
                    None => closure.solve(system)?,
                    Some(barrier) => closure.solve_with_wall(system, barrier)?,
                }
                .into())
            });
        }
        if self.method != Method::Robust {
            case = case.method("classical", move |system, order| {
                let closure = Closure::classical(order);
                Ok(match barrier {
                    None => closure.solve(system)?,
                    Some(barrier) => closure.solve_with_wall(system, barrier)?,
                }
                .into())
            });
        }
        Ok((about, Box::new(case)))
    }

    fn chain(&self) -> Result<Chosen<'_>, Box<dyn std::error::Error>> {
        if self.reference.is_some_and(|reference| reference != Reference::Exact) {
            return Err(format!(
                "--model {}: it is compared with its exact density; leave --reference out",
                CHAIN.name
            )
            .into());
        }
        let chain = DuffingChain::new([0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?;
        let mut case = Case::new(CHAIN.name, chain, |chain| Ok(Truth::exact(chain.exact()?)));
        if self.method != Method::Classical {
            case = case.method("robust", |chain, order| Ok(self.closure(order).solve(chain)?.into()));
        }
        if self.method != Method::Robust {
            case = case.method("classical", |chain, order| Ok(Closure::classical(order).solve(chain)?.into()));
        }
        Ok((CHAIN, Box::new(case)))
    }
}

/// The weight of the fit as an option.
pub fn weight(text: &str) -> Result<Weight, String> {
    match text {
        "auto" => Ok(Weight::Automatic),
        "density" => Ok(Weight::Density),
        share => share.parse().map(Weight::Tails).map_err(|_| String::from("give auto, density or the tails' share")),
    }
}

//! The values that are asked of a density.

use crate::Outcome;
use crate::system::number;
use clap::Args;
use expoly::{Crossing, Problem};

/// What is asked, on the command line.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Asked {
    /// Moments, separated by commas, such as "x^2,v^2,x^2*v^2" [default: first and second of every state]
    #[arg(long)]
    moments: Option<String>,
    /// States at which to give p, such as "0.1,0.2;0.3,0.4"
    #[arg(long, allow_hyphen_values = true)]
    at: Option<String>,
    /// Places at which to give a state's own density, such as "x=0.5,1.0;v=0"
    #[arg(long)]
    marginal: Option<String>,
    /// Levels at which to give P(X > level), such as "x=2.5,3.0"
    #[arg(long)]
    exceedance: Option<String>,
    /// Levels at which to give the mean number of up-crossings per unit time, such as "x=2.5"
    #[arg(long)]
    crossing: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A moment E[x₁^p₁ ⋯], by its name.
pub(crate) type Moment = (String, Vec<u32>);

/// A state and a place on it.
pub(crate) type Place = (usize, f64);

/// The values asked of a density of one problem.
#[derive(Clone, Debug)]
pub(crate) struct Questions {
    pub(crate) moments: Vec<Moment>,
    pub(crate) at: Vec<Vec<f64>>,
    pub(crate) marginal: Vec<Place>,
    pub(crate) exceedance: Vec<Place>,
    pub(crate) crossings: Vec<Crossing>,
}

impl Asked {
    pub(crate) fn of(&self, problem: &Problem) -> Outcome<Questions> {
        let names = problem.states();
        let usual = names.iter().flat_map(|name| [name.clone(), format!("{name}^2")]).collect::<Vec<_>>().join(",");
        let moments = self.moments.as_deref().unwrap_or(&usual);
        let moments = moments.split(',').map(|name| moment(problem, name.trim()));
        let state = |text: &str| -> Outcome<Vec<f64>> {
            let x = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
            let wrong = format!("--at: {text:?} has {} numbers for {} states", x.len(), names.len());
            if x.len() == names.len() { Ok(x) } else { Err(wrong.into()) }
        };
        let crossing = |(displacement, level): Place| {
            let velocity = problem.velocity_of(displacement);
            let refused = || format!("--crossing: no state is the velocity of {}", names[displacement]);
            velocity.map(|velocity| Crossing { displacement, velocity, level, upward: true }).ok_or_else(refused)
        };
        let crossings = places(problem, "--crossing", self.crossing.as_deref())?.into_iter().map(crossing);
        Ok(Questions {
            moments: moments.collect::<Outcome<_>>()?,
            at: self.at.as_deref().map_or(Ok(Vec::new()), |at| at.split(';').map(state).collect())?,
            marginal: places(problem, "--marginal", self.marginal.as_deref())?,
            exceedance: places(problem, "--exceedance", self.exceedance.as_deref())?,
            crossings: crossings.collect::<Result<_, _>>()?,
        })
    }
}

/// The powers of a product such as x^2*v.
fn moment(problem: &Problem, name: &str) -> Outcome<Moment> {
    let mut powers = vec![0; problem.dimension()];
    for factor in name.split('*') {
        let (state, power) = factor.split_once('^').unwrap_or((factor, "1"));
        let state = problem.state(state.trim()).map_err(|error| format!("--moments: {name:?}: {error}"))?;
        let power: u32 =
            power.trim().parse().map_err(|_| format!("--moments: {name:?}: {power:?} is no whole power"))?;
        powers[state] += power;
    }
    Ok((name.to_owned(), powers))
}

/// Places such as x=0.5,1.0;v=0.
fn places(problem: &Problem, option: &str, text: Option<&str>) -> Outcome<Vec<Place>> {
    let mut places = Vec::new();
    for part in text.into_iter().flat_map(|text| text.split(';')) {
        let (name, values) =
            part.split_once('=').ok_or_else(|| format!("{option}: {part:?}: write STATE=VALUE,VALUE"))?;
        let state = problem.state(name.trim()).map_err(|error| format!("{option}: {error}"))?;
        for value in values.split(',') {
            places.push((state, number(value)?));
        }
    }
    Ok(places)
}

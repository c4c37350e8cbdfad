//! The requested values, from the command line.

use expoly::Problem;

/// A moment E[x₁^p₁ ⋯], by its name.
pub(crate) type Moment = (String, Vec<u32>);

/// A state and a place on it.
pub(crate) type Place = (usize, f64);

/// The values requested of a density.
#[derive(Clone, Debug)]
pub(crate) struct Questions {
    pub(crate) moments: Vec<Moment>,
    pub(crate) at: Vec<Vec<f64>>,
    pub(crate) marginal: Vec<Place>,
    pub(crate) exceedance: Vec<Place>,
}

impl Questions {
    pub(crate) fn new(
        problem: &Problem,
        moments: Option<&str>,
        at: Option<&str>,
        marginal: Option<&str>,
        exceedance: Option<&str>,
    ) -> Result<Self, String> {
        let names = problem.states();
        let usual = names.iter().flat_map(|name| [name.clone(), format!("{name}^2")]).collect::<Vec<_>>().join(",");
        let moments = moments.unwrap_or(&usual).split(',').map(|name| moment(problem, name.trim()));
        let state = |text: &str| {
            let x = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
            let wrong = format!("--at: {text:?} has {} numbers for {} states", x.len(), names.len());
            if x.len() == names.len() { Ok(x) } else { Err(wrong) }
        };
        Ok(Questions {
            moments: moments.collect::<Result<_, _>>()?,
            at: at.map_or(Ok(Vec::new()), |at| at.split(';').map(state).collect())?,
            marginal: places(problem, "--marginal", marginal)?,
            exceedance: places(problem, "--exceedance", exceedance)?,
        })
    }
}

/// The powers of a product such as x^2*v.
fn moment(problem: &Problem, name: &str) -> Result<Moment, String> {
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
fn places(problem: &Problem, option: &str, text: Option<&str>) -> Result<Vec<Place>, String> {
    let mut places = Vec::new();
    for part in text.into_iter().flat_map(|text| text.split(';')) {
        let (name, values) = part.split_once('=').ok_or(format!("{option}: {part:?}: write STATE=VALUE,VALUE"))?;
        let state = problem.state(name.trim()).map_err(|error| format!("{option}: {error}"))?;
        for value in values.split(',') {
            places.push((state, number(value)?));
        }
    }
    Ok(places)
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| format!("{text:?} is no finite number"))
}

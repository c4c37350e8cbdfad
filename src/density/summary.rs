use super::{Crossing, Density};
use crate::polynomial::of_one;
use std::fmt::{Formatter, Result};

/// The states of which a summary has a value each; of more it has those of the first.
const SHOWN: usize = 6;

/// What a density prints of itself, a line each: how it was made, its domain, means and mean squares, crossings and impacts where it
/// has them, and how far it is from the truth.
pub(crate) fn summary(density: &dyn Density, f: &mut Formatter<'_>) -> Result {
    let n = density.dimension();
    write!(f, "{}", density.provenance())?;
    let sides =
        density.bounds().iter().take(SHOWN).map(|[low, high]| format!("[{low:.4}, {high:.4}]")).collect::<Vec<_>>();
    line(f, "domain", &more(sides.join(" × "), n))?;
    for (name, power) in [("means", 1), ("mean squares", 2)] {
        let moment = |state: usize| density.moment(&of_one(n, state, power)).map(|found| found.to_string());
        let moments: Vec<String> =
            (0..n.min(SHOWN)).map(|state| moment(state).unwrap_or_else(|_| "unknown".into())).collect();
        line(f, name, &more(moments.join(", "), n))?;
    }
    let mean = density.moment(&of_one(n, 0, 1)).map(|mean| mean.value);
    // A density has no word on which state is the velocity of which; the line names what it takes for granted.
    if let (true, Ok(rate)) = (n > 1, mean.and_then(|level| density.flux(Crossing::upward(level), 1))) {
        line(f, "up-crossings, x2 = x1'", &rate.to_string())?;
    }
    if let Some(rate) = density.impact_rate() {
        line(f, "impacts per unit time", &rate.to_string())?;
    }
    if density.provenance().l1_estimate.is_some() {
        line(f, "estimate of the L1 error", &format!("{:.1e}", density.l1_estimate()))?;
    }
    density.warning().map_or(Ok(()), |warning| line(f, "warning", warning))
}

fn line(f: &mut Formatter<'_>, name: &str, value: &str) -> Result {
    write!(f, "\n{name:<25} {value}")
}

fn more(text: String, states: usize) -> String {
    if states > SHOWN { text + ", …" } else { text }
}

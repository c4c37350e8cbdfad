//! Texts of systems and documents of closed forms, damaged and read again.

use super::mutants::mutant;
use super::{densities, probe::Probe};
use expoly::models::{Duffing, Solved};
use expoly::{ClosedForm, Closure, Density, Problem, Wall};

const TEXTS: [&str; 3] = [
    include_str!("../../../systems/duffing.toml"),
    include_str!("../../../systems/filtered.toml"),
    include_str!("../../../systems/absorber.toml"),
];
const MUTANTS: usize = 100;

/// The closed forms whose documents are damaged.
#[derive(Default)]
pub(super) struct Documents(Vec<(ClosedForm, String)>);

fn closed_forms() -> expoly::Result<Vec<(ClosedForm, String)>> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let walled = duffing.problem()?.with_wall(Wall::above(-0.5, 0.9)?)?;
    let closure = |problem: &Problem| Closure::new(4).pilot_states(2000).solve(problem);
    let forms = [
        ClosedForm::new(duffing.exact()?, &["x", "v"])?,
        ClosedForm::new(closure(&duffing.problem()?)?, &["x", "v"])?,
        ClosedForm::new(closure(&walled)?, &["x", "v"])?,
    ];
    forms.into_iter().map(|form| form.to_json().map(|text| (form, text))).collect()
}

impl Documents {
    pub(super) fn probe(&mut self, probe: &mut Probe) {
        if self.0.is_empty() {
            self.0 = probe.ask("closed forms", closed_forms).unwrap_or_default();
        }
        if self.0.is_empty() || probe.draw.with(0.5) {
            let text = probe.draw.of(TEXTS);
            (0..MUTANTS).for_each(|_| system(probe, text));
        } else {
            let (form, text) = &self.0[probe.draw.below(self.0.len())];
            (0..MUTANTS).for_each(|_| document(probe, form, text));
        }
    }
}

/// Every text is refused, or is a system that can be written and read again.
fn system(probe: &mut Probe, text: &str) {
    probe.documents += 1;
    let bytes = mutant(&mut probe.draw, text.as_bytes());
    let text = String::from_utf8_lossy(&bytes);
    let Some(problem) = probe.ask("from_toml", || Problem::from_toml(&text)) else { return };
    written(probe, &problem);
    if probe.draw.with(0.1) && problem.dimension() <= 4 {
        probe.ask("classical closure of a text", || Closure::classical(2).solve(&problem)?.density());
    }
}

/// Writes a problem and reads it again.
pub(super) fn written(probe: &mut Probe, problem: &Problem) {
    let Some(text) = probe.ask("to_toml", || problem.to_toml()) else { return };
    let again = probe.ask("from_toml of to_toml", || Problem::from_toml(&text));
    let told = |problem: &Problem| format!("{:?} {problem:?}", problem.operator());
    if again.is_none_or(|again| told(&again) != told(problem)) {
        probe.show(&text);
        probe.finding("other-answer", "a system that was written reads otherwise");
    }
}

/// A damaged document is refused, or the density is the same. With its checksum set right it may be any density, as long as
/// all calls of it end.
fn document(probe: &mut Probe, form: &ClosedForm, text: &str) {
    probe.documents += 1;
    let mut text = String::from_utf8_lossy(&mutant(&mut probe.draw, text.as_bytes())).into_owned();
    let refusal = match probe.step("from_json", || ClosedForm::from_json(&text)) {
        Some(Ok(read)) => {
            let told = |form: &ClosedForm| format!("{:?} {:?}", form.log_pdf(&[0.3, -0.4]), form.moment(&[2, 2]));
            if told(&read) != told(form) {
                probe.finding("other-answer", "a damaged closed form is read, with another density");
            }
            return;
        }
        Some(Err(error)) => error.to_string(),
        None => return,
    };
    // "its content has the checksum A, not B: it was altered"
    let Some((_, sums)) = refusal.split_once("the checksum ") else { return };
    let Some((found, claimed)) = sums.split_once(", not ") else { return };
    let claimed = claimed.split(':').next().unwrap_or_default();
    if claimed.len() != found.len() {
        return;
    }
    text = text.replace(claimed, found);
    if let Some(read) = probe.ask("from_json with a right checksum", || ClosedForm::from_json(&text)) {
        densities::harmless(probe, &read);
    }
}

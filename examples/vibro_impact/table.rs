//! The table in the terminal.

use crate::study::{Statistics, Study};
use expoly::{Density, compare};
use std::fmt::Write;
use support::shown;

/// One case as text: a row for each method.
pub(crate) fn table(study: &Study) -> String {
    let mut text = format!("{}\n", study.parameters.line());
    let header = [
        "method",
        "termination",
        "E Y",
        "Var Y",
        "E Y'^2",
        "impact rate",
        "balance",
        "L1 p_Y",
        "tail p_Y",
        "L1 grid",
        "estimate",
        "indicator",
        "s",
    ];
    line(&mut text, &header.map(String::from));
    let mut cut_off_seen = false;
    let mut noise = None;
    let mut remarks = String::new();
    for judged in &study.closures {
        let made = &judged.provenance;
        let mut cells = vec![judged.name(), shown(made.termination.as_ref())];
        cells.extend(values(judged.statistics.as_ref()));
        let (mut l1, mut tail) = (String::from("-"), String::from("-"));
        if let Some((distance, cut_off)) = study.distance(judged) {
            let shown = |value: String| if cut_off { format!("({value})") } else { value };
            (l1, tail) = (shown(format!("{:.1e}", distance.l1)), shown(format!("{:.2}", distance.tail)));
            cut_off_seen |= cut_off;
            noise = Some(distance);
        }
        let to_grid = study.distance_to_grid(judged).map_or_else(
            || String::from("-"),
            |(distance, cut_off)| if cut_off { format!("({distance:.1e})") } else { format!("{distance:.1e}") },
        );
        cells.extend([l1, tail, to_grid]);
        cells.extend(
            [made.l1_estimate, made.indicator]
                .map(|number| number.map_or_else(|| String::from("-"), |number| format!("{number:.1e}"))),
        );
        cells.push(format!("{:.3}", judged.seconds));
        line(&mut text, &cells);
        if let Some(reason) = made.warning.as_ref().or(made.refusal.as_ref()) {
            remarks += &format!("  {}: {reason}\n", judged.name());
        }
    }
    if let Some((grid, statistics)) = &study.gridded {
        let provenance = grid.provenance();
        let mut cells = vec![String::from("grid"), format!("{} unknowns", shown(provenance.unknowns))];
        cells.extend(values(Some(statistics)));
        let distance = study
            .simulated
            .as_ref()
            .and_then(|(simulated, _)| compare::with_histogram(grid, 0, simulated.histogram(0).ok()?).ok());
        cells.extend(distance.map_or_else(
            || [String::from("-"), String::from("-")],
            |distance| [format!("{:.1e}", distance.l1), format!("{:.2}", distance.tail)],
        ));
        cells.extend([String::new(), format!("{:.1e}", grid.l1_estimate()), String::new()]);
        cells.push(format!("{:.1}", provenance.seconds));
        line(&mut text, &cells);
        noise = noise.or(distance);
    }
    if let Some((result, statistics)) = &study.simulated {
        let steps = result.provenance().path_steps.unwrap_or_default() as f64;
        if let Some(warning) = &result.provenance().warning {
            remarks += &format!("  simulation: {warning}\n");
        }
        let mut cells = vec![String::from("simulation"), format!("{steps:.1e} steps")];
        cells.extend(values(Some(statistics)));
        let (l1, tail) = noise.map_or_else(
            || (String::from("-"), String::from("-")),
            |d| (format!("~{:.1e}", d.noise), format!("to {:.0e}", d.tail_level)),
        );
        cells.extend([l1, tail, String::new(), String::new(), String::new()]);
        cells.push(format!("{:.1}", result.provenance().seconds));
        line(&mut text, &cells);
        let mut cells = vec![String::from("  standard error"), String::new()];
        let errors = statistics.all().map(|(_, estimate)| format!("{:.5}", estimate.error));
        cells.extend(errors);
        line(&mut text, &cells);
    }
    if cut_off_seen {
        text += "  (…) no density: exp(Q) cut off at the range of the samples\n";
    }
    text + &remarks
}

fn values(statistics: Option<&Statistics>) -> [String; 5] {
    statistics.map_or_else(
        || std::array::from_fn(|_| String::from("-")),
        |statistics| statistics.all().map(|(_, estimate)| format!("{:.5}", estimate.value)),
    )
}

fn line(text: &mut String, cells: &[String]) {
    const WIDTHS: [usize; 13] = [17, 17, 8, 8, 8, 12, 8, 9, 8, 9, 8, 9, 6];
    for (k, (cell, width)) in cells.iter().zip(WIDTHS).enumerate() {
        // Names to the left, numbers to the right. Writing to a string cannot fail.
        let _ = if k < 2 { write!(text, "  {cell:<width$}") } else { write!(text, "  {cell:>width$}") };
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
}

/// p_Y at chosen displacements, a row for each.
pub(crate) fn pdf_table(study: &Study, at: &[f64]) -> expoly::Result<String> {
    let mut text = String::from("  p_Y(y)\n");
    for y in at {
        let mut cells = vec![format!("y = {y}")];
        for judged in &study.closures {
            let name = judged.name();
            let value = judged.density.as_ref().map(|density| density.marginal(0, *y)).transpose()?;
            cells.push(value.map_or_else(|| format!("{name}: -"), |p| format!("{name}: {:.6}", p.value)));
        }
        if let Some((density, _)) = &study.gridded {
            cells.push(format!("grid: {:.6}", density.marginal(0, *y)?.value));
        }
        if let Some((density, _)) = &study.simulated {
            cells.push(format!("simulation: {:.6}", density.histogram(0)?.density_at(&[*y])?));
        }
        text += &format!("  {}\n", cells.join("   "));
    }
    Ok(text)
}

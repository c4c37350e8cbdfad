//! What is measured now.

use super::Text;
use crate::forces::FORCES;
use crate::grid_in_space::SYSTEMS;
use crate::{campaign, derivatives_at_walls, impulses, public as cases, transients};
use expoly::models::{Duffing, VibroImpactDuffing};
use expoly::{Basis, Closure, Density, Grid, Problem, Result, Simulation, Wall, Weight, compare};
use support::models::{Exact, models};
use support::text::{headed, markdown, short, shown};

/// Two errors: the distance, and the estimate of it.
fn pair(distance: f64, estimate: f64) -> String {
    format!("{distance:.1e}, {estimate:.1e}")
}

/// The power of ten above a number that is rounding, which differs from machine to machine.
fn below(value: f64) -> String {
    format!("< 1e{}", value.max(1e-300).log10().ceil())
}

/// The models whose density is exp of a polynomial, by both closures at the order that holds it.
pub(super) fn solved(quick: bool) -> Text {
    let mut rows = headed(["model", "states", "n", "closure", "its estimate", "classical closure"]);
    let known = models()?.into_iter().filter(|model| matches!(model.exact, Some(Exact::ExpPolynomial(_))));
    for model in known.take(if quick { 2 } else { usize::MAX }) {
        let Some(exact) = &model.exact else { continue };
        let closed = Closure::new(model.order).solve(&model.problem)?;
        let distance = |density: &dyn Density| compare::l1(density, exact.known()).map(|l1| below(l1.value));
        let classical = match Closure::classical(model.order).solve(&model.problem)?.density() {
            Ok(density) => distance(&density)?,
            Err(_) => String::from("none"),
        };
        let [states, order] = [model.problem.dimension() as u32, model.order].map(|count| count.to_string());
        let own = [distance(&closed)?, below(closed.l1_estimate()), classical];
        rows.push([format!("`{}`", model.about.name), states, order].into_iter().chain(own).collect());
    }
    Ok(markdown(&rows))
}

/// The models without a closed form, against the grid.
pub(super) fn closures(quick: bool) -> Text {
    let orders: &[u32] = if quick { &[4] } else { &[4, 8, 12] };
    let columns = orders.iter().map(|order| format!("n = {order}: L¹, estimate"));
    let last = [format!("classical, n = {}", orders.iter().map(u32::to_string).collect::<Vec<_>>().join(", "))];
    let mut rows = vec![[String::from("model")].into_iter().chain(columns).chain(last).collect::<Vec<_>>()];
    let open = models()?.into_iter().filter(|model| model.exact.is_none() && model.problem.walls().is_empty());
    for model in open.take(if quick { 1 } else { usize::MAX }) {
        let truth = Grid::new().solve(&model.problem)?;
        let mut row = vec![format!("`{}`", model.about.name)];
        for order in orders {
            let density = Closure::new(*order).solve(&model.problem)?;
            row.push(pair(compare::l1(&density, &truth)?.value, density.l1_estimate()));
        }
        let classical = orders.iter().map(|order| -> Result<String> {
            let density = Closure::classical(*order).solve(&model.problem)?.density();
            let l1 = density.ok().map(|density| compare::l1(&density, &truth).map(|l1| l1.value)).transpose()?;
            Ok(l1.map_or_else(|| String::from("none"), |l1| format!("{l1:.1e}")))
        });
        row.push(classical.collect::<Result<Vec<_>>>()?.join(", "));
        rows.push(row);
    }
    Ok(markdown(&rows))
}

/// Forces that are no polynomials, against the grid.
pub(super) fn forces(quick: bool) -> Text {
    let mut rows = headed(["system", "n = 4: L¹, estimate", "n = 8: L¹, estimate", "grid: worst moment"]);
    for force in FORCES.iter().take(if quick { 1 } else { FORCES.len() }) {
        let problem = force.problem()?;
        let truth = Grid::new().accuracy(1e-7).solve(&problem)?;
        let closed = |order| -> Result<String> {
            let density = Closure::new(order).weight(Weight::Density).solve(&problem)?;
            Ok(pair(compare::l1(&density, &truth)?.value, density.l1_estimate()))
        };
        rows.push(vec![force.name.to_owned(), closed(4)?, closed(8)?, format!("{:.0e}", force.worst(&truth)?[0])]);
    }
    Ok(markdown(&rows))
}

/// The Duffing oscillator of the standard study above five walls.
pub(super) fn walls(quick: bool) -> Text {
    const WALLS: [[f64; 2]; 5] = [[0.0, 0.98], [0.2, 0.95], [-0.5, 0.9], [0.5, 0.7], [-0.5, 0.5]];
    let mut rows =
        headed(["b, r", "n = 4: L¹, estimate", "n = 8: L¹, estimate", "classical, n = 4", "folded, n = 4", "grid"]);
    for [b, r] in WALLS.into_iter().take(if quick { 1 } else { WALLS.len() }) {
        let problem = VibroImpactDuffing::standard([b, r])?.problem()?;
        let truth = Grid::new().solve(&problem)?;
        let closed = |order| -> Result<String> {
            let density = Closure::new(order).solve(&problem)?;
            Ok(pair(compare::l1(&density, &truth)?.value, density.l1_estimate()))
        };
        let classical = |basis| campaign::walls::classical(basis, &problem, &truth);
        rows.push(vec![
            format!("{b}, {r}").replace('-', "−"),
            closed(4)?,
            closed(8)?,
            classical(Basis::Classical)?,
            classical(Basis::Folded)?,
            format!("{:.0e}", truth.l1_estimate()),
        ]);
    }
    Ok(markdown(&rows))
}

/// The grid in three states, by the accuracy that is asked for.
pub(super) fn grid_in_space(quick: bool) -> Text {
    let mut rows = headed(["system", "accuracy", "degree", "cells", "estimate", "L¹"]);
    for system in SYSTEMS.iter().take(if quick { 1 } else { 3 }) {
        for [accuracy, finer] in system.accuracies.iter().take(if quick { 1 } else { 2 }) {
            let (found, l1) = system.solved([*accuracy, *finer], &|accuracy| Grid::new().accuracy(accuracy))?;
            let made = found.provenance();
            rows.push(vec![
                system.name.to_owned(),
                short(Some(*accuracy)),
                shown(made.degree),
                shown(made.cells),
                short(made.l1_estimate),
                short(l1),
            ]);
        }
    }
    Ok(markdown(&rows))
}

/// x_i″ + 0.1 x_i′ + 0.3 x_i′³ + x_i + x_i³ + 0.5 Σ (x_i − x_j) = ξ_i over neighbours, D from 0.3 to 0.6: the chain of `many_states`.
fn chain(oscillators: usize) -> Result<Problem> {
    let names = |letter: char| (1..=oscillators).map(move |i| format!("{letter}{i}"));
    let states: Vec<String> = names('x').chain(names('v')).map(|name| format!("\"{name}\"")).collect();
    let (mut drift, mut noise) = (String::new(), String::new());
    for i in 1..=oscillators {
        let neighbours = [i - 1, i + 1].into_iter().filter(|j| (1..=oscillators).contains(j));
        let coupling: String = neighbours.map(|j| format!(" + 0.5*(x{j} - x{i})")).collect();
        drift += &format!("x{i} = \"v{i}\"\nv{i} = \"-0.1*v{i} - 0.3*v{i}^3 - x{i} - x{i}^3{coupling}\"\n");
        let intensity = 0.3 + 0.3 * (i - 1) as f64 / (oscillators - 1) as f64;
        noise += &format!("[noise.w{i}]\nv{i} = \"sqrt({})\"\n", 2.0 * intensity);
    }
    Problem::from_toml(&format!("states = [{}]\n[drift]\n{drift}{noise}", states.join(", ")))
}

const FILTERED: &str = "states = [\"x\", \"v\", \"z\"]\n[drift]\nx = \"v\"\nv = \"z - 0.1*v - 0.3*v^3 - x - x^3\"\nz = \"-2*z\"\n\
    [noise.w]\nz = \"2\"\n";

/// Systems of three states and more at n = 4, against calibrated simulations.
pub(super) fn many_states(quick: bool) -> Text {
    let samples = if quick { 20_000 } else { 4_000_000 };
    let systems = [
        ("oscillator under filtered noise, a = 2", Problem::from_toml(FILTERED)?),
        ("structure with an absorber", Problem::from_toml(include_str!("../../../systems/absorber.toml"))?),
        ("chain of three", chain(3)?),
        ("chain of five", chain(5)?),
    ];
    let mut rows =
        headed(["system", "states", "unknowns", "estimate", "second moments off by", "fourth moments off by"]);
    for (name, problem) in systems.into_iter().take(if quick { 1 } else { 4 }) {
        let density = Closure::new(4).solve(&problem)?;
        let simulated = Simulation::new().samples(samples).seed(1).run(&problem)?;
        let worst = |power: u32| -> Result<String> {
            let mut worst = (0.0_f64, 0.0_f64);
            for state in 0..problem.dimension() {
                let mut powers = vec![0; problem.dimension()];
                powers[state] = power;
                let (own, truth) = (density.moment(&powers)?.value, simulated.moment(&powers)?);
                worst.0 = worst.0.max((own / truth.value - 1.0).abs());
                worst.1 = worst.1.max(truth.error / truth.value);
            }
            Ok(format!("{:.2} ± {:.2} %", 100.0 * worst.0, 100.0 * worst.1))
        };
        rows.push(vec![
            name.to_owned(),
            problem.dimension().to_string(),
            shown(density.provenance().unknowns),
            format!("{:.1e}", density.l1_estimate()),
            worst(2)?,
            worst(4)?,
        ]);
    }
    Ok(markdown(&rows))
}

/// Densities in time at n = 6, against the grid's.
pub(super) fn in_time(quick: bool) -> Text {
    let times: &[f64] = if quick { &[2.0] } else { &[2.0, 4.0, 8.0] };
    let header = times.iter().map(|t| format!("t = {t}: L¹, estimate"));
    let mut rows = vec![[String::from("system")].into_iter().chain(header).collect::<Vec<_>>()];
    for case in transients::cases()?.into_iter().take(if quick { 1 } else { usize::MAX }) {
        let name = case.name.to_owned();
        let truth = case.truth(1e-6, times)?;
        let found = case.distances(6, times, &truth)?;
        rows.push([name].into_iter().chain(found.into_iter().map(|[l1, estimate]| pair(l1, estimate))).collect());
    }
    Ok(markdown(&rows))
}

/// Duffing's oscillator under normal impulses at n = 6, against simulations.
pub(super) fn under_impulses(quick: bool) -> Text {
    let mut rows = headed(["λ", "ρ", "n = 6: L¹ by cells, estimate", "warning"]);
    let (rates, millions) = if quick { (&[5.0][..], 1) } else { (&[5.0, 1.0, 0.5, 0.2][..], 40) };
    for rate in rates {
        let (name, struck) = impulses::cases()?
            .into_iter()
            .find(|(name, _)| *name == format!("normal {rate}"))
            .ok_or("no such case of impulses")?;
        let problem = Problem::of(struck)?;
        let found = impulses::found(&problem, &impulses::cells(&problem, millions)?, 6, 0)?;
        let row = found.map(|found| [pair(found.distance, found.estimate), found.warning.unwrap_or_default()]);
        let row = row.unwrap_or_else(|| [String::from("none"), String::new()]);
        let rate = name.trim_start_matches("normal ").to_owned();
        let density = rate.parse::<f64>()? / 0.2;
        rows.push([rate, density.to_string()].into_iter().chain(row).collect());
    }
    Ok(markdown(&rows))
}

/// Derivatives above a wall that takes energy, against the grid's.
pub(super) fn derivatives(quick: bool) -> Text {
    let duffing = Problem::parametric(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
    let mut rows = headed(["r, n", "moments off by, stated", "impact rate off by, stated"]);
    let orders: &[u32] = if quick { &[4] } else { &[4, 6, 8] };
    for r in [0.95, 0.8].into_iter().take(if quick { 1 } else { 2 }) {
        let problem = duffing.clone().with_wall(Wall::above(-0.5, r)?)?;
        let truths = derivatives_at_walls::by_grid(&problem, if quick { 1e-3 } else { 1e-6 })?;
        for order in orders {
            let (off, stated) = derivatives_at_walls::by_closure(&problem, *order, &truths)?;
            let worst = |of: &[[f64; 2]], k: usize| of.iter().map(|off| off[k]).fold(0.0, f64::max);
            let cell = |k: usize| pair(worst(&off, k), worst(&stated, k));
            rows.push(vec![format!("{r}, {order}"), cell(0), cell(1)]);
        }
    }
    Ok(markdown(&rows))
}

/// Systems from public code by the closure of orders 4 and 8.
pub(super) fn public(quick: bool) -> Text {
    let mut rows = headed(["system", "states", "moments off by", "n = 4", "n = 8"]);
    let mut refused = Vec::new();
    for (name, text) in cases::CASES.into_iter().take(if quick { 1 } else { usize::MAX }) {
        let known = cases::known(name);
        let Ok(problem) = Problem::from_toml(text) else { continue };
        if known.is_empty() {
            continue;
        }
        let mut found = Vec::new();
        for order in [4, 8] {
            found.extend(cases::said(&problem, cases::Method::Closure(order), &known));
        }
        let [four, eight] = &found[..] else {
            refused.push(format!("`{name}`"));
            continue;
        };
        let estimate = |said: &cases::Said| {
            let text = short(said.estimate);
            if said.warning.is_some() { format!("({text})") } else { text }
        };
        let off = [four, eight].map(|said| said.off.map_or(f64::NAN, |off| off[0])).into_iter().fold(0.0, f64::max);
        rows.push(vec![
            format!("`{name}`"),
            problem.dimension().to_string(),
            format!("{off:.0e}"),
            estimate(four),
            estimate(eight),
        ]);
    }
    let none =
        if refused.is_empty() { String::new() } else { format!("\nWithout a density: {}.\n", refused.join(", ")) };
    Ok(format!("{}{none}", markdown(&rows)))
}

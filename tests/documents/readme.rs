//! The tables and sentences of README.md and of the guide's pages on accuracy, method and trust.

use super::{Comparison, Document, SEED, cycle_error, whole_numbers};
use crate::common::*;
use expoly::models::Solved;
use expoly::statistics::energy_balance;
use expoly::{Basis, Closure, Density, Error, Grid, Problem, Solution, Termination, compare};
use support::models::{Exact, models};

fn accuracy() -> Document {
    Document::read("src/guide/accuracy.md")
}

fn equation(problem: &Problem) -> String {
    problem.operator().text(problem.states()).to_string()
}

/// The problem of an example's model, under the name by which other tests ask for its densities.
fn shared(model: &str) -> (&'static str, Problem) {
    let wanted = models().unwrap().into_iter().find(|known| known.about.name == model);
    let wanted = wanted.unwrap_or_else(|| panic!("no example has the model {model:?}")).problem;
    let all = [
        ("cubic damping", problem(cubic_damping())),
        ("two wells", bistable_damping()),
        ("Duffing-van der Pol", duffing_van_der_pol()),
        ("Rayleigh", problem(rayleigh())),
        ("van der Pol", problem(van_der_pol())),
    ];
    let same = all.into_iter().find(|(_, problem)| equation(problem) == equation(&wanted));
    same.unwrap_or_else(|| panic!("no test solves the model {model:?}"))
}

/// How the classical search ended.
fn ending(solution: &Solution) -> &'static str {
    match solution.termination() {
        Termination::Root => "root",
        Termination::NotNormalisable => "not normalisable",
        _ => "none",
    }
}

/// Every cell.
#[test]
fn errors_where_no_polynomial_is_exact() {
    let (page, mut found) = (accuracy(), Comparison::default());
    let table = page.table("model | n = 4");
    let (header, rows) = table.split_first().unwrap();
    for row in rows {
        let (name, problem) = shared(&row.cells[0]);
        let truth = on_grid(name, &problem);
        let distance = |density: &dyn Density| compare::l1(density, &*truth).unwrap().value;
        for column in 1..4 {
            let density = closed(name, &problem, whole_numbers(&header.cells[column])[0], SEED);
            let printed = row.parts(column);
            found.number(&page.printed(row.line, printed[0]), distance(&*density), 0.0);
            found.number(&page.printed(row.line, printed[1]), density.l1_estimate(), 0.0);
        }
        for (order, printed) in whole_numbers(&header.cells[4]).into_iter().zip(row.parts(4)) {
            let printed = page.printed(row.line, printed);
            match Closure::classical(order).solve(&problem).unwrap().density() {
                Ok(density) if printed.text != "none" => found.number(&printed, distance(&density), 0.0),
                Ok(_) => found.words(&printed, "a density"),
                Err(_) => found.words(&printed, "none"),
            }
        }
    }
    found.finish(45);
}

/// The closure's estimates, how the classical search ended, and the distance of its roots from the closure of order 8, which is
/// the truth to within its own estimate. Distances from the grid take longer: `expoly-measure -- campaign --lattice`.
#[test]
fn estimates_and_classical_closures_above_walls() {
    let (page, mut found) = (accuracy(), Comparison::default());
    let table = page.table("b, r | n = 4");
    let (header, rows) = table.split_first().unwrap();
    for row in rows {
        let [b, r] = [0, 1].map(|k| page.printed(row.line, row.parts(0)[k]).value());
        let mut best = None;
        for column in [1, 2] {
            let density = closed_above(whole_numbers(&header.cells[column])[0], b, r);
            found.number(&page.printed(row.line, row.parts(column)[1]), density.l1_estimate(), 0.0);
            best = Some(density);
        }
        let best = best.unwrap();
        let order = whole_numbers(&header.cells[3])[0];
        for (basis, printed) in [Basis::Classical, Basis::Folded].into_iter().zip(row.parts(3)) {
            let solution = Closure::classical(order).basis(basis).solve(&duffing_above(b, r)).unwrap();
            let said = match printed {
                "none" => "none",
                cut_off if cut_off.starts_with('(') => "not normalisable",
                _ => "root",
            };
            found.words(&page.printed(row.line, said), ending(&solution));
            if let (Ok(density), "root") = (solution.density(), said) {
                let distance = compare::l1(&density, &*best).unwrap().value;
                found.number(&page.printed(row.line, printed), distance, best.l1_estimate());
            }
        }
    }
    found.finish(10 + 10 + 5);
}

/// These systems are odd: only monomials of even degree are in Q, without the constant.
#[test]
fn unknowns_in_many_states() {
    let (page, mut found) = (accuracy(), Comparison::default());
    let (_, text) = page.after("many_states -- --oscillators 3` or `5`, n = ");
    let order = whole_numbers(&text)[0];
    let even = |states: usize| monomials(states, order).iter().filter(|m| m.iter().sum::<u32>() % 2 == 0).count() - 1;
    let table = page.table("system | states");
    for row in &table[1..] {
        found.words(&page.printed(row.line, &row.cells[2]), &even(row.cells[1].parse().unwrap()).to_string());
    }
    // The first row's oscillator, at the bandwidth that its name says.
    let row = &table[1];
    let bandwidth = page.printed(row.line, row.parts(0)[1].trim_start_matches("a = ")).value();
    let filtered = format!(
        "states = [\"x\", \"v\", \"z\"]\n[parameters]\na = {bandwidth}\n[drift]\nx = \"v\"\n\
         v = \"z - 0.1*v - 0.3*v^3 - x - x^3\"\nz = \"-a*z\"\n[noise.w]\nz = \"a\"\n"
    );
    let density = Closure::new(order).solve(&Problem::from_toml(&filtered).unwrap()).unwrap();
    found.number(&page.printed(row.line, &row.cells[3]), density.l1_estimate(), 0.0);
    found.words(&page.printed(row.line, &row.cells[2]), &density.provenance().unknowns.unwrap().to_string());
    found.finish(4 + 2);
}

/// Both closures of every solved model of two states that is exp of a polynomial, and the closure of the chain.
#[test]
fn bounds_where_a_polynomial_is_exact() {
    let (page, mut found) = (accuracy(), Comparison::default());
    let [bound, chain_bound] = page.numbers("both closures find it: L¹ is below ");
    for model in models().unwrap() {
        let Some(Exact::ExpPolynomial(exact)) = &model.exact else { continue };
        let robust = Closure::new(model.order).solve(&model.problem).unwrap();
        let classical = Closure::classical(model.order).solve(&model.problem).unwrap().density().unwrap();
        for density in [&robust as &dyn Density, &classical] {
            let distance = compare::l1(density, &**exact).unwrap().value;
            found.holds(&bound, &format!("{}: {distance:.1e}", model.about.name), distance < bound.value());
        }
    }
    let distance = compare::l1(&*closed_chain(), &chain_of_two().exact().unwrap()).unwrap().value;
    found.holds(&chain_bound, &format!("{distance:.1e}"), distance < chain_bound.value());
    found.finish(2 * 8 + 1);
}

/// The dozen lines' moment, and the same system as a text, above a wall.
#[test]
fn a_dozen_lines() {
    let (readme, mut found) = (Document::read("README.md"), Comparison::default());
    let moment = closed("Duffing", &problem(duffing()), 4, 0).moment(&[2, 0]).unwrap();
    found.number(&readme.number("density.moment(&[2, 0])?.value - "), moment.value, moment.error);
    let written = Problem::from_toml(&readme.block("toml")).unwrap();
    assert_eq!(equation(&written), equation(&problem(duffing())));
    assert_eq!(written.walls(), duffing_above(-0.5, 0.9).walls());
    found.finish(1);
}

#[test]
fn highest_orders() {
    let (page, mut found) = (Document::read("src/guide/method.md"), Comparison::default());
    let (plane, walled) = (problem(duffing()), duffing_above(-0.5, 1.0));
    for (phrase, problem) in [("at every order n ≤ ", plane), ("next to any walls (n ≤ ", walled)] {
        let printed = page.number(phrase);
        let highest = printed.value() as u32;
        Closure::new(highest).solve(&problem).unwrap();
        let refused = matches!(Closure::new(highest + 1).solve(&problem), Err(Error::OutOfRange { .. }));
        found.holds(&printed, &format!("refuses {}: {refused}", highest + 1), refused);
    }
    found.finish(2);
}

/// The grid's error by the defaults, where the density is known and hard.
#[test]
fn three_wells_on_the_grid() {
    let (page, mut found) = (Document::read("src/guide/method.md"), Comparison::default());
    let [_, _, printed] = page.numbers("by the defaults the error is ");
    let density = Grid::new().solve(&problem(three_wells())).unwrap();
    found.number(&printed, compare::l1(&density, &three_wells().exact().unwrap()).unwrap().value, 0.0);
    found.finish(1);
}

#[test]
fn limits_of_the_closure() {
    let (page, mut found) = (Document::read("src/guide/trust.md"), Comparison::default());
    let [printed, order] = page.numbers("Polynomials approach limit cycles slowly: ");
    found.number(&printed, cycle_error(&order), 0.0);
    // A power tail.
    let [printed, order] = page.numbers("thousandth of the peak where that is nearer: ");
    let density = Closure::new(order.value() as u32).solve(&problem(parametric_linear())).unwrap();
    found.number(&printed, density.l1_estimate(), 0.0);
    found.number(&printed, compare::l1(&density, &parametric_linear().exact()).unwrap().value, 0.0);
    // e^(−π/√3), at which and below which impacts do not end.
    let critical = (-std::f64::consts::PI / 3.0_f64.sqrt()).exp();
    found.number(&page.number("For r ≤ "), critical, 0.0);
    found.finish(1 + 2 + 1);
}

/// The walls of the table at which it has no root, one that is no density, and a spurious one, in the order of the sentence.
#[test]
fn limits_of_the_classical_closure() {
    let (page, mut found) = (Document::read("src/guide/trust.md"), Comparison::default());
    let (line, text) = page.after("it has no root (walls of the page on accuracy at n = ");
    let order = whole_numbers(&text)[0];
    let accuracy = accuracy();
    let table = accuracy.table("b, r | n = 4");
    for (walls, expected) in text.split("r = ").skip(1).zip(["none", "not normalisable", "root"]) {
        for r in walls.split([')', ';']).next().unwrap().split(" and ") {
            let row = table.iter().find(|row| row.parts(0).last() == Some(&r)).unwrap();
            let [b, r] = [0, 1].map(|k| accuracy.printed(row.line, row.parts(0)[k]).value());
            let problem = duffing_above(b, r);
            let solution = Closure::classical(order).solve(&problem).unwrap();
            let said = page.printed(line, &format!("r = {r}, n = {order}: {expected}"));
            found.holds(&said, ending(&solution), ending(&solution) == expected);
            if let Ok(density) = solution.density() {
                let balance = energy_balance(&problem, &density).unwrap().value;
                found.holds(&said, &format!("energy balance {balance:.1e}"), balance.abs() > 0.5);
            }
        }
    }
    found.finish(5 + 1);
}

/// The short table of README is of numbers that the page on accuracy has.
#[test]
fn readme_quotes_the_accuracy() {
    let (readme, accuracy, mut found) = (Document::read("README.md"), accuracy(), Comparison::default());
    for row in &readme.table("system | error")[1..] {
        let words = row.cells[1].split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c)));
        for number in words.filter(|word| word.contains(['.', 'e']) && word.parse::<f64>().is_ok()) {
            found.holds(&readme.printed(row.line, number), "the same", accuracy.text.contains(number));
        }
    }
    found.finish(19);
}

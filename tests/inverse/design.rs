//! Design: against the closed form, other demands, hostile input.

use expoly::inverse::{Demand, Design};
use expoly::models::{Duffing, Solved};
use expoly::statistics::Marginal;
use expoly::{Density, Error, Problem, Result};

fn problem() -> Problem {
    Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap().problem().unwrap()
}

/// P(x > 2.5) of the closed form at c and μ.
fn exceedance(c: f64, mu: f64) -> f64 {
    let exact = Duffing::new(c, 1.0, mu, 0.2).unwrap().exact().unwrap();
    Marginal::new(&exact, 0).unwrap().exceedance(2.5).unwrap().value
}

/// At the optimum the closed form has the probability demanded, to the 1e-4 at which the search ends, and the slopes of cost
/// and ln P, by differences, are parallel to the 1e-3 of that.
#[test]
fn an_optimum_is_one_of_the_closed_form() -> Result<()> {
    let demand = Demand::Exceedance { state: 0, level: 2.5 };
    let cost = |x: &[_]| {
        let [c, mu] = [x[0] / 0.2, x[1] / 0.3];
        c * c + mu * mu
    };
    let found = Design::new(&problem(), &["c", "mu"], demand, 1e-4, cost).run()?;
    let [(_, c), (_, mu)] = found.parameters()[..] else { panic!("two parameters") };
    println!("c {c:.6}, mu {mu:.6}, {} solutions", found.solves());
    assert!(found.converged() && found.is_accurate() && found.solves() <= 6);
    assert!((exceedance(c, mu) / 1e-4 - 1.0).abs() < 1.1e-4);
    let h = 1e-4;
    let slope = [exceedance(c + h, mu) - exceedance(c - h, mu), exceedance(c, mu + h) - exceedance(c, mu - h)];
    let cost = [2.0 * c / 0.04, 2.0 * mu / 0.09];
    let sine = (slope[0] * cost[1] - slope[1] * cost[0]) / (slope[0].hypot(slope[1]) * cost[0].hypot(cost[1]));
    assert!(sine.abs() < 1.5e-3, "{sine:e}");
    Ok(())
}

/// One parameter leaves no choice: E v² = D/c, and the rate of zero crossings falls with the intensity's root.
#[test]
fn other_demands_are_met() -> Result<()> {
    let moment = Demand::Moment { powers: vec![0, 2] };
    let found = Design::new(&problem(), &["c"], moment, 0.5, |x| x[0]).run()?;
    assert!((found.parameters()[0].1 / 0.4 - 1.0).abs() < 1.1e-4 && found.converged());
    let rate = problem().with_parameter("D", 0.3)?;
    let wanted = expoly::Closure::new(4).solve(&rate)?.upcrossing_rate(1.0)?.value;
    let found = Design::new(&problem(), &["D"], Demand::UpcrossingRate { level: 1.0 }, wanted, |x| x[0] * x[0])
        .order(4)
        .run()?;
    assert!((found.parameters()[0].1 / 0.3 - 1.0).abs() < 1e-3, "{:?}", found.parameters());
    Ok(())
}

#[test]
fn bad_input_is_refused() {
    let of = |names: &[&str], value: f64| {
        Design::new(&problem(), names, Demand::Exceedance { state: 0, level: 2.5 }, value, |x| x[0] * x[0]).run()
    };
    assert!(matches!(of(&["c"], 0.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(of(&["c"], f64::NAN), Err(Error::OutOfRange { .. })));
    assert!(matches!(of(&["no such"], 1e-4), Err(Error::NotAName { .. })));
    assert!(matches!(of(&[], 1e-4), Err(Error::OutOfRange { .. })));
    let far = Demand::Exceedance { state: 0, level: 1e3 };
    assert!(matches!(Design::new(&problem(), &["c"], far, 1e-4, |x| x[0]).run(), Err(Error::OutOfRange { .. })));
    let state = Demand::Exceedance { state: 2, level: 1.0 };
    assert!(matches!(Design::new(&problem(), &["c"], state, 1e-4, |x| x[0]).run(), Err(Error::Dimension { .. })));
    // A cost without a finite slope.
    let cost = |x: &[num_dual::HyperDual64]| (x[0] - x[0]).recip();
    use num_dual::DualNum;
    let moment = Demand::Moment { powers: vec![0, 2] };
    assert!(matches!(Design::new(&problem(), &["c"], moment, 0.5, cost).run(), Err(Error::OutOfRange { .. })));
}

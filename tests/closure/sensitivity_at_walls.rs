//! Derivatives of densities by parameters next to walls, those of the walls among them: against closed forms, a grid and differences.

use crate::common::duffing;
use crate::common::elastic::Elastic;
use expoly::models::Solved;
use expoly::{Closure, Crossing, Density, Error, Grid, Problem, Result, Sensitivity, Wall};

/// Exact densities above an elastic wall, below one and between two, which move: ∂ ln p/∂θ in the mean under p, the derivatives of
/// moments, of a tail and of the impact rate, to 1e-8 relative at every order. Measured are 1e-10.
#[test]
fn derivatives_of_exact_densities_next_to_elastic_walls_are_exact() -> Result<()> {
    let parameters = [0.2, 1.0, 0.3, 0.2];
    for walls in [[Some(-0.5), None], [Some(0.5), None], [None, Some(0.8)], [Some(-0.6), Some(0.9)]] {
        let elastic = Elastic { parameters, walls };
        let problem = elastic.problem()?;
        for order in [4, 6, 8] {
            let density = Closure::new(order).solve(&problem)?;
            for by in density.sensitivities(&Elastic::names(&problem))? {
                let name = by.parameter();
                let along = |x: &[f64]| elastic.slope(name, x);
                let mean = density.expectation(&along)?.value;
                // A wall that moves takes away what is at it.
                let edge = match name {
                    "x.above.offset" => density.marginal(0, walls[0].unwrap())?.value,
                    "x.below.offset" => -density.marginal(0, walls[1].unwrap())?.value,
                    _ => 0.0,
                };
                let apart = |x: &[f64]| (by.relative(x).unwrap() - (along(x) - mean + edge)).abs();
                let off = density.expectation(&apart)?.value / by.size();
                let moments = [[1, 0], [2, 0], [0, 2]].map(|powers| by.moment(&powers).unwrap().value);
                let [tail, impacts] = [by.exceedance(0, 0.4)?.value, by.impact_rate().unwrap().value];
                let found = [moments[0], moments[1], moments[2], tail, impacts];
                let truths = elastic.derivatives(name);
                let errors: [f64; 5] = std::array::from_fn(|k| (found[k] - truths[k]).abs() / truths[k].abs().max(1.0));
                println!("{walls:?} n = {order} {name}: {off:.1e} off, {errors:?}");
                assert!(off < 1e-8, "{walls:?} {order} {name}: {off:e}");
                assert!(errors.iter().all(|error| *error < 1e-8), "{walls:?} {order} {name}: {found:?} and {truths:?}");
                // A mean with differences for the slope: their own error, 1e-9.
                let mean = by.expectation(&|x| x[0] * x[0]).value;
                assert!((mean - moments[1]).abs() < 1e-8 * moments[1].abs().max(1.0), "{mean}");
            }
        }
    }
    Ok(())
}

/// Between two lossy walls that move with one parameter, under noise that depends on the displacement.
const BETWEEN: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.3
g = 0.15
gap = 0.6
r = 0.8
[drift]
x = "v"
v = "-c*v - 0.2*x^2*v - x - 0.3*x^3"
[noise.w]
v = "0.6 + g*x"
[[wall]]
state = "x"
above = "-gap"
restitution = "r"
[[wall]]
state = "x"
below = "2*gap"
restitution = "r^2"
"#;

/// Next to lossy walls, by the equations' parameters and the walls', against a grid: moments to 5e-4 relative, measured are up to
/// 3e-4 where they are a hundredth of the others and 2e-5 otherwise; impact rates, and ∫ |p̃′ − p′|, within twice their estimated
/// errors.
#[test]
fn derivatives_next_to_lossy_walls_have_their_estimated_errors() -> Result<()> {
    let one = duffing().problem()?.with_wall(Wall::above(-0.5, 0.8)?)?;
    for problem in [one, Problem::from_toml(BETWEEN)?] {
        let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
        let truths = Grid::new().accuracy(1e-5).solve(&problem)?.sensitivities(&names)?;
        let density = Closure::new(6).solve(&problem)?;
        for (by, truth) in density.sensitivities(&names)?.iter().zip(&truths) {
            let name = truth.parameter();
            for powers in [[1, 0], [2, 0], [0, 2]] {
                let (found, truth) = (by.moment(&powers)?, truth.moment(&powers)?.value);
                println!("{name} {powers:?}: {found} and {truth:.8}");
                assert!((found.value / truth - 1.0).abs() < 5e-4, "{name} {powers:?}: {found} and {truth}");
            }
            let (found, impacts) = (by.impact_rate().unwrap(), truth.impact_rate().unwrap());
            println!("   impact rate {found} and {impacts}");
            let off = (found.value - impacts.value).abs();
            assert!(off < 2.0 * (found.error + impacts.error) && off < 4e-3, "{name}: {found} and {impacts}");
            let relative = |x: &[f64]| truth.pdf(x).unwrap().value / density.pdf(x).unwrap().value;
            let apart = density.expectation(&|x| (by.relative(x).unwrap() - relative(x)).abs())?.value;
            let estimate = by.l1_estimate() + truth.l1_estimate();
            println!("   {apart:.1e} off of {:.2}, estimated {estimate:.1e}", by.size());
            assert!(
                apart < 2.0 * estimate && estimate < 0.15 * by.size().max(0.3),
                "{name}: {apart:e} and {estimate:e}"
            );
        }
    }
    Ok(())
}

/// The derivatives of a closure's density are those of its neighbours' differences of fourth order: h⁴ of a fifth derivative, and
/// what the functions of Q do as they move. Moments to 3e-5, measured are up to 1e-5; the impact rate to 1.5e-2, measured are 5e-3.
#[test]
fn the_tangent_touches_the_densities_of_walls_nearby() -> Result<()> {
    let problem = duffing().problem()?.with_wall(Wall::below(0.5, 0.8)?)?;
    let names = ["x.below.offset", "x.below.restitution"];
    let density = Closure::new(6).solve(&problem)?;
    for ((by, name), value) in density.sensitivities(&names)?.iter().zip(names).zip([0.5, 0.8]) {
        let h = 0.01;
        let around = [-2.0, -1.0, 1.0, 2.0].map(|k| {
            let density = Closure::new(6).solve(&problem.with_parameter(name, value + k * h).unwrap()).unwrap();
            let moment = |powers: [u32; 2]| density.moment(&powers).unwrap().value;
            [moment([1, 0]), moment([2, 0]), moment([0, 2]), density.impact_rate().unwrap().value]
        });
        let moment = |powers: [u32; 2]| by.moment(&powers).unwrap().value;
        let found = [moment([1, 0]), moment([2, 0]), moment([0, 2]), by.impact_rate().unwrap().value];
        for (k, found) in found.into_iter().enumerate() {
            let truth = (8.0 * (around[2][k] - around[1][k]) - (around[3][k] - around[0][k])) / (12.0 * h);
            println!("{name} {k}: {found:.7} and {truth:.7}");
            let tolerance = if k == 3 { 1.5e-2 } else { 3e-5 };
            assert!((found / truth - 1.0).abs() < tolerance, "{name} {k}: {found} and {truth}");
        }
    }
    Ok(())
}

/// By r at an elastic wall, where ∂ ln p/∂r is singular and no exponential polynomial: the power balance c E v² + ½(1 − r²) ∫|v|³ p dv
/// = D gives dE v²/dr = ∫|v|³ p dv/c, which the moment equations hold exactly.
#[test]
fn an_elastic_wall_that_begins_to_take_energy() -> Result<()> {
    let problem = duffing().problem()?.with_wall(Wall::above(-0.5, 1.0)?)?;
    let density = Closure::new(4).solve(&problem)?;
    let by = density.sensitivity("x.above.restitution")?;
    let truth = density.flux(Crossing::downward(-0.5), 3)?.value / 0.2;
    let found = by.moment(&[0, 2])?;
    println!("{found} and {truth}");
    assert!((found.value / truth - 1.0).abs() < 1e-6, "{found} and {truth}");
    // The grid, with layers towards the grazing point. At order 4 the impact rate's is off by 3 %, and says so.
    let truths = Grid::new().accuracy(1e-5).solve(&problem)?.sensitivities(&["x.above.restitution"])?;
    let (found, truth) = (by.moment(&[2, 0])?, truths[0].moment(&[2, 0])?);
    println!("{found} and {truth}");
    assert!((found.value / truth.value - 1.0).abs() < 1e-4, "{found} and {truth}");
    let (found, truth) = (by.impact_rate().unwrap(), truths[0].impact_rate().unwrap());
    println!("{found} and {truth}");
    assert!(
        (found.value - truth.value).abs() < 2.0 * found.error && found.error < 0.1 * truth.value,
        "{found} and {truth}"
    );
    Ok(())
}

/// A text's walls follow its parameters by the chain rule.
#[test]
fn walls_of_a_text_move_with_its_parameters() -> Result<()> {
    let text = r#"
states = ["x", "v"]
[parameters]
D = 0.2
gap = 0.5
[drift]
x = "v"
v = "-0.2*v - x - 0.3*x^3"
[noise.w]
v = "sqrt(2*D)"
[[wall]]
state = "x"
above = "-gap"
restitution = 1
[[wall]]
state = "x"
below = "2*gap"
restitution = 1
"#;
    let density = Closure::new(4).solve(&Problem::from_toml(text)?)?;
    let found = density.sensitivities(&["gap", "x.above.offset", "x.below.offset"])?;
    let [gap, above, below] = [0, 1, 2].map(|k| found[k].moment(&[2, 0]).unwrap().value);
    assert!((gap - (2.0 * below - above)).abs() < 1e-9 * gap.abs(), "{gap}, {above} and {below}");
    assert!(matches!(density.sensitivity("x.above.mass"), Err(Error::NotAName { .. })));
    Ok(())
}

//! Derivatives of the grid's density by parameters, those of walls among them: against closed forms, differences and refusals.

use crate::common::duffing;
use crate::common::elastic::Elastic;
use expoly::models::Solved;
use expoly::{Density, Error, Grid, Problem, Result, Sensitivity, Wall};

/// The derivatives of the answers that the closed form has.
fn answers(by: &dyn Sensitivity) -> Result<[f64; 5]> {
    let impacts = by.impact_rate().map_or(0.0, |rate| rate.value);
    let moments = [[1, 0], [2, 0], [0, 2]].map(|powers| by.moment(&powers).map(|moment| moment.value));
    let [mean, square, velocity] = moments;
    Ok([mean?, square?, velocity?, by.exceedance(0, 0.4)?.value, impacts])
}

/// By all parameters without a wall, above one, below one and between two, which move. The grid's own
/// accuracy is 1e-8.
#[test]
fn derivatives_are_those_of_closed_forms() -> Result<()> {
    let parameters = [0.2, 1.0, 0.3, 0.2];
    for walls in [[None, None], [Some(-0.5), None], [None, Some(0.8)], [Some(-0.6), Some(0.9)]] {
        let elastic = Elastic { parameters, walls };
        let problem = elastic.problem()?;
        let found = Grid::new().accuracy(1e-8).solve(&problem)?.sensitivities(&Elastic::names(&problem))?;
        for by in &found {
            for (found, truth) in answers(by)?.into_iter().zip(elastic.derivatives(by.parameter())) {
                println!("{walls:?} {}: {found:.9} and {truth:.9}", by.parameter());
                assert!((found - truth).abs() < 2e-7 * truth.abs().max(1.0), "{walls:?} {}: {found}", by.parameter());
            }
        }
    }
    Ok(())
}

const TEXT: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.2
gap = 0.5
r = 0.8
[drift]
x = "v"
v = "-c*v - x - 0.3*x^3"
[noise.w]
v = "0.6"
[[wall]]
state = "x"
above = "-gap"
restitution = "r"
[[wall]]
state = "x"
below = "2*gap"
restitution = "r^2"
"#;

/// Next to lossy walls, against differences of grids that have meshes of their own: what is left is h⁴ of a fifth derivative, and the
/// errors of moments, times 16/12h. And the walls of a text follow its parameters, by the chain rule.
#[test]
fn derivatives_are_those_of_differences_next_to_lossy_walls() -> Result<()> {
    let problem = Problem::from_toml(TEXT)?;
    let grid = Grid::new().accuracy(1e-5);
    let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
    let found = grid.solve(&problem)?.sensitivities(&names)?;
    for (by, value) in found.iter().zip(problem.parameters().iter().map(|(_, value)| *value)) {
        // A mean over nodes is that of the moment.
        let (mean, moment) = (by.expectation(&|x| x[0] * x[0]).value, answers(by)?[1]);
        assert!((mean - moment).abs() < 1e-9 * moment.abs().max(1.0), "{mean} and {moment}");
        assert!(by.expectation(&|_| 1.0).value.abs() < 1e-9);
        if !["gap", "x.above.offset", "x.below.restitution"].contains(&by.parameter()) {
            continue;
        }
        let h = 0.01;
        let truths: Vec<[f64; 4]> = [-2.0, -1.0, 1.0, 2.0]
            .map(|k| {
                let moved = problem.with_parameter(by.parameter(), value + k * h).unwrap();
                let density = grid.solve(&moved).unwrap();
                let moment = |powers: [u32; 2]| density.moment(&powers).unwrap().value;
                [moment([1, 0]), moment([2, 0]), moment([0, 2]), density.impact_rate().unwrap().value]
            })
            .into();
        let own = answers(by)?;
        for (k, own) in [own[0], own[1], own[2], own[4]].into_iter().enumerate() {
            let truth = (8.0 * (truths[2][k] - truths[1][k]) - (truths[3][k] - truths[0][k])) / (12.0 * h);
            println!("{} {k}: {own:.7} and {truth:.7}", by.parameter());
            assert!((own - truth).abs() < 1e-4 * truth.abs().max(0.1), "{} {k}: {own} and {truth}", by.parameter());
        }
    }
    // Two walls that move with one parameter, and the restitutions of both.
    let [gap, r, above, first, below, second] =
        [1, 2, 3, 4, 5, 6].map(|k| found[k].moment(&[2, 0]).map_or(f64::NAN, |moment| moment.value));
    assert!((gap - (2.0 * below - above)).abs() < 1e-9, "{gap}");
    assert!((r - (first + 2.0 * 0.8 * second)).abs() < 1e-9, "{r}");
    Ok(())
}

#[test]
fn derivatives_that_the_grid_has_not_are_refused() -> Result<()> {
    let problem = duffing().problem()?.with_wall(Wall::above(-0.5, 1.0)?)?;
    let grid = Grid::new().accuracy(1e-3);
    assert!(matches!(grid.solve(&problem)?.sensitivities(&["nu"]), Err(Error::NotAName { .. })));
    let plain = Problem::of(duffing())?.with_wall(Wall::above(-0.5, 0.9)?)?;
    let density = grid.solve(&plain)?;
    assert!(matches!(density.sensitivities(&["c"]), Err(Error::NotAName { .. })));
    // Of a wall nothing else needs to be known.
    let found = density.sensitivities(&["x.above.restitution"])?;
    let by = &found[0];
    assert_eq!((by.parameter(), by.density().impact_rate()), ("x.above.restitution", density.impact_rate()));
    assert!(matches!(by.moment(&[2]), Err(Error::Dimension { .. })));
    assert!(matches!(by.moment(&[201, 0]), Err(Error::OutOfRange { .. })));
    assert!(matches!(by.relative(&[0.0]), Err(Error::Dimension { .. })));
    assert!(matches!(by.exceedance(2, 0.0), Err(Error::Dimension { .. })));
    assert!(matches!(by.upcrossing_rate(f64::NAN), Err(Error::OutOfRange { .. })));
    assert!(by.size() > 0.0 && by.l1_estimate() < by.size() && by.relative(&[-0.6, 0.0])?.is_nan());
    let free = grid.solve(&duffing().problem()?)?;
    assert!(free.sensitivities(&["D"])?[0].impact_rate().is_none());
    assert!(free.sensitivities(&[])?.is_empty());
    Ok(())
}

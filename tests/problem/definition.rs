//! The parts of a problem, and the errors of systems that are no problem.

use crate::common::*;
use expoly::models::Solved;
use expoly::{Closure, Density, Drift, Error, Interpretation, Problem, Result, Scalar, System, Wall};

/// Two masses whose velocities come last; the noise of the second is parametric.
struct Coupled {
    names: &'static [&'static str],
}

impl Drift<4, 2> for Coupled {
    fn drift<S: Scalar>(&self, [x, y, u, v]: [S; 4]) -> [S; 4] {
        let spring = (x - y) * 0.5;
        [u, v, -(u * 0.2) - x - spring, -(v * 0.3) - y - y.powi(3) + spring]
    }
    fn noise<S: Scalar>(&self, [_, y, _, _]: [S; 4]) -> [[S; 2]; 4] {
        let zero = S::from(0.0);
        [[zero, zero], [zero, zero], [S::from(0.6), zero], [zero, y * 0.1]]
    }
    fn interpretation(&self) -> Interpretation {
        Interpretation::Stratonovich
    }
    fn names(&self) -> Vec<String> {
        self.names.iter().map(ToString::to_string).collect()
    }
}

#[test]
fn a_problem_says_what_it_is_made_of() -> Result<()> {
    let problem = Problem::of(Coupled { names: &["x", "y", "u", "v"] })?;
    assert_eq!((problem.dimension(), problem.states().join(" ")), (4, String::from("x y u v")));
    assert_eq!((problem.state("u")?, problem.state("v")?), (2, 3));
    assert!(matches!(problem.state("w"), Err(Error::NotAName { name, .. }) if name == "w"));
    assert!(problem.parameters().is_empty());
    assert_eq!(problem.interpretation(), Interpretation::Stratonovich);
    assert_eq!(problem.displacements(), [(0, 2), (1, 3)]);
    assert_eq!([0, 1, 2, 3, 4].map(|state| problem.velocity_of(state)), [Some(2), Some(3), None, None, None]);
    assert_eq!(problem.drift()[2].text(problem.states()).to_string(), "- 1.5 x + 0.5 y - 0.2 u");
    // What each Wiener process drives.
    let driven =
        |k: usize| problem.noise().iter().map(|row| row[k].text(problem.states()).to_string()).collect::<Vec<_>>();
    assert_eq!(
        (driven(0), driven(1)),
        (["0", "0", "0.6", "0"].map(str::to_owned).into(), ["0", "0", "0", "0.1 y"].map(str::to_owned).into())
    );
    assert_eq!((problem.operator().dimension(), problem.walls().len()), (4, 0));
    // The usual names, where none are given.
    assert_eq!(Problem::of(Coupled { names: &[] })?.states(), ["x1", "x2", "x3", "x4"]);
    assert_eq!(crate::common::problem(duffing()).states(), ["x", "v"]);
    assert_eq!(crate::common::problem(OrnsteinUhlenbeck).states(), ["x1"]);
    assert_eq!(chain_of_three().problem()?.states(), ["x1", "v1", "x2", "v2", "x3", "v3"]);
    let parameters = duffing().problem()?.parameters().to_vec();
    assert_eq!(parameters, [("c", 0.2), ("k", 1.0), ("mu", 0.3), ("D", 0.2)].map(|(name, c)| (name.to_owned(), c)));
    // The same statement for every model: names for all states, finite parameters.
    for (name, problem) in every_model() {
        assert_eq!(problem.states().len(), problem.dimension(), "{name}");
        assert!(!problem.parameters().is_empty() && problem.parameters().iter().all(|(_, c)| c.is_finite()), "{name}");
    }
    Ok(())
}

#[test]
fn names_that_do_not_fit_the_states_are_refused() {
    let refused = |names: &'static [&'static str]| Problem::of(Coupled { names }).unwrap_err();
    assert!(matches!(refused(&["x", "y"]), Error::Dimension { expected: 4, found: 2, .. }));
    for (names, bad) in [(&["x", "y", "x", "v"], "x"), (&["x", "", "u", "v"], ""), (&["x", "y", "u", "v 1"], "v 1")] {
        assert!(matches!(refused(names), Error::NotAName { name, .. } if name == bad), "{names:?}");
    }
}

#[test]
fn walls_need_a_displacement_and_room() -> Result<()> {
    let problem = Problem::of(Coupled { names: &["x", "y", "u", "v"] })?;
    let with = |walls: &[Wall]| walls.iter().try_fold(problem.clone(), |problem, wall| problem.with_wall(*wall));
    // Each displacement may have one wall on each side.
    let (low, high) = (Wall::above(-0.5, 0.9)?, Wall::below(0.5, 0.8)?);
    let all = with(&[low, high.on(1), low.on(1), high])?;
    assert_eq!(all.walls(), [low, high.on(1), low.on(1), high]);
    assert_eq!((high.on(1).state(), high.is_above(), low.is_above()), (1, false, true));
    assert_eq!((high.offset(), high.restitution()), (0.5, 0.8));
    assert!(all.without_walls().walls().is_empty() && problem.walls().is_empty());
    for state in [2, 3, 4, usize::MAX] {
        assert_eq!(with(&[low.on(state)]).unwrap_err(), Error::NotADisplacement { state });
    }
    for (walls, value) in [
        (vec![low, Wall::above(-0.7, 1.0)?], -0.7),
        (vec![high, Wall::below(0.7, 1.0)?], 0.7),
        (vec![low, Wall::below(-0.6, 1.0)?], -0.6),
        (vec![high, Wall::above(0.6, 1.0)?], 0.6),
        (vec![low, Wall::below(-0.5, 1.0)?], -0.5),
    ] {
        let error = with(&walls).unwrap_err();
        assert!(
            matches!(error, Error::OutOfRange { name: "offset of the wall", value: v, .. } if v == value),
            "{error}"
        );
    }
    // The same two walls on different states have nothing to do with each other.
    assert!(with(&[low, low.on(1)]).is_ok());
    Ok(())
}

/// Walls between two bodies: their masses, the same wall written the other way round, and walls that together leave no room.
#[test]
fn two_bodies_hit_each_other() -> Result<()> {
    let problem = Problem::of(Coupled { names: &["x", "y", "u", "v"] })?;
    let with = |walls: &[Wall]| walls.iter().try_fold(problem.clone(), |problem, wall| problem.with_wall(*wall));
    let low = Wall::above(-0.5, 0.9)?.between([0, 1], [2.0, 1.0])?;
    assert_eq!((low.state(), low.other(), low.masses()), (0, Some(1), Some([2.0, 1.0])));
    assert!((low.mass() - 2.0 / 3.0).abs() < 1e-15 && low.on(1).other().is_none());
    for masses in [[0.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY], [1e-300, 1e300]] {
        let refused = Wall::above(0.0, 1.0)?.between([0, 1], masses);
        assert!(matches!(refused, Err(Error::OutOfRange { name: "mass of a body", .. })), "{masses:?}: {refused:?}");
    }
    let refused = |walls: &[Wall]| match with(walls).unwrap_err() {
        Error::OutOfRange { name, value, .. } => (name, value),
        error => panic!("{error}"),
    };
    assert_eq!(refused(&[Wall::above(0.0, 1.0)?.between([1, 1], [1.0, 1.0])?]), ("body", 1.0));
    assert_eq!(with(&[low.between([0, 3], [1.0, 1.0])?]).unwrap_err(), Error::NotADisplacement { state: 3 });
    // y₁ − y₂ ≥ −0.5 is y₂ − y₁ ≤ 0.5.
    let turned = Wall::below(0.7, 1.0)?.between([1, 0], [1.0, 1.0])?;
    assert_eq!(refused(&[low, turned]), ("offset of the wall", 0.7));
    assert!(with(&[low, Wall::above(-0.7, 1.0)?.between([1, 0], [1.0, 1.0])?]).is_ok());
    // y₁ ≥ 0, y₂ ≤ −1 and y₁ − y₂ ≤ 1 leave nothing but one point, and a little more leaves room.
    let single = [Wall::above(0.0, 1.0)?, Wall::below(-1.0, 1.0)?.on(1)];
    let near = |gap: f64| Wall::below(gap, 1.0)?.between([0, 1], [1.0, 1.0]);
    assert_eq!(refused(&[single[0], single[1], near(1.0)?]), ("offset of the wall", 1.0));
    let tight = with(&[single[0], single[1], near(1.3)?])?;
    // Trajectories start in that room and stay in it.
    for x in &expoly::Simulation::new().trajectories(32).samples(320).states(&tight)? {
        assert!(x[0] >= 0.0 && x[1] <= -1.0 && x[0] - x[1] <= 1.3 + 1e-15, "{x:?}");
    }
    Ok(())
}

/// A system whose drift and noise have the stated length or another one.
struct Uneven {
    drift: usize,
    rows: usize,
    columns: usize,
}

impl System for Uneven {
    fn dimension(&self) -> usize {
        3
    }
    fn processes(&self) -> usize {
        2
    }
    fn drift<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        (0..self.drift).map(|i| -x[i % 3]).collect()
    }
    fn noise<S: Scalar>(&self, _: &[S]) -> Vec<Vec<S>> {
        vec![vec![S::from(1.0); self.columns]; self.rows]
    }
}

#[test]
fn a_system_of_any_size_is_as_long_as_it_says() {
    let sound = Uneven { drift: 3, rows: 3, columns: 2 };
    let problem = Problem::of(sound).unwrap();
    assert_eq!((problem.dimension(), problem.noise()[0].len(), problem.states().len()), (3, 2, 3));
    for (drift, rows, columns, wrong) in
        [(2, 3, 2, 2), (4, 3, 2, 4), (3, 2, 2, 2), (3, 4, 2, 4), (3, 3, 1, 1), (3, 3, 3, 3)]
    {
        let error = Problem::of(Uneven { drift, rows, columns }).unwrap_err();
        assert!(matches!(error, Error::Dimension { found, .. } if found == wrong), "{error}");
    }
}

/// Problems of one, two, three and four states, some with a wall, in one list, on other threads, by one method.
#[test]
fn problems_of_several_dimensions_are_solved_in_a_loop() -> Result<()> {
    struct Filtered;
    impl Drift<3, 1> for Filtered {
        fn drift<S: Scalar>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
            [v, -v - x + z, -z]
        }
        fn noise<S: Scalar>(&self, _: [S; 3]) -> [[S; 1]; 3] {
            [[S::from(0.0)], [S::from(0.0)], [S::from(2.0_f64.sqrt())]]
        }
    }
    // E x₁² of each: closed forms, and for the wall the reference table's Var y + (E y)².
    let problems: Vec<(&str, Problem, f64)> = vec![
        ("Ornstein-Uhlenbeck", Problem::of(OrnsteinUhlenbeck)?, 1.0),
        ("Duffing", Problem::of(duffing())?, 0.661_714_969_204),
        ("elastic wall", duffing_above(0.0, 1.0), 0.661_714_969_204),
        ("filtered", Problem::of(Filtered)?, 2.0 / 3.0),
        ("chain of 2", chain_of_two().problem()?, chain_of_two().exact()?.moment(&[2, 0, 0, 0])?.value),
    ];
    let solve = |(name, problem, truth): &(&'static str, Problem, f64)| -> Result<()> {
        let density = closed(name, problem, 4, 0);
        let square: Vec<u32> = (0..problem.dimension()).map(|i| if i == 0 { 2 } else { 0 }).collect();
        let moment = density.moment(&square)?;
        assert_eq!(
            (density.dimension(), density.impact_rate().is_some()),
            (problem.dimension(), !problem.walls().is_empty())
        );
        assert!((moment.value / truth - 1.0).abs() < 1e-2, "{problem:?}: {moment} instead of {truth}");
        Ok(())
    };
    problems.iter().try_for_each(solve)?;
    let (_, sent, truth) = problems[1].clone();
    std::thread::spawn(move || solve_alone(&sent, truth)).join().unwrap()
}

fn solve_alone(problem: &Problem, truth: f64) -> Result<()> {
    let found = Closure::classical(4).solve(problem)?.density()?.moment(&[2, 0])?;
    assert!((found.value - truth).abs() < 1e-10);
    Ok(())
}

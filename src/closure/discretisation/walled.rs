//! The discretisation of an oscillator next to a wall, or between two.

use super::likelihood::likeliest;
use super::nodes::Nodes;
use super::trust_domain::TrustDomain;
use crate::closure::density::exponent::known_values;
use crate::closure::discretisation::{Discretisation, WallPassage, locals};
use crate::closure::pilot::Pilot;
use crate::closure::space::nested_spaces::{SpaceFamily, Walled};
use crate::closure::{FULL_DROP, LOW_DEGREE, WIDENING};
use crate::functions::{Corner, Functions, Polynomials};
use crate::numerics::Rule;
use crate::problem::{Problem, Symmetry};
use crate::states::States;
use crate::walls::Wall;

/// Next to walls in two states the answer is defined where the reference is above e^−21 = 1e-9 of its highest value, which next
/// to a grazing point is far above the rest.
const WALLED_KEPT: f64 = 21.0;
/// Panels from a wall on, in s with the distance u = u_max s³, since the density varies with ∛u: u/u_max at the end of each,
/// and its nodes.
const CUBED: [(f64, usize); 5] = [(1e-5, 6), (1e-4, 7), (1e-3, 7), (0.006, 7), (0.03, 7)];
/// Panels in the distance u from a wall, beyond those that are graded by its cube root: u/u_max at the end of each, and its
/// nodes.
const PLAIN: [(f64, usize); 4] = [(0.12, 8), (0.35, 10), (0.65, 10), (1.0, 10)];
/// Panels in the speed on either side of 0, next to walls: the speed at the end of each, relative to the largest, and its
/// nodes.
const SPEEDS: [(f64, usize); 6] = [(0.006, 7), (0.03, 7), (0.12, 7), (0.3, 8), (0.6, 9), (1.0, 9)];
/// Nodes in each panel of speeds on a wall itself, for its impacts. None of nine closures of orders 4 to 8 depends on it.
const ON_WALL: usize = 16;

/// The discretisation of an oscillator whose displacement (state 0, its velocity state 1) meets a wall below, above, or both.
/// `None` if the pilot's states cannot be fitted.
pub(in crate::closure) fn walled(problem: &Problem, pilot: &Pilot, walls: [Option<Wall>; 2]) -> Option<Discretisation> {
    let offsets = walls.map(|wall| wall.map(|wall| wall.offset()));
    let pilot = pilot.between(offsets);
    if pilot.states.is_empty() {
        return None;
    }
    let domain = hull(&pilot, offsets);
    let bounds = domain.bounds();
    let speed = bounds[1][1].abs().max(bounds[1][0].abs());
    let reach = [bounds[0][1] - bounds[0][0], speed];
    let corners = |inflation: f64| -> Vec<Corner> {
        let corner = |wall: &Wall| Corner::new(*wall, vec![1], inflation * problem.intensity_at_rest(wall), reach);
        walls.iter().flatten().map(corner).collect()
    };

    let rules = rules(&domain);
    let nodes = Nodes::tensor(&domain, rules.clone());
    let (centre, half_width) = domain.box_around();
    let exponents = (1..=LOW_DEGREE).flat_map(|n| (0..=n).map(move |j| vec![n - j, j])).collect();
    let polynomials = Functions::from(Polynomials::new(centre.clone(), half_width.clone(), exponents));
    let mut guess = likeliest(polynomials, corners(pilot.inflation), &nodes, &pilot.states, pilot.inflation)?;
    // The singular part scales with the intensity by its argument, and is not multiplied.
    guess.known = corners(1.0);

    let domain = domain.above(|points| guess.values(points), FULL_DROP);
    let impacts = |wall: &Wall| impacts(wall, speed).collect::<Vec<_>>();
    let passages = walls.iter().flatten().flat_map(impacts);
    let passages = passages.filter(|passage| domain.contains(&passage.before) && domain.contains(&passage.after));
    let passages = passages.collect();
    let nodes = nodes.within(&domain);
    let (locals, fixed) = (locals(problem, &nodes.points), known_values(&guess.known, &nodes.points));
    let family = SpaceFamily::Walled(Walled { corners: corners(1.0), centre, half_width });
    Some(Discretisation {
        family,
        domain,
        nodes,
        locals,
        lines: rules,
        passages,
        impulses: Vec::new(),
        fixed,
        guess,
        drop: WALLED_KEPT,
    })
}

/// The hull of the states. About a single wall it is star-shaped about the wall's grazing point, and what lies behind the
/// wall is the mirror image, so that directions along the wall have neighbours on both sides.
fn hull(pilot: &Pilot, offsets: [Option<f64>; 2]) -> TrustDomain {
    let symmetry = Symmetry::none(2);
    match offsets {
        [Some(low), Some(high)] => TrustDomain::new(pilot, &symmetry, vec![(low + high) / 2.0, 0.0], offsets, WIDENING),
        [wall, other] => {
            let wall = wall.or(other).unwrap_or(0.0);
            let mut states = States::new(2);
            for x in &pilot.states {
                states.push(x);
                states.push(&[2.0 * wall - x[0], x[1]]);
            }
            let pilot = Pilot { states, ..pilot.clone() };
            TrustDomain::new(&pilot, &symmetry, vec![wall, 0.0], offsets, WIDENING)
        }
    }
}

/// The rules along both states of a domain, graded towards its walls.
pub(in crate::closure) fn rules(domain: &TrustDomain) -> Vec<Rule> {
    let bounds = domain.bounds();
    let speed = bounds[1][1].abs().max(bounds[1][0].abs());
    vec![across(bounds[0], domain.limits().map(|limit| Some(limit).filter(|limit| limit.is_finite()))), speeds(speed)]
}

/// The rule across the displacement, graded towards each wall.
fn across([low, high]: [f64; 2], offsets: [Option<f64>; 2]) -> Rule {
    // From a wall at 0 to 1.
    let cubed = panels(0.0, &CUBED, f64::cbrt);
    let cubed = cubed.into_iter().map(|(s, w)| (s.powi(3), 3.0 * s * s * w));
    let end = CUBED.last().map_or(0.0, |(end, _)| *end);
    let graded: Vec<(f64, f64)> = cubed.chain(panels(end, &PLAIN, |u| u)).collect();
    let from = |wall: f64, length: f64| graded.iter().map(move |(t, w)| (wall + length * t, length.abs() * w));
    let width = high - low;
    let (nodes, weights) = match offsets {
        [Some(_), Some(_)] => from(low, width / 2.0).chain(from(high, -width / 2.0)).unzip(),
        [None, Some(_)] => from(high, -width).unzip(),
        _ => from(low, width).unzip(),
    };
    Rule { nodes, weights }
}

/// The rule across the velocity, graded towards 0 from both sides.
fn speeds(reach: f64) -> Rule {
    let half = panels(0.0, &SPEEDS, |speed| reach * speed);
    let (nodes, weights) = half.iter().flat_map(|&(w, q)| [(w, q), (-w, q)]).unzip();
    Rule { nodes, weights }
}

/// The nodes and weights of Gauss rules on panels that follow each other from `start`, given by their ends and numbers of
/// nodes, in the variable that `place` turns these into.
fn panels(start: f64, ends: &[(f64, usize)], place: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let starts = std::iter::once(start).chain(ends.iter().map(|(end, _)| *end));
    let rules = starts.zip(ends).map(|(start, &(end, count))| Rule::legendre(count).on(place(start), place(end)));
    rules.flat_map(|rule| rule.iter().collect::<Vec<_>>()).collect()
}

/// The impacts at a wall, by their speed.
fn impacts(wall: &Wall, reach: f64) -> impl Iterator<Item = WallPassage> {
    let (b, r) = (wall.offset(), wall.restitution());
    let side = if wall.is_above() { 1.0 } else { -1.0 };
    let ends = SPEEDS.map(|(end, _)| (end, ON_WALL));
    panels(0.0, &ends, |speed| reach * speed).into_iter().map(move |(speed, weight)| WallPassage {
        before: [b, -side * speed],
        after: [b, side * r * speed],
        weight: speed * weight,
        contraction: r * r,
    })
}

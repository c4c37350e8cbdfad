//! The discretisation of an oscillator next to a wall, or between two.

use super::nodes::Nodes;
use super::trust_domain::TrustDomain;
use crate::closure::density::exponent::known_value;
use crate::closure::discretisation::{Discretisation, Passage, likeliest, locals};
use crate::closure::pilot::Pilot;
use crate::closure::space::nested_spaces::{SpaceFamily, Walled};
use crate::closure::space::{Corner, Functions, Polynomials};
use crate::numerics::Rule;
use crate::problem::{Problem, Symmetry, Wall};
use crate::states::States;

/// The hull of the pilot's states is widened by this factor.
const WIDENING: f64 = 1.1;
/// The domain ends where the first guess is e^−32 = 1e-14 of its peak.
const DROP: f64 = 32.0;
/// The answer is defined where the reference is above e^−21 = 1e-9 of its highest value at a node, which next to a grazing
/// point is far above the rest.
const KEPT: f64 = 21.0;
/// The degree of the polynomial that the pilot's states are fitted by, beside the singular part.
const FIT: u32 = 4;

/// Panels in u = u_max s³ next to a wall, where the density varies with ∛u, then in u itself; nodes in each.
const CUBED: [f64; 6] = [0.0, 1e-5, 1e-4, 1e-3, 0.006, 0.03];
const CUBED_NODES: [usize; 5] = [6, 7, 7, 7, 7];
const PLAIN: [f64; 5] = [0.03, 0.12, 0.35, 0.65, 1.0];
const PLAIN_NODES: [usize; 4] = [8, 10, 10, 10];
/// Panels in |w|, on either side of 0.
const SPEEDS: [f64; 7] = [0.0, 0.006, 0.03, 0.12, 0.3, 0.6, 1.0];
const SPEED_NODES: [usize; 6] = [7, 7, 7, 8, 9, 9];
/// Nodes in each of these panels on the wall itself.
const WALL_NODES: usize = 16;

/// The highest order for which a wall's reference is accurate enough.
pub(in crate::closure) const HIGHEST_ORDER: u32 = 10;

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
        let corner = |wall: &Wall| {
            let (mut drift, mut diffusion) = ([0.0; 2], [0.0; 4]);
            problem.point(&[wall.offset(), 0.0], &mut drift, &mut diffusion);
            Corner::new(*wall, inflation * (diffusion[3] / 2.0), reach)
        };
        walls.iter().flatten().map(corner).collect()
    };

    let rules = vec![across(bounds[0], offsets), speeds(speed)];
    let nodes = Nodes::tensor(&domain, rules.clone());
    let (centre, half_width) = domain.box_around();
    let exponents = (1..=FIT).flat_map(|n| (0..=n).map(move |j| vec![n - j, j])).collect();
    let polynomials = Functions::Polynomials(Polynomials::new(centre.clone(), half_width.clone(), exponents));
    let mut guess = likeliest(polynomials, corners(pilot.inflation), &nodes, &pilot.states, pilot.inflation)?;
    // The singular part scales with the intensity by its argument, and is not multiplied.
    guess.known = corners(1.0);

    let domain = domain.above(|x| guess.value(x), DROP);
    let impacts = |wall: &Wall| impacts(wall, speed).collect::<Vec<_>>();
    let passages = walls.iter().flatten().flat_map(impacts);
    let passages = passages.filter(|passage| domain.contains(&passage.before) && domain.contains(&passage.after));
    let passages = passages.collect();
    let nodes = nodes.within(&domain);
    let (locals, fixed) =
        (locals(problem, &nodes), nodes.points.iter().map(|x| known_value(&guess.known, x)).collect());
    let family = SpaceFamily::Walled(Walled { corners: corners(1.0), centre, half_width });
    Some(Discretisation { family, domain, nodes, locals, lines: rules, passages, fixed, guess, drop: KEPT })
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

/// The rule across the displacement, graded towards each wall.
fn across([low, high]: [f64; 2], offsets: [Option<f64>; 2]) -> Rule {
    // From a wall at 0 to 1.
    let cubed = panels(&CUBED.map(f64::cbrt), &CUBED_NODES).into_iter().map(|(s, w)| (s.powi(3), 3.0 * s * s * w));
    let graded: Vec<(f64, f64)> = cubed.chain(panels(&PLAIN, &PLAIN_NODES)).collect();
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
    let half = panels(&SPEEDS.map(|speed| reach * speed), &SPEED_NODES);
    let (nodes, weights) = half.iter().flat_map(|&(w, q)| [(w, q), (-w, q)]).unzip();
    Rule { nodes, weights }
}

/// The nodes and weights of Gauss rules between neighbouring lines.
fn panels(lines: &[f64], counts: &[usize]) -> Vec<(f64, f64)> {
    let rules = lines.windows(2).zip(counts).map(|(ends, &count)| Rule::legendre(count).on(ends[0], ends[1]));
    rules.flat_map(|rule| rule.iter().collect::<Vec<_>>()).collect()
}

/// The impacts at a wall, by their speed.
fn impacts(wall: &Wall, reach: f64) -> impl Iterator<Item = Passage> {
    let (b, r) = (wall.offset(), wall.restitution());
    let side = if wall.is_above() { 1.0 } else { -1.0 };
    panels(&SPEEDS.map(|speed| reach * speed), &[WALL_NODES; 6]).into_iter().map(move |(speed, weight)| Passage {
        before: [b, -side * speed],
        after: [b, side * r * speed],
        weight: speed * weight,
        contraction: r * r,
    })
}

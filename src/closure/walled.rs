//! The setting of an oscillator above a wall, or between two.

use super::exponent::Known;
use super::family::{Family, Ladder};
use super::nodes::Nodes;
use super::pilot::Pilot;
use super::setting::{Passage, Setting, likeliest};
use super::space::{Corner, CornerRecord, Jet, Polynomials, Space, WallFunctions, WallLevel};
use super::symmetry::Symmetry;
use super::trust_domain::TrustDomain;
use crate::quadrature::Rule;
use crate::{Barrier, FokkerPlanck};
use std::sync::Arc;

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

/// The level that the weight is sought in, and that of the reference with the next lower one.
const WEIGHT: WallLevel = WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7 };
const LOWER: WallLevel = WallLevel { degree: 10, kinks: 5, depth: 4, angular: 9 };
const ALL: WallLevel = WallLevel { degree: 12, kinks: 5, depth: 4, angular: 9 };

/// The highest order that a wall's reference can judge.
pub(super) const HIGHEST_ORDER: u32 = 10;

/// The functions of an order: polynomials to that degree, and more kinks and angular functions the higher it is.
fn level(order: u32) -> WallLevel {
    let (kinks, angular) = match order {
        0..=1 => (0, 1),
        2..=3 => (2, 3),
        4..=5 => (3, 5),
        6..=7 => (3, 7),
        8..=9 => (5, 7),
        _ => (5, 9),
    };
    WallLevel { degree: order, kinks, depth: if order < 9 { 3 } else { 4 }, angular }
}

/// The singular parts of ln p at the walls.
pub(super) struct Singular {
    pub(super) corners: Vec<Corner>,
}

impl Known<2> for Singular {
    fn jet(&self, x: &[f64; 2]) -> Jet<2> {
        let mut sum = Jet::ZERO;
        self.corners.iter().for_each(|corner| sum.add(1.0, &corner.singular_part(*x)));
        sum
    }

    fn corners(&self) -> Vec<CornerRecord> {
        self.corners.iter().map(Corner::record).collect()
    }
}

/// Polynomials with kinks and angular functions.
struct Walled {
    corners: Vec<Corner>,
    centre: [f64; 2],
    half_width: [f64; 2],
}

impl Family<2> for Walled {
    fn ladder(&self, order: u32) -> Ladder<2> {
        // From order 9 on the weight is of the answer's own level.
        let weight = if order <= WEIGHT.degree { WEIGHT } else { level(order) };
        let levels = [level(order), weight, LOWER, ALL];
        let functions =
            |steps: usize| WallFunctions::new(self.corners.clone(), self.centre, self.half_width, &levels[..steps]);
        let [answer, weight, lower, all] = [1, 2, 3, 4].map(|steps| Arc::new(functions(steps)));
        Ladder::new([answer, weight, lower, all])
    }
}

/// The setting of an oscillator whose displacement (state 0, its velocity state 1) meets a floor, a ceiling, or both.
/// `None` if the pilot's states cannot be fitted.
pub(super) fn walled(operator: FokkerPlanck<2>, pilot: &Pilot<2>, walls: [Option<Barrier>; 2]) -> Option<Setting<2>> {
    let offsets = walls.map(|wall| wall.map(|wall| wall.offset()));
    let both = offsets[0].is_some() && offsets[1].is_some();
    let pilot = Pilot { states: within(pilot.states.clone(), offsets), ..pilot.clone() };
    if pilot.states.is_empty() {
        return None;
    }
    let domain = hull(&pilot, offsets, both);
    let bounds = domain.bounds();
    let speed = bounds[1][1].abs().max(bounds[1][0].abs());
    let reach = [bounds[0][1] - bounds[0][0], speed];
    let corners = |inflation: f64| -> Vec<Corner> {
        let corner = |wall: Barrier, make: fn(f64, f64, f64, [f64; 2]) -> Corner| {
            let intensity = operator.diffusion()[1][1].evaluate(&[wall.offset(), 0.0]) / 2.0;
            make(wall.offset(), wall.restitution(), inflation * intensity, reach)
        };
        let floor = walls[0].map(|wall| corner(wall, Corner::floor));
        floor.into_iter().chain(walls[1].map(|wall| corner(wall, Corner::ceiling))).collect()
    };

    let rules = [across(bounds[0], offsets), speeds(speed)];
    let nodes = Nodes::tensor(&domain, &rules);
    let [centre, half_width] = domain.box_around();
    let inflated: Arc<dyn Known<2>> = Arc::new(Singular { corners: corners(pilot.inflation) });
    let exponents = (1..=FIT).flat_map(|n| (0..=n).map(move |j| [n - j, j])).collect();
    let polynomials: Arc<dyn Space<2> + Send> = Arc::new(Polynomials::new(centre, half_width, exponents));
    let mut guess = likeliest(polynomials, Some(inflated), &nodes, &pilot.states, pilot.inflation)?;
    // The singular part scales with the intensity by its argument, and is not multiplied.
    let known: Arc<dyn Known<2>> = Arc::new(Singular { corners: corners(1.0) });
    guess.known = Some(known.clone());

    let domain = domain.above(|x| guess.value(x), DROP);
    let nodes = nodes.filtered(|x| domain.contains(x));
    let passages = walls
        .iter()
        .enumerate()
        .flat_map(|(side, wall)| wall.map(|wall| passages(wall, side == 1, speed)))
        .flatten()
        .filter(|passage| domain.contains(&passage.before) && domain.contains(&passage.after))
        .collect();
    let fixed = nodes.points.iter().map(|x| known.jet(x).value).collect();
    let family = Arc::new(Walled { corners: corners(1.0), centre, half_width });
    let lines = [across(bounds[0], offsets), speeds(speed)];
    Some(Setting {
        operator,
        family,
        smooth: None,
        domain,
        nodes,
        lines,
        passages,
        known: Some(known),
        fixed,
        guess,
        drop: KEPT,
    })
}

/// The states between the walls: a pilot knows the floor alone.
fn within(mut states: Vec<[f64; 2]>, offsets: [Option<f64>; 2]) -> Vec<[f64; 2]> {
    let [low, high] = [offsets[0].unwrap_or(f64::NEG_INFINITY), offsets[1].unwrap_or(f64::INFINITY)];
    states.retain(|x| (low..=high).contains(&x[0]));
    states
}

/// The hull of the states. About a single wall it is star-shaped about the wall's grazing point, and what lies behind the
/// wall is the mirror image, so that directions along the wall have neighbours on both sides.
fn hull(pilot: &Pilot<2>, offsets: [Option<f64>; 2], both: bool) -> TrustDomain<2> {
    let symmetry = Symmetry::none();
    match offsets {
        [Some(low), Some(high)] if both => {
            TrustDomain::new(pilot, &symmetry, [(low + high) / 2.0, 0.0], offsets, WIDENING)
        }
        _ => {
            let wall = offsets[0].or(offsets[1]).unwrap_or(0.0);
            let mirrored = pilot.states.iter().flat_map(|x| [*x, [2.0 * wall - x[0], x[1]]]).collect();
            let pilot = Pilot { states: mirrored, ..pilot.clone() };
            TrustDomain::new(&pilot, &symmetry, [wall, 0.0], offsets, WIDENING)
        }
    }
}

/// The rule across the displacement, graded towards each wall.
pub(super) fn across(bounds: [f64; 2], offsets: [Option<f64>; 2]) -> Rule {
    let width = bounds[1] - bounds[0];
    // From a wall at 0 to 1.
    let graded = || {
        let cubed = CUBED_NODES.iter().enumerate().flat_map(|(k, &count)| {
            let rule = Rule::legendre(count).on(CUBED[k].cbrt(), CUBED[k + 1].cbrt());
            rule.iter().map(|(s, w)| (s.powi(3), 3.0 * s * s * w)).collect::<Vec<_>>()
        });
        let plain = PLAIN_NODES
            .iter()
            .enumerate()
            .flat_map(|(k, &count)| Rule::legendre(count).on(PLAIN[k], PLAIN[k + 1]).iter().collect::<Vec<_>>());
        cubed.chain(plain).collect::<Vec<_>>()
    };
    let pairs: Vec<(f64, f64)> = match offsets {
        [Some(_), Some(_)] => {
            let half = width / 2.0;
            let low = graded().into_iter().map(|(t, w)| (bounds[0] + half * t, half * w));
            let high = graded().into_iter().map(|(t, w)| (bounds[1] - half * t, half * w));
            low.chain(high).collect()
        }
        [None, Some(_)] => graded().into_iter().map(|(t, w)| (bounds[1] - width * t, width * w)).collect(),
        _ => graded().into_iter().map(|(t, w)| (bounds[0] + width * t, width * w)).collect(),
    };
    let (nodes, weights) = pairs.into_iter().unzip();
    Rule { nodes, weights }
}

/// The rule across the velocity, graded towards 0 from both sides.
pub(super) fn speeds(reach: f64) -> Rule {
    let half = speed_panels(reach, |k| SPEED_NODES[k]);
    let pairs = half.iter().flat_map(|&(w, q)| [(w, q), (-w, q)]);
    let (nodes, weights) = pairs.unzip();
    Rule { nodes, weights }
}

fn speed_panels(reach: f64, count: impl Fn(usize) -> usize) -> Vec<(f64, f64)> {
    (0..SPEED_NODES.len())
        .flat_map(|k| {
            let rule = Rule::legendre(count(k)).on(reach * SPEEDS[k], reach * SPEEDS[k + 1]);
            rule.iter().collect::<Vec<_>>()
        })
        .collect()
}

/// The impacts at a wall, by their speed.
fn passages(wall: Barrier, above: bool, reach: f64) -> impl Iterator<Item = Passage<2>> {
    let (b, r) = (wall.offset(), wall.restitution());
    let side = if above { -1.0 } else { 1.0 };
    speed_panels(reach, |_| WALL_NODES).into_iter().map(move |(speed, weight)| Passage {
        before: [b, -side * speed],
        after: [b, side * r * speed],
        weight: speed * weight,
        contraction: r * r,
    })
}

//! All that a closure of one system needs at any order: where the density is, and the points that stand for integrals.

use super::exponent::{Exponent, Known};
use super::family::{Family, Smooth};
use super::likelihood::most_likely;
use super::nodes::Nodes;
use super::pilot::Pilot;
use super::space::Space;
use super::trust_domain::TrustDomain;
use crate::FokkerPlanck;
use crate::quadrature::Rule;
use rayon::prelude::*;
use std::sync::Arc;

/// The degree of the polynomial that the pilot's states are fitted by.
const FIT: u32 = 8;
/// Nodes along each state for that fit, and for everything else, in one state and in two.
const COARSE: usize = 40;
pub(super) const FINE: [usize; 2] = [240, 80];
/// A low order's functions are smoother, and the answer is to come fast.
const LOW_ORDER: u32 = 5;
const LOW_ORDER_NODES: usize = 44;
/// Nodes on either side of 0 along a line.
const LINE: usize = 72;
/// The answer is defined where the reference is above e^−13.8 = 1e-6 of its peak.
const KEPT: f64 = 13.8;
/// The domain ends where the fit is e^−18 = 1.5e-8 of its peak, but not beyond 1.4 times the pilot's reach.
const DROP: f64 = 18.0;
const WIDENING: f64 = 1.4;

/// A jump that trajectories make where they meet a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage<const N: usize> {
    pub(super) before: [f64; N],
    pub(super) after: [f64; N],
    /// The flux through the wall for p = 1 times the quadrature weight.
    pub(super) weight: f64,
    /// r², by which p falls at the jump.
    pub(super) contraction: f64,
}

/// A system with its trust domain, the nodes in it, and the functions on it.
pub(super) struct Setting<const N: usize> {
    pub(super) operator: FokkerPlanck<N>,
    pub(super) family: Arc<dyn Family<N>>,
    /// The same as polynomials, where they are no more than that.
    pub(super) smooth: Option<Smooth<N>>,
    pub(super) domain: TrustDomain<N>,
    pub(super) nodes: Nodes<N>,
    /// Rules along the states, for integrals over a single one; 0 is the edge of a panel.
    pub(super) lines: [Rule; N],
    pub(super) passages: Vec<Passage<N>>,
    /// The part of ln p that no function here can follow, and its values at the nodes.
    pub(super) known: Option<Arc<dyn Known<N>>>,
    pub(super) fixed: Vec<f64>,
    /// The first guess of ln p.
    pub(super) guess: Exponent<N>,
    /// How far below its peak, in ln p, the answer is still defined.
    pub(super) drop: f64,
}

impl<const N: usize> Setting<N> {
    /// The setting of a system on the whole space.
    ///
    /// Its pilot ran at an inflated intensity, under which ln p is roughly divided by the inflation (exactly so for a Gibbs
    /// density): the most likely polynomial, multiplied back, is the first guess, and good in the tails as well. The nodes
    /// serve up to `highest_order`. `None` if the states cannot be fitted.
    pub(super) fn new(
        operator: FokkerPlanck<N>,
        pilot: &Pilot<N>,
        family: Smooth<N>,
        highest_order: u32,
    ) -> Option<Self> {
        let met = TrustDomain::new(pilot, &family.symmetry, family.centre, [None, None], 1.0);
        let coarse = Nodes::gauss(&met, COARSE);
        let [centre, half_width] = met.box_around();
        let space = Smooth { centre, half_width, ..family.clone() }.polynomials(FIT);
        let guess = likeliest(Arc::new(space), None, &coarse, &pilot.states, pilot.inflation)?;
        let domain = met.following(|x| guess.value(x), DROP, WIDENING);
        let along = if N == 2 && highest_order <= LOW_ORDER { LOW_ORDER_NODES } else { FINE[N.min(2) - 1] };
        let nodes = Nodes::gauss(&domain, along);
        let [centre, half_width] = domain.box_around();
        let family = Smooth { centre, half_width, ..family };
        let fixed = vec![0.0; nodes.len()];
        let lines = lines(&domain);
        Some(Setting {
            operator,
            family: Arc::new(family.clone()),
            smooth: Some(family),
            domain,
            nodes,
            lines,
            passages: Vec::new(),
            known: None,
            fixed,
            guess,
            drop: KEPT,
        })
    }
}

/// Rules across a domain along each state, in two panels that meet at 0 or in the middle.
pub(super) fn lines<const N: usize>(domain: &TrustDomain<N>) -> [Rule; N] {
    let rule = Rule::legendre(LINE);
    domain.bounds().map(|[low, high]| {
        let middle = if low < 0.0 && high > 0.0 { 0.0 } else { (low + high) / 2.0 };
        let (left, right) = (rule.on(low, middle), rule.on(middle, high));
        Rule { nodes: [left.nodes, right.nodes].concat(), weights: [left.weights, right.weights].concat() }
    })
}

/// The most likely Q of a space for a pilot's states, times `inflation`; a known part of ln p is kept as it is.
pub(super) fn likeliest<const N: usize>(
    space: Arc<dyn Space<N> + Send>,
    known: Option<Arc<dyn Known<N>>>,
    nodes: &Nodes<N>,
    states: &[[f64; N]],
    inflation: f64,
) -> Option<Exponent<N>> {
    let mean = means(&*space, states);
    let table = rows(&*space, &nodes.points);
    let fixed: Vec<f64> = nodes.points.iter().map(|x| known.as_ref().map_or(0.0, |known| known.jet(x).value)).collect();
    let a = most_likely(table.as_ref(), &fixed, &nodes.weights, &mean)?;
    Some(Exponent { known, space, constant: 0.0, coefficients: a.iter().map(|a| inflation * a).collect() })
}

/// States whose functions' values are added up at a time: sums of sums are the same on any number of threads.
const CHUNK: usize = 512;

/// The means of a space's functions over some states.
fn means<const N: usize>(space: &(impl Space<N> + ?Sized), states: &[[f64; N]]) -> Vec<f64> {
    let sums = |chunk: &[[f64; N]]| {
        let (mut sums, mut values) = (vec![0.0; space.len()], vec![0.0; space.len()]);
        for x in chunk {
            space.values(x, &mut values);
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
        }
        sums
    };
    let parts: Vec<Vec<f64>> = states.par_chunks(CHUNK).map(sums).collect();
    (0..space.len()).map(|k| parts.iter().map(|part| part[k]).sum::<f64>() / states.len() as f64).collect()
}

/// The values of a space's functions at some points: one row a point.
fn rows<const N: usize>(space: &(impl Space<N> + ?Sized), points: &[[f64; N]]) -> faer::Mat<f64> {
    let values = |x: &[f64; N]| {
        let mut values = vec![0.0; space.len()];
        space.values(x, &mut values);
        values
    };
    let rows: Vec<Vec<f64>> = points.par_iter().map(values).collect();
    faer::Mat::from_fn(points.len(), space.len(), |i, k| rows[i][k])
}

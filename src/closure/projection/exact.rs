//! Densities that are exact: the end of the search where the truth itself is an exponential polynomial.

use crate::closure::candidates::{Fitted, Retained, Scoring};
use crate::closure::density::content::{Content, Integrals};
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::nodes::{self, Nodes};
use crate::closure::discretisation::panels::{ResolvedRules, resolved};
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::discretisation::{Discretisation, lines, walled};
use crate::closure::nodal::NodalClosure;
use crate::closure::projection::{distance, project, tempered};
use crate::closure::reference::scaled_mass;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::space::sweep;
use crate::closure::{CONVERGING, EXACT_STEPS, FINE_NODES, FINE_REFERENCE, FULL_DROP, ROUNDING, SOLVED};
use crate::numerics::{Rule, least_norm, weighted_product};
use crate::states::States;
use faer::{Col, Mat};

/// The largest factor by which the domain is widened for an exact density on Gauss nodes.
const EXACT_FOLLOWED: f64 = 3.0;
/// The orders at which known densities are exact: those below the order of the closure are tried.
const LOWER_ORDERS: [u32; 4] = [2, 4, 6, 8];
/// A density whose L¹ distance from the reference exceeds the reference's own error by this factor is not exact. Halved, it
/// misses the exact density of two wells at order 6.
const POLISHABLE: f64 = 30.0;
/// The root mean square of the residual, relative to its parts, above which no exact density is near. None of nine closures of
/// orders 4 to 8 depends on it.
const NEAR: f64 = 0.3;
/// Two rules for an exact density agree to this part of its mass and second moments.
const EXACT: f64 = 1e-10;
/// An exact density has no known integrals where two rules differ by more than this part of its mass and second moments.
const UNKNOWN: f64 = 1e-6;

impl NodalClosure {
    /// The exact density next to the chosen one, or the density of a lower order if that is exact: the equations of the
    /// higher order are then all but singular at it.
    pub(in crate::closure) fn exact_at(
        &self,
        order: u32,
        scoring: &Scoring<'_>,
        kept: &Retained,
        chosen: &Fitted,
    ) -> Option<Exponent> {
        let discretisation = &self.discretisation;
        let solution = |exponent: &Exponent| polished(discretisation, exponent, kept);
        // The distance of an exact density from the reference is the reference's own error.
        let polishable = POLISHABLE * scoring.reference.doubt + FINE_REFERENCE;
        let measure = tempered(&scoring.target, &kept.weights, 1.0);
        let lower = LOWER_ORDERS.iter().filter(|lower| **lower < order).find_map(|&lower| {
            let space = discretisation.family.nested(lower).answer;
            let functions = Orthonormal::new(nodes::values(&space, &kept.points), &measure)?;
            let fit = project((&functions, functions.values.as_ref()), &scoring.fixed, &scoring.target, &measure)?;
            if distance(&fit.logarithm, &scoring.target, &kept.weights) > polishable {
                return None;
            }
            let (constant, coefficients) = (fit.constant, fit.coefficients);
            solution(&Exponent { known: discretisation.known().to_vec(), space, constant, coefficients })
        });
        lower.or_else(|| (chosen.candidate.l1_estimate <= polishable).then(|| solution(&chosen.exponent))?)
    }

    /// An exact density that was found by so many linear systems: it is its own reference, and its trust domain extends as far as it
    /// falls. None where it has no integral there.
    pub(in crate::closure) fn exact(&self, order: u32, mut exponent: Exponent, solved: usize) -> Option<Content> {
        let discretisation = &self.discretisation;
        let found = if self.lattice.is_some() {
            let Discretisation { domain, nodes, lines, .. } = discretisation;
            Integrated { domain: domain.clone(), nodes: nodes.clone(), lines: lines.clone(), apart: 0.0 }
        } else if discretisation.family.is_smooth() {
            Integrated::within(&exponent, &discretisation.domain)?
        } else {
            let domain = followed(&discretisation.domain, &exponent);
            let rules = walled::rules(&domain);
            let nodes = Nodes::tensor(&domain, rules.clone());
            Integrated { domain, nodes, lines: rules, apart: 0.0 }
        };
        let Integrated { domain, nodes, lines, mut apart } = found;
        exponent.constant += log_normaliser(&exponent, &nodes);
        if self.lattice.is_none() {
            apart += domain.mass_beyond(|x| exponent.value(x));
        }
        let unknowns = exponent.coefficients.len();
        let integrals = self.integrals(&exponent, ResolvedRules { rules: nodes.rules, apart }, lines)?;
        let lattice = self.lattice.as_ref().map(|(lattice, _)| lattice.clone());
        let provenance = self.provenance(order, unknowns, solved);
        Some(Content { lattice, provenance, ..Content::exact(exponent, domain, integrals, apart) })
    }
}

/// The content of an exact density in open space that was found without nodes, integrated about the region that a pilot has visited.
pub(in crate::closure) fn exact_about(mut exponent: Exponent, region: &TrustDomain) -> Option<Content> {
    let Integrated { domain, nodes, lines, apart } = Integrated::within(&exponent, region)?;
    exponent.constant += log_normaliser(&exponent, &nodes);
    let error = apart + domain.mass_beyond(|x| exponent.value(x));
    let integrals = Integrals::Panels { rules: nodes.rules, lines, apart: error };
    Some(Content::exact(exponent, domain, integrals, error))
}

/// −ln of the mass of exp(Q) on some nodes.
fn log_normaliser(exponent: &Exponent, nodes: &Nodes) -> f64 {
    let (top, mass) = scaled_mass(&exponent.values(&nodes.points), &nodes.weights);
    -top - mass.ln()
}

/// A domain about a region as far as exp(Q) falls.
fn followed(region: &TrustDomain, exponent: &Exponent) -> TrustDomain {
    let log = |points: &States| exponent.values(points);
    region.following(log, FULL_DROP, EXACT_FOLLOWED)
}

/// Where an exact density is integrated: its domain with nodes, rules along the states, and what two rules differ by.
struct Integrated {
    domain: TrustDomain,
    nodes: Nodes,
    lines: Vec<Rule>,
    apart: f64,
}

impl Integrated {
    /// About the region that a pilot has visited, and wherever else in a larger ellipse exp(Q) is not small. None where no rule of two
    /// agrees with the other.
    fn within(exponent: &Exponent, region: &TrustDomain) -> Option<Self> {
        let own = followed(region, exponent);
        let farthest = EXACT_FOLLOWED * region.reach.iter().copied().fold(0.0, f64::max);
        let ellipse = TrustDomain::whole(region.centre.clone(), region.scale.clone(), farthest);
        let elsewhere = ellipse.above(|points| exponent.values(points), FULL_DROP);
        Self::over(exponent, own.joined(&elsewhere))
    }

    fn over(exponent: &Exponent, domain: TrustDomain) -> Option<Self> {
        let given = Nodes::gauss(&domain, FINE_NODES[domain.centre.len().min(2) - 1]).rules;
        let found = resolved(&domain, |points| exponent.values(points), &given, EXACT);
        let lines = if found.rules == given { lines(&domain) } else { found.rules.clone() };
        let nodes = Nodes::tensor(&domain, found.rules);
        (found.apart <= UNKNOWN).then_some(Integrated { domain, nodes, lines, apart: found.apart })
    }
}

/// Newton's method on ∫ r ψ_k p̃ dx = 0 from an exponent that is close already. Where the order contains the exact density
/// the residual vanishes at every node, and this, which does not hold for most roots, is required; otherwise `None`.
///
/// The residual is pointwise: neither the edge of the domain nor the reference's error stands in the way. The last step begins where
/// the residual counts as zero, so that Q, whose derivatives by parameters follow from it, is right to rounding.
fn polished(discretisation: &Discretisation, exponent: &Exponent, kept: &Retained) -> Option<Exponent> {
    let count = exponent.coefficients.len();
    let mut current = exponent.clone();
    let ends = WallEnds::new(discretisation, exponent);
    let mut last = f64::INFINITY;
    for _ in 0..EXACT_STEPS {
        let log = current.values(&kept.points);
        let measure = tempered(&log, &kept.weights, 1.0);
        let linearised = linearised(discretisation, &current, kept);
        let size = relative_size(&linearised, &measure);
        if size < ROUNDING {
            return Some(current);
        }
        let solved = size < SOLVED;
        // The negation also excludes NaN.
        if !(solved || size < NEAR && size < CONVERGING * last) {
            return None;
        }
        last = size;
        let (basis, mut system) = tested(discretisation, exponent, kept, (&linearised, &measure))?;
        if !ends.points.is_empty() {
            system -= ends.missing(discretisation, &current, (&log, &kept.weights), &basis);
        }
        // Coefficients in units in which every function has the same size under p̃.
        let scale: Vec<f64> = (1..=count).map(|k| basis.triangle.col(k).norm_l2().recip()).collect();
        // Next to an exact solution many functions about a wall do nothing: the least step is taken.
        let matrix = Mat::from_fn(count, count, |k, l| system[(k + 1, l + 1)] * scale[l]);
        let right = Col::from_fn(count, |k| -system[(k + 1, 0)]);
        let step = least_norm(&matrix, &right, SOLVED * matrix.norm_l2())?;
        for k in 0..count {
            current.coefficients[k] += scale[k] * step[k];
        }
        if !current.coefficients.iter().all(|a| a.is_finite()) {
            return None;
        }
        if solved {
            return Some(current);
        }
    }
    None
}

/// The residual at a node, the square of its part that the drift makes, and the drift of its linearisation.
type LinearisedResidual = (f64, f64, Vec<f64>);

fn linearised(discretisation: &Discretisation, current: &Exponent, kept: &Retained) -> Vec<LinearisedResidual> {
    sweep::at_jets(current, &kept.points, |i, gradient, hessian| {
        let local = &discretisation.locals[kept.nodes[i]];
        let mut reversed = vec![0.0; gradient.len()];
        local.reversed(gradient, &mut reversed);
        let along: f64 = local.drift.iter().zip(gradient).map(|(f, slope)| (f * slope).powi(2)).sum();
        (local.residual(gradient, hessian), along, reversed)
    })
}

/// The root mean square of the residual, relative to that of its part.
fn relative_size(linearised: &[LinearisedResidual], measure: &[f64]) -> f64 {
    let [square, parts] = linearised
        .iter()
        .zip(measure)
        .fold([0.0; 2], |[square, parts], ((r, along, _), w)| [square + w * r * r, parts + w * along]);
    (square / parts.max(f64::MIN_POSITIVE)).sqrt()
}

/// The functions of an exponent orthonormal under p̃, and ∫ ψ_k L′φ_l p̃ dx, with the residual itself in the first column.
fn tested(
    discretisation: &Discretisation,
    exponent: &Exponent,
    kept: &Retained,
    (linearised, measure): (&[LinearisedResidual], &[f64]),
) -> Option<(Orthonormal, Mat<f64>)> {
    let (points, count) = (&kept.points, exponent.coefficients.len());
    let [mut values, mut images] = [(); 2].map(|()| Mat::zeros(points.len(), count + 1));
    let local = |i: usize| (&linearised[i].2[..], &discretisation.locals[kept.nodes[i]].diffusion[..]);
    sweep::tabulate_rates(&exponent.space, points, &local, [values.as_mut(), images.as_mut()]);
    images.col_as_slice_mut(0).iter_mut().zip(linearised).for_each(|(image, (r, ..))| *image = *r);
    let basis = Orthonormal::new(values, measure)?;
    let system = weighted_product(basis.values.as_ref(), images.as_ref(), measure);
    Some((basis, system))
}

/// The states before and after each impact, one after the other, with the functions there.
struct WallEnds {
    points: States,
    functions: Mat<f64>,
}

impl WallEnds {
    fn new(discretisation: &Discretisation, exponent: &Exponent) -> Self {
        let mut points = States::new(discretisation.domain.centre.len());
        let passages = discretisation.passages.iter();
        passages.for_each(|passage| [passage.before, passage.after].iter().for_each(|x| points.push(x)));
        let functions = nodes::values(&exponent.space, &points);
        WallEnds { points, functions }
    }

    /// What impacts take out of the equations: the first column is that of the constant function, the mismatch itself.
    fn missing(
        &self,
        discretisation: &Discretisation,
        current: &Exponent,
        (log, weights): (&[f64], &[f64]),
        basis: &Orthonormal,
    ) -> Mat<f64> {
        let (impacts, columns) = (discretisation.passages.len(), self.functions.ncols());
        let (top, mass) = scaled_mass(log, weights);
        let density: Vec<f64> = self.points.iter().map(|x| (current.value(x) - top).exp() / mass).collect();
        let mut tests = Mat::from_fn(impacts, columns, |i, k| self.functions[(2 * i + 1, k)]);
        basis.transform(tests.as_mut());
        let missing = Mat::from_fn(impacts, columns, |i, k| {
            let passage = &discretisation.passages[i];
            let [before, after] = [0, 1].map(|end| density[2 * i + end] * self.functions[(2 * i + end, k)]);
            passage.weight * (passage.contraction * after - before)
        });
        tests.transpose() * missing
    }
}

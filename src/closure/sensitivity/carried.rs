use super::slope::Slope;
use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::space::Jet;
use crate::closure::space::sweep::{self, Differentiable};
use crate::estimate::Estimate;

/// What the derivative of a density p has at fixed states beside ∂q/∂θ in the coordinate in which walls stand still, at a fixed
/// place of which x moves at the rate η: ∂p/∂θ = ∂q/∂θ − ∂_x(R p) with R = η.
///
/// By two parameters, with η of each, s = (∂q/∂θ)/q, κ = ηₖηₗ and ζ = ∂²x/∂θ∂φ, the rate is R = ζ + ηₖsₗ + ηₗsₖ − ∂_x(κ p)/p, and
/// (∂²q/∂θ∂φ)/q has the product sₖsₗ beside ∂² ln q/∂θ∂φ.
#[derive(Clone, Debug, Default)]
pub(super) struct Carried {
    /// η, or ζ, as [0] + [1] x.
    shift: [f64; 2],
    /// By two parameters, what is of each.
    along: Option<[Along; 2]>,
    /// R without its last part at the density's nodes, by p̃ and by the reference; none where nothing moves,
    rates: Vec<[f64; 2]>,
    /// and −∂_x(R p)/p.
    pub(super) at_nodes: Vec<[f64; 2]>,
}

/// A first derivative as a part of a second one: s and η.
#[derive(Clone, Debug)]
pub(super) struct Along {
    pub(super) slope: Slope,
    pub(super) shift: [f64; 2],
}

/// ln p at a point, by its slope and bend in the displacement, with s of both parameters, and their slopes.
struct Local {
    log: [f64; 2],
    s: [f64; 2],
    bend: [f64; 2],
}

impl Carried {
    pub(super) fn new(shift: [f64; 2], density: &ClosureDensity) -> Self {
        Carried { shift, ..Carried::default() }.on_nodes(density, [(); 2].map(|()| [Vec::new(), Vec::new()]))
    }

    /// By two parameters, given s at the nodes by p̃ and by the reference for each.
    pub(super) fn second(shift: [f64; 2], along: [Along; 2], density: &ClosureDensity, s: [[Vec<f64>; 2]; 2]) -> Self {
        Carried { shift, along: Some(along), ..Carried::default() }.on_nodes(density, s)
    }

    fn on_nodes(mut self, density: &ClosureDensity, s: [[Vec<f64>; 2]; 2]) -> Self {
        let shifts = self.along.iter().flatten().map(|along| along.shift).chain([self.shift]);
        if shifts.into_iter().all(|shift| shift == [0.0; 2]) {
            return self;
        }
        let points = &density.nodes;
        let logs = sweep::at_jets(density.exponent(), points, |_, gradient, hessian| [gradient[0], hessian[0]]);
        let bends = self.along.as_ref().map(|along| along.each_ref().map(|a| a.slope.along_displacements(points)));
        let reference = density.content.reference.as_ref().map(|found| found.slopes(points, 0));
        for (i, x) in points.iter().enumerate() {
            let local = |k: usize| {
                let [slope, bend] = logs[i];
                let slope = reference.as_ref().filter(|_| k == 1).map_or(slope, |reference| reference[i]);
                let of = |j: usize| s[j][k].get(i).copied().unwrap_or(0.0);
                let bends = bends.as_ref().map_or([0.0; 2], |bends| [bends[0][i], bends[1][i]]);
                Local { log: [slope, bend], s: [of(0), of(1)], bend: bends }
            };
            let both = [local(0), local(1)];
            self.rates.push(both.each_ref().map(|local| self.rate(x[0], local.s)));
            self.at_nodes.push(both.each_ref().map(|local| self.spread(x[0], local)));
        }
        self
    }

    /// Whether anything moves.
    pub(super) fn moves(&self) -> bool {
        !self.at_nodes.is_empty()
    }

    /// sₖsₗ by two parameters, and else 0.
    pub(super) fn product(&self, x: &[f64]) -> f64 {
        self.along.as_ref().map_or(0.0, |[k, l]| k.slope.value(x) * l.slope.value(x))
    }

    /// −∂_x(R p̃)/p̃ at a state.
    pub(super) fn value(&self, log: &Exponent, x: &[f64]) -> f64 {
        if self.moves() { self.spread(x[0], &self.local(log, x)) } else { 0.0 }
    }

    /// R at a state, by which mass passes over its displacement.
    pub(super) fn through(&self, log: &Exponent, x: &[f64]) -> f64 {
        let local = self.local(log, x);
        let [kappa, slope, _] = self.both(x[0]);
        self.rate(x[0], local.s) - slope - kappa * local.log[0]
    }

    /// What the states that move add to the derivative of a mean of a function, given its first and second derivative in the
    /// displacement: ∫ (R p + ∂_x(κ p)) ∂_x g + κ p ∂_x²g dx.
    pub(super) fn mean(&self, density: &ClosureDensity, slopes: impl Fn(&[f64]) -> [f64; 2]) -> Estimate {
        let all = density.nodes.iter().zip(&density.masses).zip(&self.rates);
        let [own, other] = all.fold([0.0; 2], |sums, ((x, masses), rates)| {
            let ([slope, bend], [kappa, ..]) = (slopes(x), self.both(x[0]));
            [0, 1].map(|k| sums[k] + (rates[k] * slope + kappa * bend) * masses[k])
        });
        Estimate::new(own, own - other)
    }

    fn local(&self, log: &Exponent, x: &[f64]) -> Local {
        let mut jet = Jet::zero(2);
        log.jet(x, &mut jet);
        let [s, bend] = self.along.as_ref().map_or([[0.0; 2]; 2], |along| {
            let of = |of: &dyn Fn(&Slope) -> f64| along.each_ref().map(|along| of(&along.slope));
            [of(&|slope| slope.value(x)), of(&|slope| slope.along_displacement(x))]
        });
        Local { log: [jet.gradient[0], jet.hessian[0]], s, bend }
    }

    /// R without its last part.
    fn rate(&self, x: f64, [s_k, s_l]: [f64; 2]) -> f64 {
        let both = self.along.as_ref().map_or(0.0, |[k, l]| linear(k.shift, x) * s_l + linear(l.shift, x) * s_k);
        linear(self.shift, x) + both
    }

    /// κ and its derivatives.
    fn both(&self, x: f64) -> [f64; 3] {
        self.along.as_ref().map_or([0.0; 3], |[k, l]| {
            let (eta_k, eta_l) = (linear(k.shift, x), linear(l.shift, x));
            [eta_k * eta_l, k.shift[1] * eta_l + l.shift[1] * eta_k, 2.0 * k.shift[1] * l.shift[1]]
        })
    }

    /// −∂_x(R p)/p.
    fn spread(&self, x: f64, local: &Local) -> f64 {
        let [slope, bend] = local.log;
        let mut sum = -self.shift[1] - linear(self.shift, x) * slope;
        if let Some(along) = &self.along {
            for (k, l) in [(0, 1), (1, 0)] {
                let eta = linear(along[k].shift, x);
                sum -= along[k].shift[1] * local.s[l] + eta * (local.bend[l] + local.s[l] * slope);
            }
            let [kappa, first, second] = self.both(x);
            sum += second + 2.0 * first * slope + kappa * (bend + slope * slope);
        }
        sum
    }
}

fn linear(shift: [f64; 2], x: f64) -> f64 {
    shift[0] + shift[1] * x
}

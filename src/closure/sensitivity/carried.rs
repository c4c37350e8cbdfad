use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::space::Jet;
use crate::closure::space::sweep::{self, Differentiable};

/// What ∂ ln p/∂θ has at fixed states beside that in the coordinate that moves with the walls by η: −η′ − η ∂_x ln p.
#[derive(Clone, Debug, Default)]
pub(super) struct Carried {
    /// η = [0] + [1] x.
    shift: [f64; 2],
    /// That part at the density's nodes, of p̃ and of the reference; none where nothing moves.
    pub(super) at_nodes: Vec<[f64; 2]>,
}

impl Carried {
    pub(super) fn new(shift: [f64; 2], density: &ClosureDensity) -> Self {
        if shift == [0.0; 2] {
            return Carried::default();
        }
        let slopes = sweep::at_jets(density.exponent(), &density.nodes, |_, gradient, _| gradient[0]);
        let reference = &density.content.reference;
        let of_reference = reference.as_ref().map_or_else(|| slopes.clone(), |found| found.slopes(&density.nodes, 0));
        let part = |(x, slopes): (&[f64], [f64; 2])| slopes.map(|s| -shift[1] - (shift[0] + shift[1] * x[0]) * s);
        let slopes = slopes.into_iter().zip(of_reference).map(<[f64; 2]>::from);
        Carried { shift, at_nodes: density.nodes.iter().zip(slopes).map(part).collect() }
    }

    /// Whether anything moves.
    pub(super) fn moves(&self) -> bool {
        !self.at_nodes.is_empty()
    }

    /// η.
    pub(super) fn rate(&self, x: f64) -> f64 {
        self.shift[0] + self.shift[1] * x
    }

    /// That part of p̃'s at a state.
    pub(super) fn value(&self, log: &Exponent, x: &[f64]) -> f64 {
        if !self.moves() {
            return 0.0;
        }
        let mut jet = Jet::zero(2);
        log.jet(x, &mut jet);
        -self.shift[1] - self.rate(x[0]) * jet.gradient[0]
    }
}

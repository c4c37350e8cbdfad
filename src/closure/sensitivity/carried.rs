use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::space::Jet;
use crate::closure::space::sweep::{self, Differentiable};

/// What ∂ ln p/∂θ has at fixed states beside that in the coordinates that move with the walls: −Σ_i (η_i′ + η_i ∂_i ln p).
#[derive(Clone, Debug, Default)]
pub(super) struct Carried {
    /// η_i = [0] + [1] x_i of each state that moves.
    shift: Vec<(usize, [f64; 2])>,
    /// That part at the density's nodes, of p̃ and of the reference; none where nothing moves.
    pub(super) at_nodes: Vec<[f64; 2]>,
}

impl Carried {
    pub(super) fn new(shift: [f64; 2], density: &ClosureDensity) -> Self {
        if shift == [0.0; 2] {
            return Carried::default();
        }
        let shift = vec![(0, shift)];
        let slopes = sweep::at_jets(density.exponent(), &density.nodes, |_, gradient, _| gradient[0]);
        let reference = &density.content.reference;
        let of_reference = reference.as_ref().map_or_else(|| slopes.clone(), |found| found.slopes(&density.nodes, 0));
        let slopes = slopes.into_iter().zip(of_reference).map(<[f64; 2]>::from);
        let mut carried = Carried { shift, at_nodes: Vec::new() };
        let part = |(x, slopes): (&[f64], [f64; 2])| slopes.map(|slope| carried.along(x, &[slope]));
        carried.at_nodes = density.nodes.iter().zip(slopes).map(part).collect();
        carried
    }

    /// In any number of states, with no nodes.
    pub(super) fn of_states(shift: &[[f64; 2]]) -> Self {
        let moving = shift.iter().copied().enumerate().filter(|(_, rates)| *rates != [0.0; 2]);
        Carried { shift: moving.collect(), at_nodes: Vec::new() }
    }

    /// Whether anything moves.
    pub(super) fn moves(&self) -> bool {
        !self.shift.is_empty()
    }

    /// η of a state where that is x.
    pub(super) fn rate(&self, state: usize, x: f64) -> f64 {
        let own = self.shift.iter().find(|(moving, _)| *moving == state);
        own.map_or(0.0, |(_, [rate, slope])| rate + slope * x)
    }

    /// Σ η_i ∂_i g by differences of these steps in the states.
    pub(super) fn slope(&self, g: &dyn Fn(&[f64]) -> f64, x: &[f64], steps: &[f64]) -> f64 {
        let along = |(i, [rate, slope]): &(usize, [f64; 2])| {
            let mut at = x.to_vec();
            let [above, below] = [steps[*i], -steps[*i]].map(|step| {
                at[*i] = x[*i] + step;
                g(&at)
            });
            (rate + slope * x[*i]) * (above - below) / (2.0 * steps[*i])
        };
        self.shift.iter().map(along).sum()
    }

    /// That part where ln p has these slopes.
    fn along(&self, x: &[f64], gradient: &[f64]) -> f64 {
        -self.shift.iter().map(|(i, [_, slope])| slope + self.rate(*i, x[*i]) * gradient[*i]).sum::<f64>()
    }

    /// That part of p̃'s at a state.
    pub(super) fn value(&self, log: &Exponent, x: &[f64]) -> f64 {
        if !self.moves() {
            return 0.0;
        }
        let mut jet = Jet::zero(x.len());
        log.jet(x, &mut jet);
        self.along(x, &jet.gradient)
    }
}

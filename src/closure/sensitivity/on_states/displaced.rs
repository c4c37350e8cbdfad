use crate::closure::density::exponent::Exponent;

/// How displacements move with walls, x_i′ = η_i(x_i), so that ∂ ln p/∂θ at fixed states has −Σ_i (η_i′ + η_i ∂_i ln p) beside that in the
/// coordinates in which walls stand still.
#[derive(Clone, Debug)]
pub(in crate::closure::sensitivity) struct Displaced {
    /// η_i = [0] + [1] x_i of each state that moves.
    shift: Vec<(usize, [f64; 2])>,
}

impl Displaced {
    pub(super) fn new(shift: &[[f64; 2]]) -> Self {
        let moving = shift.iter().copied().enumerate().filter(|(_, rates)| *rates != [0.0; 2]);
        Displaced { shift: moving.collect() }
    }

    /// Whether anything moves.
    pub(in crate::closure::sensitivity) fn moves(&self) -> bool {
        !self.shift.is_empty()
    }

    /// η of a state where that is x.
    pub(in crate::closure::sensitivity) fn rate(&self, state: usize, x: f64) -> f64 {
        let own = self.shift.iter().find(|(moving, _)| *moving == state);
        own.map_or(0.0, |(_, [rate, slope])| rate + slope * x)
    }

    /// Σ η_i ∂_i g by differences of these steps in the states.
    pub(in crate::closure::sensitivity) fn slope(&self, g: &dyn Fn(&[f64]) -> f64, x: &[f64], steps: &[f64]) -> f64 {
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

    /// −Σ_i (η_i′ + η_i ∂_i ln p̃) at a state.
    pub(in crate::closure::sensitivity) fn value(&self, log: &Exponent, x: &[f64]) -> f64 {
        if !self.moves() {
            return 0.0;
        }
        let gradient = log.gradient(x);
        -self.shift.iter().map(|(i, [_, slope])| slope + self.rate(*i, x[*i]) * gradient[*i]).sum::<f64>()
    }
}

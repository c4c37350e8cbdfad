use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::estimate::Estimate;

/// What the derivative of a density p has at fixed states beside ∂q/∂θ in the coordinate in which walls stand still, at a fixed
/// place of which x moves at the rate η: ∂p/∂θ = ∂q/∂θ − ∂_x(η p).
#[derive(Clone, Debug, Default)]
pub(super) struct Carried {
    /// η, as [0] + [1] x.
    shift: [f64; 2],
    /// −∂_x(η p)/p at the density's nodes, by p̃ and by the reference; none where nothing moves.
    pub(super) at_nodes: Vec<[f64; 2]>,
}

impl Carried {
    pub(super) fn new(shift: [f64; 2], density: &ClosureDensity) -> Self {
        let mut carried = Carried { shift, at_nodes: Vec::new() };
        if shift == [0.0; 2] {
            return carried;
        }
        let points = &density.nodes;
        let slopes = density.exponent().gradients(points, |_, gradient| gradient[0]);
        let reference = density.content.reference.as_ref().map(|found| found.slopes(points, 0));
        let of_reference = reference.as_ref().unwrap_or(&slopes);
        let all = points.iter().zip(slopes.iter().zip(of_reference));
        carried.at_nodes =
            all.map(|(x, (own, other))| [own, other].map(|slope| carried.spread(x[0], *slope))).collect();
        carried
    }

    /// Whether anything moves.
    pub(super) fn moves(&self) -> bool {
        !self.at_nodes.is_empty()
    }

    /// −∂_x(η p̃)/p̃ at a state.
    pub(super) fn value(&self, log: &Exponent, x: &[f64]) -> f64 {
        if !self.moves() {
            return 0.0;
        }
        self.spread(x[0], log.gradient(x)[0])
    }

    /// η at a displacement.
    pub(super) fn rate(&self, x: f64) -> f64 {
        self.shift[0] + self.shift[1] * x
    }

    /// What the states that move add to the derivative of a mean of a function, given its derivative in the displacement: ∫ η p ∂_x g dx.
    pub(super) fn mean(&self, density: &ClosureDensity, slope: impl Fn(&[f64]) -> f64) -> Estimate {
        let all = density.nodes.iter().zip(&density.masses);
        let [own, other] = all.fold([0.0; 2], |sums, (x, masses)| {
            let moved = self.rate(x[0]) * slope(x);
            [0, 1].map(|k| sums[k] + moved * masses[k])
        });
        Estimate::new(own, own - other)
    }

    /// −∂_x(η p)/p, given the slope of ln p.
    fn spread(&self, x: f64, slope: f64) -> f64 {
        -self.shift[1] - self.rate(x) * slope
    }
}

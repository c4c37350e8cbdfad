//! What of a problem moves with a parameter.

use super::Problem;
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::Polynomial;

/// The derivative of a problem by a parameter θ, or the second one by two.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// ∂f/∂θ and ∂B/∂θ at a fixed state, and what impulses have.
    pub(crate) operator: FokkerPlanck,
    /// ∂b/∂θ and ∂r/∂θ of each wall.
    pub(crate) walls: Vec<[f64; 2]>,
}

/// The same of a displacement (state 0) and its velocity (state 1) in the coordinate ξ in which walls stand still: x moves with
/// them by dx/dθ = η(x) at a fixed ξ, η the rate of a single wall, and linear between two.
///
/// The density q in ξ satisfies the equation with f(x(ξ)) over dx/dξ, and with η′ = dη/dx
///
/// ∂f_x = η ∂_x f_x − η′ f_x, ∂f_v = η ∂_x f_v, ∂B_vv = η ∂_x B_vv.
///
/// At a fixed x the density has the derivative ∂p/∂θ = ∂q/∂θ − ∂_x(η q).
///
/// By two parameters θ and φ, with ζ the second derivative of x, an operator T_η that is the one above, and f″ at a fixed x,
///
/// ∂²f/∂θ∂φ = f″ + T_η(φ) f′_θ + T_η(θ) f′_φ + T_η(θ) T_η(φ) f + T_(ζ − η(θ) η(φ)′) f.
#[derive(Clone, Debug)]
pub(crate) struct PlaneMotion {
    /// ∂f/∂θ and ∂B/∂θ at a fixed ξ.
    pub(crate) operator: FokkerPlanck,
    /// η = [0] + [1] x.
    pub(crate) shift: [f64; 2],
    /// ∂r/∂θ of the walls below the motion and above it.
    pub(crate) restitution: [f64; 2],
}

impl Motion {
    /// The motion of a problem of two states with walls on state 0 alone.
    pub(crate) fn on_plane(&self, problem: &Problem) -> PlaneMotion {
        let (shift, restitution) = self.of_walls(problem);
        let stretched = stretched(problem.operator(), shift);
        let operator = stretched.map_or_else(|| self.operator.clone(), |stretched| self.operator.plus(&stretched));
        PlaneMotion { operator, shift, restitution }
    }

    /// The second motion there, which this is at a fixed state, given the first ones.
    pub(crate) fn second_on_plane(&self, problem: &Problem, first: [&Motion; 2]) -> PlaneMotion {
        let (shift, restitution) = self.of_walls(problem);
        let [one, other] = first.map(|motion| motion.on_plane(problem));
        let bend = [0, 1].map(|k| shift[k] - one.shift[k] * other.shift[1]);
        let parts = [
            stretched(&first[0].operator, other.shift),
            stretched(&other.operator, one.shift),
            stretched(problem.operator(), bend),
        ];
        let operator = parts.iter().flatten().fold(self.operator.clone(), |sum, part| sum.plus(part));
        PlaneMotion { operator, shift, restitution }
    }

    /// η of the coordinate in which walls stand still, and the rates of the restitutions.
    fn of_walls(&self, problem: &Problem) -> ([f64; 2], [f64; 2]) {
        let rates = problem.walls().iter().zip(&self.walls);
        let of_side = |above: bool| rates.clone().find(|(wall, _)| wall.is_above() == above);
        let sides = [of_side(true), of_side(false)];
        let shift = match sides.map(|side| side.map(|(wall, [rate, _])| (wall.offset(), *rate))) {
            [Some((low, first)), Some((high, second))] => {
                let slope = (second - first) / (high - low);
                [first - slope * low, slope]
            }
            [one, other] => [one.or(other).map_or(0.0, |(_, rate)| rate), 0.0],
        };
        (shift, sides.map(|side| side.map_or(0.0, |(_, [_, rate])| *rate)))
    }
}

/// An operator as the coordinate of state 0 moves by η; none where it does not.
fn stretched(operator: &FokkerPlanck, shift: [f64; 2]) -> Option<FokkerPlanck> {
    let field = Polynomial::variable(operator.dimension(), 0) * shift[1] + shift[0];
    (shift != [0.0; 2]).then(|| operator.stretched(0, &field))
}

impl PlaneMotion {
    /// η at a displacement.
    pub(crate) fn rate(&self, x: f64) -> f64 {
        self.shift[0] + self.shift[1] * x
    }

    /// Whether a wall moves.
    pub(crate) fn moves(&self) -> bool {
        self.shift != [0.0; 2]
    }
}

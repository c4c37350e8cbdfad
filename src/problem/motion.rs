//! What of a problem moves with a parameter.

use super::Problem;
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use crate::numerics::least_norm;
use crate::polynomial::Polynomial;
use crate::walls::Wall;
use faer::{Col, Mat};

/// What is left of rates by rounding, relative to the largest.
const ROUNDING: f64 = 1e-12;

/// The derivative of a problem by a parameter θ.
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
#[derive(Clone, Debug)]
pub(crate) struct PlaneMotion {
    /// ∂f/∂θ and ∂B/∂θ at a fixed ξ.
    pub(crate) operator: FokkerPlanck,
    /// η = [0] + [1] x.
    pub(crate) shift: [f64; 2],
    /// ∂r/∂θ of the walls below the motion and above it.
    pub(crate) restitution: [f64; 2],
}

/// The same of any states in coordinates in which all walls stand still: displacement i moves with them by dx_i/dθ = η_i(x_i), each
/// η_i linear in its own displacement, and q has the derivatives of [`PlaneMotion`] for each of them.
#[derive(Clone, Debug)]
pub(crate) struct StillMotion {
    /// ∂f/∂θ and ∂B/∂θ in these coordinates.
    pub(crate) operator: FokkerPlanck,
    /// η_i = [0] + [1] x_i, for each state.
    pub(crate) shift: Vec<[f64; 2]>,
    /// ∂r/∂θ of each wall.
    pub(crate) restitution: Vec<f64>,
}

impl Motion {
    /// The motion of a problem of any states.
    ///
    /// # Errors
    /// [`Error::NotServed`] where no such coordinates let all walls stand still.
    pub(crate) fn still(&self, problem: &Problem) -> Result<StillMotion> {
        let shift = self.field(problem).ok_or(Error::NotServed {
            method: "closure",
            what: "a derivative by the offset of a wall that no shift or stretch of the displacements follows while the other walls stay",
            remedy: "take differences of two densities, at `Problem::with_parameter`",
        })?;
        let n = problem.dimension();
        let moving = (0..n).filter(|i| shift[*i] != [0.0; 2]);
        let operator = moving.fold(self.operator.clone(), |operator, i| {
            let field = Polynomial::variable(n, i) * shift[i][1] + shift[i][0];
            operator.plus(&problem.operator().stretched(i, &field))
        });
        Ok(StillMotion { operator, shift, restitution: self.walls.iter().map(|[_, rate]| *rate).collect() })
    }

    /// η_i = [0] + [1] x_i with which all walls move, the smallest shifts where these alone do it.
    ///
    /// A wall at x_i − x_j = b that moves at the rate β asks for η_i − η_j = β wherever it stands, of one displacement alone for
    /// η_i(b) = β.
    fn field(&self, problem: &Problem) -> Option<Vec<[f64; 2]>> {
        let n = problem.dimension();
        let walls = || problem.walls().iter().zip(&self.walls);
        let equations = |slopes: bool| {
            let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
            let ends =
                |wall: &Wall| std::iter::once((wall.state(), 1.0)).chain(wall.other().map(|other| (other, -1.0)));
            for (wall, [rate, _]) in walls() {
                let mut row = vec![0.0; 2 * n];
                ends(wall).for_each(|(i, sign)| row[i] = sign);
                row[n + wall.state()] = wall.offset();
                rows.push((row, *rate));
                if wall.other().is_some() {
                    let mut row = vec![0.0; 2 * n];
                    ends(wall).for_each(|(i, sign)| row[n + i] = sign);
                    rows.push((row, 0.0));
                }
            }
            let columns = if slopes { 2 * n } else { n };
            let matrix = Mat::from_fn(rows.len(), columns, |k, i| rows[k].0[i]);
            (matrix, Col::from_fn(rows.len(), |k| rows[k].1))
        };
        if walls().all(|(_, [rate, _])| *rate == 0.0) {
            return Some(vec![[0.0; 2]; n]);
        }
        let solve = |slopes: bool| {
            let (matrix, rates) = equations(slopes);
            let found = least_norm(&matrix, &rates, ROUNDING * matrix.norm_max())?;
            let left = (&matrix * &found - &rates).norm_max();
            (left <= ROUNDING * rates.norm_max()).then_some(found)
        };
        let field = |found: Col<f64>| {
            let entry = |i: usize| if i < found.nrows() { found[i] } else { 0.0 };
            // What rounding leaves of a rate of zero is none.
            let clean = |rate: f64| if rate.abs() > ROUNDING * found.norm_max() { rate } else { 0.0 };
            (0..n).map(|i| [clean(entry(i)), clean(entry(n + i))]).collect()
        };
        solve(false).or_else(|| solve(true)).map(field)
    }

    /// The motion of a problem of two states with walls on state 0 alone.
    pub(crate) fn on_plane(&self, problem: &Problem) -> PlaneMotion {
        let (shift, restitution) = self.of_walls(problem);
        let stretched = stretched(problem.operator(), shift);
        let operator = stretched.map_or_else(|| self.operator.clone(), |stretched| self.operator.plus(&stretched));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{DuffingChain, Solved};

    fn moved(walls: &[(Wall, [f64; 2])]) -> Result<Vec<[f64; 2]>> {
        let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.5, 0.5, 0.8)?.problem()?;
        let problem = walls.iter().try_fold(chain, |problem, (wall, _)| problem.with_wall(*wall))?;
        let rates = walls.iter().map(|(_, rates)| *rates).collect();
        Ok(Motion { operator: FokkerPlanck::zero(4), walls: rates }.still(&problem)?.shift)
    }

    fn close(found: &[[f64; 2]], truth: [[f64; 2]; 4]) -> bool {
        found.iter().flatten().zip(truth.iter().flatten()).all(|(found, truth)| (found - truth).abs() < 1e-14)
    }

    /// A wall alone is followed by a shift, which two bodies share; of two on one displacement one stands still where the other
    /// moves, and so it is between bodies, both of which are stretched then.
    #[test]
    fn coordinates_follow_the_walls() -> Result<()> {
        let nothing = [0.0; 2];
        let (above, below) = (Wall::above(-0.5, 0.8)?, Wall::below(1.5, 0.8)?);
        let between = |wall: Wall| wall.between([0, 2], [1.0, 0.5]);
        assert!(close(&moved(&[(above, [1.0, 0.0])])?, [[1.0, 0.0], nothing, nothing, nothing]));
        assert!(close(&moved(&[(above, [0.0, 1.0])])?, [nothing; 4]));
        let one_of_two = moved(&[(above, [1.0, 0.0]), (below, nothing)])?;
        assert!(close(&one_of_two, [[0.75, -0.5], nothing, nothing, nothing]));
        assert!(close(&moved(&[(between(above)?, [1.0, 0.0])])?, [[0.5, 0.0], nothing, [-0.5, 0.0], nothing]));
        let stops = moved(&[(between(above)?, [1.0, 0.0]), (between(below)?, nothing)])?;
        assert!(close(&stops, [[0.375, -0.5], nothing, [-0.375, -0.5], nothing]), "{stops:?}");
        // Beside a wall that stands still the other body gives way.
        let other = moved(&[(between(above)?, [1.0, 0.0]), (Wall::below(2.0, 0.8)?, nothing)])?;
        assert!(close(&other, [nothing, nothing, [-1.0, 0.0], nothing]), "{other:?}");
        Ok(())
    }

    #[test]
    fn walls_that_exclude_each_other_are_refused() -> Result<()> {
        let sides = |state: usize| {
            [Wall::above(-2.0, 0.8).map(|wall| wall.on(state)), Wall::below(2.0, 0.8).map(|wall| wall.on(state))]
        };
        let fixed =
            sides(0).into_iter().chain(sides(2)).map(|wall| Ok((wall?, [0.0; 2]))).collect::<Result<Vec<_>>>()?;
        let between = Wall::above(-1.0, 0.8)?.between([0, 2], [1.0, 1.0])?;
        let all: Vec<_> = fixed.into_iter().chain([(between, [1.0, 0.0])]).collect();
        assert!(matches!(moved(&all), Err(Error::NotServed { .. })));
        Ok(())
    }
}

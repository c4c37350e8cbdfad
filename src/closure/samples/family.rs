use crate::closure::MOST_FUNCTIONS;
use crate::closure::pilot::Pilot;
use crate::closure::samples::MANY;
use crate::closure::space::WallLevel;
use crate::closure::space::degrees::Degrees;
use crate::closure::space::folded;
use crate::functions::{Corner, Fold, Functions, Polynomials};
use crate::numerics::sort_by_number;
use crate::problem::{Problem, Symmetry};
use crate::walls::Contact;

/// The functions besides the polynomials of an order next to walls in four states and more: those of the closure, and those by
/// which its error is estimated. Polynomials of degree 0 in the other states left an oscillator beside a second mass with twice
/// the residual.
const AT_WALLS: [WallLevel; 2] = [beside(3, 5, 1), beside(4, 7, 2)];
/// The functions besides the polynomials of an order next to walls in three states: those of the closure, and those by which
/// its error is estimated.
const AT_WALLS_OF_THREE: [WallLevel; 2] = [beside(3, 5, 2), beside(4, 7, 2)];
/// The functions besides the polynomials of an order below four next to walls in three states and more: those of the closure,
/// and those by which its error is estimated.
const AT_WALLS_LOW: [WallLevel; 2] = [beside(2, 3, 1), beside(3, 5, 2)];
const fn beside(kinks: u32, angular: u32, others: u32) -> WallLevel {
    WallLevel { degree: 0, kinks, depth: 3, angular, others }
}
/// Of more functions than this means have no covariance next to walls in three states and more: a bound on work.
const MANY_AT_WALLS: usize = 480;
/// Where the density of samples two degrees higher has more polynomials than this, next to walls in three states and more, only
/// those of one and of two states are taken beyond the order: a bound on work.
const MOST_AT_WALLS: usize = 260;
/// The degree of the polynomials that multiply folds in functions that calibrate the pilot's means: with 4 the error of E x² of a
/// hysteretic oscillator falls to a third of that by polynomials of degree 6 alone.
const FOLDED: u32 = 4;
/// The kinks A u^i w^j z^a beside the polynomials that calibrate the pilot's means next to walls have i + j + |a| up to this.
const KINKS: u32 = 2;

/// The functions of all orders for one system: polynomials with its symmetry, and next to walls the functions with the
/// singularity of grazing impacts.
#[derive(Clone, Debug)]
pub(in crate::closure) struct FunctionFamily {
    degrees: Degrees,
    symmetry: Symmetry,
    centre: Vec<f64>,
    half_width: Vec<f64>,
    corners: Vec<Corner>,
    folds: Vec<Fold>,
    /// Whether noise acts across each of their places.
    crossed: Vec<bool>,
}

/// The singularities at all walls, in what the pilot's states reach. None where the noise on the rate of a gap depends on the state at
/// rest on the wall.
pub(in crate::closure) fn corners(problem: &Problem, pilot: &Pilot) -> Option<Vec<Corner>> {
    let corner = |contact: &Contact| {
        let gaps = pilot.states.iter().map(|x| contact.gap(x)).fold(0.0, f64::max);
        let rates = pilot.states.iter().map(|x| contact.rate(x).abs()).fold(0.0, f64::max);
        let velocities = contact.velocities().collect();
        Some(Corner::new(contact.wall, velocities, problem.intensity_at(contact)?, [gaps, rates]))
    };
    problem.contacts().iter().map(corner).collect()
}

impl FunctionFamily {
    /// On a box that holds the pilot's states. None where the noise on the rate of a gap depends on the state at rest on the wall.
    pub(in crate::closure) fn new(
        problem: &Problem,
        pilot: &Pilot,
        degrees: &Degrees,
        symmetry: &Symmetry,
    ) -> Option<Self> {
        let (centre, _) = pilot.spread(symmetry);
        let farthest = |i: usize| pilot.states.iter().map(|x| (x[i] - centre[i]).abs()).fold(0.0, f64::max);
        let half_width = (0..centre.len()).map(farthest).collect();
        let corners = corners(problem, pilot)?;
        // Next to walls products with kinks of the drift are left out.
        let surfaces = if corners.is_empty() { problem.surfaces() } else { &[] };
        let (folds, symmetry) = folded::at(surfaces, symmetry);
        let crossed = surfaces.iter().map(|surface| surface.crossed).collect();
        let degrees = degrees.clone();
        Some(FunctionFamily { degrees, symmetry, centre, half_width, corners, folds, crossed })
    }

    /// The same without kinks, if all walls are elastic and there are any kinks.
    pub(in crate::closure) fn without_kinks(&self) -> Option<Self> {
        let elastic = self.corners.iter().all(|corner| corner.wall().restitution() == 1.0);
        let corners = self.corners.iter().map(Corner::without_noise).collect();
        (elastic && self.has_kinks()).then(|| FunctionFamily { corners, ..self.clone() })
    }

    /// Whether noise makes grazing impacts singular at a wall.
    pub(super) fn has_kinks(&self) -> bool {
        self.corners.iter().any(|corner| corner.intensity() > 0.0)
    }

    pub(in crate::closure) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// The most functions whose means have covariances.
    pub(super) fn covered(&self) -> usize {
        if self.corners.is_empty() { MANY } else { MANY_AT_WALLS }
    }

    fn dimension(&self) -> usize {
        self.centre.len()
    }

    fn exponents(&self, order: u32) -> Vec<Vec<u32>> {
        folded::exponents(&self.degrees, order, &self.symmetry, &self.folds)
    }

    /// Whether the drift has a kink or a jump.
    pub(in crate::closure) fn has_folds(&self) -> bool {
        !self.folds.is_empty()
    }

    /// The functions of an order.
    pub(in crate::closure) fn functions(&self, order: u32) -> Functions {
        self.ladder(&[order], |order| self.exponents(order))
    }

    /// Those of an order, and after them those of a higher one, by which the error is estimated.
    pub(super) fn compared(&self, order: u32) -> Functions {
        let kept = self.exponents(order);
        let mut higher = self.exponents(order + 2);
        let most = if self.corners.is_empty() { MOST_FUNCTIONS } else { MOST_AT_WALLS };
        if higher.len() > most {
            let few = |alpha: &Vec<u32>| alpha.iter().filter(|power| **power > 0).count() <= 2;
            let beyond: Vec<Vec<u32>> =
                higher.into_iter().filter(|alpha| few(alpha) && !kept.contains(alpha)).collect();
            higher = kept.iter().cloned().chain(beyond).collect();
        }
        self.ladder(&[order, order + 2], |degree| if degree == order { kept.clone() } else { higher.clone() })
    }

    /// The functions ψ whose moment equations calibrate means: kinks or folds, and after them polynomials of a degree, those of a lower
    /// one first; and the number of those before them.
    pub(super) fn tests(&self, mut exponents: Vec<Vec<u32>>) -> (Functions, usize) {
        // The tests of a lower degree come first.
        sort_by_number(&mut exponents, |alpha| f64::from(alpha.iter().sum::<u32>()));
        if self.corners.is_empty() {
            // Across a kink of a function itself noise has a mean rate of change that is none of the generator's.
            let crossed =
                |fold: &Fold| self.folds.iter().zip(&self.crossed).any(|(own, crossed)| own == fold && *crossed);
            let degree = |fold: &Fold| (fold.power >= 2.0 || !crossed(fold)).then_some(FOLDED);
            let folded = folded::products(&Degrees::complete(), &self.symmetry, &self.folds, degree);
            let count = folded.len();
            return (self.polynomials([folded, exponents].concat()).into(), count);
        }
        let level = WallLevel { degree: 0, kinks: KINKS, depth: 0, angular: 0, others: 0 };
        let kinks = self.contacts(&[level], |_| Vec::new());
        let count = kinks.len();
        (kinks.then(self.polynomials(exponents)), count)
    }

    fn polynomials(&self, exponents: Vec<Vec<u32>>) -> Polynomials {
        Polynomials::new(self.centre.clone(), self.half_width.clone(), exponents).folded(self.folds.clone())
    }

    fn ladder(&self, orders: &[u32], exponents: impl Fn(u32) -> Vec<Vec<u32>>) -> Functions {
        if self.corners.is_empty() {
            let highest = orders.last().copied().unwrap_or(0);
            return self.polynomials(exponents(highest)).into();
        }
        let ladder = match (orders[0], self.dimension()) {
            (..4, _) => AT_WALLS_LOW,
            (_, ..=3) => AT_WALLS_OF_THREE,
            _ => AT_WALLS,
        };
        let level = |(level, order): (WallLevel, &u32)| WallLevel { degree: *order, ..level };
        let levels: Vec<WallLevel> = ladder.into_iter().zip(orders).map(level).collect();
        self.contacts(&levels, exponents)
    }

    fn contacts(&self, levels: &[WallLevel], exponents: impl Fn(u32) -> Vec<Vec<u32>>) -> Functions {
        Functions::next_to_walls(self.corners.clone(), (&self.centre, &self.half_width), levels, exponents)
    }

    pub(in crate::closure) fn box_around(&self) -> [&[f64]; 2] {
        [&self.centre, &self.half_width]
    }

    pub(in crate::closure) fn degrees(&self) -> &Degrees {
        &self.degrees
    }

    pub(in crate::closure) fn symmetry(&self) -> &Symmetry {
        &self.symmetry
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{DuffingChain, Solved};
    use crate::states::States;
    use crate::walls::Wall;

    /// The noises of two bodies, of intensity c_i T each, add up at a wall between them.
    #[test]
    fn corners_have_the_noise_of_their_gaps() -> Result<()> {
        let chain = DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?.problem()?;
        let between = Wall::above(-0.4, 0.6)?.between([0, 2], [1.0, 1.0])?;
        let problem = chain.with_wall(between)?.with_wall(Wall::below(1.5, 0.8)?.on(2))?;
        let pilot = Pilot::of(States::from_values(4, vec![0.3, 1.0, -0.2, -0.5]), 1.0);
        let found: Vec<f64> = corners(&problem, &pilot).unwrap_or_default().iter().map(Corner::intensity).collect();
        assert!((found[0] - 0.48).abs() < 1e-14 && (found[1] - 0.32).abs() < 1e-14, "{found:?}");
        Ok(())
    }
}

use super::degrees::Degrees;
use super::folded::{self, Known};
use crate::closure::REFERENCE_EXCESS;
use crate::closure::space::WallLevel;
use crate::functions::{Corner, Fold, Functions, Polynomials};
use crate::problem::{Problem, Surface, Symmetry};

/// The number of highest degrees of a reference's correction, where the edge of the domain shows as ripples; the correction may
/// be cut off below them.
const BUFFER: u32 = 4;
/// The levels of functions next to walls in two states: that of the weight, and those of the reference without and with its
/// highest functions.
const WALLED: [WallLevel; 3] = [
    WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7, others: 0 },
    WallLevel { degree: 10, kinks: 5, depth: 4, angular: 9, others: 0 },
    WallLevel { degree: 12, kinks: 5, depth: 4, angular: 9, others: 0 },
];
/// The degrees of the moment equations in time in one state and two, of which the highest stable one is taken.
const DEGREES: [u32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];
/// The degrees of the moment equations in time in three states and more, as far as their functions are few enough.
const DEGREES_OF_MANY: [u32; 6] = [2, 4, 6, 8, 10, 12];
/// The most functions of the moment equations in time in three states and more.
const MOST_FUNCTIONS: usize = 500;

/// The nested spaces that an order needs. Each but the last holds the first functions of the next.
pub(in crate::closure) struct NestedSpaces {
    /// The functions of the closure's Q.
    pub(in crate::closure) answer: Functions,
    /// The functions of the reference's weight, which contain the answer's, though not as the first ones.
    pub(in crate::closure) weight: Functions,
    /// The functions of the correction of the weight, which also test the moment equations.
    pub(in crate::closure) all: Functions,
    /// The columns, the constant's included, of `all` that hold the answer, the weight, and all but the last degrees.
    pub(in crate::closure) answer_columns: usize,
    pub(in crate::closure) weight_columns: usize,
    pub(in crate::closure) lower_columns: usize,
    /// Two truncations, each with the columns whose share in the correction is its error and the end of the columns kept:
    /// all, or fewer.
    pub(in crate::closure) whole: Truncation,
    pub(in crate::closure) cut: Option<Truncation>,
}

/// The columns by which a correction's error is estimated, and the place where it ends.
#[derive(Clone, Copy, Debug)]
pub(in crate::closure) struct Truncation {
    pub(in crate::closure) lower: usize,
    pub(in crate::closure) end: usize,
}

impl NestedSpaces {
    /// The spaces of the answer's space, the weight's, all functions but those of the last degrees, and all.
    fn new([answer, weight, lower, all]: [Functions; 4], cut: Option<Truncation>) -> Self {
        NestedSpaces {
            answer_columns: answer.len() + 1,
            weight_columns: weight.len() + 1,
            lower_columns: lower.len() + 1,
            whole: Truncation { lower: lower.len() + 1, end: all.len() + 1 },
            cut,
            answer,
            weight,
            all,
        }
    }

    /// The columns of `all`.
    pub(in crate::closure) fn columns(&self) -> usize {
        self.all.len() + 1
    }
}

/// The spaces of all orders for one system.
#[derive(Clone, Debug)]
pub(in crate::closure) enum SpaceFamily {
    Smooth(Smooth),
    Walled(Walled),
}

impl SpaceFamily {
    pub(in crate::closure) fn nested(&self, order: u32) -> NestedSpaces {
        match self {
            SpaceFamily::Smooth(smooth) => {
                let degree = smooth.reference_degree(order);
                // A weight of low degree serves a low order, and is faster.
                let weight = order.max(match (smooth.centre.len(), order) {
                    (..=2, 6..) => 12,
                    (..=3, _) => 8,
                    _ => 6,
                });
                let spaces = [order, weight, degree - 2, degree].map(|d| smooth.functions(d));
                let cut = (degree > order + BUFFER).then(|| {
                    let [lower, end] = [BUFFER + 2, BUFFER].map(|less| smooth.functions(degree - less).len() + 1);
                    Truncation { lower, end }
                });
                NestedSpaces::new(spaces, cut)
            }
            SpaceFamily::Walled(walled) => NestedSpaces::new(walled.spaces(order), None),
        }
    }

    /// The functions of an order's answer alone.
    pub(in crate::closure) fn functions(&self, order: u32) -> Functions {
        match self {
            SpaceFamily::Smooth(smooth) => smooth.functions(order),
            SpaceFamily::Walled(walled) => {
                let [answer, ..] = walled.spaces(order);
                answer
            }
        }
    }

    /// The same with polynomials alone next to walls.
    pub(in crate::closure) fn without_kinks(&self) -> Self {
        match self {
            SpaceFamily::Walled(walled) => {
                let corners = walled.corners.iter().map(Corner::without_noise).collect();
                SpaceFamily::Walled(Walled { corners, ..walled.clone() })
            }
            SpaceFamily::Smooth(_) => self.clone(),
        }
    }

    /// The same for densities that do not share the system's symmetry, with all monomials.
    pub(in crate::closure) fn without_symmetry(&self) -> Self {
        match self {
            SpaceFamily::Smooth(smooth) => {
                SpaceFamily::Smooth(Smooth::complete(smooth.centre.clone(), smooth.half_width.clone()))
            }
            SpaceFamily::Walled(walled) => SpaceFamily::Walled(walled.clone()),
        }
    }

    /// The nested spaces in which densities are followed in time.
    pub(in crate::closure) fn ladder(&self) -> Vec<Functions> {
        match self {
            SpaceFamily::Smooth(smooth) if smooth.centre.len() > 2 => smooth.ladder_of_many(),
            SpaceFamily::Smooth(smooth) => DEGREES.map(|degree| smooth.functions(degree)).to_vec(),
            SpaceFamily::Walled(walled) => (1..=WALLED.len())
                .map(|steps| {
                    let sides = (&walled.centre[..], &walled.half_width[..]);
                    Functions::in_a_plane(walled.corners.clone(), sides, &WALLED[..steps])
                })
                .collect(),
        }
    }

    /// Polynomials of these degrees with a symmetry; none next to walls.
    pub(in crate::closure) fn of_degrees(&self, degrees: [u32; 2], symmetry: &Symmetry) -> Option<Vec<Functions>> {
        let SpaceFamily::Smooth(smooth) = self else { return None };
        let smooth = Smooth { symmetry: symmetry.clone(), ..smooth.clone() };
        Some(degrees.map(|degree| smooth.functions(degree)).to_vec())
    }

    /// Whether there is nothing but polynomials.
    pub(in crate::closure) fn is_smooth(&self) -> bool {
        matches!(self, SpaceFamily::Smooth(_))
    }
}

/// Complete polynomials with the system's symmetry, and their products with functions that have a kink where the drift has one.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Smooth {
    pub(in crate::closure) degrees: Degrees,
    pub(in crate::closure) symmetry: Symmetry,
    pub(in crate::closure) centre: Vec<f64>,
    pub(in crate::closure) half_width: Vec<f64>,
    pub(in crate::closure) folds: Vec<Fold>,
}

impl Smooth {
    /// All polynomials on a box.
    pub(in crate::closure) fn complete(centre: Vec<f64>, half_width: Vec<f64>) -> Self {
        let (degrees, symmetry) = (Degrees::complete(), Symmetry::none(centre.len()));
        Smooth { degrees, symmetry, centre, half_width, folds: Vec::new() }
    }

    /// The same with the kinks that ln p has at the surfaces of a problem within a box.
    pub(in crate::closure) fn bent(self, problem: &Problem, bounds: &[[f64; 2]]) -> Self {
        let within = |surface: &&Surface| {
            let [low, high] = bounds[surface.state];
            low < surface.place && surface.place < high
        };
        let surfaces: Vec<Surface> = problem.surfaces().iter().filter(within).copied().collect();
        let (folds, symmetry) = folded::at(&surfaces, &self.symmetry);
        Smooth { folds, symmetry, ..self }
    }

    /// The same with the potentials of forces that are no polynomials, as far as they are to be known. None without such forces.
    pub(in crate::closure) fn with_potentials(&self, problem: &Problem, known: Known<'_>) -> Option<Self> {
        let potentials =
            if problem.operator().is_polynomial() { Vec::new() } else { folded::potentials(problem, known) };
        let folds = [&self.folds[..], &potentials].concat();
        (!potentials.is_empty()).then(|| Smooth { folds, ..self.clone() })
    }

    /// Those of rising degree that are few enough in three states and more; the first two are in any case.
    fn ladder_of_many(&self) -> Vec<Functions> {
        let most = MOST_FUNCTIONS;
        let few = |degree: &u32| !self.degrees.are_more_than(most, self.centre.len(), *degree);
        let degrees: Vec<u32> = DEGREES_OF_MANY.into_iter().take_while(few).collect();
        let degrees = if degrees.len() < 2 { vec![1, 2] } else { degrees };
        degrees.into_iter().map(|degree| self.functions(degree)).collect()
    }

    /// The degree of the reference of an order.
    pub(in crate::closure) fn reference_degree(&self, order: u32) -> u32 {
        order + REFERENCE_EXCESS[self.centre.len().min(4) - 1]
    }

    pub(in crate::closure) fn functions(&self, degree: u32) -> Functions {
        let exponents = folded::exponents(&self.degrees, degree, &self.symmetry, &self.folds);
        let (centre, half_width) = (self.centre.clone(), self.half_width.clone());
        Polynomials::new(centre, half_width, exponents).folded(self.folds.clone()).into()
    }
}

/// Polynomials with kinks and angular functions.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Walled {
    pub(in crate::closure) corners: Vec<Corner>,
    pub(in crate::closure) centre: Vec<f64>,
    pub(in crate::closure) half_width: Vec<f64>,
}

impl Walled {
    /// The spaces of the answer, the weight, and the reference and the one below it.
    fn spaces(&self, order: u32) -> [Functions; 4] {
        // From order 9 on the weight is of the answer's own level.
        let [weight, lower, all] = WALLED;
        let weight = if order <= weight.degree { weight } else { level(order) };
        let levels = [level(order), weight, lower, all];
        [1, 2, 3, 4].map(|steps| {
            Functions::in_a_plane(self.corners.clone(), (&self.centre, &self.half_width), &levels[..steps])
        })
    }
}

/// The functions of an order: polynomials to that degree, and more kinks and angular functions the higher it is.
fn level(order: u32) -> WallLevel {
    let (kinks, angular) = match order {
        0..=1 => (0, 1),
        2..=3 => (2, 3),
        4..=5 => (3, 5),
        6..=7 => (3, 7),
        8..=9 => (5, 7),
        _ => (5, 9),
    };
    WallLevel { degree: order, kinks, depth: if order < 9 { 3 } else { 4 }, angular, others: 0 }
}

use super::carried::{Along, Carried};
use super::moving::Moving;
use super::slope::Slope;
use super::tangent::Derivative;
use super::{First, Linearised, Sensitivity, Solution};
use crate::closure::density::ClosureDensity;
use crate::error::Result;
use crate::problem::{Problem, Symmetry};
use crate::states::States;
use rayon::prelude::*;

/// Pairs of parameters by which second derivatives are asked for.
pub(super) struct Pairs<'a> {
    /// Each parameter once.
    pub(super) names: Vec<&'a str>,
    /// Where the parameters of each pair are among these.
    pub(super) places: Vec<[usize; 2]>,
}

impl<'a> Pairs<'a> {
    pub(super) fn new(pairs: &[[&'a str; 2]]) -> Self {
        let mut names = Vec::new();
        let mut place = |name: &'a str| {
            let known = names.iter().position(|other| *other == name);
            known.unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            })
        };
        let places = pairs.iter().map(|pair| pair.map(&mut place)).collect();
        Pairs { names, places }
    }

    /// The names of a pair.
    pub(super) fn names(&self, places: [usize; 2]) -> [&'a str; 2] {
        places.map(|place| self.names[place])
    }
}

/// A second derivative of q, the density in the coordinate in which walls stand still.
struct Second<'a> {
    /// ∂² ln q̃/∂θ∂φ.
    slope: Slope,
    first: [&'a First<'a>; 2],
    /// That of the reference; none where the density is exact.
    reference: Option<Derivative<'a>>,
}

impl ClosureDensity {
    /// The second derivatives in one state and in two.
    pub(super) fn second_on_nodes(&self, problem: &Problem, pairs: &Pairs<'_>) -> Result<Vec<Sensitivity>> {
        let corners = self.exponent().space.corners();
        let moving = pairs.names.iter().map(|name| Moving::new(problem, name, corners)).collect::<Result<Vec<_>>>()?;
        let twice = |places: &[usize; 2]| {
            let both = Moving::second(problem, pairs.names(*places), places.map(|place| &moving[place]), corners)?;
            let grazes = places.iter().map(|place| &moving[*place]).chain([&both]).any(Moving::grazes);
            Ok((both, grazes))
        };
        let twice = pairs.places.iter().map(twice).collect::<Result<Vec<_>>>()?;
        let operators = moving.iter().chain(twice.iter().map(|(both, _)| both)).map(|moving| &moving.operator);
        let symmetry = operators.clone().fold(problem.symmetry(), Symmetry::and_of);
        let system = self.system_of_order(twice.iter().any(|(_, grazes)| *grazes), &symmetry)?;
        let linearised = self.linearised(problem, system.as_ref(), &symmetry, operators)?;
        // The first derivatives that pairs take which graze, and those of the others.
        let first = |grazes: bool| {
            let taken =
                |place| pairs.places.iter().zip(&twice).any(|(pair, at)| at.1 == grazes && pair.contains(&place));
            let one = |place| taken(place).then(|| linearised.first(self, &moving[place], grazes)).flatten();
            (0..moving.len()).into_par_iter().map(one).collect::<Vec<_>>()
        };
        let first = [first(false), first(true)];
        let one = |(places, (both, grazes)): (&[usize; 2], &(Moving, bool))| {
            let [k, l] = places.map(|place| first[usize::from(*grazes)][place].as_ref().ok_or(self.failed()));
            let (first, moving) = ([k?, l?], places.map(|place| &moving[place]));
            let second = linearised.second(self, (moving, both), (first, *grazes)).ok_or(self.failed())?;
            Ok(self.moving_twice(pairs.names(*places), (moving, both), second))
        };
        // The first error is that of the first pair.
        let found: Vec<Result<Sensitivity>> = pairs.places.par_iter().zip(&twice).map(one).collect();
        found.into_iter().collect()
    }

    /// The second derivative of the density from that of q.
    fn moving_twice(&self, names: [&str; 2], moving: ([&Moving; 2], &Moving), mut found: Second<'_>) -> Sensitivity {
        let ((moving, both), first) = (moving, found.first);
        found.slope.regular.constant -= self.centred(found.own(&self.nodes), 0).1;
        let [own, reference, _] = found.relative(self, &self.nodes);
        let stretch = moving.map(|moving| moving.shift[1]);
        // The rate of impacts is that of q over the stretched length.
        let impacts = self.impacts_along(|points| {
            let [of_k, of_l] = first.map(|first| first.relative(self, points));
            let [own, other, below] = found.relative(self, points);
            let again = 2.0 * stretch[0] * stretch[1] - both.shift[1];
            let over = |twice: Vec<f64>, j: usize| -> Vec<f64> {
                let along = of_k[j].iter().zip(&of_l[j]);
                let all = twice.iter().zip(along);
                all.map(|(twice, (s_k, s_l))| twice - s_k * stretch[1] - s_l * stretch[0] + again).collect()
            };
            [over(own, 0), over(other, 1), over(below, 2)]
        });
        let whole = found.reference.as_ref().zip(found.of_references());
        let whole = whole.map(|(reference, first)| reference.whole(Some(first)));
        let s = first.map(|first| first.at_nodes.clone());
        let along = [0, 1].map(|j| Along { slope: first[j].slope.clone(), shift: moving[j].shift });
        let carried = Carried::second(both.shift, along, self, s);
        let names = names.map(str::to_owned).to_vec();
        let slope = found.slope.clone();
        Sensitivity { carried, impacts, ..self.moving_with(names, slope, [own, reference], whole) }
    }
}

impl<'a> Linearised<'a> {
    /// The derivative along two motions, given those along each of them. None where it is not finite.
    fn second(
        &self,
        density: &ClosureDensity,
        (moving, both): ([&Moving; 2], &Moving),
        (first, grazes): ([&'a First<'a>; 2], bool),
    ) -> Option<Second<'a>> {
        let moved = moving.map(|moving| &moving.operator);
        let Linearised { newton, fitted } = self;
        if let (Some(newton), false) = (newton, grazes) {
            let regular = newton.second(moved, &both.operator, first.map(|first| &first.slope.regular))?;
            return Some(Second { slope: Slope { regular, singular: Vec::new() }, first, reference: None });
        }
        let (fit, solution) = fitted.as_ref()?;
        let of_references = [first[0].reference.as_ref()?, first[1].reference.as_ref()?];
        let reference = match solution {
            Solution::Smooth(tangent) => tangent.second(moved, &both.operator, of_references)?,
            Solution::Walled(tangent) => tangent.second(moving, both, of_references)?,
        };
        let along = density.centred(reference.second_values(of_references, &density.nodes), 1).0;
        let at = |k: usize| first.map(|first| &first.at_nodes[k][..]);
        let [s_k, s_l] = at(1);
        let curved: Vec<f64> = along.iter().zip(s_k.iter().zip(s_l)).map(|(along, (k, l))| along - k * l).collect();
        let known = reference.s.singulars(&density.nodes);
        let regular = fit.second(at(0), at(1), &curved, &known)?;
        let slope = Slope { regular, singular: both.singular.clone() };
        Some(Second { slope, first, reference: Some(reference) })
    }
}

impl Second<'_> {
    /// (∂²q/∂θ∂φ)/q at some points: of p̃, of the reference, and of the reference by the equations of the degree below.
    fn relative(&self, density: &ClosureDensity, points: &States) -> [Vec<f64>; 3] {
        let own = self.own(points);
        let Some((reference, first)) = self.reference.as_ref().zip(self.of_references()) else {
            return [own.clone(), own.clone(), own];
        };
        let of = |along: &Derivative<'_>| density.centred_at(|points| along.second_values(first, points), points);
        [own, of(reference), of(&reference.by_lower_degree())]
    }

    /// That of p̃.
    fn own(&self, points: &States) -> Vec<f64> {
        let [k, l] = self.first.map(|first| first.slope.values(points));
        let products = k.iter().zip(&l).map(|(k, l)| k * l);
        self.slope.values(points).into_iter().zip(products).map(|(s, product)| s + product).collect()
    }

    fn of_references(&self) -> Option<[&Derivative<'_>; 2]> {
        let [k, l] = self.first;
        Some([k.reference.as_ref()?, l.reference.as_ref()?])
    }
}

//! Lists of functions: products of Legendre polynomials, and of these with the kinks at walls.

use super::corner::{Kink, Radius};
use super::{Corner, Jet, PlaneJet, Polynomials};
use crate::fokker_planck::generator;
use crate::numerics::Number;
use crate::record::Read;
use serde::{Deserialize, Serialize};

/// A list of functions φ₁ … φ_K of the state, without the constant, in order of rising degree: polynomials, and at each wall products
/// of functions with the singularity of grazing impacts and polynomials of the other states, of which a plane has none but the
/// constant.
///
/// The lists are nested: those of a smaller degree come first in the list of a larger one.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Functions {
    corners: Vec<Corner>,
    pub(super) blocks: Vec<Block>,
    /// The highest powers of u, w, A and 1/A in kinks.
    #[serde(skip)]
    pub(super) highest: [usize; 4],
}

/// Polynomials, or the products of each of some kinks with all of them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Block {
    /// The number of a wall, and its kinks.
    pub(super) kinks: Option<(usize, Vec<Kink>)>,
    pub(super) factors: Polynomials,
}

/// A kink, if there is one, with the polynomials that it is multiplied by and their coefficients.
pub(crate) type FunctionTerms<'a> = (Option<(usize, Kink)>, &'a Polynomials, &'a [f64]);

impl Block {
    /// The kinks one after the other, or none once.
    pub(super) fn each(&self) -> impl Iterator<Item = Option<(usize, Kink)>> {
        let kinks = self.kinks.iter().flat_map(|(wall, kinks)| kinks.iter().map(|kink| Some((*wall, *kink))));
        kinks.chain(self.kinks.is_none().then_some(None))
    }

    fn len(&self) -> usize {
        self.factors.len() * self.kinks.as_ref().map_or(1, |(_, kinks)| kinks.len())
    }
}

impl From<Polynomials> for Functions {
    fn from(factors: Polynomials) -> Self {
        Functions::of(Vec::new(), vec![Block { kinks: None, factors }])
    }
}

impl Functions {
    pub(super) fn of(corners: Vec<Corner>, blocks: Vec<Block>) -> Self {
        let kinks = || blocks.iter().flat_map(Block::each).flatten().map(|(_, kink)| kink.powers());
        let highest = std::array::from_fn(|k| kinks().map(|powers| powers[k]).max().unwrap_or(0));
        Functions { corners, blocks, highest }
    }

    /// The same with polynomials after them.
    pub(in crate::closure) fn then(mut self, factors: Polynomials) -> Self {
        self.blocks.push(Block { kinks: None, factors });
        self
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, states: usize) -> Read<Self> {
        let corners: Vec<Corner> =
            self.corners.into_iter().map(|corner| corner.checked(states)).collect::<Read<_>>()?;
        let block = |Block { kinks, factors }: Block| {
            let kinks = match kinks {
                Some((wall, kinks)) if wall < corners.len() => {
                    Some((wall, kinks.into_iter().map(Kink::checked).collect::<Read<_>>()?))
                }
                Some((wall, _)) => return Err(format!("there is no wall {wall}")),
                None => None,
            };
            Ok(Block { kinks, factors: factors.checked(states)? })
        };
        let blocks: Vec<Block> = self.blocks.into_iter().map(block).collect::<Read<_>>()?;
        if blocks.is_empty() {
            return Err("there are no functions".into());
        }
        Ok(Functions::of(corners, blocks))
    }

    /// K.
    pub(in crate::closure) fn len(&self) -> usize {
        self.blocks.iter().map(Block::len).sum()
    }

    /// The number of states.
    pub(crate) fn dimension(&self) -> usize {
        self.blocks.first().map_or(0, |block| block.factors.centre().len())
    }

    /// The polynomials alone, where there is no more.
    pub(crate) fn polynomials(&self) -> Option<&Polynomials> {
        match &self.blocks[..] {
            [Block { kinks: None, factors }] if self.corners.is_empty() => Some(factors),
            _ => None,
        }
    }

    /// The walls.
    pub(crate) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// The centre and the half widths of the box of the polynomials.
    pub(crate) fn box_around(&self) -> [&[f64]; 2] {
        self.blocks.first().map_or([&[]; 2], |block| [block.factors.centre(), block.factors.half_width()])
    }

    /// The functions by their kinks, with the coefficients of a combination of them.
    pub(crate) fn terms<'a>(&'a self, mut a: &'a [f64]) -> impl Iterator<Item = FunctionTerms<'a>> {
        self.blocks.iter().flat_map(|block| block.each().map(move |kink| (kink, &block.factors))).map(
            move |(kink, factors)| {
                let (own, rest) = a.split_at(factors.len());
                a = rest;
                (kink, factors, own)
            },
        )
    }

    /// The powers of the polynomials without kinks, in their order, each with its place in the list.
    pub(in crate::closure) fn powers(&self) -> Vec<(usize, &[u32])> {
        let mut at = 0;
        let mut found = Vec::new();
        for block in &self.blocks {
            if block.kinks.is_none() {
                found.extend(block.factors.exponents().iter().enumerate().map(|(k, alpha)| (at + k, alpha.as_slice())));
            }
            at += block.len();
        }
        found
    }

    /// A at each wall.
    #[inline(always)]
    fn radii<T: Number>(&self, x: &[T]) -> Vec<Radius<T>> {
        self.corners.iter().map(|corner| Radius::new(corner, x, self.highest)).collect()
    }

    /// φ_k at `x`.
    #[inline(always)]
    pub(in crate::closure) fn values<T: Number>(&self, x: &[T], mut values: &mut [T]) {
        let radii = self.radii(x);
        for Block { kinks, factors } in &self.blocks {
            let Some((wall, kinks)) = kinks else {
                let (own, rest) = values.split_at_mut(factors.len());
                factors.values(x, own);
                values = rest;
                continue;
            };
            let beside = factor_values(factors, x);
            for kink in kinks {
                let (own, rest) = values.split_at_mut(factors.len());
                let kink = radii[*wall].value(kink);
                own.iter_mut().zip(&beside).for_each(|(value, beside)| *value = *beside * kink);
                values = rest;
            }
        }
    }

    /// Σ a_k φ_k over as many functions as there are a_k.
    #[inline(always)]
    pub(in crate::closure) fn sum<T: Number>(&self, x: &[T], mut a: &[f64]) -> T {
        let radii = self.radii(x);
        let mut sum = T::everywhere(0.0);
        for Block { kinks, factors } in &self.blocks {
            let Some((wall, kinks)) = kinks else {
                sum = factors.added(sum, x, a);
                a = &a[factors.len().min(a.len())..];
                continue;
            };
            let beside = factor_values(factors, x);
            for kink in kinks {
                let mut part = T::everywhere(0.0);
                beside.iter().zip(a).for_each(|(beside, &a)| part += *beside * a);
                sum += part * radii[*wall].value(kink);
                a = &a[factors.len().min(a.len())..];
            }
        }
        sum
    }

    /// φ_k and their mean rates of change f·∇φ_k + ½ B:∇∇φ_k at `x`, B by rows.
    #[inline(always)]
    pub(in crate::closure) fn rates<T: Number>(
        &self,
        x: &[T],
        local: (&[T], &[T]),
        mut values: &mut [T],
        mut rates: &mut [T],
    ) {
        let (radii, states, zero) = (self.radii(x), x.len(), T::everywhere(0.0));
        for Block { kinks, factors } in &self.blocks {
            let Some((wall, kinks)) = kinks else {
                let ((own, values_left), (own_rates, rates_left)) =
                    (values.split_at_mut(factors.len()), rates.split_at_mut(factors.len()));
                factors.rates(x, local, own, own_rates);
                (values, rates) = (values_left, rates_left);
                continue;
            };
            let [mut beside, mut carried] = [T::everywhere(1.0), zero].map(|start| vec![start; factors.len()]);
            let (mut jet, mut drift) = (Jet::zero(states), vec![zero; states]);
            let (still, mut mixed) = (vec![zero; states * states], vec![zero; factors.len()]);
            let mut scratch = beside.clone();
            if !factors.are_constant() {
                factors.rates(x, local, &mut beside, &mut carried);
            }
            for kink in kinks {
                let ((own, values_left), (own_rates, rates_left)) =
                    (values.split_at_mut(factors.len()), rates.split_at_mut(factors.len()));
                self.place(&radii[*wall].jet(kink), *wall, &mut jet);
                let rate = generator(local, &jet.gradient, &jet.hessian);
                if !factors.are_constant() {
                    for (i, to) in drift.iter_mut().enumerate() {
                        *to = zero;
                        (0..states).for_each(|j| *to += local.1[i * states + j] * jet.gradient[j]);
                    }
                    factors.rates(x, (&drift, &still), &mut scratch, &mut mixed);
                }
                for k in 0..factors.len() {
                    own_rates[k] = carried[k] * jet.value + mixed[k] + beside[k] * rate;
                    own[k] = beside[k] * jet.value;
                }
                (values, rates) = (values_left, rates_left);
            }
        }
    }

    /// Adds Σ a_k φ_k with its derivatives to `sum`.
    #[inline(always)]
    pub(in crate::closure) fn combine<T: Number>(&self, x: &[T], mut a: &[f64], sum: &mut Jet<T>) {
        let (radii, states) = (self.radii(x), x.len());
        for Block { kinks, factors } in &self.blocks {
            let Some((wall, kinks)) = kinks else {
                factors.combine(x, &a[..factors.len()], sum);
                a = &a[factors.len()..];
                continue;
            };
            let [mut part, mut jet] = [Jet::zero(states), Jet::zero(states)];
            for kink in kinks {
                let (own, rest) = a.split_at(factors.len());
                a = rest;
                part.clear();
                if factors.are_constant() {
                    part.value = T::everywhere(own.iter().sum());
                } else {
                    factors.combine(x, own, &mut part);
                }
                self.place(&radii[*wall].jet(kink), *wall, &mut jet);
                sum.value += part.value * jet.value;
                for i in 0..states {
                    sum.gradient[i] += part.gradient[i] * jet.value + part.value * jet.gradient[i];
                    for j in 0..states {
                        let at = i * states + j;
                        sum.hessian[at] += part.hessian[at] * jet.value
                            + part.value * jet.hessian[at]
                            + part.gradient[i] * jet.gradient[j]
                            + jet.gradient[i] * part.gradient[j];
                    }
                }
            }
        }
    }

    /// A kink at a wall with its derivatives in the states.
    #[inline(always)]
    fn place<T: Number>(&self, plane: &PlaneJet<T>, wall: usize, jet: &mut Jet<T>) {
        let states = jet.gradient.len();
        jet.clear();
        jet.value = plane.value;
        let forms = self.corners[wall].forms();
        for (p, form) in forms.iter().enumerate() {
            for (i, sign) in form.parts() {
                jet.gradient[i] += plane.gradient[p] * sign;
                for (q, other) in forms.iter().enumerate() {
                    for (j, with) in other.parts() {
                        jet.hessian[i * states + j] += plane.hessian[p][q] * (sign * with);
                    }
                }
            }
        }
    }
}

/// The polynomials that kinks are multiplied by, at `x`.
#[inline(always)]
fn factor_values<T: Number>(factors: &Polynomials, x: &[T]) -> Vec<T> {
    let mut values = vec![T::everywhere(1.0); factors.len()];
    if !factors.are_constant() {
        factors.values(x, &mut values);
    }
    values
}

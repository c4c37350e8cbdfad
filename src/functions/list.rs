//! Lists of functions: products of Legendre polynomials, and of these with the kinks at walls.

use super::impulses::{ImpulseImages, images};
use super::tree::Tree;
use super::{Corner, Fold, Kink, Polynomials};
use crate::fokker_planck::ImpulseTerm;
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
    pub(super) corners: Vec<Corner>,
    pub(super) blocks: Vec<Block>,
    #[serde(skip)]
    pub(super) tree: Tree,
    /// The part of the images of φ₁ … φ_K that impulses make; empty without any.
    #[serde(skip)]
    pub(super) impulses: ImpulseImages,
}

/// Polynomials, or the products of each of some kinks with all of them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Block {
    /// The number of a wall, and its kinks.
    pub(crate) kinks: Option<(usize, Vec<Kink>)>,
    pub(crate) factors: Polynomials,
}

/// A kink, if there is one, with the polynomials that it is multiplied by and their coefficients.
pub(crate) type FunctionTerms<'a> = (Option<(usize, Kink)>, &'a Polynomials, &'a [f64]);

impl Block {
    /// The kinks one after the other, or none once.
    pub(crate) fn each(&self) -> impl Iterator<Item = Option<(usize, Kink)>> {
        let kinks = self.kinks.iter().flat_map(|(wall, kinks)| kinks.iter().map(|kink| Some((*wall, *kink))));
        kinks.chain(self.kinks.is_none().then_some(None))
    }

    fn len(&self) -> usize {
        self.factors.len() * self.kinks.as_ref().map_or(1, |(_, kinks)| kinks.len())
    }
}

/// No function but the constant.
impl Default for Functions {
    fn default() -> Self {
        Functions::of(Vec::new(), Vec::new())
    }
}

impl From<Polynomials> for Functions {
    fn from(factors: Polynomials) -> Self {
        Functions::of(Vec::new(), vec![Block { kinks: None, factors }])
    }
}

impl Functions {
    pub(crate) fn of(corners: Vec<Corner>, blocks: Vec<Block>) -> Self {
        let tree = Tree::new(&corners, &blocks);
        Functions { corners, blocks, tree, impulses: Vec::new() }
    }

    /// Products of Legendre polynomials of these degrees in the states, on the box `centre` ± `half_width`.
    pub(crate) fn on_box(centre: &[f64], half_width: &[f64], exponents: &[Vec<u32>]) -> Self {
        Functions::from(Polynomials::new(centre.to_vec(), half_width.to_vec(), exponents.to_vec()))
    }

    /// The same with impulses in the images of its functions.
    pub(crate) fn struck(self, impulses: ImpulseImages) -> Self {
        Functions { impulses, ..self }
    }

    /// The images of its functions under impulses' terms; nothing without any. None where these images are no combinations of its
    /// functions.
    pub(crate) fn images(&self, terms: &[ImpulseTerm]) -> Option<ImpulseImages> {
        if terms.is_empty() {
            return Some(Vec::new());
        }
        let own = self.polynomials()?;
        images(terms, (own.centre(), own.half_width()), own.exponents())
    }

    /// The part of the images of φ₁ … φ_K that impulses make; empty without any.
    pub(crate) fn impulses(&self) -> &ImpulseImages {
        &self.impulses
    }

    /// The same with polynomials after them.
    pub(crate) fn then(mut self, factors: Polynomials) -> Self {
        self.blocks.push(Block { kinks: None, factors });
        Functions::of(self.corners, self.blocks)
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(crate) fn checked(self, states: usize) -> Read<Self> {
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
    pub(crate) fn len(&self) -> usize {
        self.blocks.iter().map(Block::len).sum()
    }

    /// The number of states.
    pub(crate) fn dimension(&self) -> usize {
        self.blocks.first().map_or(0, |block| block.factors.centre().len())
    }

    /// The polynomials alone, where there is no more.
    pub(crate) fn polynomials(&self) -> Option<&Polynomials> {
        self.on_one_box().filter(|factors| factors.folds().is_empty())
    }

    /// The same, perhaps with folds.
    pub(crate) fn on_one_box(&self) -> Option<&Polynomials> {
        match &self.blocks[..] {
            [Block { kinks: None, factors }] if self.corners.is_empty() => Some(factors),
            _ => None,
        }
    }

    /// The folds, of which all its polynomials have the same list.
    pub(crate) fn folds(&self) -> &[Fold] {
        self.blocks.first().map_or(&[], |block| block.factors.folds())
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
    pub(crate) fn powers(&self) -> Vec<(usize, &[u32])> {
        let mut at = 0;
        let mut found = Vec::new();
        for block in &self.blocks {
            if block.kinks.is_none() {
                let own = block.factors.exponents().iter().enumerate();
                let plain = own.filter(|(_, alpha)| Polynomials::is_plain(alpha));
                found.extend(plain.map(|(k, alpha)| (at + k, alpha.as_slice())));
            }
            at += block.len();
        }
        found
    }
}

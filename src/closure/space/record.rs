//! Spaces of functions as what they depend on, to be saved and to be written out.

use super::{Corner, Polynomials, Space, WallFunctions};
use crate::closure::degrees::HIGHEST;
use crate::record::{Read, exponents, positive, positive_states, states};
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::sync::Arc;

/// The highest power in a kink.
const HIGHEST_POWER: u32 = 30;

/// A list of functions: those of each step after those of the one before.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpaceRecord {
    /// The walls, if any.
    pub(crate) corners: Vec<CornerRecord>,
    pub(crate) steps: Vec<StepRecord>,
}

/// Products of Legendre polynomials in (x − centre)/half_width, then, for each corner, A^p u^i w^j by [p, i, j].
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StepRecord {
    pub(crate) centre: Vec<f64>,
    pub(crate) half_width: Vec<f64>,
    pub(crate) exponents: Vec<Vec<u32>>,
    pub(crate) kinks: Vec<[i32; 3]>,
}

/// A wall with what the functions next to it depend on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CornerRecord {
    pub(crate) offset: f64,
    pub(crate) ceiling: bool,
    pub(crate) restitution: f64,
    pub(crate) intensity: f64,
    pub(crate) reach: [f64; 2],
}

impl CornerRecord {
    pub(in crate::closure) fn corner(&self) -> Read<Corner> {
        let &CornerRecord { offset, ceiling, restitution, intensity, reach } = self;
        states::<1>("the offset of a wall", &[offset])?;
        if !(restitution > 0.0 && restitution <= 1.0) {
            return Err(format!("the restitution {restitution} does not lie between 0 and 1"));
        }
        positive("the intensity at a wall", intensity)?;
        let reach = positive_states::<2>("the reach of a wall's functions", &reach)?;
        let make = if ceiling { Corner::ceiling } else { Corner::floor };
        Ok(make(offset, restitution, intensity, reach))
    }
}

impl SpaceRecord {
    /// The number of functions.
    pub(crate) fn len(&self) -> usize {
        self.steps.iter().map(|step| step.exponents.len() + self.corners.len() * step.kinks.len()).sum()
    }

    /// The polynomials, where the functions are no more than that.
    pub(in crate::closure) fn polynomials<const N: usize>(&self) -> Read<Polynomials<N>> {
        match &self.steps[..] {
            [step] if step.kinks.is_empty() => step.polynomials(),
            _ => Err(String::from("its polynomials are not one list")),
        }
    }

    /// The functions themselves.
    pub(in crate::closure) fn space<const N: usize>(&self) -> Read<Arc<dyn Space<N> + Send>> {
        if self.corners.is_empty() {
            return Ok(Arc::new(self.polynomials::<N>()?));
        }
        let corners = self.corners.iter().map(CornerRecord::corner).collect::<Read<_>>()?;
        let powers = |kink: &[i32; 3]| {
            kink.iter().all(|power| power.unsigned_abs() <= HIGHEST_POWER) && kink[1].min(kink[2]) >= 0
        };
        if let Some(kink) = self.steps.iter().flat_map(|step| &step.kinks).find(|kink| !powers(kink)) {
            return Err(format!("the powers {kink:?} are none of a kink"));
        }
        let steps = self.steps.iter().map(|step| Ok((step.polynomials::<2>()?, step.kinks.clone())));
        let functions: Arc<dyn Space<2> + Send> =
            Arc::new(WallFunctions::of_steps(corners, steps.collect::<Read<_>>()?));
        same(functions).ok_or_else(|| format!("walls stand in two states, not in {N}"))
    }
}

impl StepRecord {
    fn polynomials<const N: usize>(&self) -> Read<Polynomials<N>> {
        let centre = states("the centre of the polynomials", &self.centre)?;
        let half_width = positive_states("the half width of the polynomials", &self.half_width)?;
        let alphas = self.exponents.iter().map(|alpha| exponents(alpha, HIGHEST)).collect::<Read<_>>()?;
        Ok(Polynomials::new(centre, half_width, alphas))
    }
}

/// A value as one of another type that turns out to be the same.
pub(in crate::closure) fn same<A: 'static, B: 'static>(value: A) -> Option<B> {
    let value: Box<dyn Any> = Box::new(value);
    value.downcast().ok().map(|value| *value)
}

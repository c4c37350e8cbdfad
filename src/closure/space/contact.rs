use super::corner::{Kink, Radius};
use super::degrees::Degrees;
use super::wall::WallLevel;
use super::{Corner, Jet, PlaneJet, Polynomials};
use crate::fokker_planck::generator;
use crate::numerics::Number;
use crate::record::Read;
use serde::{Deserialize, Serialize};

/// How many functions of each kind there are in three states and more, z the states beside the gap and its rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ContactLevel {
    /// Kinks A u^i w^j z^a are those with i + j + |a| up to `plane.kinks`.
    pub(crate) plane: WallLevel,
    /// Angular functions A^{d−j} w^j z^a have |a| up to d and to this.
    pub(crate) others: u32,
}

/// Functions for ln p next to walls in three states and more: polynomials of the states, and at each wall products of the
/// functions with the singularity of grazing impacts and polynomials of the other states.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactFunctions {
    pub(super) corners: Vec<Corner>,
    pub(super) blocks: Vec<Block>,
}

/// Polynomials, perhaps times one kink at one wall.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Block {
    /// The number of the wall, and the kink.
    pub(super) kink: Option<(usize, Kink)>,
    pub(super) factors: Polynomials,
}

impl ContactLevel {
    /// The kinks at a wall, each with the exponents of the other states that it is multiplied by.
    fn kinks(&self, corner: &Corner, states: usize) -> Vec<(Kink, Vec<Vec<u32>>)> {
        let [gap, rate] = corner.forms();
        let beside = |alpha: &[u32]| alpha[gap.first] == 0 && alpha[rate.first] == 0;
        let others = |degree: i32| -> Vec<Vec<u32>> {
            let constant = std::iter::once(vec![0; states]);
            constant.chain(Degrees::complete().exponents(states, degree.max(0) as u32, beside)).collect()
        };
        let WallLevel { kinks, .. } = self.plane;
        let with_others = |kink: Kink| {
            let Kink([power, i, j]) = kink;
            let degree =
                if power == 1 && i + j <= kinks as i32 { kinks as i32 - i - j } else { self.angular(power + j) };
            (kink, others(degree))
        };
        self.plane.kinks().map(with_others).collect()
    }

    /// The degree in the other states beside an angular function of degree `d`.
    fn angular(&self, d: i32) -> i32 {
        d.min(self.others as i32)
    }
}

impl ContactFunctions {
    /// The functions of a ladder of levels, each after those of the ones below it; polynomials are scaled to the box
    /// `centre` ± `half_width`, and `polynomials` lists the exponents of those alone up to a degree.
    pub(in crate::closure) fn new(
        corners: Vec<Corner>,
        (centre, half_width): (&[f64], &[f64]),
        ladder: &[ContactLevel],
        polynomials: impl Fn(u32) -> Vec<Vec<u32>>,
    ) -> Self {
        let states = centre.len();
        let scaled = |exponents| Polynomials::new(centre.to_vec(), half_width.to_vec(), exponents);
        let mut blocks: Vec<Block> = Vec::new();
        for level in ladder {
            let known: Vec<Vec<u32>> = blocks
                .iter()
                .filter(|block| block.kink.is_none())
                .flat_map(|b| b.factors.exponents().to_vec())
                .collect();
            let new = polynomials(level.plane.degree).into_iter().filter(|alpha| !known.contains(alpha)).collect();
            let mut added = vec![Block { kink: None, factors: scaled(new) }];
            // Where no noise ends a grazing impact it leaves no singularity of this kind.
            let noisy = |(_, corner): &(usize, &Corner)| corner.intensity() > 0.0;
            for (wall, corner) in corners.iter().enumerate().filter(noisy) {
                for (kink, exponents) in level.kinks(corner, states) {
                    let same = blocks.iter().filter(|block| block.kink == Some((wall, kink)));
                    let known: Vec<Vec<u32>> = same.flat_map(|block| block.factors.exponents().to_vec()).collect();
                    let new: Vec<Vec<u32>> = exponents.into_iter().filter(|alpha| !known.contains(alpha)).collect();
                    if !new.is_empty() {
                        added.push(Block { kink: Some((wall, kink)), factors: scaled(new) });
                    }
                }
            }
            blocks.extend(added);
        }
        ContactFunctions { corners, blocks }
    }

    /// The same with polynomials after them.
    pub(in crate::closure) fn then(mut self, factors: Polynomials) -> Self {
        self.blocks.push(Block { kink: None, factors });
        self
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self, states: usize) -> Read<Self> {
        let corners: Vec<Corner> =
            self.corners.into_iter().map(|corner| corner.checked(states)).collect::<Read<_>>()?;
        let block = |Block { kink, factors }: Block| {
            let kink = match kink {
                Some((wall, kink)) if wall < corners.len() => Some((wall, kink.checked()?)),
                Some((wall, _)) => return Err(format!("there is no wall {wall}")),
                None => None,
            };
            Ok(Block { kink, factors: factors.checked(states)? })
        };
        let blocks = self.blocks.into_iter().map(block).collect::<Read<_>>()?;
        Ok(ContactFunctions { corners, blocks })
    }

    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    pub(in crate::closure) fn len(&self) -> usize {
        self.blocks.iter().map(|block| block.factors.len()).sum()
    }

    pub(super) fn dimension(&self) -> usize {
        self.blocks.first().map_or(0, |block| block.factors.centre().len())
    }

    /// The powers of the polynomials alone, in their order, each with its place in the list of functions.
    pub(in crate::closure) fn polynomials(&self) -> Vec<(usize, &[u32])> {
        let mut at = 0;
        let mut found = Vec::new();
        for block in &self.blocks {
            if block.kink.is_none() {
                found.extend(block.factors.exponents().iter().enumerate().map(|(k, alpha)| (at + k, alpha.as_slice())));
            }
            at += block.factors.len();
        }
        found
    }

    /// A at each wall.
    #[inline(always)]
    fn radii<T: Number>(&self, x: &[T]) -> Vec<Radius<T>> {
        let kinks = self.blocks.iter().filter_map(|block| block.kink);
        let highest = kinks.fold([0; 4], |highest, (_, kink)| {
            let powers = kink.powers();
            [0, 1, 2, 3].map(|k| highest[k].max(powers[k]))
        });
        self.corners.iter().map(|corner| Radius::new(corner, x, highest)).collect()
    }

    #[inline(always)]
    pub(super) fn values<T: Number>(&self, x: &[T], mut values: &mut [T]) {
        let radii = self.radii(x);
        for Block { kink, factors } in &self.blocks {
            let (own, rest) = values.split_at_mut(factors.len());
            factors.values(x, own);
            if let Some((wall, kink)) = kink {
                let kink = radii[*wall].value(kink);
                own.iter_mut().for_each(|value| *value = *value * kink);
            }
            values = rest;
        }
    }

    #[inline(always)]
    pub(super) fn sum<T: Number>(&self, x: &[T], mut a: &[f64]) -> T {
        let radii = self.radii(x);
        let mut sum = T::everywhere(0.0);
        for Block { kink, factors } in &self.blocks {
            let (own, rest) = a.split_at(factors.len().min(a.len()));
            let part = factors.added(T::everywhere(0.0), x, own);
            sum += kink.as_ref().map_or(part, |(wall, kink)| part * radii[*wall].value(kink));
            a = rest;
        }
        sum
    }

    /// A kink with its derivatives in the states.
    #[inline(always)]
    fn kink_jet<T: Number>(&self, jet: &PlaneJet<T>, wall: usize, states: usize) -> Jet<T> {
        let mut found = Jet::zero(states);
        found.value = jet.value;
        let forms = self.corners[wall].forms();
        for (p, form) in forms.iter().enumerate() {
            for (i, sign) in form.parts() {
                found.gradient[i] += jet.gradient[p] * sign;
                for (q, other) in forms.iter().enumerate() {
                    for (j, with) in other.parts() {
                        found.hessian[i * states + j] += jet.hessian[p][q] * (sign * with);
                    }
                }
            }
        }
        found
    }

    #[inline(always)]
    pub(super) fn rates<T: Number>(&self, x: &[T], local: (&[T], &[T]), mut values: &mut [T], mut rates: &mut [T]) {
        let (radii, states) = (self.radii(x), x.len());
        let still = vec![T::everywhere(0.0); states * states];
        for Block { kink, factors } in &self.blocks {
            let (own_values, rest_of_values) = values.split_at_mut(factors.len());
            let (own_rates, rest_of_rates) = rates.split_at_mut(factors.len());
            factors.rates(x, local, own_values, own_rates);
            if let Some((wall, kink)) = kink {
                let jet = self.kink_jet(&radii[*wall].jet(kink), *wall, states);
                let own = generator(local, &jet.gradient, &jet.hessian);
                let mut carried = vec![T::everywhere(0.0); states];
                for (i, to) in carried.iter_mut().enumerate() {
                    for j in 0..states {
                        *to += local.1[i * states + j] * jet.gradient[j];
                    }
                }
                let mut mixed = own_rates.to_vec();
                factors.rates(x, (&carried, &still), own_values, &mut mixed);
                for ((value, rate), mixed) in own_values.iter_mut().zip(own_rates).zip(mixed) {
                    *rate = *rate * jet.value + mixed + *value * own;
                    *value = *value * jet.value;
                }
            }
            (values, rates) = (rest_of_values, rest_of_rates);
        }
    }

    #[inline(always)]
    pub(super) fn combine<T: Number>(&self, x: &[T], mut a: &[f64], sum: &mut Jet<T>) {
        let (radii, states) = (self.radii(x), x.len());
        for Block { kink, factors } in &self.blocks {
            let (own, rest) = a.split_at(factors.len());
            a = rest;
            let Some((wall, kink)) = kink else {
                factors.combine(x, own, sum);
                continue;
            };
            let mut part = Jet::zero(states);
            factors.combine(x, own, &mut part);
            let jet = self.kink_jet(&radii[*wall].jet(kink), *wall, states);
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

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::problem::Wall;

    /// Four states (x, y, u, v), a wall below x and one between the bodies, which have the velocities u and v.
    pub(in crate::closure::space) fn functions() -> ContactFunctions {
        let between = Wall::below(1.5, 0.7).unwrap().between([0, 1], [1.0, 2.0]).unwrap();
        let corners = vec![
            Corner::new(Wall::above(-0.5, 0.8).unwrap(), vec![2], 0.2, [3.0, 4.0]),
            Corner::new(between, vec![2, 3], 0.3, [2.5, 5.0]),
        ];
        let level = |degree, kinks, angular, others| ContactLevel {
            plane: WallLevel { degree, kinks, depth: 2, angular },
            others,
        };
        let polynomials = |degree| Degrees::complete().exponents(4, degree, |_| true);
        let sides: (&[f64], &[f64]) = (&[0.5, 0.1, 0.0, 0.2], &[2.0, 2.5, 4.0, 3.0]);
        ContactFunctions::new(corners, sides, &[level(2, 1, 3, 1), level(4, 2, 4, 2)], polynomials)
    }

    pub(in crate::closure::space) const POINTS: [[f64; 4]; 3] =
        [[0.4, -0.3, 1.1, -0.8], [-0.3, 0.2, -0.7, 0.5], [1.2, 0.1, 0.6, 1.3]];

    /// Kinks A u^i w^j z^a of a total degree up to m in the gap, its rate and two more states: C(m + 4, 4); of the angular
    /// functions with d = 1, 2 those with j = 0 … J but d and d − 1, and 3 or 6 polynomials of the other two states.
    #[test]
    fn levels_are_nested_and_counted() {
        let functions = functions();
        let [first, second] = [(14, 5 + 2 * 2 * 3), (69, 15 + 3 * 3 + 3 * 6)].map(|(p, kinks)| p + 2 * kinks);
        assert_eq!(functions.len(), second);
        let polynomials: Vec<(usize, &[u32])> = functions.polynomials();
        assert_eq!((polynomials.len(), polynomials[14].0), (69, first));
        assert_eq!(functions.dimension(), 4);
    }

    /// Rates and combinations agree, and gradients are those of the differences, whose error is the step squared times third
    /// derivatives.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let functions = functions();
        let count = functions.len();
        let local: (&[f64], &[f64]) = (&[1.1, -0.8, 0.3, -0.6], &{
            let mut b = [0.0; 16];
            (b[10], b[11], b[14], b[15]) = (0.5, 0.2, 0.2, 0.7);
            b
        });
        for x in POINTS {
            let [mut values, mut rates, mut plain] = [(); 3].map(|()| vec![0.0; count]);
            functions.rates(&x, local, &mut values, &mut rates);
            functions.values(&x, &mut plain);
            for k in 0..count {
                let mut a = vec![0.0; count];
                a[k] = 1.0;
                let mut jet = Jet::zero(4);
                functions.combine(&x, &a, &mut jet);
                let size = 1.0 + jet.value.abs() + rates[k].abs();
                assert!((jet.value - values[k]).abs() + (plain[k] - values[k]).abs() < 1e-13 * size, "{k}");
                assert!((functions.sum(&x, &a) - values[k]).abs() < 1e-13 * size, "{k}");
                assert!((generator(local, &jet.gradient, &jet.hessian) - rates[k]).abs() < 1e-12 * size, "{k}");
                for i in 0..4 {
                    let moved = |h: f64| {
                        let mut y = x;
                        y[i] += h;
                        functions.sum(&y, &a)
                    };
                    let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    assert!((difference - jet.gradient[i]).abs() < 1e-6 * (1.0 + jet.gradient[i].abs()), "{k} {i}");
                }
            }
        }
    }
}

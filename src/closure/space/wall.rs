use super::corner::{Kink, Radius};
use super::{Corner, Jet, Polynomials};
use crate::fokker_planck::generator;
use crate::numerics::Number;
use crate::record::Read;
use serde::{Deserialize, Serialize};

/// How many functions of each kind, with A = (w⁶ + (κu)²)^{1/6}, which grows like |w| and u^{1/3}.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WallLevel {
    /// Polynomials of total degree 1 to this.
    pub(crate) degree: u32,
    /// Kinks A u^i w^j with i + j up to this.
    pub(crate) kinks: u32,
    /// Angular functions A^{d−j} wʲ with d from 1 to this,
    pub(crate) depth: u32,
    /// and j from 0 to this.
    pub(crate) angular: u32,
}

/// Functions for ln p next to walls: polynomials, and at each wall functions with the singularity of grazing impacts.
///
/// Near (0, 0) p is a sum of functions of w/u^{1/3} times powers of A, of which polynomials contain only a few. A ladder
/// of levels makes one list in which the functions of each level come before those that the next one adds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WallFunctions {
    corners: Vec<Corner>,
    steps: Vec<LevelStep>,
    /// The highest powers of u, w, A and 1/A in kinks.
    #[serde(skip)]
    highest: [usize; 4],
}

/// What one level adds to those below it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct LevelStep {
    polynomials: Polynomials,
    /// The same at each corner.
    kinks: Vec<Kink>,
}

impl WallLevel {
    fn exponents(&self) -> impl Iterator<Item = Vec<u32>> + use<> {
        (1..=self.degree).flat_map(|total| (0..=total).map(move |j| vec![total - j, j]))
    }

    pub(super) fn kinks(&self) -> impl Iterator<Item = Kink> + use<> {
        let WallLevel { kinks, depth, angular, .. } = *self;
        let lines = (0..=kinks as i32).flat_map(|total| (0..=total).map(move |j| Kink([1, total - j, j])));
        let angles = (1..=depth as i32).flat_map(move |d| (0..=angular as i32).map(move |j| (d - j, j)));
        // Powers 0 and 1 are a polynomial and a kink.
        let angles = angles.filter(|(power, _)| !(0..=1).contains(power)).map(|(power, j)| Kink([power, 0, j]));
        lines.chain(angles)
    }
}

impl WallFunctions {
    /// The functions of a ladder of levels; polynomials are scaled to the box `centre` ± `half_width` of the states.
    pub(in crate::closure) fn new(
        corners: Vec<Corner>,
        centre: &[f64],
        half_width: &[f64],
        nested: &[WallLevel],
    ) -> Self {
        let step = |(step, level): (usize, &WallLevel)| {
            let below = &nested[..step];
            let new = |alpha: &Vec<u32>| below.iter().all(|level| alpha[0] + alpha[1] > level.degree);
            let exponents = level.exponents().filter(new).collect();
            let kinks = level.kinks().filter(|kink| below.iter().all(|level| level.kinks().all(|k| k != *kink)));
            let polynomials = Polynomials::new(centre.to_vec(), half_width.to_vec(), exponents);
            LevelStep { polynomials, kinks: kinks.collect() }
        };
        WallFunctions::of(corners, nested.iter().enumerate().map(step).collect())
    }

    fn of(corners: Vec<Corner>, steps: Vec<LevelStep>) -> Self {
        let powers = || steps.iter().flat_map(|step| &step.kinks).map(Kink::powers);
        let highest = std::array::from_fn(|k| powers().map(|powers| powers[k]).max().unwrap_or(0));
        WallFunctions { corners, steps, highest }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self) -> Read<Self> {
        let step = |LevelStep { polynomials, kinks }: LevelStep| {
            let kinks = kinks.into_iter().map(Kink::checked).collect::<Read<_>>()?;
            Ok(LevelStep { polynomials: polynomials.checked(2)?, kinks })
        };
        let corners = self.corners.into_iter().map(|corner| corner.checked(2)).collect::<Read<_>>()?;
        Ok(WallFunctions::of(corners, self.steps.into_iter().map(step).collect::<Read<_>>()?))
    }

    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    pub(super) fn single(&self) -> Option<(&Polynomials, &[Kink])> {
        match &self.steps[..] {
            [LevelStep { polynomials, kinks }] => Some((polynomials, kinks)),
            _ => None,
        }
    }

    /// A at each corner.
    #[inline(always)]
    fn radii<T: Number>(&self, x: &[T]) -> Vec<Radius<T>> {
        self.corners.iter().map(|corner| Radius::new(corner, x, self.highest)).collect()
    }

    pub(super) fn len(&self) -> usize {
        self.steps.iter().map(|step| step.polynomials.len() + self.corners.len() * step.kinks.len()).sum()
    }

    #[inline(always)]
    pub(super) fn values<T: Number>(&self, x: &[T], values: &mut [T]) {
        let radii = self.radii(x);
        let mut at = 0;
        for LevelStep { polynomials, kinks } in &self.steps {
            let end = at + polynomials.len();
            polynomials.values(x, &mut values[at..end]);
            at = end;
            for radius in &radii {
                for kink in kinks {
                    values[at] = radius.value(kink);
                    at += 1;
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn sum<T: Number>(&self, x: &[T], mut a: &[f64]) -> T {
        let radii = self.radii(x);
        let mut sum = T::everywhere(0.0);
        for LevelStep { polynomials, kinks } in &self.steps {
            sum = polynomials.added(sum, x, a);
            a = &a[polynomials.len().min(a.len())..];
            for radius in &radii {
                for (kink, &a) in kinks.iter().zip(a) {
                    sum += radius.value(kink) * a;
                }
                a = &a[kinks.len().min(a.len())..];
            }
        }
        sum
    }

    #[inline(always)]
    pub(super) fn rates<T: Number>(&self, x: &[T], local: (&[T], &[T]), values: &mut [T], rates: &mut [T]) {
        let radii = self.radii(x);
        let mut at = 0;
        for LevelStep { polynomials, kinks } in &self.steps {
            let end = at + polynomials.len();
            polynomials.rates(x, local, &mut values[at..end], &mut rates[at..end]);
            at = end;
            for (radius, corner) in radii.iter().zip(&self.corners) {
                for kink in kinks {
                    let jet = corner.turned(radius.jet(kink));
                    values[at] = jet.value;
                    rates[at] = generator(local, &jet.gradient, jet.hessian.as_flattened());
                    at += 1;
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn combine<T: Number>(&self, x: &[T], a: &[f64], sum: &mut Jet<T>) {
        let radii = self.radii(x);
        let mut at = 0;
        for LevelStep { polynomials, kinks } in &self.steps {
            let end = at + polynomials.len();
            polynomials.combine(x, &a[at..end], sum);
            at = end;
            for (radius, corner) in radii.iter().zip(&self.corners) {
                for kink in kinks {
                    sum.add(a[at], &corner.turned(radius.jet(kink)));
                    at += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::problem::Wall;

    const LEVELS: [WallLevel; 3] = [
        WallLevel { degree: 4, kinks: 3, depth: 3, angular: 5 },
        WallLevel { degree: 6, kinks: 3, depth: 3, angular: 7 },
        WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7 },
    ];

    fn functions(corners: Vec<Corner>) -> WallFunctions {
        WallFunctions::new(corners, &[1.0, 0.0], &[1.5, 4.0], &LEVELS)
    }

    fn lower() -> Corner {
        Corner::new(Wall::above(-0.5, 0.7).unwrap(), vec![1], 0.2, [3.0, 4.0])
    }

    fn upper() -> Corner {
        Corner::new(Wall::below(2.5, 0.9).unwrap(), vec![1], 0.2, [3.0, 4.0])
    }

    #[test]
    fn levels_are_nested_and_counted() {
        let counts = |corners: &[Corner]| {
            [1, 2, 3]
                .map(|steps| WallFunctions::new(corners.to_vec(), &[1.0, 0.0], &[1.5, 4.0], &LEVELS[..steps]).len())
        };
        assert_eq!(counts(&[lower()]), [36, 55, 83]);
        assert_eq!(counts(&[lower(), upper()]), [58, 83, 122]);
        let (all, first) =
            (functions(vec![lower()]), WallFunctions::new(vec![lower()], &[1.0, 0.0], &[1.5, 4.0], &LEVELS[..1]));
        let (mut long, mut short) = ([0.0; 83], [0.0; 36]);
        all.values(&[0.3, 1.2], &mut long);
        first.values(&[0.3, 1.2], &mut short);
        assert_eq!(long[..36], short);
    }

    /// Values, rates and combinations agree, and are those of the differences. Their error is the step squared, 1e-8,
    /// times derivatives of the third and fourth order, which are large near the corner: 1e4 of the functions' size.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let functions = functions(vec![lower(), upper()]);
        let count = functions.len();
        let h = 1e-4;
        let at = |x: [f64; 2]| {
            let mut values = vec![0.0; count];
            functions.values(&x, &mut values);
            values
        };
        let points = [[0.4, 1.1], [-0.2, -0.7], [2.2, 0.9], [1.0, 0.0], [-0.45, -1.0]];
        for x in points {
            let local: (&[f64], &[f64]) = (&[x[1], 0.7], &[0.3, 0.1, 0.1, 0.8]);
            let (mut values, mut rates) = (vec![0.0; count], vec![0.0; count]);
            functions.rates(&x, local, &mut values, &mut rates);
            let moved = |p: f64, q: f64| at([x[0] + p * h, x[1] + q * h]);
            let [here, e, w, n, s] =
                [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(p, q)| moved(p, q));
            let [ne, sw, nw, se] = [(1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)].map(|(p, q)| moved(p, q));
            for k in 0..count {
                assert!((here[k] - values[k]).abs() < 1e-14 * (1.0 + here[k].abs()), "{k}");
                let mut a = vec![0.0; count];
                a[k] = 1.0;
                let mut jet = Jet::zero(2);
                functions.combine(&x, &a, &mut jet);
                assert!((functions.sum(&x, &a) - jet.value).abs() < 1e-14 * (1.0 + jet.value.abs()), "{k}");
                assert!(
                    (generator(local, &jet.gradient, &jet.hessian) - rates[k]).abs() < 1e-12 * (1.0 + rates[k].abs()),
                    "{k}"
                );
                let slopes = [(e[k] - w[k]) / (2.0 * h), (n[k] - s[k]) / (2.0 * h)];
                let bends = [(e[k] + w[k] - 2.0 * here[k]) / (h * h), (n[k] + s[k] - 2.0 * here[k]) / (h * h)];
                let mixed = (ne[k] + sw[k] - nw[k] - se[k]) / (4.0 * h * h);
                let close = |exact: f64, difference: f64| (exact - difference).abs() < 2e-4 * (1.0 + exact.abs());
                assert!((0..2).all(|i| close(jet.gradient[i], slopes[i])), "{x:?} {k} {jet:?} {slopes:?}");
                assert!((0..2).all(|i| close(jet.hessian[3 * i], bends[i])), "{x:?} {k} {jet:?} {bends:?}");
                assert!(close(jet.hessian[1], mixed) && jet.hessian[1] == jet.hessian[2], "{x:?} {k}");
            }
        }
    }

    #[test]
    fn the_corner_itself_is_finite() {
        let functions = functions(vec![lower()]);
        let mut values = vec![0.0; functions.len()];
        functions.values(&[-0.5, 0.0], &mut values);
        assert!(values.iter().all(|value| value.is_finite()));
        assert!(functions.sum(&[-0.5, 0.0], &vec![1.0; functions.len()]).is_finite());
    }
}

//! Ladders of functions next to walls.

use super::corner::Kink;
use super::degrees::Degrees;
use super::functions::{Block, Functions};
use super::{Corner, Polynomials};

/// How many functions of each kind, with A = (w⁶ + (κu)²)^{1/6}, which grows like |w| and u^{1/3}, and z the states beside the gap u and
/// its rate w.
///
/// Near (0, 0) p is a sum of functions of w/u^{1/3} times powers of A, of which polynomials contain only a few.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::closure) struct WallLevel {
    /// Polynomials of total degree 1 to this.
    pub(in crate::closure) degree: u32,
    /// Kinks A u^i w^j z^a with i + j + |a| up to this.
    pub(in crate::closure) kinks: u32,
    /// Angular functions A^{d−j} wʲ z^a with d from 1 to this,
    pub(in crate::closure) depth: u32,
    /// j from 0 to this,
    pub(in crate::closure) angular: u32,
    /// and |a| up to d and to this.
    pub(in crate::closure) others: u32,
}

impl WallLevel {
    fn kinks(&self) -> impl Iterator<Item = Kink> + use<> {
        let WallLevel { kinks, depth, angular, .. } = *self;
        let lines = (0..=kinks as i32).flat_map(|total| (0..=total).map(move |j| Kink([1, total - j, j])));
        let angles = (1..=depth as i32).flat_map(move |d| (0..=angular as i32).map(move |j| (d - j, j)));
        // Powers 0 and 1 are a polynomial and a kink.
        let angles = angles.filter(|(power, _)| !(0..=1).contains(power)).map(|(power, j)| Kink([power, 0, j]));
        lines.chain(angles)
    }

    /// The kinks at a wall, each with the exponents of the other states that it is multiplied by.
    fn kinks_at(&self, corner: &Corner, states: usize) -> Vec<(Kink, Vec<Vec<u32>>)> {
        let [gap, rate] = corner.forms();
        let beside = |alpha: &[u32]| alpha[gap.first] == 0 && alpha[rate.first] == 0;
        let others = |degree: i32| -> Vec<Vec<u32>> {
            let constant = std::iter::once(vec![0; states]);
            constant.chain(Degrees::complete().exponents(states, degree.max(0) as u32, beside)).collect()
        };
        let with_others = |kink: Kink| {
            let (Kink([power, i, j]), kinks) = (kink, self.kinks as i32);
            let degree = if power == 1 && i + j <= kinks { kinks - i - j } else { (power + j).min(self.others as i32) };
            (kink, others(degree))
        };
        self.kinks().map(with_others).collect()
    }
}

impl Functions {
    /// The functions of a ladder of levels, each after those of the ones below it; polynomials are scaled to the box
    /// `centre` ± `half_width`, and `polynomials` lists the exponents of those alone up to a degree.
    pub(in crate::closure) fn next_to_walls(
        corners: Vec<Corner>,
        (centre, half_width): (&[f64], &[f64]),
        ladder: &[WallLevel],
        polynomials: impl Fn(u32) -> Vec<Vec<u32>>,
    ) -> Self {
        let states = centre.len();
        let scaled = |exponents| Polynomials::new(centre.to_vec(), half_width.to_vec(), exponents);
        let mut blocks: Vec<Block> = Vec::new();
        // The exponents of a list that no block below has beside the same kink, or beside none.
        let new = |blocks: &[Block], kink: Option<(usize, Kink)>, mut exponents: Vec<Vec<u32>>| {
            let same = blocks.iter().filter(|block| block.each().any(|own| own == kink));
            let known: Vec<&Vec<u32>> = same.flat_map(|block| block.factors.exponents()).collect();
            exponents.retain(|alpha| !known.contains(&alpha));
            exponents
        };
        for level in ladder {
            let mut added = vec![Block { kinks: None, factors: scaled(new(&blocks, None, polynomials(level.degree))) }];
            // Where no noise ends a grazing impact it leaves no singularity of this kind.
            let noisy = |(_, corner): &(usize, &Corner)| corner.intensity() > 0.0;
            for (wall, corner) in corners.iter().enumerate().filter(noisy) {
                for (kink, exponents) in level.kinks_at(corner, states) {
                    let new = new(&blocks, Some((wall, kink)), exponents);
                    match added.last_mut() {
                        _ if new.is_empty() => {}
                        Some(Block { kinks: Some((last, kinks)), factors })
                            if *last == wall && factors.exponents() == new =>
                        {
                            kinks.push(kink);
                        }
                        _ => added.push(Block { kinks: Some((wall, vec![kink])), factors: scaled(new) }),
                    }
                }
            }
            blocks.extend(added);
        }
        Functions::of(corners, blocks)
    }

    /// The same in a plane, with all polynomials.
    pub(in crate::closure) fn in_a_plane(corners: Vec<Corner>, sides: (&[f64], &[f64]), ladder: &[WallLevel]) -> Self {
        Functions::next_to_walls(corners, sides, ladder, |degree| Degrees::complete().exponents(2, degree, |_| true))
    }
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::closure::space::Jet;
    use crate::fokker_planck::generator;
    use crate::problem::Wall;

    const LEVELS: [WallLevel; 3] = [
        WallLevel { degree: 4, kinks: 3, depth: 3, angular: 5, others: 0 },
        WallLevel { degree: 6, kinks: 3, depth: 3, angular: 7, others: 0 },
        WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7, others: 0 },
    ];

    fn of_levels(corners: Vec<Corner>, levels: &[WallLevel]) -> Functions {
        Functions::in_a_plane(corners, (&[1.0, 0.0], &[1.5, 4.0]), levels)
    }

    fn functions(corners: Vec<Corner>) -> Functions {
        of_levels(corners, &LEVELS)
    }

    fn lower() -> Corner {
        Corner::new(Wall::above(-0.5, 0.7).unwrap(), vec![1], 0.2, [3.0, 4.0])
    }

    fn upper() -> Corner {
        Corner::new(Wall::below(2.5, 0.9).unwrap(), vec![1], 0.2, [3.0, 4.0])
    }

    #[test]
    fn levels_are_nested_and_counted() {
        let counts = |corners: &[Corner]| [1, 2, 3].map(|steps| of_levels(corners.to_vec(), &LEVELS[..steps]).len());
        assert_eq!(counts(&[lower()]), [36, 55, 83]);
        assert_eq!(counts(&[lower(), upper()]), [58, 83, 122]);
        let (all, first) = (functions(vec![lower()]), of_levels(vec![lower()], &LEVELS[..1]));
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
    fn a_list_without_functions_is_refused() {
        assert!(Functions::of(Vec::new(), Vec::new()).checked(2).is_err());
    }

    #[test]
    fn the_corner_itself_is_finite() {
        let functions = functions(vec![lower()]);
        let mut values = vec![0.0; functions.len()];
        functions.values(&[-0.5, 0.0], &mut values);
        assert!(values.iter().all(|value| value.is_finite()));
        assert!(functions.sum(&[-0.5, 0.0], &vec![1.0; functions.len()]).is_finite());
    }

    /// Four states (x, y, u, v), a wall below x and one between the bodies, which have the velocities u and v.
    pub(in crate::closure::space) fn functions_of_four() -> Functions {
        let between = Wall::below(1.5, 0.7).unwrap().between([0, 1], [1.0, 2.0]).unwrap();
        let corners = vec![
            Corner::new(Wall::above(-0.5, 0.8).unwrap(), vec![2], 0.2, [3.0, 4.0]),
            Corner::new(between, vec![2, 3], 0.3, [2.5, 5.0]),
        ];
        let level = |degree, kinks, angular, others| WallLevel { degree, kinks, depth: 2, angular, others };
        let polynomials = |degree| Degrees::complete().exponents(4, degree, |_| true);
        let sides: (&[f64], &[f64]) = (&[0.5, 0.1, 0.0, 0.2], &[2.0, 2.5, 4.0, 3.0]);
        Functions::next_to_walls(corners, sides, &[level(2, 1, 3, 1), level(4, 2, 4, 2)], polynomials)
    }

    pub(in crate::closure::space) const POINTS: [[f64; 4]; 3] =
        [[0.4, -0.3, 1.1, -0.8], [-0.3, 0.2, -0.7, 0.5], [1.2, 0.1, 0.6, 1.3]];

    /// Kinks A u^i w^j z^a of a total degree up to m in the gap, its rate and two more states: C(m + 4, 4); of the angular
    /// functions with d = 1, 2 those with j = 0 … J but d and d − 1, and 3 or 6 polynomials of the other two states.
    #[test]
    fn levels_of_four_states_are_nested_and_counted() {
        let functions = functions_of_four();
        let [first, second] = [(14, 5 + 2 * 2 * 3), (69, 15 + 3 * 3 + 3 * 6)].map(|(p, kinks)| p + 2 * kinks);
        assert_eq!(functions.len(), second);
        let polynomials: Vec<(usize, &[u32])> = functions.powers();
        assert_eq!((polynomials.len(), polynomials[14].0), (69, first));
        assert_eq!(functions.dimension(), 4);
    }

    /// Rates and combinations agree, and gradients are those of the differences, whose error is the step squared times third
    /// derivatives.
    #[test]
    fn derivatives_in_four_states_are_those_of_the_values() {
        let functions = functions_of_four();
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

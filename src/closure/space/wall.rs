//! Ladders of functions next to walls.

use super::degrees::Degrees;
use crate::functions::{Block, Corner, Functions, Kink, Polynomials};

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
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::functions::Scratch;
    use crate::numerics::differences;
    use crate::walls::Wall;

    const STEP: f64 = 3e-4;
    const LEVELS: [WallLevel; 3] = [
        WallLevel { degree: 4, kinks: 3, depth: 3, angular: 5, others: 0 },
        WallLevel { degree: 6, kinks: 3, depth: 3, angular: 7, others: 0 },
        WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7, others: 0 },
    ];

    fn of_levels(corners: Vec<Corner>, levels: &[WallLevel]) -> Functions {
        Functions::in_a_plane(corners, (&[1.0, 0.0], &[1.5, 4.0]), levels)
    }

    fn lower() -> Corner {
        Corner::new(Wall::above(-0.5, 0.7).unwrap(), vec![1], 0.2, [3.0, 4.0])
    }

    fn upper() -> Corner {
        Corner::new(Wall::below(2.5, 0.9).unwrap(), vec![1], 0.2, [3.0, 4.0])
    }

    /// The constant and the functions at a state.
    fn values(functions: &Functions, x: &[f64]) -> Vec<f64> {
        let mut scratch = Scratch::default();
        functions.place_values(x, &mut scratch);
        (0..=functions.len()).map(|k| functions.value(&scratch, k)).collect()
    }

    #[test]
    fn levels_are_nested_and_counted() {
        let counts = |corners: &[Corner]| [1, 2, 3].map(|steps| of_levels(corners.to_vec(), &LEVELS[..steps]).len());
        assert_eq!(counts(&[lower()]), [36, 55, 83]);
        assert_eq!(counts(&[lower(), upper()]), [58, 83, 122]);
        let [all, first] = [3, 1].map(|steps| values(&of_levels(vec![lower()], &LEVELS[..steps]), &[0.3, 1.2]));
        assert_eq!(all[..37], first);
    }

    /// Four states (x, y, u, v), a wall below x and one between the bodies, which have the velocities u and v.
    fn functions_of_four() -> Functions {
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

    /// Gradients and images are those of differences, which are off by the fourth power of the step, 1e-14, times derivatives of the
    /// fifth and the sixth order, some hundred near a corner, and by the rounding of a value, 1e-16, over the step, 3e-13, or its
    /// square, 1e-9. Measured are 3e-12 and 1.4e-9.
    fn assert_derivatives<const N: usize>(
        functions: &Functions,
        points: &[[f64; N]],
        drift: [f64; N],
        b: &[[f64; N]; N],
    ) {
        let coupled: Vec<usize> = (0..N).filter(|&i| (0..N).any(|j| j != i && b[i][j] != 0.0)).collect();
        for x in points {
            let (here, found) = (values(functions, x), differences(|x| values(functions, x), x, STEP));
            let mut scratch = Scratch::default();
            functions.place(x, &mut scratch);
            functions.apply((&drift, b.as_flattened()), &coupled, &mut scratch);
            let images: Vec<f64> = (0..here.len()).map(|k| functions.image(&scratch, k)).collect();
            for (k, (slopes, bends)) in found.iter().enumerate().skip(1) {
                let bent = b.as_flattened().iter().zip(bends).map(|(b, bend)| 0.5 * b * bend).sum::<f64>();
                let image = drift.iter().zip(slopes).map(|(f, slope)| f * slope).sum::<f64>() + bent;
                let size = 1.0 + bends.iter().chain(slopes).fold(here[k].abs(), |most, d| most.max(d.abs()));
                let mut a = vec![0.0; functions.len()];
                a[k - 1] = 1.0;
                functions.gradient(&a, &mut scratch);
                let off = scratch.gradient.iter().zip(slopes).map(|(own, slope)| (own - slope).abs());
                let off = off.fold(0.0, f64::max);
                assert!((images[k] - image).abs() < 5e-9 * size, "{x:?} {k}: {} and {image}", images[k]);
                assert!(off < 1e-11 * size, "{x:?} {k}: {off:e}");
                assert!((functions.sum(&a, &scratch) - here[k]).abs() < 1e-14 * (1.0 + here[k].abs()), "{x:?} {k}");
            }
        }
    }

    /// The noises of two bodies are correlated, or not: a kink between them has the velocities of both.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let plane = of_levels(vec![lower(), upper()], &LEVELS);
        let points = [[0.4, 1.1], [-0.2, -0.7], [2.2, 0.9], [1.0, 0.0], [-0.45, -1.0]];
        assert_derivatives(&plane, &points, [1.1, 0.7], &[[0.3, 0.1], [0.1, 0.8]]);
        let points = [[0.4, -0.3, 1.1, -0.8], [-0.3, 0.2, -0.7, 0.5], [1.2, 0.1, 0.6, 1.3]];
        for mixed in [0.2, 0.0] {
            let b = [[0.0; 4], [0.0; 4], [0.0, 0.0, 0.5, mixed], [0.0, 0.0, mixed, 0.7]];
            assert_derivatives(&functions_of_four(), &points, [1.1, -0.8, 0.3, -0.6], &b);
        }
    }

    #[test]
    fn a_list_without_functions_is_refused() {
        assert!(Functions::of(Vec::new(), Vec::new()).checked(2).is_err());
    }

    #[test]
    fn the_corner_itself_is_finite() {
        let functions = of_levels(vec![lower()], &LEVELS);
        assert!(values(&functions, &[-0.5, 0.0]).iter().all(|value| value.is_finite()));
    }
}

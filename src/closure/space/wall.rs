use super::kink::{Kink, Radius};
use super::{Corner, Jet, Local, Polynomials, Space, SpaceRecord, StepRecord};

/// How many functions of each kind, with A = (w⁶ + (κu)²)^{1/6}, which grows like |w| and u^{1/3}.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::closure) struct WallLevel {
    /// Polynomials of total degree 1 to this.
    pub(in crate::closure) degree: u32,
    /// Kinks A u^i w^j with i + j up to this.
    pub(in crate::closure) kinks: u32,
    /// Angular functions A^{d−j} wʲ with d from 1 to this,
    pub(in crate::closure) depth: u32,
    /// and j from 0 to this.
    pub(in crate::closure) angular: u32,
}

/// Functions for ln p next to walls: polynomials, and at each wall functions with the singularity of grazing impacts.
///
/// Near (0, 0) p is a sum of functions of w/u^{1/3} times powers of A, of which polynomials know only a few. A ladder
/// of levels makes one list in which the functions of each level come before those that the next one adds.
#[derive(Clone, Debug)]
pub(in crate::closure) struct WallFunctions {
    corners: Vec<Corner>,
    additions: Vec<Addition>,
}

/// What one level adds to those below it.
#[derive(Clone, Debug)]
struct Addition {
    polynomials: Polynomials<2>,
    /// The same at each corner.
    kinks: Vec<Kink>,
}

impl WallLevel {
    fn exponents(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        (1..=self.degree).flat_map(|total| (0..=total).map(move |j| [total - j, j]))
    }

    fn kinks(&self) -> impl Iterator<Item = Kink> + use<> {
        let WallLevel { kinks, depth, angular, .. } = *self;
        let lines = (0..=kinks as i32).flat_map(|total| (0..=total).map(move |j| Kink { power: 1, i: total - j, j }));
        let angles = (1..=depth as i32).flat_map(move |d| (0..=angular as i32).map(move |j| (d - j, j)));
        // Powers 0 and 1 are a polynomial and a kink.
        let angles = angles.filter(|(power, _)| !(0..=1).contains(power)).map(|(power, j)| Kink { power, i: 0, j });
        lines.chain(angles)
    }
}

impl WallFunctions {
    /// The functions of a record whose numbers have been checked.
    pub(super) fn of_steps(corners: Vec<Corner>, steps: Vec<(Polynomials<2>, Vec<[i32; 3]>)>) -> Self {
        let addition = |(polynomials, kinks): (Polynomials<2>, Vec<[i32; 3]>)| {
            let kinks = kinks.into_iter().map(|[power, i, j]| Kink { power, i, j }).collect();
            Addition { polynomials, kinks }
        };
        WallFunctions { corners, additions: steps.into_iter().map(addition).collect() }
    }

    /// The functions of a ladder of levels; polynomials are scaled to the box `centre` ± `half_width` of the states.
    pub(in crate::closure) fn new(
        corners: Vec<Corner>,
        centre: [f64; 2],
        half_width: [f64; 2],
        ladder: &[WallLevel],
    ) -> Self {
        let mut additions = Vec::new();
        for (step, level) in ladder.iter().enumerate() {
            let below = &ladder[..step];
            let new = |alpha: &[u32; 2]| below.iter().all(|level| alpha[0] + alpha[1] > level.degree);
            let exponents = level.exponents().filter(new).collect();
            let kinks = level.kinks().filter(|kink| below.iter().all(|level| level.kinks().all(|k| k != *kink)));
            let polynomials = Polynomials::new(centre, half_width, exponents);
            additions.push(Addition { polynomials, kinks: kinks.collect() });
        }
        WallFunctions { corners, additions }
    }

    fn added(&self, addition: &Addition) -> usize {
        addition.polynomials.len() + self.corners.len() * addition.kinks.len()
    }

    /// A at each corner.
    fn radii(&self, x: &[f64; 2]) -> Vec<Radius> {
        self.corners.iter().map(|corner| Radius::new(corner, x)).collect()
    }
}

impl Space<2> for WallFunctions {
    fn record(&self) -> SpaceRecord {
        let step = |addition: &Addition| StepRecord {
            kinks: addition.kinks.iter().map(|kink| [kink.power, kink.i, kink.j]).collect(),
            ..addition.polynomials.step()
        };
        SpaceRecord {
            corners: self.corners.iter().map(Corner::record).collect(),
            steps: self.additions.iter().map(step).collect(),
        }
    }

    fn len(&self) -> usize {
        self.additions.iter().map(|addition| self.added(addition)).sum()
    }

    fn values(&self, x: &[f64; 2], values: &mut [f64]) {
        let radii = self.radii(x);
        let mut rest = values;
        for Addition { polynomials, kinks } in &self.additions {
            let (smooth, after) = rest.split_at_mut(polynomials.len());
            polynomials.values(x, smooth);
            let (singular, after) = after.split_at_mut(radii.len() * kinks.len());
            let pairs = radii.iter().flat_map(|radius| kinks.iter().map(move |kink| radius.value(kink)));
            singular.iter_mut().zip(pairs).for_each(|(value, kink)| *value = kink);
            rest = after;
        }
    }

    fn rates(&self, x: &[f64; 2], local: &Local<2>, values: &mut [f64], rates: &mut [f64]) {
        let radii = self.radii(x);
        let mut at = 0;
        for Addition { polynomials, kinks } in &self.additions {
            let end = at + polynomials.len();
            polynomials.rates(x, local, &mut values[at..end], &mut rates[at..end]);
            at = end;
            for (radius, corner) in radii.iter().zip(&self.corners) {
                for kink in kinks {
                    let jet = corner.turned(radius.jet(kink));
                    (values[at], rates[at]) = (jet.value, local.generator(&jet));
                    at += 1;
                }
            }
        }
    }

    fn combination(&self, x: &[f64; 2], a: &[f64]) -> Jet<2> {
        let radii = self.radii(x);
        let mut sum = Jet::ZERO;
        let mut at = 0;
        for Addition { polynomials, kinks } in &self.additions {
            let end = at + polynomials.len();
            sum.add(1.0, &polynomials.combination(x, &a[at..end]));
            at = end;
            for (radius, corner) in radii.iter().zip(&self.corners) {
                for kink in kinks {
                    sum.add(a[at], &corner.turned(radius.jet(kink)));
                    at += 1;
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LADDER: [WallLevel; 3] = [
        WallLevel { degree: 4, kinks: 3, depth: 3, angular: 5 },
        WallLevel { degree: 6, kinks: 3, depth: 3, angular: 7 },
        WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7 },
    ];

    fn functions(corners: Vec<Corner>) -> WallFunctions {
        WallFunctions::new(corners, [1.0, 0.0], [1.5, 4.0], &LADDER)
    }

    fn floor() -> Corner {
        Corner::floor(-0.5, 0.7, 0.2, [3.0, 4.0])
    }

    fn ceiling() -> Corner {
        Corner::ceiling(2.5, 0.9, 0.2, [3.0, 4.0])
    }

    #[test]
    fn levels_are_nested_and_counted() {
        let counts = |corners: &[Corner]| {
            [1, 2, 3].map(|steps| WallFunctions::new(corners.to_vec(), [1.0, 0.0], [1.5, 4.0], &LADDER[..steps]).len())
        };
        assert_eq!(counts(&[floor()]), [36, 55, 83]);
        assert_eq!(counts(&[floor(), ceiling()]), [58, 83, 122]);
        let (all, first) =
            (functions(vec![floor()]), WallFunctions::new(vec![floor()], [1.0, 0.0], [1.5, 4.0], &LADDER[..1]));
        let (mut long, mut short) = ([0.0; 83], [0.0; 36]);
        all.values(&[0.3, 1.2], &mut long);
        first.values(&[0.3, 1.2], &mut short);
        assert_eq!(long[..36], short);
    }

    /// Values, rates and combinations agree, and are those of the differences. Their error is the step squared, 1e-8,
    /// times derivatives of the third and fourth order, which are large near the corner: 1e4 of the functions' size.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let functions = functions(vec![floor(), ceiling()]);
        let count = functions.len();
        let h = 1e-4;
        let at = |x: [f64; 2]| {
            let mut values = vec![0.0; count];
            functions.values(&x, &mut values);
            values
        };
        let points = [[0.4, 1.1], [-0.2, -0.7], [2.2, 0.9], [1.0, 0.0], [-0.45, -1.0]];
        for x in points {
            let local = Local { drift: [x[1], 0.7], diffusion: [[0.3, 0.1], [0.1, 0.8]] };
            let (mut values, mut rates) = (vec![0.0; count], vec![0.0; count]);
            functions.rates(&x, &local, &mut values, &mut rates);
            let moved = |p: f64, q: f64| at([x[0] + p * h, x[1] + q * h]);
            let [here, e, w, n, s] =
                [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(p, q)| moved(p, q));
            let [ne, sw, nw, se] = [(1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)].map(|(p, q)| moved(p, q));
            for k in 0..count {
                assert!((here[k] - values[k]).abs() < 1e-14 * (1.0 + here[k].abs()), "{k}");
                let mut a = vec![0.0; count];
                a[k] = 1.0;
                let jet = functions.combination(&x, &a);
                assert!((local.generator(&jet) - rates[k]).abs() < 1e-12 * (1.0 + rates[k].abs()), "{k}");
                let slopes = [(e[k] - w[k]) / (2.0 * h), (n[k] - s[k]) / (2.0 * h)];
                let bends = [(e[k] + w[k] - 2.0 * here[k]) / (h * h), (n[k] + s[k] - 2.0 * here[k]) / (h * h)];
                let mixed = (ne[k] + sw[k] - nw[k] - se[k]) / (4.0 * h * h);
                let close = |exact: f64, difference: f64| (exact - difference).abs() < 2e-4 * (1.0 + exact.abs());
                assert!((0..2).all(|i| close(jet.gradient[i], slopes[i])), "{x:?} {k} {jet:?} {slopes:?}");
                assert!((0..2).all(|i| close(jet.hessian[i][i], bends[i])), "{x:?} {k} {jet:?} {bends:?}");
                assert!(close(jet.hessian[0][1], mixed) && jet.hessian[0][1] == jet.hessian[1][0], "{x:?} {k}");
            }
        }
    }

    #[test]
    fn the_corner_itself_is_finite() {
        let functions = functions(vec![floor()]);
        let mut values = vec![0.0; functions.len()];
        functions.values(&[-0.5, 0.0], &mut values);
        assert!(values.iter().all(|value| value.is_finite()));
        assert!(functions.combination(&[-0.5, 0.0], &vec![1.0; functions.len()]).value.is_finite());
    }
}

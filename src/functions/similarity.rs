use super::PlaneJet;
use num_dual::DualNum;
use std::f64::consts::PI;

/// Points of the table per unit of z, on either side of 0.
pub(crate) const PER_UNIT: usize = 16;
pub(crate) const STEPS: usize = 60;
/// |z| where the table ends: there the terms of the asymptotic series fall to e^(−z³) = 1e-23 before they grow.
const EDGE: f64 = STEPS as f64 / PER_UNIT as f64;
/// Terms of a Taylor series, used up to one step away: the last one is below 1e-18 of the first.
pub(crate) const TAYLOR: usize = 20;
/// Those used up to half a step away, with the same last one.
const NEAREST: usize = 16;
/// Terms of the asymptotic series: the last one is below 1e-17 of the first from the edge on.
const ASYMPTOTIC: usize = 24;
/// A smaller velocity counts as 0, so that no power of it underflows.
pub(crate) const CLOSEST: f64 = 1e-90;

/// The exponent g(r) of p ~ u^g at grazing impacts: the root nearest 0 of r^{−(2+3g)} = 2 sin(π(1/6 − g)).
///
/// It falls from 0 at r = 1 to −2/3 at r = e^{−π/√3} ≈ .163. There it meets the other root, and below there is none.
fn grazing_exponent(r: f64) -> Option<f64> {
    if r <= (-PI / 3.0_f64.sqrt()).exp() || r > 1.0 {
        return None;
    }
    if r == 1.0 {
        return Some(0.0);
    }
    // The difference of the sides is convex and positive at 0: Newton's method comes down to the root and not past it.
    let mut g = 0.0;
    for _ in 0..100 {
        let (power, angle) = (r.powf(-(2.0 + 3.0 * g)), PI * (1.0 / 6.0 - g));
        let step = (power - 2.0 * angle.sin()) / (-3.0 * r.ln() * power + 2.0 * PI * angle.cos());
        g -= step;
        if step.abs() < 1e-16 {
            break;
        }
    }
    Some(g)
}

/// The same with its derivative, by the function whose root it is: a step of Newton's method with the slope at the root.
fn exponent_of<T: DualNum<Primitive = f64> + Copy>(r: T) -> Option<T> {
    let root = grazing_exponent(r.re())?;
    let sides = |g: T| [(r.ln() * -(g * 3.0 + 2.0)).exp(), (-g + 1.0 / 6.0) * PI];
    let [power, angle] = sides(T::from(root)).map(|side| side.re());
    let (slope, rest) = (-3.0 * r.re().ln() * power + 2.0 * PI * angle.cos(), power - 2.0 * angle.sin());
    let [moved, turned] = sides(T::from(root));
    Some(T::from(root) - (moved - turned.sin() * 2.0 - rest) / slope)
}

/// The similarity solution of grazing impacts, S(u, w) = ln p for w p_u = D p_ww and p(0, w) = r⁻² p(0, −w/r).
///
/// Near u = w = 0 only diffusion and the wall matter, and the density is p = u^g k(z) with z = −w/(9Du)^{1/3} and
///
/// k″ = 3z² k′ − 9g z k,
///
/// which is Tricomi's U(−g, 2/3, z³) for z > 0, continued through 0. At u = 0 S is finite except at w = 0. With dual numbers for r
/// and D it has its derivatives by them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Similarity<T = f64> {
    pub(crate) exponent: T,
    /// 9D.
    pub(crate) scale: T,
    /// ln k and k′/k at the table's points, from −EDGE up.
    pub(crate) table: Vec<[T; 2]>,
    /// The Taylor coefficients of k/k(z) there.
    series: Vec<[T; NEAREST]>,
    /// The coefficients (−g)_n (1/3 − g)_n/n! of the asymptotic series in −z⁻³.
    pub(crate) expansion: [T; ASYMPTOTIC],
    /// The limits of ln k − 3g ln|z| for z → −∞ and z → ∞.
    pub(crate) limits: [T; 2],
}

impl Similarity {
    /// S at the distance `u` from the wall and the velocity `w` away from it, with its derivatives in (u, w).
    pub(super) fn at(&self, u: f64, w: f64) -> PlaneJet<f64> {
        if self.exponent == 0.0 { PlaneJet::ZERO } else { self.jet(u, w) }
    }
}

impl<T: DualNum<Primitive = f64> + Copy> Similarity<T> {
    /// The solution for a restitution `r` and noise of intensity `intensity` on the velocity, if there is one.
    pub(super) fn new(r: T, intensity: T) -> Option<Self> {
        let exponent = exponent_of(r)?;
        let mut expansion = [T::from(1.0); ASYMPTOTIC];
        for n in 1..ASYMPTOTIC {
            let before = -exponent + (n - 1) as f64;
            expansion[n] = expansion[n - 1] * before * (before + 1.0 / 3.0) / n as f64;
        }
        // The wall's condition is the ratio of the two limits.
        let limits = [-(exponent * 3.0 + 2.0) * r.ln(), T::from(0.0)];
        let table = vec![[T::from(0.0); 2]; 2 * STEPS + 1];
        let mut similarity =
            Similarity { exponent, scale: intensity * 9.0, table, series: Vec::new(), expansion, limits };
        // From z = ∞ downwards every other solution decays faster, so that errors die out; below 0 all but one do.
        similarity.table[2 * STEPS] = similarity.outer(EDGE);
        for i in (0..2 * STEPS).rev() {
            let [log, slope] = similarity.table[i + 1];
            let coefficients: [T; TAYLOR] = similarity.coefficients(point(i + 1), slope);
            let [change, slope, _] = log_of_series(&coefficients, T::from(-1.0 / PER_UNIT as f64));
            similarity.table[i] = [log + change, slope];
        }
        let slopes = similarity.table.iter().enumerate();
        similarity.series = slopes.map(|(i, [_, slope])| similarity.coefficients(point(i), *slope)).collect();
        Some(similarity)
    }

    /// S with its derivatives in (u, w), also where it vanishes and its derivatives by r do not.
    pub(super) fn jet(&self, u: f64, w: f64) -> PlaneJet<T> {
        // At the singular point itself a large value, not an infinite one.
        let u = if w.abs() < CLOSEST { u.max(f64::MIN_POSITIVE) } else { u.max(0.0) };
        if w.abs().powi(3) > EDGE.powi(3) * self.scale.re() * u { self.far(u, w) } else { self.near(u, w) }
    }

    /// S where ln k comes from the table.
    fn near(&self, u: f64, w: f64) -> PlaneJet<T> {
        let (g, length) = (self.exponent, (self.scale * u).cbrt());
        let z = -(length.recip() * w);
        let nearest = ((z.re() + EDGE) * PER_UNIT as f64).round().clamp(0.0, 2.0 * STEPS as f64) as usize;
        let [change, slope, bend] = log_of_series(&self.series[nearest], z - point(nearest));
        let log = self.table[nearest][0] + change;
        let (z_u, z_w) = (-z / (3.0 * u), -length.recip());
        let mixed = bend * z_u * z_w + slope / (length * (3.0 * u));
        PlaneJet {
            value: g * u.ln() + log,
            gradient: [g / u + slope * z_u, slope * z_w],
            hessian: [
                [-g / (u * u) + bend * z_u * z_u + slope * z * 4.0 / (9.0 * u * u), mixed],
                [mixed, bend * z_w * z_w],
            ],
        }
    }

    /// S where the asymptotic series serves: written in w and x = 9Du/|w|³, it has no singular term at u = 0.
    fn far(&self, u: f64, w: f64) -> PlaneJet<T> {
        let g = self.exponent;
        let unit = self.scale / w.abs().powi(3);
        let (x, limit) = (unit * u, self.limits[usize::from(w < 0.0)]);
        let [log, slope, bend] = self.asymptotic(x, -w);
        let (x_w, x_ww) = (x * -3.0 / w, x * 12.0 / (w * w));
        let mixed = bend * unit * x_w - slope * unit * 3.0 / w;
        PlaneJet {
            value: -g * unit.ln() + limit + log,
            gradient: [slope * unit, g * 3.0 / w + slope * x_w],
            hessian: [[bend * unit * unit, mixed], [mixed, g * -3.0 / (w * w) + bend * x_w * x_w + slope * x_ww]],
        }
    }

    /// ln k and its derivative in z from the asymptotic series.
    fn outer(&self, z: f64) -> [T; 2] {
        let (g, x) = (self.exponent, z.abs().powi(-3));
        let [log, slope, _] = self.asymptotic(T::from(x), z);
        let limit = self.limits[usize::from(z > 0.0)];
        [g * (3.0 * z.abs().ln()) + limit + log, g * (3.0 / z) + slope * (-3.0 * x / z)]
    }

    /// The logarithm of the asymptotic series on the side of z's sign, with two derivatives in x = |z|⁻³.
    fn asymptotic(&self, x: T, z: f64) -> [T; 3] {
        let sign = -z.signum();
        let [log, slope, bend] = log_of_series(&self.expansion, x * sign);
        [log, slope * sign, bend]
    }

    /// The Taylor coefficients of k around z over its value there, by its logarithmic slope there and the equation.
    fn coefficients<const N: usize>(&self, z: f64, slope: T) -> [T; N] {
        let g = self.exponent;
        let mut c = [T::from(0.0); N];
        (c[0], c[1]) = (T::from(1.0), slope);
        for n in 0..N - 2 {
            let m = n as f64;
            let before = if n > 0 { (-g * 9.0 + 3.0 * (m - 1.0)) * c[n - 1] } else { T::from(0.0) };
            let sum = c[n + 1] * (3.0 * z * z * (m + 1.0)) + (-g * 9.0 + 6.0 * m) * c[n] * z + before;
            c[n + 2] = sum / ((m + 1.0) * (m + 2.0));
        }
        c
    }
}

/// ln Σ c_n xⁿ with two derivatives.
fn log_of_series<T: DualNum<Primitive = f64> + Copy>(coefficients: &[T], x: T) -> [T; 3] {
    let (mut sum, mut first, mut second) = (T::from(0.0), T::from(0.0), T::from(0.0));
    for c in coefficients.iter().rev() {
        second = second * x + first * 2.0;
        first = first * x + sum;
        sum = sum * x + *c;
    }
    let slope = first / sum;
    [sum.ln(), slope, second / sum - slope * slope]
}

/// z at a point of the table.
fn point(i: usize) -> f64 {
    (i as f64 - STEPS as f64) / PER_UNIT as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    const RESTITUTIONS: [f64; 7] = [0.98, 0.95, 0.9, 0.7, 0.5, 0.3, 0.2];

    /// Points over all of the table, on both sides of its ends and on the wall.
    fn points() -> impl Iterator<Item = (f64, f64)> {
        let distances = [0.0, 1e-9, 1e-4, 0.003, 0.1, 0.7, 3.0];
        let speeds = [1e-3, 0.02, 0.2, 0.9, 2.5, 4.0].map(|w| [w, -w]).concat();
        distances.into_iter().flat_map(move |u| speeds.clone().into_iter().map(move |w| (u, w)))
    }

    #[test]
    fn the_exponent_solves_its_equation() {
        let known = [(1.0, 0.0), (0.98, -0.00754), (0.95, -0.01960), (0.9, -0.04183), (0.7, -0.16177)];
        for (r, g) in known {
            assert!((grazing_exponent(r).unwrap() - g).abs() < 6e-6, "{r}");
        }
        assert!((grazing_exponent(0.5).unwrap() + 1.0 / 3.0).abs() < 1e-14);
        for r in RESTITUTIONS {
            let g = grazing_exponent(r).unwrap();
            let sides = [r.powf(-(2.0 + 3.0 * g)), 2.0 * (PI * (1.0 / 6.0 - g)).sin()];
            assert!((sides[0] / sides[1] - 1.0).abs() < 1e-13 && g > -2.0 / 3.0 && g < 0.0, "{r}");
        }
        assert!(grazing_exponent(0.163).is_none() && grazing_exponent(0.0).is_none());
    }

    /// The derivatives satisfy w S_u = D (S_ww + S_w²), up to the rounding of its terms.
    #[test]
    fn derivatives_satisfy_the_equation() {
        for r in RESTITUTIONS {
            let similarity = Similarity::new(r, 0.2).unwrap();
            for (u, w) in points() {
                let s = similarity.at(u, w);
                let terms = [w * s.gradient[0], -0.2 * s.hessian[1][1], -0.2 * s.gradient[1] * s.gradient[1]];
                let size: f64 = terms.iter().map(|t| t.abs()).sum();
                assert!(terms.iter().sum::<f64>().abs() < 1e-11 * size, "{r} {u} {w} {terms:?}");
            }
        }
    }

    /// Central differences with steps of 1e-4 of the distance to the singular point: their error is the step squared,
    /// and rounding over the step.
    #[test]
    fn derivatives_are_those_of_the_value() {
        for r in [0.95, 0.5, 0.2] {
            let similarity = Similarity::new(r, 0.2).unwrap();
            for (u, w) in points().filter(|&(u, _)| u > 0.0) {
                let s = similarity.at(u, w);
                let size = u.max(w.abs().powi(3) / 1.8);
                let steps = [1e-4 * u.min(size), 1e-4 * w.abs().min(u.cbrt())];
                for (i, moves) in [[steps[0], 0.0], [0.0, steps[1]]].into_iter().enumerate() {
                    let [after, before] =
                        [1.0, -1.0].map(|sign| similarity.at(u + sign * moves[0], w + sign * moves[1]));
                    let unit = 1.0 / [u, w.abs().min(u.cbrt())][i];
                    let difference = (after.value - before.value) / (2.0 * steps[i]);
                    assert!((difference - s.gradient[i]).abs() < 1e-6 * unit, "{r} {u} {w} {i}");
                    for j in 0..2 {
                        let difference = (after.gradient[j] - before.gradient[j]) / (2.0 * steps[i]);
                        let unit = unit / [u, w.abs().min(u.cbrt())][j];
                        assert!((difference - s.hessian[i][j]).abs() < 1e-6 * unit, "{r} {u} {w} {i} {j}");
                    }
                }
            }
        }
    }

    /// p(0, w) = r⁻² p(0, −w/r). The limit for z → −∞ that follows is where the integration from z = ∞ arrives.
    #[test]
    fn the_wall_holds_its_condition() {
        for r in RESTITUTIONS {
            let similarity = Similarity::new(r, 0.3).unwrap();
            for w in [1e-4, 0.3, 5.0] {
                let jump = similarity.at(0.0, -w).value - similarity.at(0.0, r * w).value;
                assert!((jump - 2.0 * r.ln()).abs() < 1e-13, "{r} {w}");
            }
            let [log, slope] = similarity.table[0];
            let outer = similarity.outer(-EDGE);
            assert!((log - outer[0]).abs() < 1e-12 && (slope - outer[1]).abs() < 1e-12, "{r} {log} {outer:?}");
        }
    }

    #[test]
    fn the_two_representations_meet() {
        for r in RESTITUTIONS {
            let similarity = Similarity::new(r, 1.0 / 9.0).unwrap();
            for w in [EDGE, -EDGE] {
                let (near, far) = (similarity.near(1.0, w), similarity.far(1.0, w));
                let numbers = |jet: PlaneJet<f64>| {
                    let hessian = jet.hessian.concat();
                    [[jet.value].as_slice(), &jet.gradient, &hessian].concat()
                };
                let differences = numbers(near).into_iter().zip(numbers(far)).map(|(near, far)| (near - far).abs());
                assert!(differences.fold(0.0, f64::max) < 1e-12, "{r} {w} {near:?} {far:?}");
            }
        }
    }

    /// For r = .5, U(1/3, 2/3, t) = π^{−1/2} e^{t/2} t^{1/6} K_{1/6}(t/2) (DLMF 13.6.10), and its continuation to −t:
    /// values from SciPy's Bessel function and confluent hypergeometric function.
    #[test]
    fn values_of_tricomis_function() {
        let similarity = Similarity::new(0.5, 1.0 / 9.0).unwrap();
        let known = [
            (0.5, 1.0219155362832646),
            (2.0, 0.7321592024955152),
            (10.0, 0.45480529938501674),
            (-0.5, 2.519705018054908),
            (-2.0, 1.8238555649606636),
            (-10.0, 0.9519945754154449),
        ];
        for (t, u) in known {
            let value = similarity.at(1.0, -f64::cbrt(t)).value;
            assert!((value - f64::ln(u)).abs() < 1e-12, "{t} {value}");
        }
    }

    /// An elastic wall has no singular part, and the singular point itself no infinite value.
    #[test]
    fn limits() {
        assert_eq!(Similarity::new(1.0, 0.2).unwrap().at(0.1, 0.3), PlaneJet::ZERO);
        let corner = Similarity::new(0.7, 0.2).unwrap();
        assert!(corner.at(0.0, 0.0).value.is_finite() && corner.at(0.0, 1e-200).value.is_finite());
        assert!(corner.at(0.0, 0.0).value > corner.at(1e-30, 0.0).value);
    }

    /// By dual numbers, against differences of fourth order: h⁴ of a fifth derivative and rounding over h, 1e-9 where the largest
    /// logarithm is 20. At r = 1, where S vanishes, from one side.
    #[test]
    fn derivatives_by_restitution_and_intensity() {
        let (d, h) = (0.2, 1e-3);
        let at = |r: f64, d: f64, u: f64, w: f64| Similarity::new(r, d).unwrap().at(u, w).value;
        for r in [1.0, 0.95, 0.8, 0.5] {
            let by_r = Similarity::new(Dual64::new(r, 1.0), Dual64::from(d)).unwrap();
            let by_d = Similarity::new(Dual64::from(r), Dual64::new(d, 1.0)).unwrap();
            for (u, w) in points() {
                let differences = if r == 1.0 {
                    let f = |k: f64| at(r - k * h, d, u, w);
                    (25.0 * f(0.0) - 48.0 * f(1.0) + 36.0 * f(2.0) - 16.0 * f(3.0) + 3.0 * f(4.0)) / (12.0 * h)
                } else {
                    let f = |k: f64| at(r + k * h, d, u, w);
                    (8.0 * (f(1.0) - f(-1.0)) - (f(2.0) - f(-2.0))) / (12.0 * h)
                };
                let found = by_r.jet(u, w).value.eps;
                assert!(
                    (found - differences).abs() < 2e-8 * found.abs().max(1.0),
                    "{r} {u} {w}: {found} {differences}"
                );
                let f = |k: f64| at(r, d + k * h, u, w);
                let differences = (8.0 * (f(1.0) - f(-1.0)) - (f(2.0) - f(-2.0))) / (12.0 * h);
                let found = by_d.jet(u, w).value.eps;
                assert!(
                    (found - differences).abs() < 1e-8 * found.abs().max(1.0),
                    "{r} {u} {w}: {found} {differences}"
                );
            }
        }
    }
}

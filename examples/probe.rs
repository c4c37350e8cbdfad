use expoly::{models::*, *};
struct Vdpr {
    e: f64,
    d: Intensity,
}
impl Oscillator for Vdpr {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        (x * x + v * v - 1.0) * v * self.e + x
    }
    fn intensity(&self) -> Intensity {
        self.d
    }
}
struct Sextic;
impl Oscillator for Sextic {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v + x - x.powi(3) * 1.8 + x.powi(5) * 0.6
    }
    fn intensity(&self) -> Intensity {
        Intensity::new(0.3).unwrap()
    }
}
struct E4;
impl Oscillator for E4 {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        let h = v * v * 0.5 + x * x * 0.5 + x.powi(4) * 0.075;
        (h * 0.3 - 0.2) * v + x + x.powi(3) * 0.3
    }
    fn intensity(&self) -> Intensity {
        Intensity::new(0.2).unwrap()
    }
}
struct Chain3;
impl PolynomialDrift<6, 3> for Chain3 {
    fn drift<S: Scalar>(&self, s: [S; 6]) -> [S; 6] {
        let [x, u, y, v, z, w] = s;
        let a = (x - y) * 0.5;
        let b = (y - z) * 0.5;
        [
            u,
            -(u * 0.2) - x - x.powi(3) * 0.3 - a,
            v,
            -(v * 0.4) - y - y.powi(3) * 0.3 + a - b,
            w,
            -(w * 0.3) - z - z.powi(3) * 0.3 + b,
        ]
    }
    fn noise<S: Scalar>(&self, _: [S; 6]) -> [[S; 3]; 6] {
        let o = S::from(0.0);
        let f = |c: f64| S::from((2.0 * c * 0.8f64).sqrt());
        [[o; 3], [f(0.2), o, o], [o; 3], [o, f(0.4), o], [o; 3], [o, o, f(0.3)]]
    }
}
fn show<const N: usize>(name: &str, s: Result<Solution<N>>, p: [u32; N], truth: f64) {
    match s {
        Err(e) => println!("{name}: {e}"),
        Ok(s) => {
            let t = std::time::Instant::now();
            let m = s.density().map(|d| d.moment(p));
            println!(
                "{name:12} n={} {} {:?} it {} F {:.1e} cond {:.1e} {:?} | {} err {:.1e} {:?}",
                s.order(),
                s.termination(),
                s.route(),
                s.iterations(),
                s.residual(),
                s.condition(),
                s.elapsed(),
                m.as_ref().map(|m| format!("{} +- {:.0e}", m.value, m.error)).unwrap_or_else(|e| e.to_string()),
                m.map(|m| m.value / truth - 1.0).unwrap_or(f64::NAN),
                t.elapsed()
            );
        }
    }
}
fn main() {
    let duff = Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap();
    for n in 1..=8 {
        show("duffing", Closure::classical(n).solve(&duff), [2, 0], 0.661714969204);
    }
    let bi = Duffing::new(1.0, -1.0, 1.0, 0.3).unwrap();
    for n in [2, 4, 6, 8] {
        show("bistable", Closure::classical(n).solve(&bi), [2, 0], 0.840546465231);
    }
    for n in [4, 6, 8] {
        show("sextic", Closure::classical(n).solve(&Sextic), [2, 0], 1.13676678784);
    }
    for n in [2, 4, 6] {
        show(
            "E3",
            Closure::classical(n).solve(&Vdpr { e: 1.0, d: Intensity::new(0.15).unwrap() }),
            [2, 0],
            0.521360652674,
        );
    }
    for n in [6, 8, 10] {
        show("E4", Closure::classical(n).solve(&E4), [2, 0], 0.697729334502);
    }
    show("neg", Closure::classical(4).solve(&Duffing::new(-0.2, 1.0, 0.3, 0.2).unwrap()), [2, 0], 1.0);
    show("undamped", Closure::classical(4).solve(&Duffing::new(0.0, 1.0, 0.3, 0.2).unwrap()), [2, 0], 1.0);
    show("chain3", Closure::classical(2).solve(&Chain3), [2, 0, 0, 0, 0, 0], 1.0);
    show("chain3", Closure::classical(4).solve(&Chain3), [0, 2, 0, 0, 0, 0], 0.8);
    for (b, r) in [
        (0.0, 1.0),
        (-0.5, 1.0),
        (0.2, 1.0),
        (0.5, 1.0),
        (0.0, 0.98),
        (0.0, 0.95),
        (0.0, 0.9),
        (-0.5, 0.98),
        (-0.5, 0.95),
        (-0.5, 0.9),
        (0.2, 0.98),
        (0.2, 0.95),
        (0.2, 0.9),
    ] {
        for basis in [Basis::Classical, Basis::Folded] {
            for n in [2, 4, 6, 8] {
                show(
                    &format!("{b} {r} {basis}"),
                    Closure::classical(n).with_basis(basis).solve_with_wall(&duff, Barrier::new(b, r).unwrap()),
                    [1, 0],
                    1.0,
                );
            }
        }
    }
}

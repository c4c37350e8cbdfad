//! Integrals of densities that are narrower than the distance of nodes.

use expoly::{Closure, Density, Origin, Problem};

/// E x² of p ~ exp(−U/T) by the trapezoidal rule on [−4, 4], which converges faster than any power of its step.
fn square(well: impl Fn(f64) -> f64) -> f64 {
    let nodes = || (0..=80_000).map(|k| f64::from(k) * 1e-4 - 4.0);
    nodes().map(|x| x * x * well(x)).sum::<f64>() / nodes().map(&well).sum::<f64>()
}

/// x″ + c x′ − x + x³ = s ξ, whose barrier is 1/4 and whose temperature is s²/2c: the density is exact, and so are its moments where the
/// wells are narrower than the distance of nodes.
#[test]
fn narrow_wells_are_integrated_within_their_errors() {
    for (c, barrier, order) in [(3.5, 175.0, 6), (3.5, 175.0, 8), (0.5, 1.0, 4), (0.5, 30.0, 6), (0.5, 300.0, 8)] {
        let temperature = 0.25 / barrier;
        let text = format!(
            "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '-{c}*v + x - x^3'\nnoise.w.v = '{}'",
            (2.0_f64 * c * temperature).sqrt()
        );
        let density = Closure::new(order).solve(&Problem::from_toml(&text).unwrap()).unwrap();
        let [x, v] = [[2, 0], [0, 2]].map(|powers| density.moment(&powers).unwrap());
        let exact = square(|x| (-(0.25 * x.powi(4) - 0.5 * x * x + 0.25) / temperature).exp());
        println!("{barrier} temperatures, n = {order}: {x}, {v} instead of {exact}, {temperature}");
        // 1e-12 for Q, which is found to rounding; rules agree to 1e-10.
        assert!((x.value - exact).abs() < x.error + 1e-12 && (v.value - temperature).abs() < v.error + 1e-12 * v.value);
        assert!(x.error < 2e-10 && v.error < 2e-10 * v.value, "{x}, {v}");
        assert_eq!(density.candidates()[0].origin, Origin::Exact);
        assert!(density.l1_estimate() > 0.0 && density.l1_estimate() < 2e-10, "{:e}", density.l1_estimate());
    }
}

/// A state in two wells, x′ = −4 x (x² − 1) + ξ √(2/β), beside linear ones with E y² = 1/(0.6 β): the lattice varies along one of its axes
/// alone.
#[test]
fn a_well_along_one_axis_of_a_lattice_is_integrated_within_its_error() {
    for (states, beta) in [(3, 3.0), (4, 3.0), (4, 6.0)] {
        let name = |k: usize| format!("x{k}");
        let mut text =
            format!("states = {:?}\n[drift]\nx1 = '-4*x1*(x1^2 - 1)'\n", (1..=states).map(name).collect::<Vec<_>>());
        (2..=states).for_each(|k| text += &format!("x{k} = '-0.6*x{k}'\n"));
        (1..=states).for_each(|k| text += &format!("[noise.w{k}]\nx{k} = 'sqrt(2/{beta})'\n"));
        let density = Closure::new(4).solve(&Problem::from_toml(&text).unwrap()).unwrap();
        let exact = square(|x| (-beta * (x * x - 1.0).powi(2)).exp());
        for (state, exact) in [(0, exact), (1, 1.0 / (0.6 * beta))] {
            let mut powers = vec![0; states];
            powers[state] = 2;
            let found = density.moment(&powers).unwrap();
            println!("{states} states, β = {beta}: {found} instead of {exact}");
            // Three standard errors on draws, which are 5e-5 of it at most.
            assert!((found.value - exact).abs() < 3.0 * found.error, "{found} instead of {exact}");
            assert!(found.error < 1e-4 * exact, "{found}");
        }
        assert_eq!(density.candidates()[0].origin, Origin::Exact);
    }
}

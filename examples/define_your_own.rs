//! How do I get the stationary density of my own oscillator? Copy this file: it is meant as a start.
//!
//! The oscillator here is x″ + (c + β x²) x′ + k x + a x² + μ x³ = ξ, a shallow arch: asymmetric, with damping that grows
//! away from the middle. No closed form is known. Run it with `cargo run --release --example define_your_own`.

#![allow(clippy::print_stdout)]

use expoly::{Closure, Density, FokkerPlanck, Intensity, Oscillator, Scalar, Simulation, compare};

// 1. The parameters, and the force once, generically: sums, products and whole powers of the states.
struct Arch {
    damping: f64,
    growth: f64,
    quadratic: f64,
    cubic: f64,
    intensity: Intensity,
}

impl Oscillator for Arch {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        (x * x * self.growth + self.damping) * v + x + x.powi(2) * self.quadratic + x.powi(3) * self.cubic
    }
    fn intensity(&self) -> Intensity {
        self.intensity
    }
}

fn main() -> expoly::Result<()> {
    // 2. D is the intensity of E[ξ(t)ξ(t+τ)] = 2D δ(τ); `Intensity` converts σ and spectral densities.
    let arch = Arch { damping: 0.3, growth: 0.2, quadratic: 0.8, cubic: 0.5, intensity: Intensity::new(0.25)? };

    // 3. The library derives the Fokker-Planck equation from the force.
    let equation = FokkerPlanck::new(&arch)?;
    println!("{}\n", equation.text(["x", "v"]));

    // 4. A simulation to judge by: every value comes with its standard error.
    let simulated = Simulation::new(&arch).samples(2_000_000).seed(1).run()?;
    println!("simulation  E x = {:.4}   E x^2 = {:.4}", simulated.moment([1, 0]), simulated.moment([2, 0]));

    // 5. The closure, order by order. At some orders it has no root or no density, and says so.
    for order in [2, 4, 6, 8] {
        let solution = Closure::classical(order).solve(&arch)?;
        match solution.density() {
            Ok(density) => {
                let (mean, square) = (density.moment([1, 0]).value, density.moment([2, 0]).value);
                let distance = compare::with_histogram(&density, 0, simulated.histogram(0)?)?;
                let (l1, noise) = (distance.l1, distance.noise);
                println!(
                    "n = {order}       E x = {mean:.4}            E x^2 = {square:.4}            L1 of p(x) = {l1:.4} (noise {noise:.4})"
                );
            }
            Err(reason) => println!("n = {order}       {reason}"),
        }
    }

    // 6. The closed density is a formula.
    let density = Closure::classical(4).solve(&arch)?.density()?;
    println!("\nln p = {:.4}", density.log_polynomial().text(["x", "v"]));
    println!("up-crossings of x = 1 per unit time: {:.5}", density.upcrossing_rate(1.0)?.value);
    Ok(())
}

//! How do I get the stationary density of my own oscillator?
//!
//! Answer: write its force once, and solve with `Closure::new(order)`; the answer has an estimate of its own error, and here
//! a simulation agrees. Copy this file: it is meant as a start. Run it with `cargo run --release --example define_your_own`.
//!
//! The oscillator here is x″ + (c + β x²) x′ + k x + a x² + μ x³ = ξ, a shallow arch: asymmetric, with damping that grows
//! away from the middle. No closed form is known.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use expoly::{
    Closure, Density, Intensity, Oscillator, Parameter, Problem, Scalar, Sensitivity, Simulation, compare, parametric,
};

// 1. The parameters, and the force once, generically: sums, products and whole powers of the states.
struct Arch<P = f64> {
    damping: P,
    growth: P,
    quadratic: P,
    cubic: P,
    intensity: Intensity<P>,
}

impl<P: Parameter> Oscillator<P> for Arch<P> {
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        (x * x * self.growth + self.damping) * v + x + x.powi(2) * self.quadratic + x.powi(3) * self.cubic
    }
    fn intensity(&self) -> Intensity<P> {
        self.intensity
    }
}

// 2. Their names, by which answers can be differentiated. (Without this line a system needs no `P`, and `Problem::of` takes it.)
parametric!(Arch { damping: "c", growth: "beta", quadratic: "a", cubic: "mu", intensity: "D" });

fn main() -> expoly::Result<()> {
    // 3. D is the intensity of E[ξ(t)ξ(t+τ)] = 2D δ(τ); `Intensity` converts σ and spectral densities.
    let arch = Arch { damping: 0.3, growth: 0.2, quadratic: 0.8, cubic: 0.5, intensity: Intensity::new(0.25)? };

    // 4. The problem that all methods take. The library derives the Fokker-Planck equation from the force.
    let problem = Problem::parametric(arch)?;
    println!("{}\n", problem.operator().text(problem.states()));

    // 5. A simulation to compare with: every value comes with its standard error.
    let simulated = Simulation::new().samples(2_000_000).seed(1).run(&problem)?;
    println!("simulation  E x = {:.4}   E x^2 = {:.4}", simulated.moment(&[1, 0])?, simulated.moment(&[2, 0])?);

    // 6. The closure, order by order. It estimates its own error, which the simulation confirms.
    for order in [2, 4, 6, 8] {
        let density = Closure::new(order).solve(&problem)?;
        let (mean, square) = (density.moment(&[1, 0])?.value, density.moment(&[2, 0])?.value);
        let distance = compare::with_histogram(&density, 0, simulated.histogram(0)?)?;
        println!(
            "n = {order}       E x = {mean:.4}            E x^2 = {square:.4}            L1 of p(x) = {:.4} (noise {:.4}), \
             estimated joint L1 error {:.4}",
            distance.l1,
            distance.noise,
            density.l1_estimate()
        );
        if let Some(warning) = density.warning() {
            println!("            {warning}");
        }
    }

    // 7. The closed density is a formula, valid on its trust domain. `Closure::adaptive(target)` finds the order for a given
    //    error.
    let density = Closure::new(4).solve(&problem)?;
    if let Some(formula) = density.log_polynomial() {
        println!("\nln p = {:.4}", formula.text(problem.states()));
    }
    let density = Closure::adaptive(5e-3).solve(&problem)?;
    println!("estimated L1 error {:.4} at n = {}", density.l1_estimate(), density.provenance().order.unwrap_or(0));
    println!("up-crossings of x = 1 per unit time: {:.5}", density.upcrossing_rate(1.0)?.value);

    // 8. What a parameter changes: one more linear solve, by its name.
    for name in ["c", "mu"] {
        println!("d E x^2 / d {name} = {:.4}", density.sensitivity(name)?.moment(&[2, 0])?);
    }
    Ok(())
}

//! What changes when the noise multiplies the state?
//!
//! Answer, by `cargo run --release --example parametric_noise`, in three parts. One equation in Itô's and in Stratonovich's
//! sense has different mean squares, 1.11 and 1.25 at the same weak noise, and they become infinite at different strengths. A
//! density may have a power tail, which no polynomial follows: the closure is off by 5 % in L¹ and carries a warning. Where
//! noise and damping grow together the density is an exponential again, and the closure exact. A figure of both tails goes to
//! `out/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{DisplacementNoise, ParametricLinear, Solved};
use expoly::{Closure, Density, Drift, Intensity, Interpretation, Problem, Scalar, compare};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, between, curve, values, write_figure};

/// Multiplicative noise: its meaning, stability, and tails.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/parametric_noise")]
    out: PathBuf,
}

const DAMPING: f64 = 0.1;
const EXTERNAL: f64 = 0.2;

/// x″ + 2α x′ (1 + η) + x = ξ with α = 0.1: noise η in the damping, noise ξ of intensity D = 0.2 from outside.
struct NoisyDamping {
    parametric: Intensity,
    interpretation: Interpretation,
}

impl Drift<2, 2> for NoisyDamping {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -(v * (2.0 * DAMPING)) - x]
    }
    fn noise<S: Scalar>(&self, [_, v]: [S; 2]) -> [[S; 2]; 2] {
        let external = S::from((2.0 * EXTERNAL).sqrt());
        [[S::from(0.0); 2], [external, -(v * (2.0 * DAMPING * self.parametric.amplitude()))]]
    }
    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    println!("1. x'' + 0.2 x' (1 + eta) + x = xi: E v^2 by the closure of order 2, and exactly");
    for (interpretation, share) in [(Interpretation::Ito, 1.0), (Interpretation::Stratonovich, 2.0)] {
        for d_eta in [0.5, 2.0, 3.0, 6.0] {
            let system = NoisyDamping { parametric: Intensity::new(d_eta)?, interpretation };
            // A linear system's moment equations are closed: D = 2α (1 − 2α D_η) E v², and 4α D_η with Stratonovich.
            let exact = EXTERNAL / (2.0 * DAMPING * (1.0 - share * 2.0 * DAMPING * d_eta));
            let answer = match Problem::of(system)?.gaussian() {
                Ok(gaussian) => format!("{:.5} {exact:.5}", gaussian.covariance[(1, 1)]),
                Err(error) => error.to_string(),
            };
            println!("   {interpretation:?}, D_eta = {d_eta}: {answer}");
        }
    }

    println!("\n2. x'' + 0.2 x' (1 + eta) + x (1 + zeta) = xi, a power tail: how many decades p(x) is off");
    let labels = ["displacement x [L]", "density p(x) [1/L]"];
    let system = ParametricLinear::new(DAMPING, 1.0, 0.5, EXTERNAL)?;
    let (exact, x) = (system.exact(), between([0.2, 20.0], 120));
    let problem = Problem::of(system)?;
    let mut curves = vec![curve("exact", Style::Dashed, 0, &values(&x, |x| exact.marginal(0, x))?)];
    for (colour, order) in [(1, 4), (2, 8)] {
        let density = Closure::new(order).solve(&problem)?;
        let off = |x| Ok((density.marginal(0, x)?.value / exact.marginal(0, x)?.value).log10());
        let off = [2.0, 4.0, 6.0].map(off).into_iter().collect::<expoly::Result<Vec<f64>>>()?;
        let (l1, estimate) = (compare::l1(&density, &exact)?.value, density.l1_estimate());
        println!("   n = {order}: {off:.2?} at x = 2, 4, 6; L1 {l1:.1e}, estimated {estimate:.1e}");
        println!("          {}", density.warning().unwrap_or("no warning"));
        let closed = values(&x, |x| density.marginal(0, x))?;
        curves.push(curve(&format!("closure, n = {order}"), Style::Solid, colour, &closed));
    }
    let power = Panel::new(labels, Scale::LogLog, curves).with_y_range([1e-9, 1.0]);

    println!("\n3. x'' + c (1 + g x^2) x' + x + 0.4 x^3 = xi1 + sqrt(g) x xi2: noise and damping in balance");
    let system = DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?;
    let (density, exact) = (Closure::new(4).solve(&system.problem()?)?, system.exact()?);
    println!("   n = 4: L1 {:.1e}, estimated {:.1e}", compare::l1(&density, &exact)?.value, density.l1_estimate());
    let closed = values(&between([0.0, 4.0], 120), |x| density.marginal(0, x))?;
    let known = values(&between([0.0, 4.0], 21), |x| exact.marginal(0, x))?;
    let curves = vec![curve("closure, n = 4", Style::Solid, 1, &closed), curve("exact", Style::Points, 0, &known)];
    let caption = "Left: x″ + 2α x′ (1 + η) + x (1 + ζ) = ξ, Stratonovich, α = 0.1, D_η = 0.5, D = 0.2. Right: \
        x″ + c (1 + g x²) x′ + x + 0.4 x³ = ξ₁ + √g x ξ₂, c = D = 0.5, g = 0.7. E[ξ(t)ξ(t+τ)] = 2D δ(τ); seed 0.";
    let views = [power, Panel::new(labels, Scale::Logarithmic, curves)].map(View::Curves);
    write_figure(&options.out.join("tails.svg"), caption, 2, &views)?;
    println!("\nfigure: {}", options.out.join("tails.svg").display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

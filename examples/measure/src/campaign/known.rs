//! Random systems whose density is exp of a polynomial of degree two or four: wells, linear systems, wells beside linear states.

use super::Options;
use super::runner::{Named, Place, Row};
use super::statistics::{quantile, share};
use crate::Outcome;
use crate::draw::Draw;
use expoly::{Closure, Density, Problem};
use std::fmt;
use std::time::Instant;

/// A moment may be off by so many times its error.
const WITHIN: f64 = 3.0;
/// An error relative to the moment that is rounding, of rates 1 : 1e4 and of the truth's quadrature.
const ROUNDING: f64 = 1e-9;

/// A system as text, and its mean squares.
struct Known {
    name: String,
    text: String,
    squares: Vec<f64>,
}

impl Named for Known {
    fn problem(&self) -> expoly::Result<Problem> {
        Problem::from_toml(&self.text)
    }
}

impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl Known {
    fn random(seed: u64, index: usize) -> Self {
        let mut draw = Draw::new(seed, index);
        match index % 3 {
            0 => Known::wells(draw.log_within(1.0, 1e3), draw.log_within(0.02, 50.0), draw.log_within(0.1, 10.0)),
            1 => Known::linear(&mut draw),
            _ => Known::wells_beside_linear(&mut draw),
        }
    }

    /// x″ + c x′ − x + μ x³ = ξ, with the barrier 1/(4μ) in temperatures D/c and the damping ratio c/(2√2) at its bottom.
    fn wells(barrier: f64, ratio: f64, cubic: f64) -> Self {
        let damping = ratio * 8.0_f64.sqrt();
        let temperature = 1.0 / (4.0 * cubic * barrier);
        let noise = (2.0 * damping * temperature).sqrt();
        let text = format!(
            "states = [\"x\", \"v\"]\n[drift]\nx = \"v\"\nv = \"-{damping:e}*v + x - {cubic:e}*x^3\"\n[noise.w]\nv = {noise:e}\n"
        );
        let square = mean_square(|x| (0.5 * x * x - 0.25 * cubic * x.powi(4)) / temperature, cubic.sqrt().recip());
        let name = format!("wells, {barrier:.3} temperatures deep, damping ratio {ratio:.3}, mu = {cubic:.3}");
        Known { name, text, squares: vec![square, temperature] }
    }

    /// x′ = (W − M) P x + √(2M) ξ with W = −Wᵀ, whose covariance is P⁻¹ for every W: P = UᵀU with unit triangles U between
    /// scales from 1 to 1e4.
    fn linear(draw: &mut Draw) -> Self {
        let n = 2 + draw.below(3);
        let scale: Vec<f64> = (0..n).map(|_| draw.log_within(1e-4, 1.0)).collect();
        let mut upper = vec![vec![0.0; n]; n];
        for i in 0..n {
            upper[i][i] = 1.0 / scale[i];
            for (j, scale) in scale.iter().enumerate().skip(i + 1) {
                upper[i][j] = draw.within(-0.8, 0.8) / scale;
            }
        }
        let p = |i: usize, j: usize| (0..n).map(|k| upper[k][i] * upper[k][j]).sum::<f64>();
        // Rows of U⁻¹: column by column, from the last row up.
        let mut inverse = vec![vec![0.0; n]; n];
        for j in 0..n {
            for i in (0..=j).rev() {
                let right = f64::from(i == j) - (i + 1..=j).map(|k| upper[i][k] * inverse[k][j]).sum::<f64>();
                inverse[i][j] = right / upper[i][i];
            }
        }
        let squares = inverse.iter().map(|row| row.iter().map(|u| u * u).sum()).collect();
        let rates: Vec<f64> = (0..n).map(|_| draw.log_within(0.1, 10.0)).collect();
        let mut factor = vec![vec![0.0; n]; n];
        for i in 0..n {
            factor[i][i] = -rates[i] * scale[i] * scale[i];
            for j in 0..i {
                let w = draw.within(-3.0, 3.0) * scale[i] * scale[j];
                (factor[i][j], factor[j][i]) = (w, -w);
            }
        }
        let entry = |i: usize, j: usize| (0..n).map(|k| factor[i][k] * p(k, j)).sum::<f64>();
        let row = |i: usize| (0..n).map(|j| format!("{:+e}*x{j}", entry(i, j))).collect::<String>();
        let drift: String = (0..n).map(|i| format!("x{i} = \"{}\"\n", row(i))).collect();
        let noise = |i: usize| format!("[noise.w{i}]\nx{i} = {:e}\n", (-2.0 * factor[i][i]).sqrt());
        let noise: String = (0..n).map(noise).collect();
        let name =
            format!("linear, standard deviations from {:.1e}, {n} states", scale.iter().copied().fold(1.0, f64::min));
        Known { name, text: format!("{}[drift]\n{drift}{noise}", states(n)), squares }
    }

    /// x′ = −∂V/∂x + √(2T) ξ with V = x₀⁴/4 − x₀²/2 + Σ k_i (x_i − a_i x₀)²/2.
    fn wells_beside_linear(draw: &mut Draw) -> Self {
        let others = 1 + draw.below(9);
        let temperature = 0.25 / draw.log_within(1.0, 8.0);
        let mut drift = "x0 = \"x0 - x0^3".to_owned();
        let (mut rest, mut squares) = (String::new(), Vec::new());
        let own = mean_square(|x| (0.5 * x * x - 0.25 * x.powi(4)) / temperature, 1.0);
        for i in 1..=others {
            let (k, a) = (draw.log_within(0.3, 3.0), draw.within(-0.5, 0.5));
            drift += &format!(" {:+e}*(x{i} {:+e}*x0)", k * a, -a);
            rest += &format!("x{i} = \"-{k:e}*(x{i} {:+e}*x0)\"\n", -a);
            squares.push(temperature / k + a * a * own);
        }
        let noise = (2.0 * temperature).sqrt();
        let noise: String = (0..=others).map(|i| format!("[noise.w{i}]\nx{i} = {noise:e}\n")).collect();
        squares.insert(0, own);
        let name = format!("wells, {:.2} temperatures deep, beside {others} linear states", 0.25 / temperature);
        Known { name, text: format!("{}[drift]\n{drift}\"\n{rest}{noise}", states(others + 1)), squares }
    }
}

fn states(n: usize) -> String {
    let names: Vec<String> = (0..n).map(|i| format!("\"x{i}\"")).collect();
    format!("states = [{}]\n", names.join(", "))
}

/// E x² under exp(q), which is even and has its maximum at `well`: by the trapezoidal rule about it, whose error is below rounding.
fn mean_square(q: impl Fn(f64) -> f64, well: f64) -> f64 {
    let top = q(well);
    // The spacing resolves the curvature at the bottom; the ends are where nothing is left.
    let h = 1e-4 * well;
    let curvature = (2.0 * top - q(well + h) - q(well - h)) / (h * h);
    let spacing = (0.1 / curvature.sqrt()).min(well / 50.0);
    let (mut mass, mut square) = (0.5 * (q(0.0) - top).exp(), 0.0);
    for k in 1.. {
        let x = f64::from(k) * spacing;
        let p = (q(x) - top).exp();
        mass += p;
        square += x * x * p;
        if x > well && p < 1e-20 {
            break;
        }
    }
    square / mass
}

/// The density of one of them.
struct Closed {
    place: Place,
    states: usize,
    estimate: f64,
    /// The largest error of a mean square over what is stated, and relative to the moment.
    over_stated: f64,
    relative: f64,
    warning: Option<String>,
    seconds: f64,
}

impl Row for Closed {
    const COLUMNS: &'static [&'static str] = &["states", "estimate", "over_stated", "relative", "seconds"];

    fn place(&self) -> Place {
        self.place
    }

    fn numbers(&self) -> Vec<f64> {
        vec![self.states as f64, self.estimate, self.over_stated, self.relative, self.seconds]
    }

    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    fn read(place: Place, numbers: &[f64], warning: Option<String>) -> Option<Self> {
        let &[states, estimate, over_stated, relative, seconds] = numbers else { return None };
        Some(Closed { place, states: states as usize, estimate, over_stated, relative, warning, seconds })
    }
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "       n = {:2}: estimate {:.1e}, mean squares off by {:.2} of their errors, {:.1e} of themselves  {:.2} s  {}",
            self.place.order,
            self.estimate,
            self.over_stated,
            self.relative,
            self.seconds,
            self.warning.as_deref().unwrap_or("")
        )
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let orders = options.orders(&[4]);
    println!("seed {}; the closure of random systems with a density that it has", options.seed);
    let system = |index| Ok(Known::random(options.seed, index));
    let truth = |index: usize, _: &Problem| Ok(Known::random(options.seed, index).squares);
    let campaign = options.campaign("known.csv", 300, &orders);
    let Some(findings) =
        campaign.findings(system, truth, |place, problem, squares: &Vec<f64>| row(place, problem, squares))?
    else {
        return Ok(());
    };
    findings.print_missing();
    for order in orders {
        let rows: Vec<&Closed> = findings.rows.iter().filter(|row| row.place.order == order).collect();
        let count = |which: &dyn Fn(&Closed) -> bool| share(rows.iter().filter(|row| which(row)).count(), rows.len());
        let quantile_of = |of: &dyn Fn(&Closed) -> f64, share| quantile(rows.iter().map(|row| of(row)), share);
        println!("\nn = {order}: {} densities", rows.len());
        println!("  mean squares within {WITHIN} errors: {}", count(&|row| row.over_stated <= WITHIN));
        println!("  estimate at most 1e-4: {}", count(&|row| row.estimate <= 1e-4));
        println!("  with a warning: {}", count(&|row| row.warning.is_some()));
        println!("  worst mean square: off by {:.1e}", quantile_of(&|row| row.relative, 1.0));
        println!(
            "  seconds: median {:.2}, worst {:.1}",
            quantile_of(&|row| row.seconds, 0.5),
            quantile_of(&|row| row.seconds, 1.0)
        );
    }
    println!("table: {}", campaign.path.display());
    Ok(())
}

fn row(place: Place, problem: &Problem, squares: &[f64]) -> expoly::Result<Closed> {
    let begin = Instant::now();
    let density = Closure::new(place.order).solve(problem)?;
    let seconds = begin.elapsed().as_secs_f64();
    let (mut over_stated, mut relative) = (0.0_f64, 0.0_f64);
    for (i, &truth) in squares.iter().enumerate() {
        let mut powers = vec![0; squares.len()];
        powers[i] = 2;
        let found = density.moment(&powers)?;
        let off = (found.value - truth).abs();
        // NaN is no answer.
        let over = |size: f64| if off.is_nan() { f64::INFINITY } else { off / size };
        over_stated = over_stated.max(over(found.error.max(ROUNDING * truth)));
        relative = relative.max(over(truth));
    }
    let (states, estimate) = (squares.len(), density.l1_estimate());
    Ok(Closed {
        place,
        states,
        estimate,
        over_stated,
        relative,
        warning: density.warning().map(str::to_owned),
        seconds,
    })
}

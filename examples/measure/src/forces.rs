//! How good are closure, grid and simulation where forces are no polynomials?
//!
//! Oscillators with sines, roots, quotients, friction, clearances and drag: the closure's distance in L¹ from a grid of accuracy 1e-7 with its
//! own estimate, of each order; and the worst error of known moments by each method. These are by quadrature where the density has a
//! closed form, and otherwise of solutions on finer grids by other means. Then an oscillator with hysteresis, against a simulation.

use crate::Outcome;
use clap::Args;
use expoly::models::BoucWen;
use expoly::{Closure, Density, Grid, Histogram, Problem, Simulation, Weight, compare};
use support::text::{aligned, short};

/// The methods where forces are no polynomials.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Only the systems whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Orders of the closure, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "4,6,8,12")]
    orders: Vec<u32>,
    /// Samples of the simulation
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
}

/// The highest order of the closure in three states.
const MOST: u32 = 8;
/// Bins of a histogram along a state that make one.
const TOGETHER: usize = 4;

/// A system: its name, the force −v′ − …, the intensity D, and known moments.
pub(crate) struct Force {
    pub(crate) name: &'static str,
    force: &'static str,
    intensity: f64,
    known: &'static [([u32; 2], f64)],
}

/// E x, E x², E x⁴ by quadrature, or E x² and E v² on a grid.
pub(crate) const FORCES: [Force; 14] = [
    Force {
        name: "sine",
        force: "0.3*v + x + sin(2*x)",
        intensity: 0.3,
        known: &[([2, 0], 0.753_324_065_31), ([4, 0], 2.510_274_826_7)],
    },
    Force {
        name: "smooth and discontinuous",
        force: "0.2*v + x*(1 - 1/sqrt(x^2 + 0.25))",
        intensity: 0.05,
        known: &[([2, 0], 1.022_301_767_97), ([4, 0], 2.051_508_832_2)],
    },
    Force {
        name: "nearly discontinuous",
        force: "0.2*v + x*(1 - 1/sqrt(x^2 + 0.01))",
        intensity: 0.05,
        known: &[([2, 0], 1.260_817_689_3), ([4, 0], 2.705_248_421_8)],
    },
    Force {
        name: "Morse",
        force: "0.2*v + 2*(1 - exp(-x))*exp(-x) + 0.1*x",
        intensity: 0.1,
        known: &[([1, 0], 0.673_134_787_27), ([2, 0], 1.633_607_562_83)],
    },
    Force {
        name: "quotient",
        force: "0.5*v*(1 - 1/(1 + v^2/2 + x^2/2 + 0.025*x^4)) + x + 0.1*x^3",
        intensity: 0.3,
        known: &[([2, 0], 0.854_336_201_64), ([0, 2], 1.032_625_034_45)],
    },
    Force {
        name: "smooth friction",
        force: "0.1*v + 0.3*tanh(v/0.3) + x + 0.3*x^3",
        intensity: 0.2,
        known: &[([2, 0], 0.370_818_741_7), ([0, 2], 0.498_497_893)],
    },
    Force {
        name: "bilinear",
        force: "0.2*v + x + 3*pos(x - 0.5)",
        intensity: 0.2,
        known: &[([1, 0], -0.223_690_535_18), ([2, 0], 0.759_372_101_67)],
    },
    Force {
        name: "bilinear, van der Pol",
        force: "0.2*v*(1 + x^2) + x + 3*pos(x - 0.5)",
        intensity: 0.2,
        known: &[([2, 0], 0.526_581_838_8), ([0, 2], 0.684_941_158_8)],
    },
    Force {
        name: "clearance",
        force: "0.2*v + 0.1*x + 4*pos(abs(x) - 1)*sign(x)",
        intensity: 0.2,
        known: &[([2, 0], 0.941_359_359_29), ([4, 0], 1.894_537_62)],
    },
    Force {
        name: "Hertz",
        force: "0.2*v + x + 4*pos(x)^1.5",
        intensity: 0.2,
        known: &[([1, 0], -0.393_646_384_64), ([2, 0], 0.737_734_131_97)],
    },
    Force {
        name: "preload",
        force: "0.2*v + x + sign(x)",
        intensity: 0.2,
        known: &[([2, 0], 0.474_864_723_84), ([4, 0], 0.849_188_343)],
    },
    Force {
        name: "roll",
        force: "0.05*v + 0.2*abs(v)*v + x + 0.1*x^3",
        intensity: 0.2,
        known: &[([2, 0], 0.588_685_867_7), ([0, 2], 0.674_151_822_4)],
    },
    Force {
        name: "friction",
        force: "0.1*v + 0.2*sign(v) + x + 0.3*x^3",
        intensity: 0.2,
        known: &[([2, 0], 0.492_735_454_7), ([0, 2], 0.712_668_340_2)],
    },
    Force {
        name: "strong friction",
        force: "0.05*v + 0.6*sign(v) + x",
        intensity: 0.2,
        known: &[([2, 0], 0.200_246_831_3), ([0, 2], 0.189_710_952_7)],
    },
];

impl Force {
    /// x″ + h(x, x′) = ξ.
    pub(crate) fn problem(&self) -> expoly::Result<Problem> {
        let Force { force, intensity, .. } = self;
        Problem::from_toml(&format!(
            "states = ['x', 'v']\ndrift = {{ x = 'v', v = '-({force})' }}\nnoise.w.v = 'sqrt(2*{intensity})'"
        ))
    }

    /// The worst error of the known moments, relative, and in their own errors.
    pub(crate) fn worst(&self, density: &dyn Density) -> expoly::Result<[f64; 2]> {
        self.known.iter().try_fold([0.0, 0.0], |[relative, own]: [f64; 2], (powers, truth)| {
            let found = density.moment(powers)?;
            let off = (found.value - truth).abs();
            // The truths have ten digits.
            Ok([relative.max(off / truth.abs()), own.max(off / found.error.hypot(1e-9 * truth.abs()))])
        })
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let orders = options.orders.iter().flat_map(|n| [format!("L1, n = {n}"), String::from("estimate")]);
    let moments = ["grid: worst moment", "in errors", "simulation", "in errors"].map(String::from);
    let mut rows = vec![[String::from("system")].into_iter().chain(orders).chain(moments).collect::<Vec<_>>()];
    for force in FORCES.iter().filter(|force| force.name.contains(&options.only)) {
        let problem = force.problem()?;
        let grid = Grid::new().accuracy(1e-7).solve(&problem)?;
        let mut row = vec![force.name.to_owned()];
        for &order in &options.orders {
            let found = Closure::new(order).weight(Weight::Density).solve(&problem);
            row.extend(match found {
                Ok(found) => [Some(compare::l1(&found, &grid)?.value), Some(found.l1_estimate())].map(short),
                Err(_) => [None, None].map(short),
            });
        }
        let sampled = Simulation::new().samples(options.samples).run(&problem)?;
        for density in [&grid as &dyn Density, &sampled] {
            let [relative, own] = force.worst(density)?;
            row.extend([short(Some(relative)), format!("{own:.1}")]);
        }
        rows.push(row);
        println!("{}", aligned(&rows[rows.len() - 1..], 1).trim_end());
    }
    println!("\n{}", aligned(&rows, 1));
    if "hysteresis".contains(&options.only) { hysteresis(options) } else { Ok(()) }
}

/// Pairs of states of Bouc's and Wen's oscillator.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Bouc's and Wen's oscillator, c = 0.1, α = β = γ = 0.5, D = 0.05, of two exponents: L¹ of the densities of two states against the
/// histograms of a simulation, the histograms' own noise beside it, and how much calibration lowers the standard error of E x².
fn hysteresis(options: &Options) -> Outcome {
    let heads = [
        "exponent",
        "n",
        "E x^2",
        "error",
        "plain / calibrated",
        "L1 of (x, v)",
        "of (v, z)",
        "of (x, z)",
        "noise",
        "estimate",
    ];
    let mut rows = vec![heads.map(String::from).to_vec()];
    for exponent in [1, 2] {
        let problem = Problem::of(BoucWen::new([0.1, 0.5, 0.5, 0.5], exponent, 0.05)?)?;
        let simulation = || Simulation::new().samples(options.samples);
        let sampled = simulation().samples(20 * options.samples).joint([1, 2]).joint([0, 2]).run(&problem)?;
        let [plain, calibrated] = [false, true].map(|with| {
            let found = simulation().control_variates(with).run(&problem)?;
            found.moment(&[2, 0, 0])
        });
        let (plain, calibrated) = (plain?, calibrated?);
        for &order in options.orders.iter().filter(|order| **order <= MOST) {
            let found = Closure::new(order).solve(&problem)?;
            let mut row = vec![exponent.to_string(), order.to_string(), format!("{:.6}", calibrated.value)];
            row.extend([format!("{:.1e}", calibrated.error), format!("{:.0}", plain.error / calibrated.error)]);
            let mut noise: f64 = 0.0;
            for pair in PAIRS {
                let [l1, own] = distance(&found, pair, &sampled.joint(pair)?)?;
                row.push(short(Some(l1)));
                noise = noise.max(own);
            }
            row.extend([short(Some(noise)), short(Some(found.l1_estimate()))]);
            rows.push(row);
        }
    }
    println!("hysteresis\n\n{}", aligned(&rows, 2));
    Ok(())
}

/// Σ |p − h| over the bins of two states, four by four together, and what the histogram's own noise makes of it.
fn distance(density: &dyn Density, pair: [usize; 2], histogram: &Histogram) -> expoly::Result<[f64; 2]> {
    let edges: Vec<Vec<f64>> = [0, 1].map(|along| histogram.edges(along).collect()).to_vec();
    let together = |along: usize| (0..edges[along].len() - 1).step_by(TOGETHER);
    let (mut l1, mut noise) = (0.0, 0.0);
    for (i, j) in together(0).flat_map(|i| together(1).map(move |j| (i, j))) {
        let [to_i, to_j] = [(i, 0), (j, 1)].map(|(k, along)| (k + TOGETHER).min(edges[along].len() - 1));
        let (mut share, mut squared) = (0.0, 0.0);
        for (p, q) in (i..to_i).flat_map(|p| (j..to_j).map(move |q| (p, q))) {
            let area = (edges[0][p + 1] - edges[0][p]) * (edges[1][q + 1] - edges[1][q]);
            let cell = histogram.cell(&[p, q])?;
            share += area * cell.value;
            squared += (area * cell.error).powi(2);
        }
        if share == 0.0 {
            continue;
        }
        let mut mass = 0.0;
        let sides = [edges[0][to_i] - edges[0][i], edges[1][to_j] - edges[1][j]];
        for s in [-1.0, 1.0].map(|sign| 0.5 + sign * 0.5 / 3.0_f64.sqrt()) {
            for t in [-1.0, 1.0].map(|sign| 0.5 + sign * 0.5 / 3.0_f64.sqrt()) {
                let place = [edges[0][i] + s * sides[0], edges[1][j] + t * sides[1]];
                mass += sides[0] * sides[1] / 4.0 * density.joint_marginal(pair, place)?.value;
            }
        }
        l1 += (mass - share).abs();
        noise += (2.0 / std::f64::consts::PI * squared).sqrt();
    }
    Ok([l1, noise])
}

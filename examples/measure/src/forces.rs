//! How good are closure, grid and simulation where forces are no polynomials?
//!
//! Oscillators with sines, roots, quotients, friction, clearances and drag: the closure's distance in L¹ from a grid of accuracy 1e-7 with its
//! own estimate, of each order; and the worst error of known moments by each method. These are by quadrature where the density has a
//! closed form, and otherwise of solutions on finer grids by other means.

use crate::Outcome;
use clap::Args;
use expoly::{Closure, Density, Grid, Problem, Simulation, Weight, compare};
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
    fn worst(&self, density: &dyn Density) -> expoly::Result<[f64; 2]> {
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
    Ok(())
}

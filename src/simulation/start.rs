use super::Simulation;
use crate::error::{Error, Result};
use crate::polynomial::Frame;
use crate::problem::{Problem, TimeScales};
use crate::transient::Start;
use crate::walls::{Contact, reflect};

/// The noise of so many time steps spreads the default start: enough for trajectories to differ, too little to leave the rest
/// position.
const SPREAD_STEPS: f64 = 4.0;
/// The time in units of 1/λ for which a burn-in goes on after small motions that grow as e^λt have come from the start to the
/// width of the density: one trajectory in twenty starts so near to rest that it needs more.
const LEAVING: f64 = 3.0;
/// The longest time that trajectories are given to leave a state of rest at which small motions grow, in the shortest of the
/// system's times: a bound on work.
const LONGEST_LEAVING: f64 = 20_000.0;

impl Simulation<'_> {
    /// Where trajectories start: a point, or points drawn from a normal distribution, reflected at walls; other densities are refused. By default
    /// they start near 0, or near the wall if that stands above 0, as far apart as the noise makes them within four steps, and the burn-in leads
    /// on from there; from a top that they would leave too late, with the spread of the Gaussian closure.
    pub fn start(self, start: impl Into<Start>) -> Self {
        Simulation { start: start.into(), ..self }
    }

    /// Refuses a start without a meaning.
    pub(super) fn validate_start(&self, problem: &Problem, contacts: &[Contact]) -> Result<()> {
        self.start.check(problem.dimension())?;
        let at = match &self.start {
            Start::Point(x) => x.as_slice(),
            Start::Gaussian(gaussian) => gaussian.mean.as_slice(),
            Start::Stationary => return Ok(()),
            Start::Density(_) => {
                let (method, what) = ("simulation", "a density as the start");
                return Err(Error::NotServed { method, what, remedy: "take a point or a normal distribution" });
            }
        };
        let beyond = contacts.iter().find(|contact| contact.gap(at) < 0.0);
        let remedy = "a trajectory must start on the side of each wall that the motion is on";
        let value = |contact: &Contact| at[contact.wall.state()];
        beyond.map_or(Ok(()), |contact| Err(Error::OutOfRange { name: "start", value: value(contact), remedy }))
    }
}

/// Where trajectories begin.
#[derive(Debug)]
pub(super) struct TrajectoryStart {
    /// The point, or the mean and the lower Cholesky factor of the covariance by rows; empty by default.
    pub(super) origin: Vec<Vec<f64>>,
    spread: Vec<f64>,
    /// The state of rest that no wall excludes.
    centre: Vec<f64>,
    contacts: Vec<Contact>,
}

impl TrajectoryStart {
    /// The start given to the simulation, or near 0, or beside the walls that exclude 0; each state spreads as far as the
    /// noise at 0 takes it in four steps, or as far as its density where it would take too long to leave.
    pub(super) fn new(simulation: &Simulation<'_>, problem: &Problem, step: f64) -> Result<Self> {
        let free = matches!(simulation.start, Start::Stationary);
        // Without time scales nothing says that they would take too long.
        let wide = if free { wide(problem, step).ok().flatten() } else { None };
        let wide = wide.map(|wide| wide.iter().map(|deviation| simulation.amplitude * deviation).collect());
        let spread = wide.unwrap_or_else(|| spread(problem, simulation.amplitude, step));
        let origin = match &simulation.start {
            Start::Point(x) => vec![x.clone()],
            Start::Gaussian(gaussian) => {
                let frame = Frame::new(gaussian)?;
                let rows = frame.scale().row_iter().map(|row| row.iter().copied().collect());
                std::iter::once(frame.origin().to_vec()).chain(rows).collect()
            }
            Start::Stationary | Start::Density(_) => Vec::new(),
        };
        Ok(TrajectoryStart { origin, spread, centre: problem.still(), contacts: problem.contacts() })
    }

    /// The number of states.
    pub(super) fn dimension(&self) -> usize {
        self.spread.len()
    }

    /// Turns standard normal numbers into the state that a trajectory begins at.
    pub(super) fn place(&self, x: &mut [f64]) {
        match self.origin.split_first() {
            Some((point, [])) => return x.copy_from_slice(point),
            Some((mean, rows)) => {
                // From the last state on, since each one needs those before it.
                for (i, row) in rows.iter().enumerate().rev() {
                    x[i] = mean[i] + row[..=i].iter().zip(x.iter()).map(|(l, z)| l * z).sum::<f64>();
                }
            }
            None => {
                for ((x, spread), centre) in x.iter_mut().zip(&self.spread).zip(&self.centre) {
                    *x = centre + *x * spread;
                }
            }
        }
        reflect(&self.contacts, x);
    }
}

/// How far each state starts from the state of rest: as the noise there takes it in some time steps.
fn spread(problem: &Problem, amplitude: f64, step: f64) -> Vec<f64> {
    let time = SPREAD_STEPS * step;
    let variance = |i: usize| {
        let at_rest = problem.columns().iter().map(|column| column[i].constant_term() * amplitude);
        let impulses = problem.impulses().iter().map(|impulse| {
            let struck = impulse.field()[i].constant_term() * amplitude;
            2.0 * impulse.process().intensity() * struck * struck
        });
        (at_rest.map(|g| g * g).sum::<f64>() + impulses.sum::<f64>()) * time
    };
    let deviation = |variance: f64| if variance > 0.0 { variance.sqrt() } else { 0.1 };
    let mut spread: Vec<f64> = (0..problem.dimension()).map(|i| deviation(variance(i))).collect();
    for &(i, j) in problem.displacements() {
        spread[i] = spread[j] * time;
    }
    spread
}

/// The time after which trajectories have forgotten their start: the system's memory, or longer where they start at a state that they
/// leave slowly, as the top between two wells; in steps of about this length.
///
/// # Errors
/// Those of [`TimeScales::of`].
pub(crate) fn burn_in(problem: &Problem, scales: &TimeScales, step: f64) -> Result<f64> {
    Ok(scales.memory().max(leaving(problem, scales, step)?.min(scales.short(LONGEST_LEAVING))))
}

/// The time in which trajectories leave a state that they start near, for that far away which their density has; 0 where they stay.
fn leaving(problem: &Problem, scales: &TimeScales, step: f64) -> Result<f64> {
    let growth = scales.growth(problem);
    if growth == 0.0 {
        return Ok(0.0);
    }
    let (spread, deviations) = (spread(problem, 1.0, step), TimeScales::deviations(problem)?);
    let far = deviations.iter().zip(&spread).map(|(end, start)| end / start).fold(1.0, f64::max);
    Ok((LEAVING + far.ln()) / growth)
}

/// The deviations of the Gaussian closure, where trajectories that start near rest would take too long to leave.
fn wide(problem: &Problem, step: f64) -> Result<Option<Vec<f64>>> {
    let scales = TimeScales::of(problem)?;
    let long = leaving(problem, &scales, step)? > scales.short(LONGEST_LEAVING);
    if long { Ok(Some(TimeScales::deviations(problem)?)) } else { Ok(None) }
}

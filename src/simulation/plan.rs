use super::{
    bins::Axis,
    boundaries::Boundaries,
    generator::ControlVariates,
    layout::TallyLayout,
    passage::Passages,
    pilot::SimulationPilot,
    statistics::{Recorders, Requests},
    timetable::Timetable,
};
use crate::polynomial::Polynomial;
use crate::problem::Problem;
use crate::simulation::BURN_IN_STRETCHES;
use crate::walls::Wall;
use serde::{Deserialize, Serialize};

/// The options and settings that determine the results of a simulation of given length: two runs of one plan have the same
/// results.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct Plan {
    /// The system's equations, term by term.
    pub(super) equations: Vec<String>,
    pub(super) walls: Vec<Wall>,
    pub(super) seed: u64,
    pub(super) trajectories: usize,
    pub(super) time_step: f64,
    /// The rate ω that the time step was chosen by.
    pub(super) rate: Option<f64>,
    pub(super) timetable: Timetable,
    /// The point, or a mean and the lower Cholesky factor of a covariance by rows; empty by default.
    pub(super) start: Vec<Vec<f64>>,
    pub(super) levels: Vec<f64>,
    /// The displacements, each with the state that is its velocity.
    pub(super) displacements: Vec<(usize, usize)>,
    pub(super) axes: Vec<Axis>,
    pub(super) plane: Option<[Axis; 2]>,
    pub(super) requests: Requests,
    pub(super) control_variates: ControlVariates,
}

/// The Itô equations of a problem as text, every coefficient with all its digits.
pub(crate) fn equations(problem: &Problem) -> Vec<String> {
    let text = |p: &Polynomial| {
        let terms = p.terms().map(|(m, c)| format!("{c:?} x^{m:?}")).collect::<Vec<_>>().join(" + ");
        if p.is_plain() { terms } else { format!("{terms} with {:?}", p.functions()) }
    };
    let rows = problem.operator().drift().iter().enumerate();
    rows.map(|(i, drift)| {
        let columns = problem.columns().iter().enumerate();
        let noise: String = columns.map(|(k, column)| format!(" + ({}) dW{}", text(&column[i]), k + 1)).collect();
        let impulses = problem.impulses().iter();
        let impulses: String =
            impulses.map(|impulse| format!(" + ({}) d{:?}", text(&impulse.field()[i]), impulse.process())).collect();
        format!("dx{} = ({}) dt{noise}{impulses}", i + 1, text(drift))
    })
    .collect()
}

/// Whether two levels are the same up to rounding.
pub(super) fn same_level(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (a.abs() + b.abs() + 1e-300)
}

impl Plan {
    pub(super) fn layout(&self) -> TallyLayout {
        let layout = TallyLayout::new(self.axes.clone(), self.plane, &self.requests.moments, Recorders::new(self));
        layout.with(self.control_variates.clone(), self.displacements.len(), self.gates())
    }

    /// The velocity of state 0.
    pub(super) fn velocity(&self) -> Option<usize> {
        self.velocity_of(0)
    }

    fn velocity_of(&self, state: usize) -> Option<usize> {
        self.displacements.iter().find(|&&(displacement, _)| displacement == state).map(|&(_, velocity)| velocity)
    }

    /// The number of levels and walls whose passages are counted; the walls are the last.
    pub(super) fn gates(&self) -> usize {
        self.levels.len() + self.walls.len()
    }

    /// The bins of the speeds at impacts, as many as those of a state and as far as the velocities reach; none without a wall.
    pub(super) fn impact_speeds(&self) -> Option<Axis> {
        let reach = |state: usize| {
            let axis = &self.axes[self.velocity_of(state)?];
            Some(axis.edge(0).abs().max(axis.edge(axis.bins()).abs()))
        };
        let fastest = |wall: &Wall| Some(reach(wall.state())? + wall.other().map_or(Some(0.0), reach)?);
        let fastest = self.walls.iter().filter_map(fastest).reduce(f64::max)?;
        Axis::new(0.0, fastest, self.axes[0].bins()).ok()
    }

    /// The time between two samples.
    pub(super) fn interval(&self) -> f64 {
        self.timetable.interval_steps as f64 * self.time_step
    }

    /// Boundaries on which the passages of this plan are counted, all of them recorded for control variates.
    pub(super) fn counted_by(&self, boundaries: Boundaries) -> Boundaries {
        let counting = boundaries.counting(self.levels.clone(), self.impact_speeds(), self.interval());
        counting.recording(!self.control_variates.is_empty())
    }

    /// The time before the first sample.
    pub(super) fn burn_in(&self) -> f64 {
        self.timetable.steps(BURN_IN_STRETCHES) as f64 * self.time_step
    }

    /// The path-steps of the pilot and of `trajectories` trajectories with so many samples each.
    pub(super) fn path_steps(&self, trajectories: usize, samples: usize) -> u64 {
        self.pilot_steps() + (trajectories * self.timetable.steps(BURN_IN_STRETCHES + samples)) as u64
    }

    pub(super) fn pilot_steps(&self) -> u64 {
        SimulationPilot::path_steps(&self.timetable)
    }

    /// The first option by which a run of another plan makes other numbers, with both values.
    pub(super) fn difference(&self, other: &Self) -> Option<String> {
        if *self == (Plan { rate: self.rate, ..other.clone() }) {
            return None;
        }
        let options = |plan: &Self| {
            [
                ("system", plan.equations.join(", ")),
                ("list of walls", format!("{:?}", plan.walls)),
                ("seed", plan.seed.to_string()),
                ("number of trajectories", plan.trajectories.to_string()),
                ("time step", plan.time_step.to_string()),
                ("burn-in", plan.burn_in().to_string()),
                ("sampling interval", plan.interval().to_string()),
                ("start", format!("{:?}", plan.start)),
                ("list of levels", format!("{:?}", plan.levels)),
                ("number of bins", plan.axes[0].bins().to_string()),
                ("list of further statistics", format!("{:?}", plan.requests)),
            ]
        };
        let differing = options(self).into_iter().zip(options(other)).find(|(here, there)| here != there);
        let text = |((what, here), (_, there)): ((&str, String), (&str, String))| {
            format!("its {what} is {there}, here {here}")
        };
        Some(differing.map_or_else(|| String::from("its control variates or histograms are others"), text))
    }

    /// Passages before the first one, as every batch of the plan begins with.
    pub(super) fn passages(&self) -> Passages {
        Passages::new([self.levels.len(), self.walls.len(), self.equations.len()], self.impact_speeds())
    }
}

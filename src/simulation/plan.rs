use super::{
    histogram::Axis,
    pilot::Pilot,
    statistics::{Questions, Watch},
    store::{Reader, Stored, stored},
    tally::Layout,
    timetable::{BURN_IN_STRETCHES, Timetable},
};
use crate::{Arena, Barrier, Error, FokkerPlanck, Polynomial, PolynomialDrift, Result, Symbol};

/// All that decides which numbers a simulation of given length finds: two runs of one plan are one run.
#[derive(Clone, Debug)]
pub(super) struct Plan<const N: usize> {
    /// The system's equations, term by term.
    pub(super) equations: Vec<String>,
    pub(super) seed: u64,
    pub(super) trajectories: usize,
    pub(super) time_step: f64,
    /// The rate ω that the time step was chosen by.
    pub(super) rate: Option<f64>,
    pub(super) timetable: Timetable,
    pub(super) start: Option<[f64; N]>,
    pub(super) barrier: Option<Barrier>,
    pub(super) levels: Vec<f64>,
    /// The velocity of state 0.
    pub(super) velocity: Option<usize>,
    pub(super) axes: [Axis; N],
    pub(super) plane: Option<[Axis; 2]>,
    pub(super) questions: Questions<N>,
}
stored!(Plan[N] {
    equations, seed, trajectories, time_step, rate, timetable, start, barrier, levels, velocity, axes, plane, questions
});

impl Stored for Barrier {
    fn write(&self, out: &mut Vec<u8>) {
        [self.offset(), self.restitution()].write(out);
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        let [offset, restitution] = Stored::read(input)?;
        Barrier::new(offset, restitution).ok()
    }
}

/// The equations of a system as text, every coefficient with all its digits.
pub(super) fn equations<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(
    system: &T,
    operator: &FokkerPlanck<N>,
) -> Vec<String> {
    let arena = Arena::new();
    let noise = system.noise(arena.variables()).map(|row| row.map(Symbol::polynomial));
    let text = |p: &Polynomial<N>| p.terms().map(|(m, c)| format!("{c:?} x^{:?}", m.0)).collect::<Vec<_>>().join(" + ");
    let rows = operator.drift().iter().zip(&noise).enumerate();
    rows.map(|(i, (drift, noise))| {
        let noise: String = noise.iter().enumerate().map(|(k, g)| format!(" + ({}) dW{}", text(g), k + 1)).collect();
        format!("dx{} = ({}) dt{noise}", i + 1, text(drift))
    })
    .collect()
}

impl<const N: usize> Plan<N> {
    pub(super) fn layout(&self) -> Layout<N> {
        let interval = self.timetable.interval_steps as f64 * self.time_step;
        let ends = [self.axes[0].edge(0), self.axes[0].edge(self.axes[0].bins())];
        let floor = self.barrier.map_or(f64::NEG_INFINITY, |wall| wall.offset());
        let watch = Watch::new(&self.questions, interval, (&self.levels, self.velocity), ends, floor);
        Layout::new(self.axes, self.plane, &self.questions.moments, watch)
    }

    /// The bins of the speeds at impacts, as many and as far as those of the velocity; none without a wall.
    pub(super) fn impact_speeds(&self) -> Option<Axis> {
        let velocity = self.velocity.filter(|_| self.barrier.is_some())?;
        let axis = self.axes[velocity];
        Axis::new(0.0, axis.edge(0).abs().max(axis.edge(axis.bins()).abs()), axis.bins()).ok()
    }

    /// The path-steps of the pilot and of `trajectories` trajectories with so many samples each.
    pub(super) fn path_steps(&self, trajectories: usize, samples: usize) -> u64 {
        self.pilot_steps() + (trajectories * self.timetable.steps(BURN_IN_STRETCHES + samples)) as u64
    }

    pub(super) fn pilot_steps(&self) -> u64 {
        Pilot::<N>::path_steps(&self.timetable)
    }

    /// Refuses another plan. Merging allows another seed.
    pub(super) fn same_as(&self, other: &Self, any_seed: bool) -> Result<()> {
        for ((what, here), (_, there)) in self.traits().into_iter().zip(other.traits()) {
            if here != there && !(any_seed && what == "seed") {
                return Err(Error::OtherSimulation { what, found: there, expected: here });
            }
        }
        Ok(())
    }

    fn traits(&self) -> [(&'static str, String); 13] {
        [
            ("system", self.equations.join(", ")),
            ("wall", format!("{:?}", self.barrier)),
            ("seed", self.seed.to_string()),
            ("number of trajectories", self.trajectories.to_string()),
            ("time step", format!("{:?}", self.time_step)),
            ("burn-in in steps", self.timetable.steps(BURN_IN_STRETCHES).to_string()),
            ("sampling interval in steps", self.timetable.interval_steps.to_string()),
            ("start", format!("{:?}", self.start)),
            ("list of levels", format!("{:?}", self.levels)),
            ("range or number of bins", format!("{:?}", self.axes)),
            ("joint histogram", format!("{:?}", self.plane)),
            ("velocity", format!("{:?}", self.velocity)),
            ("list of further statistics", format!("{:?}", self.questions)),
        ]
    }
}

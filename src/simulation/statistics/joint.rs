//! The joint histogram of any two states.

use super::{Sample, Statistic};
use crate::checks::{require, state_index};
use crate::error::{Error, Result};
use crate::simulation::bins::{Axis, Counts};
use crate::simulation::{Histogram, SimulatedDensity, Simulation, plan::Plan, run::at_most};

/// The most pairs of states with a joint histogram: each is some megabytes in all batches together.
const MOST_PAIRS: usize = 16;

impl Simulation<'_> {
    /// Keeps the joint histogram of two states, with half as many bins along each as for a single state. That of states 0 and 1 is
    /// there for any simulation. [`Density::joint_marginal`](crate::Density::joint_marginal) and [`SimulatedDensity::joint`] have it
    /// then.
    ///
    /// ```
    /// use expoly::{Density, Simulation, models::{DuffingChain, Solved}};
    /// let chain = DuffingChain::new(&[0.4, 0.4], 1.0, 0.0, 0.5, 0.45)?;
    /// let found = Simulation::new().samples(200_000).joint([0, 2]).run(&chain.problem()?)?;
    /// let truth = chain.exact()?.joint_marginal([0, 2], [0.3, -0.2])?.value;
    /// assert!(found.joint_marginal([0, 2], [0.3, -0.2])?.deviation(truth) < 4.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn joint(mut self, [first, second]: [usize; 2]) -> Self {
        self.requests.joints.push([first.min(second), first.max(second)]);
        self
    }
}

impl SimulatedDensity {
    /// The joint histogram of two states, the one with the lower number first.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there is no such state; [`Error::NotKnown`] if it is none of states 0 and 1 and was not requested by
    /// [`Simulation::joint`].
    pub fn joint(&self, states: [usize; 2]) -> Result<Histogram> {
        let [first, second] = states;
        states.iter().try_for_each(|state| state_index("a state's index", *state, self.layout.axes.len()).map(drop))?;
        let pair = [first.min(second), first.max(second)];
        if let (Some(histogram), [0, 1]) = (self.plane(), pair) {
            return Ok(histogram.clone());
        }
        let joints = &self.layout.recorders.joints;
        let place = joints.iter().position(|joint| joint.states == pair).ok_or_else(|| Error::NotKnown {
            what: format!("the joint density of states {first} and {second}"),
            remedy: "request it by `Simulation::joint` before the run",
        })?;
        let counts = self.batches.iter().map(|b| b.recordings.joints[place].clone()).collect();
        Ok(Histogram::new(&joints[place].axes, counts))
    }
}

/// The bins of two states.
#[derive(Clone, Debug)]
pub(in crate::simulation) struct JointBins {
    states: [usize; 2],
    axes: [Axis; 2],
}

impl Statistic for JointBins {
    type Request = [usize; 2];
    type Sums = Counts;
    type Path = ();

    fn check(requests: &[[usize; 2]], states: usize, _: f64) -> Result<()> {
        at_most("number of joint histograms", requests.len(), MOST_PAIRS, "at most 16 can be kept")?;
        for (k, pair) in requests.iter().enumerate() {
            pair.iter()
                .try_for_each(|state| state_index("the state of a joint histogram", *state, states).map(drop))?;
            let [first, second] = pair.map(|state| state as f64);
            require(first < second, "state of a joint histogram", second, "give two states that differ")?;
            let remedy = "the joint histogram of these two states is requested twice";
            require(!requests[..k].contains(pair), "state of a joint histogram", second, remedy)?;
        }
        Ok(())
    }

    fn of(states: &[usize; 2], plan: &Plan) -> Result<Self> {
        let [first, second] = states.map(|state| plan.axes[state].halved());
        Ok(JointBins { states: *states, axes: [first?, second?] })
    }

    fn sums(&self) -> Counts {
        Counts::new(&self.axes)
    }

    fn observe(&self, sums: &mut Counts, (): &mut (), sample: &Sample<'_>) {
        sums.add(&self.axes, &self.states.map(|state| sample.x[state]));
    }
}

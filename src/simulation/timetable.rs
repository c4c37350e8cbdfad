use crate::simulation::BURN_IN_STRETCHES;
use serde::{Deserialize, Serialize};

/// Samples of each trajectory before the first check of precision.
const FIRST_CHECK: usize = 8;
/// Path-steps of all trajectories in one round, about: some hundredths of a second.
const ROUND: usize = 1 << 21;
/// Path-steps of all trajectories beyond which a stretch can be given up on its way, at the price of a copy of their states:
/// more than about a second.
const LONG: usize = 1 << 26;

/// The time before the first sample and that between two, in the user's unit of time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    pub(super) burn_in: f64,
    pub(super) interval: f64,
}

/// A count rounded up to a whole number; what rounding alone has put above one is that one.
pub(super) fn whole(count: f64) -> f64 {
    (count * (1.0 - 1e-12)).ceil()
}

/// The path of every trajectory, cut into stretches: first those of the burn-in, then one for each sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) struct Timetable {
    /// Time steps in each stretch of the burn-in.
    pub(super) burn_in_steps: usize,
    /// Time steps between two samples.
    pub(super) interval_steps: usize,
}

impl Timetable {
    /// The time steps in the first `stretches` stretches.
    pub(super) fn steps(&self, stretches: usize) -> usize {
        let samples = samples(stretches);
        (stretches - samples) * self.burn_in_steps + samples * self.interval_steps
    }

    /// Whether stretch number `stretch` is long for so many trajectories.
    pub(super) fn is_long(&self, stretch: usize, trajectories: usize) -> bool {
        let steps = self.steps(stretch + 1) - self.steps(stretch);
        steps.saturating_mul(trajectories) > LONG
    }

    /// The time that `trajectories` take for so many samples each, with the time step h.
    pub(super) fn sampled_time(&self, samples: usize, trajectories: usize, h: f64) -> f64 {
        (samples * self.interval_steps) as f64 * h * trajectories as f64
    }

    /// The end of the next round: stretches that every trajectory completes before the next decision. It depends on
    /// `trajectories`, their number in the whole simulation, so that rounds end at the same places in all its parts.
    pub(super) fn next_round(&self, done: usize, trajectories: usize) -> usize {
        let (first, steps) =
            if done < BURN_IN_STRETCHES { (0, self.burn_in_steps) } else { (BURN_IN_STRETCHES, self.interval_steps) };
        let round = (ROUND / trajectories.saturating_mul(steps)).max(1);
        let end = first + ((done - first) / round + 1).saturating_mul(round);
        if first == 0 { end.min(BURN_IN_STRETCHES) } else { end }
    }
}

/// The samples of each trajectory after so many stretches.
pub(super) fn samples(stretches: usize) -> usize {
    stretches.saturating_sub(BURN_IN_STRETCHES)
}

/// The number of samples per trajectory at the first check of precision after `samples`: each check is an eighth after the
/// one before. Where they fall depends on nothing else, so that a run that stops there can be repeated bit for bit; and they
/// are few, since each check of a standard error that is itself uncertain is one more chance to stop too soon.
pub(super) fn next_check(samples: usize) -> usize {
    let mut check = FIRST_CHECK;
    while check <= samples {
        check += check / 8;
    }
    check
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_end_with_the_burn_in_and_on_a_fixed_grid() {
        let timetable = Timetable { burn_in_steps: 40, interval_steps: 50 };
        assert_eq!(timetable.next_round(0, 1024), 51);
        assert_eq!(timetable.next_round(51, 1024), 64);
        assert_eq!(timetable.next_round(64, 1024), 104);
        assert_eq!((timetable.next_round(70, 1024), timetable.next_round(103, 1024)), (104, 104));
        assert_eq!(timetable.next_round(104, usize::MAX), 105);
        assert_eq!(timetable.steps(66), 64 * 40 + 2 * 50);
    }

    #[test]
    fn checks_are_an_eighth_apart() {
        let checks: Vec<usize> = std::iter::successors(Some(0), |&n| Some(next_check(n))).skip(1).take(6).collect();
        assert_eq!(checks, [8, 9, 10, 11, 12, 13]);
        assert_eq!(next_check(1000), next_check(1001));
        assert!((1000..=1125).contains(&next_check(1000)));
    }
}

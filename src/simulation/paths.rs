use crate::states::States;

/// States of trajectories at equal intervals: trajectory by trajectory, and each in order of time; and the impacts on the way.
#[derive(Clone, Debug)]
pub(crate) struct Paths {
    pub(crate) states: States,
    pub(crate) collisions: Collisions,
    /// The time from state to state.
    pub(crate) interval: f64,
}

/// The impacts on the way of trajectories.
#[derive(Clone, Debug)]
pub(crate) struct Collisions {
    pub(crate) impacts: Vec<Impact>,
    /// The state at each, with the velocities of approach.
    pub(crate) states: States,
}

/// An impact at a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Impact {
    /// The number of the wall.
    pub(crate) wall: usize,
    /// The place of the state that follows.
    pub(crate) next: usize,
}

impl Paths {
    /// No states yet, with room for some.
    pub(super) fn new(dimension: usize, count: usize) -> Self {
        let collisions = Collisions { impacts: Vec::new(), states: States::new(dimension) };
        Paths { states: States::with_capacity(dimension, count), collisions, interval: 0.0 }
    }

    /// One after the other.
    pub(super) fn joined(dimension: usize, parts: &[Paths]) -> Self {
        let mut all = Paths::new(dimension, parts.iter().map(|part| part.states.len()).sum());
        for Paths { states, collisions, .. } in parts {
            let before = all.states.len();
            let impacts = collisions.impacts.iter().map(|impact| Impact { next: before + impact.next, ..*impact });
            all.collisions.impacts.extend(impacts);
            all.collisions.states.extend(&collisions.states);
            all.states.extend(states);
        }
        all
    }

    /// Adds an impact before the next state.
    pub(super) fn collided(&mut self, wall: usize, at: &[f64]) {
        self.collisions.impacts.push(Impact { wall, next: self.states.len() });
        self.collisions.states.push(at);
    }
}

use serde::{Deserialize, Serialize};

/// The part of R^n outside of which a density is 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Support {
    /// All of it.
    WholeSpace,
    /// The half space in which state 0 is at least this: above a wall.
    Above(f64),
    /// A box, as pairs of lower and upper limit. Outside, the density has been set to 0.
    Region(Vec<[f64; 2]>),
}

impl Support {
    /// Whether the value `x` of state `state` lies inside, for any values of the other states.
    pub fn contains(&self, state: usize, x: f64) -> bool {
        match self {
            Support::WholeSpace => true,
            Support::Above(bound) => state > 0 || x >= *bound,
            Support::Region(limits) => limits.get(state).is_some_and(|[low, high]| (*low..=*high).contains(&x)),
        }
    }
}

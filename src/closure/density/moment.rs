use crate::record::number;
use serde::{Deserialize, Serialize};

/// A raw moment with its standard error.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Moment {
    pub(in crate::closure) powers: Vec<u32>,
    #[serde(with = "number")]
    pub(in crate::closure) value: f64,
    #[serde(with = "number")]
    pub(in crate::closure) error: f64,
}

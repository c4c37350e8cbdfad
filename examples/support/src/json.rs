//! Numbers that are an error instead of `null`: JSON has no NaN and no infinity, and serde_json writes both as `null`.

use serde::{Serialize, Serializer, ser::Error};

/// A number in a JSON document. Serialising one that is NaN or infinite is an error that names it.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    name: &'static str,
    value: f64,
}

impl Number {
    /// The number `value` under the name that an error should give.
    pub fn new(name: &'static str, value: f64) -> Self {
        Number { name, value }
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.value.is_finite() {
            serializer.serialize_f64(self.value)
        } else {
            Err(S::Error::custom(format!("{} = {} has no place in JSON", self.name, self.value)))
        }
    }
}

/// An estimate with its standard error.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sampled {
    value: Number,
    standard_error: Number,
}

impl Sampled {
    /// The estimate under the name that an error should give.
    pub fn new(name: &'static str, estimate: expoly::Estimate) -> Self {
        Sampled { value: Number::new(name, estimate.value), standard_error: Number::new(name, estimate.error) }
    }
}

//! Numbers that leave the program as text and come back bit for bit.

/// The result of a reader; its error is the end of a sentence that begins with the document's name.
pub(crate) type Read<T> = Result<T, String>;

/// A number that may be infinite or no number at all, which JSON has no signs for: a text holds them as words. A binary
/// document holds every number as it is.
pub(crate) mod number {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Clone, Copy)]
    struct AnyNumber(f64);

    impl Serialize for AnyNumber {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            if self.0.is_finite() || !serializer.is_human_readable() {
                serializer.serialize_f64(self.0)
            } else {
                serializer.collect_str(&self.0)
            }
        }
    }

    impl<'de> Deserialize<'de> for AnyNumber {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            #[derive(Deserialize)]
            #[serde(untagged, expecting = "expected a number, \"inf\", \"-inf\" or \"NaN\"")]
            enum Either {
                Number(f64),
                Word(Word),
            }
            #[derive(Deserialize)]
            enum Word {
                #[serde(rename = "inf")]
                Infinite,
                #[serde(rename = "-inf")]
                MinusInfinite,
                NaN,
            }
            if !deserializer.is_human_readable() {
                return f64::deserialize(deserializer).map(AnyNumber);
            }
            Ok(AnyNumber(match Either::deserialize(deserializer)? {
                Either::Number(value) => value,
                Either::Word(Word::Infinite) => f64::INFINITY,
                Either::Word(Word::MinusInfinite) => f64::NEG_INFINITY,
                Either::Word(Word::NaN) => f64::NAN,
            }))
        }
    }

    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        AnyNumber(*value).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        AnyNumber::deserialize(deserializer).map(|number| number.0)
    }

    /// The same for a number that may be missing.
    pub(crate) mod option {
        use super::{AnyNumber, Deserialize, Deserializer, Serialize, Serializer};

        pub(crate) fn serialize<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
            value.map(AnyNumber).serialize(serializer)
        }

        pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
            Ok(Option::<AnyNumber>::deserialize(deserializer)?.map(|number| number.0))
        }
    }
}

/// Refuses a list that has not one finite number for each state.
pub(crate) fn states(what: &str, values: &[f64], states: usize) -> Read<()> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("{what} holds {value}")),
        None if values.len() != states => Err(format!("{what} holds {} numbers for {states} states", values.len())),
        None => Ok(()),
    }
}

/// Refuses a list that has not one finite positive number for each state.
pub(crate) fn positive_states(what: &str, values: &[f64], count: usize) -> Read<()> {
    match values.iter().find(|value| **value <= 0.0) {
        Some(value) => Err(format!("{what} holds {value}, which is not above zero")),
        None => states(what, values, count),
    }
}

/// Refuses a number that is not finite and positive.
pub(crate) fn positive(what: &str, value: f64) -> Read<f64> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{what} = {value} is not above zero")) }
}

/// Refuses exponents that are not one for each state, none above `highest`.
pub(crate) fn exponents(values: &[u32], states: usize, highest: u32) -> Read<()> {
    if values.len() == states && values.iter().all(|power| *power <= highest) {
        return Ok(());
    }
    Err(format!("the exponents {values:?} do not fit {states} states and powers up to {highest}"))
}

/// FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo): it detects accidental damage, not deliberate changes.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::{Deserialize, Serialize};

    #[derive(Debug, Deserialize, Serialize)]
    struct Example {
        #[serde(with = "number")]
        one: f64,
        #[serde(with = "number::option")]
        maybe: Option<f64>,
    }

    #[test]
    fn numbers_without_a_sign_come_back_from_text_and_from_bytes() -> Result<(), Box<dyn std::error::Error>> {
        let all = Example { one: f64::NAN, maybe: Some(f64::NEG_INFINITY) };
        let text = serde_json::to_string(&all)?;
        assert_eq!(text, r#"{"one":"NaN","maybe":"-inf"}"#);
        let bytes = postcard::to_stdvec(&all)?;
        for back in [serde_json::from_str::<Example>(&text)?, postcard::from_bytes(&bytes)?] {
            assert!(back.one.is_nan() && back.maybe == all.maybe);
        }
        assert!(serde_json::from_str::<Example>(r#"{"one":"all","maybe":null}"#).is_err());
        Ok(())
    }
}

//! Numbers that leave the program as text and come back bit for bit.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What a reader finds wrong, in words for a sentence that begins with the document's name.
pub(crate) type Read<T> = Result<T, String>;

/// A number that may be infinite or no number at all, which JSON has no signs for: they are written as words.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number(pub(crate) f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() { serializer.serialize_f64(self.0) } else { serializer.collect_str(&self.0) }
    }
}

impl<'de> Deserialize<'de> for Number {
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
        Ok(Number(match Either::deserialize(deserializer)? {
            Either::Number(value) => value,
            Either::Word(Word::Infinite) => f64::INFINITY,
            Either::Word(Word::MinusInfinite) => f64::NEG_INFINITY,
            Either::Word(Word::NaN) => f64::NAN,
        }))
    }
}

/// One number for each state, all finite.
pub(crate) fn states<const N: usize>(what: &str, values: &[f64]) -> Read<[f64; N]> {
    values
        .iter()
        .try_for_each(|value| if value.is_finite() { Ok(()) } else { Err(format!("{what} holds {value}")) })
        .and_then(|()| values.try_into().map_err(|_| format!("{what} holds {} numbers for {N} states", values.len())))
}

/// One positive number for each state.
pub(crate) fn positive_states<const N: usize>(what: &str, values: &[f64]) -> Read<[f64; N]> {
    match values.iter().find(|value| **value <= 0.0) {
        Some(value) => Err(format!("{what} holds {value}, which is not above zero")),
        None => states(what, values),
    }
}

/// Refuses a number that is not finite and positive.
pub(crate) fn positive(what: &str, value: f64) -> Read<f64> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(format!("{what} = {value} is not above zero")) }
}

/// The exponents of one monomial, none above `highest`.
pub(crate) fn exponents<const N: usize>(values: &[u32], highest: u32) -> Read<[u32; N]> {
    let fits = values.iter().all(|power| *power <= highest);
    let array: Option<[u32; N]> = values.try_into().ok().filter(|_| fits);
    array.ok_or_else(|| format!("the exponents {values:?} do not fit {N} states and powers up to {highest}"))
}

/// FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo): it guards against accidents, not against intent.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

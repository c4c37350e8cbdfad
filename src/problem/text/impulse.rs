//! Impulses from text and to text.

use super::read::{Entry, TextDocument};
use super::written::{Formula, WrittenImpulse};
use crate::error::Result;
use crate::system::Amplitude;
use num_dual::Dual64;
use toml::de::DeTable;

/// The remedy for a law that is none.
const LAWS: &str = "give one law: amplitude = { normal = { mean = 0, deviation = 0.3 } }, { exponential = { mean = 0.2 } }, \
{ uniform = { low = -1, high = 1 } }, { two_point = { a = -0.3, b = 0.3 } } or { laplace = { mean = 0, scale = 0.2 } }";

/// A law of amplitudes, by its numbers.
pub(super) type Law = fn(&[Dual64]) -> Amplitude<Dual64>;

/// The laws, with the names of their numbers.
const KNOWN: [(&str, &[&str], Law); 5] = [
    ("normal", &["mean", "deviation"], |y| Amplitude::Normal { mean: y[0], deviation: y[1] }),
    ("exponential", &["mean"], |y| Amplitude::Exponential { mean: y[0] }),
    ("uniform", &["low", "high"], |y| Amplitude::Uniform { low: y[0], high: y[1] }),
    ("two_point", &["a", "b"], |y| Amplitude::TwoPoint { a: y[0], b: y[1] }),
    ("laplace", &["mean", "scale"], |y| Amplitude::Laplace { mean: y[0], scale: y[1] }),
];

impl TextDocument<'_> {
    /// The impulses of a table.
    pub(super) fn impulse(
        self,
        name: &str,
        table: &DeTable<'_>,
        place: usize,
        states: &[String],
    ) -> Result<WrittenImpulse> {
        let rate = match table.get("rate") {
            Some(rate) => self.formula(name, rate)?,
            None => return self.wrong(place, name, "it has no rate; rate = 2.0 is two impulses per unit time"),
        };
        let (law, numbers) = match table.get("amplitude") {
            Some(amplitude) => self.law(name, amplitude)?,
            None => return self.wrong(place, name, LAWS),
        };
        let field = self.by_state(table, (name, &["rate", "amplitude"]), states)?;
        Ok(WrittenImpulse { name: name.to_owned(), place, rate, law, numbers, field })
    }

    fn law(self, name: &str, value: &Entry<'_>) -> Result<(Law, Vec<Formula>)> {
        let place = value.span().start;
        let laws = self.table(name, value)?;
        let (Some((law, numbers)), 1) = (laws.iter().next(), laws.len()) else { return self.wrong(place, name, LAWS) };
        let law = law.get_ref().as_ref();
        let numbers = self.table(law, numbers)?;
        let Some((_, entries, of)) = KNOWN.iter().find(|(known, ..)| *known == law) else {
            return self.wrong(place, law, LAWS);
        };
        self.known(numbers, law, entries)?;
        let number = |name: &&str| match numbers.get(*name) {
            Some(value) => self.formula(name, value),
            None => self.wrong(place, name, LAWS),
        };
        Ok((*of, entries.iter().map(number).collect::<Result<_>>()?))
    }
}

/// A law as the inline table that it is read from.
pub(super) fn law(amplitude: Amplitude) -> String {
    match amplitude {
        Amplitude::Normal { mean, deviation } => {
            format!("{{ normal = {{ mean = {mean:?}, deviation = {deviation:?} }} }}")
        }
        Amplitude::Exponential { mean } => format!("{{ exponential = {{ mean = {mean:?} }} }}"),
        Amplitude::Uniform { low, high } => format!("{{ uniform = {{ low = {low:?}, high = {high:?} }} }}"),
        Amplitude::TwoPoint { a, b } => format!("{{ two_point = {{ a = {a:?}, b = {b:?} }} }}"),
        Amplitude::Laplace { mean, scale } => format!("{{ laplace = {{ mean = {mean:?}, scale = {scale:?} }} }}"),
    }
}

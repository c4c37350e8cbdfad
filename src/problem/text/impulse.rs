//! Impulses from text and to text.

use super::read::{Entry, TextDocument};
use crate::error::Result;
use crate::fokker_planck::Impulse;
use crate::polynomial::Polynomial;
use crate::problem::expression::Names;
use crate::system::{Amplitude, PoissonImpulses};
use num_dual::Dual64;
use toml::de::DeTable;

/// The remedy for a law that is none.
const LAWS: &str = "give one law: amplitude = { normal = { mean = 0, deviation = 0.3 } }, { exponential = { mean = 0.2 } }, \
{ uniform = { low = -1, high = 1 } }, { two_point = { a = -0.3, b = 0.3 } } or { laplace = { mean = 0, scale = 0.2 } }";

impl TextDocument<'_> {
    /// The impulses of a table.
    pub(super) fn impulse(
        self,
        name: &str,
        table: &DeTable<'_>,
        place: usize,
        names: &Names,
    ) -> Result<Impulse<Dual64>> {
        let rate = match table.get("rate") {
            Some(rate) => self.dual(name, rate, &names.parameters)?,
            None => return self.wrong(place, name, "it has no rate; rate = 2.0 is two impulses per unit time"),
        };
        let amplitude = match table.get("amplitude") {
            Some(amplitude) => self.amplitude(name, amplitude, names)?,
            None => return self.wrong(place, name, LAWS),
        };
        let field = self.by_state(table, (name, &["rate", "amplitude"]), names)?;
        let zero = || Polynomial::zero(names.variables());
        let field = field.into_iter().map(|entry| entry.unwrap_or_else(zero)).collect();
        let impulses = PoissonImpulses::of(rate, amplitude)
            .checked()
            .or_else(|error| self.wrong(place, name, error.to_string()))?;
        Ok(Impulse::new(impulses, field))
    }

    fn amplitude(self, name: &str, value: &Entry<'_>, names: &Names) -> Result<Amplitude<Dual64>> {
        let place = value.span().start;
        let laws = self.table(name, value)?;
        let (Some((law, numbers)), 1) = (laws.iter().next(), laws.len()) else { return self.wrong(place, name, LAWS) };
        let law = law.get_ref().as_ref();
        let numbers = self.table(law, numbers)?;
        let all = |entries: &[&str]| -> Result<Vec<Dual64>> {
            self.known(numbers, law, entries)?;
            let number = |name: &&str| match numbers.get(*name) {
                Some(value) => self.dual(name, value, &names.parameters),
                None => self.wrong(place, name, LAWS),
            };
            entries.iter().map(number).collect()
        };
        Ok(match law {
            "normal" => {
                let numbers = all(&["mean", "deviation"])?;
                Amplitude::Normal { mean: numbers[0], deviation: numbers[1] }
            }
            "exponential" => Amplitude::Exponential { mean: all(&["mean"])?[0] },
            "uniform" => {
                let numbers = all(&["low", "high"])?;
                Amplitude::Uniform { low: numbers[0], high: numbers[1] }
            }
            "two_point" => {
                let numbers = all(&["a", "b"])?;
                Amplitude::TwoPoint { a: numbers[0], b: numbers[1] }
            }
            "laplace" => {
                let numbers = all(&["mean", "scale"])?;
                Amplitude::Laplace { mean: numbers[0], scale: numbers[1] }
            }
            _ => return self.wrong(place, law, LAWS),
        })
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

//! The reference table of Duffing oscillators above a wall, `tests/reference/vibro_impact.csv`.

use expoly::models::Duffing;
use expoly::{Density, Estimate, Problem, Result, SimulatedDensity, Wall};
use serde::Deserialize;
use std::path::Path;

/// A row of the table: the parameters, the values, and by how much each differs between the two meshes that it is from.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Row {
    /// Damping c.
    pub c: f64,
    /// Stiffness k.
    pub k: f64,
    /// Cubic stiffness μ.
    pub mu: f64,
    /// Offset b of the wall.
    pub b: f64,
    /// Restitution r.
    pub r: f64,
    /// Intensity D.
    #[serde(rename = "D")]
    pub d: f64,
    /// E y.
    #[serde(rename = "E_y")]
    pub mean: f64,
    /// Var y.
    #[serde(rename = "Var_y")]
    pub variance: f64,
    /// E y′².
    #[serde(rename = "E_v2")]
    pub square: f64,
    /// The skewness of y′ about zero.
    #[serde(rename = "skew_v")]
    pub skewness: f64,
    /// The kurtosis of y′ about zero.
    #[serde(rename = "kurt_v")]
    pub kurtosis: f64,
    /// Impacts per unit time.
    pub impact_rate: f64,
    /// Of E y, relative.
    #[serde(rename = "rel_E_y")]
    pub of_mean: f64,
    /// Of Var y, relative.
    #[serde(rename = "rel_Var_y")]
    pub of_variance: f64,
    /// Of E y′², relative.
    #[serde(rename = "rel_E_v2")]
    pub of_square: f64,
    /// Of the impact rate, relative.
    #[serde(rename = "rel_impact_rate")]
    pub of_rate: f64,
}

/// Impact rates for strong losses, as (b, r, rate), from the library's grid of degree 9 with cells down to 1e-4:
/// those of the table are up to 0.6 % low there.
const REFINED_RATES: [[f64; 3]; 4] =
    [[0.5, 0.7, 0.7665531], [0.2, 0.7, 0.492937], [-0.5, 0.7, 0.2025310], [-0.5, 0.5, 0.2052083]];
/// The relative uncertainty of [`REFINED_RATES`].
const REFINED: f64 = 1e-6;

/// A number of the table beside that of a simulation.
#[derive(Clone, Copy, Debug)]
pub struct Statistic {
    /// Its name.
    pub name: &'static str,
    /// The table's value, with the difference of two meshes as its error.
    pub truth: Estimate,
    /// The scale of a standard error: the value itself; of E y the standard deviation, and 1 for the skewness, which may be
    /// zero.
    pub scale: f64,
    /// The simulation's value.
    pub found: Estimate,
}

impl Statistic {
    /// The deviation of the simulation from the table, in standard errors, with its sign.
    pub fn deviation(&self) -> f64 {
        (self.found.value - self.truth.value) / self.found.error.hypot(self.truth.error)
    }
}

impl Row {
    /// The oscillator above its wall.
    ///
    /// # Errors
    /// Those of the model.
    pub fn problem(&self) -> Result<Problem> {
        Problem::of(Duffing::new(self.c, self.k, self.mu, self.d)?)?.with_wall(Wall::above(self.b, self.r)?)
    }

    /// The same row with the impact rate of the finer mesh where there is one.
    pub fn refined(self) -> Self {
        let refined = REFINED_RATES.iter().find(|[b, r, _]| [self.b, self.r] == [*b, *r]);
        refined.map_or(self, |[.., rate]| Row { impact_rate: *rate, of_rate: REFINED, ..self })
    }

    /// Every number of the refined row beside that of a simulation of its oscillator.
    ///
    /// # Errors
    /// Those of the simulation's answers.
    pub fn beside(self, result: &SimulatedDensity) -> Result<[Statistic; 6]> {
        let row = self.refined();
        let statistic = |name, value: f64, relative: f64, scale: f64, found| Statistic {
            name,
            truth: Estimate::new(value, relative * scale),
            scale,
            found,
        };
        let rate = result.impact_rate().unwrap_or(Estimate::exact(f64::NAN));
        Ok([
            statistic("E y", row.mean, row.of_mean, row.variance.sqrt(), result.mean(0)?),
            statistic("Var y", row.variance, row.of_variance, row.variance, result.variance(0)?),
            statistic("E v^2", row.square, row.of_square, row.square, result.moment(&[0, 2])?),
            statistic("skew v", row.skewness, row.of_square, 1.0, result.skewness(1)?),
            statistic("kurt v", row.kurtosis, row.of_square, row.kurtosis, result.kurtosis(1)?),
            statistic("rate", row.impact_rate, row.of_rate, row.impact_rate, rate),
        ])
    }
}

/// All rows of the table.
///
/// # Errors
/// Where the table cannot be read.
pub fn table() -> csv::Result<Vec<Row>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/vibro_impact.csv");
    csv::Reader::from_path(path)?.deserialize().collect()
}

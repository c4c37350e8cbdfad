//! The Duffing oscillator above a wall as options of a command line.

use clap::Args;
use expoly::models::{Duffing, VibroImpactDuffing};
use serde::Serialize;
use std::fmt;

/// The options of one oscillator; what is left out has the values of the standard study.
#[derive(Clone, Copy, Debug, Args)]
pub struct OscillatorOptions {
    /// Damping c [default: 0.2]
    #[arg(long, allow_negative_numbers = true)]
    damping: Option<f64>,
    /// Stiffness k [default: 1]
    #[arg(long, allow_negative_numbers = true)]
    stiffness: Option<f64>,
    /// Cubic stiffness μ [default: 0.3]
    #[arg(long, allow_negative_numbers = true)]
    cubic: Option<f64>,
    /// Position b of the wall [default: 0]
    #[arg(long, allow_negative_numbers = true)]
    offset: Option<f64>,
    /// Coefficient of restitution r, 0 < r ≤ 1 [default: 0.98]
    #[arg(long, allow_negative_numbers = true)]
    restitution: Option<f64>,
    /// Intensity D [default: 0.2]
    #[arg(long, allow_negative_numbers = true)]
    intensity: Option<f64>,
}

/// The parameters of one oscillator and its wall.
#[derive(Clone, Copy, Debug, Serialize)]
#[allow(missing_docs, reason = "the options say what each is")]
pub struct Oscillator {
    pub damping: f64,
    pub stiffness: f64,
    pub cubic: f64,
    pub offset: f64,
    pub restitution: f64,
    pub intensity: f64,
}

impl OscillatorOptions {
    /// The oscillator that the options describe above one of the standard walls.
    fn above(&self, [offset, restitution]: [f64; 2]) -> Oscillator {
        Oscillator {
            damping: self.damping.unwrap_or(0.2),
            stiffness: self.stiffness.unwrap_or(1.0),
            cubic: self.cubic.unwrap_or(0.3),
            offset: self.offset.unwrap_or(offset),
            restitution: self.restitution.unwrap_or(restitution),
            intensity: self.intensity.unwrap_or(0.2),
        }
    }

    /// The oscillator that the options describe; where none is given, that of the standard study above each of its walls,
    /// but for `single`.
    pub fn cases(&self, single: bool) -> Vec<Oscillator> {
        let given = [self.damping, self.stiffness, self.cubic, self.offset, self.restitution, self.intensity];
        let walls = VibroImpactDuffing::STANDARD_WALLS;
        let single = single || given.iter().any(Option::is_some);
        walls[..if single { 1 } else { walls.len() }].iter().map(|wall| self.above(*wall)).collect()
    }
}

impl Oscillator {
    /// The library's model.
    ///
    /// # Errors
    /// Those of the model.
    pub fn model(&self) -> expoly::Result<VibroImpactDuffing> {
        let duffing = Duffing::new(self.damping, self.stiffness, self.cubic, self.intensity)?;
        VibroImpactDuffing::new(duffing, self.offset, self.restitution)
    }
}

impl fmt::Display for Oscillator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Oscillator { damping, stiffness, cubic, offset, restitution, intensity } = self;
        write!(f, "b = {offset}, r = {restitution}, c = {damping}, k = {stiffness}, μ = {cubic}, D = {intensity}")
    }
}

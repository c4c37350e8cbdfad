//! What several tests need.
#![allow(clippy::unwrap_used, reason = "a test's own input that is wrong should fail the test")]
#![allow(dead_code, unreachable_pub, reason = "each test compiles its own copy and uses part of it")]

use expoly::models::{
    CubicDamping, DisplacementNoise, Duffing, DuffingVanDerPol, EnergyDamping, Linear, ParametricLinear,
    QuinticDuffing, VanDerPolRayleigh, VelocityNoise,
};
use expoly::{PolynomialDrift, Scalar};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

/// What several tests of a program ask for, by its key: made for the first that asks.
#[derive(Debug)]
pub struct Shared<K, V>(Mutex<BTreeMap<K, Arc<OnceLock<Arc<V>>>>>);

impl<K: Ord, V> Shared<K, V> {
    pub const fn new() -> Self {
        Shared(Mutex::new(BTreeMap::new()))
    }

    pub fn get(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let place = self.0.lock().unwrap().entry(key).or_default().clone();
        place.get_or_init(|| Arc::new(make())).clone()
    }
}

/// dx = −x dt + √2 dW.
#[derive(Debug)]
pub struct OrnsteinUhlenbeck;

impl PolynomialDrift<1, 1> for OrnsteinUhlenbeck {
    fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-x]
    }
    fn noise<S: Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
        [[S::from(2.0_f64.sqrt())]]
    }
}

/// Duffing's oscillator of all reference tables: c = 0.2, k = 1, μ = 0.3, D = 0.2.
pub fn duffing() -> Duffing {
    Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap()
}

pub fn linear() -> Linear {
    Linear::new(0.3, 2.0, 0.45).unwrap()
}

pub fn bistable() -> Duffing {
    Duffing::new(1.0, -1.0, 1.0, 0.3).unwrap()
}

pub fn three_wells() -> QuinticDuffing {
    QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3).unwrap()
}

pub fn van_der_pol_rayleigh() -> VanDerPolRayleigh {
    VanDerPolRayleigh::new(1.0, 0.15).unwrap()
}

pub fn energy_damping() -> EnergyDamping {
    EnergyDamping::new(0.2, 0.3, 0.3, 0.2).unwrap()
}

pub fn parametric_linear() -> ParametricLinear {
    ParametricLinear::new(0.1, 1.0, 0.5, 0.2).unwrap()
}

pub fn displacement_noise() -> DisplacementNoise {
    DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5).unwrap()
}

pub fn velocity_noise() -> VelocityNoise {
    VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4).unwrap()
}

pub fn van_der_pol() -> DuffingVanDerPol {
    DuffingVanDerPol::van_der_pol(0.5, 0.3).unwrap()
}

pub fn rayleigh() -> CubicDamping {
    CubicDamping::rayleigh(1.0, 0.2).unwrap()
}

/// Numbers in (−1, 1) from a linear congruential generator (D. E. Knuth's MMIX): fixed points for tests without a crate.
pub struct Points(u64);

impl Points {
    pub fn new(seed: u64) -> Self {
        Points(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn array<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }
}

/// The rows of a reference table as numbers, without its header.
pub fn reference(name: &str) -> Vec<Vec<f64>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let number = |field: &str| field.parse().unwrap_or(f64::NAN);
    reader.records().map(|row| row.unwrap().iter().map(number).collect()).collect()
}

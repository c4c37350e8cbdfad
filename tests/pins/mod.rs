//! Pins: numbers of small problems by every route through the library, which a change inside of it must keep.
//!
//! `reference/pins.csv` has a line for each: a name, a value with all of its digits, and a tolerance. The tolerance is absolute, |found −
//! value| ≤ tolerance, and is made when the table is written: a share, which stands in the code, of the largest |value| of the list that
//! the number belongs to, so that what vanishes by symmetry is judged by what does not. The errors of estimates have a thousand times
//! that share of the largest error, 1e-9 for a simulation, or a hundredth of the values' own tolerance, if that is more: an error that
//! is a difference of two values has no more digits.
//!
//! The numbers are what was found, right or not: problems are too small, and accuracies too coarse, for any other use. Where some
//! differ, the table of what was found is written beside the tests' other files, and the failure names it: after a change that is
//! meant to move numbers it takes the place of the old one, and `git diff` shows each that has moved, to the last bit.

mod answers;
mod closure;
mod closure_in_time;
mod grid;
mod impulses;
mod many_states;
mod simulation;
mod uses;

use expoly::{Density, Estimate, Result};
use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fs, path::Path, sync::Mutex, thread, time::Instant};

/// The share for straight sums: simulations, statistics of a density that is known, equations on a mesh that is given.
const SUMS: f64 = 1e-12;
/// That for optima, roots and eigenvalues, and what follows from them.
const OPTIMA: f64 = 1e-9;
/// That for integrals on cells, and on meshes next to walls that take energy: where two cells are mirror images, or as rough, rounding
/// decides which one is halved.
const HALVINGS: f64 = 2e-6;
/// That for closures by moment equations in two states. The edge of their domain is one of 128 points on each ray, the last of which is
/// inside or outside by rounding: changes of 1e-14 of the pilot's states move densities by 1e-5, and more where they are 1e-5.
const EDGES: f64 = 1e-4;

/// The name of a group, and what computes it.
type Group = (&'static str, fn(&mut Pins) -> Result<()>);

/// Those that take longest come first, so that two threads end together.
fn groups() -> Vec<Group> {
    let all = [
        many_states::GROUPS,
        closure_in_time::GROUPS,
        closure::GROUPS,
        grid::GROUPS,
        uses::GROUPS,
        answers::GROUPS,
        impulses::GROUPS,
        simulation::GROUPS,
    ];
    all.concat()
}

/// A number, and how far from it another may be.
#[derive(Clone, Debug)]
struct Pin {
    name: String,
    value: f64,
    tolerance: f64,
}

/// The numbers of one group.
#[derive(Debug)]
struct Pins {
    group: &'static str,
    found: Vec<Pin>,
}

impl Pins {
    /// Numbers of one kind, to a share of the largest of them.
    fn all(&mut self, name: &str, share: f64, values: &[f64]) {
        self.within(name, share * largest(values), values);
    }

    /// A single number, to a share of itself.
    fn one(&mut self, name: &str, share: f64, value: f64) {
        self.all(name, share, &[value]);
    }

    /// Numbers to an absolute tolerance, such as those that should vanish.
    fn within(&mut self, name: &str, tolerance: f64, values: &[f64]) {
        for (k, &value) in values.iter().enumerate() {
            let place = if values.len() > 1 { format!(" {k}") } else { String::new() };
            self.found.push(Pin { name: format!("{}: {name}{place}", self.group), value, tolerance });
        }
    }

    /// Estimates of one kind, each with its error.
    fn estimates(&mut self, name: &str, share: f64, estimates: &[Estimate]) {
        let values: Vec<f64> = estimates.iter().map(|estimate| estimate.value).collect();
        let errors: Vec<f64> = estimates.iter().map(|estimate| estimate.error).collect();
        self.all(name, share, &values);
        let tolerance = (1e3 * share * largest(&errors)).max(0.01 * share * largest(&values));
        self.within(&format!("{name} error"), tolerance, &errors);
    }

    /// What every density has: moments, one with its error, and values at two places.
    fn density(&mut self, what: &str, share: f64, density: &dyn Density, places: [&[f64]; 2]) -> Result<()> {
        let n = density.dimension();
        let of = |state: usize, power: u32| density.moment(&power_of(n, state, power));
        self.estimates(&format!("{what} square"), share, &[of(0, 2)?]);
        self.all(&format!("{what} moments"), share, &[of(0, 1)?.value, of(n - 1, 2)?.value, of(0, 4)?.value]);
        let logs = places.iter().map(|x| density.log_pdf(x)).collect::<Result<Vec<_>>>()?;
        self.all(&format!("{what} ln p"), share, &logs);
        self.one(&format!("{what} marginal"), share, density.marginal(0, places[1][0])?.value);
        Ok(())
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().filter(|value| value.is_finite()).fold(0.0, |most, value| value.abs().max(most))
}

/// The exponents of one state's power among `states`.
fn power_of(states: usize, state: usize, power: u32) -> Vec<u32> {
    (0..states).map(|k| if k == state { power } else { 0 }).collect()
}

/// All pins, in the order of the groups, by as many threads as there are processors.
fn computed() -> Vec<Pin> {
    let (groups, next) = (groups(), AtomicUsize::new(0));
    let found = Mutex::new(vec![Vec::new(); groups.len()]);
    let work = || {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(&(name, compute)) = groups.get(k) else { break };
            let (mut pins, begin) = (Pins { group: name, found: Vec::new() }, Instant::now());
            compute(&mut pins).unwrap_or_else(|error| panic!("{name}: {error}"));
            println!("{name}: {} numbers, {:.2} s", pins.found.len(), begin.elapsed().as_secs_f64());
            found.lock().unwrap()[k] = pins.found;
        }
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    found.into_inner().unwrap().concat()
}

/// The table as it was written.
fn expected() -> Vec<Pin> {
    let pin = |line: &str| {
        let [name, value, tolerance] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        Pin { name: String::from(name), value: value.parse().unwrap(), tolerance: tolerance.parse().unwrap() }
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/pins.csv");
    fs::read_to_string(path).unwrap().lines().skip(1).map(pin).collect()
}

/// What differs: a number beyond its tolerance, or a name that stands on one side alone.
fn differences(expected: &[Pin], found: &[Pin]) -> Vec<String> {
    let among = |pins: &[Pin], name: &str| pins.iter().find(|pin| pin.name == name).cloned();
    let compared = found.iter().filter_map(|own| match among(expected, &own.name) {
        Some(pin) if (own.value - pin.value).abs() <= pin.tolerance || own.value.to_bits() == pin.value.to_bits() => {
            None
        }
        Some(pin) => {
            let off = own.value - pin.value;
            Some(format!(
                "{}: expected {:e}, found {:e}, {off:.1e} off, {:.0e} allowed",
                pin.name, pin.value, own.value, pin.tolerance
            ))
        }
        None => Some(format!("{}: found {:e}, which is not in the table", own.name, own.value)),
    });
    let missing = expected.iter().filter(|pin| among(found, &pin.name).is_none());
    compared.chain(missing.map(|pin| format!("{}: expected {:e}, not found", pin.name, pin.value))).collect()
}

#[test]
fn the_pins_hold() {
    let (expected, found) = (expected(), computed());
    let names: std::collections::BTreeSet<&str> = found.iter().map(|pin| pin.name.as_str()).collect();
    assert_eq!(names.len(), found.len(), "two pins have one name");
    let differences = differences(&expected, &found);
    if !differences.is_empty() {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pins.csv");
        fs::write(&path, table(&found)).unwrap();
        let (count, all, path, list) = (differences.len(), found.len(), path.display(), differences.join("\n"));
        panic!("{count} of {all} differ; {path} has what was found:\n{list}");
    }
}

fn table(pins: &[Pin]) -> String {
    let mut table = String::from("name,value,tolerance\n");
    for Pin { name, value, tolerance } in pins {
        assert!(!name.contains(','), "{name}");
        writeln!(table, "{name},{value:.16e},{tolerance:.0e}").unwrap();
    }
    table
}

//! Lists of states.

use crate::error::{Error, Result};
use crate::file::file_error;
use crate::record::Read;
use serde::{Deserialize, Serialize};
use std::io;
use std::ops::Index;
use std::path::Path;
use std::slice::ChunksExact;

/// A list of states of one system, each a slice of as many numbers as the system has states.
///
/// ```
/// use expoly::States;
/// let mut list = States::new(2);
/// list.push(&[0.5, -1.0]);
/// assert_eq!((list.len(), &list[0]), (1, &[0.5, -1.0][..]));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StatesParts")]
pub struct States {
    dimension: usize,
    values: Vec<f64>,
}

/// The parts of a list in a document.
#[derive(Deserialize)]
struct StatesParts {
    dimension: usize,
    values: Vec<f64>,
}

impl TryFrom<StatesParts> for States {
    type Error = String;

    fn try_from(StatesParts { dimension, values }: StatesParts) -> Read<Self> {
        if dimension == 0 || !values.len().is_multiple_of(dimension) {
            return Err(format!("{} numbers are no states of {dimension} numbers each", values.len()));
        }
        Ok(States { dimension, values })
    }
}

impl States {
    /// An empty list of states of `dimension` numbers each, at least one.
    pub fn new(dimension: usize) -> Self {
        States::with_capacity(dimension, 0)
    }

    /// The states of a table of comma-separated values: its first line names the columns, of which those with the names `states` are
    /// taken, in their order, and others are left out.
    ///
    /// # Errors
    /// [`Error::File`] for a file that cannot be read, or a field that is no finite number, by its line; [`Error::NotAName`] for a
    /// state that no column has.
    pub fn from_csv(path: impl AsRef<Path>, states: &[String]) -> Result<Self> {
        let path = path.as_ref();
        let failed = |error: io::Error| file_error("read", path, error);
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(|error| failed(error.into()))?;
        let heading = reader.headers().map_err(|error| failed(error.into()))?.clone();
        let column = |name: &String| {
            let missing = || Error::not_a_name(name, "no column of the table has it");
            heading.iter().position(|other| other == name).ok_or_else(missing)
        };
        let columns = states.iter().map(column).collect::<Result<Vec<usize>>>()?;
        let mut all = States::new(states.len());
        let mut state = vec![0.0; states.len()];
        for record in reader.records() {
            let record = record.map_err(|error| failed(error.into()))?;
            for (x, &column) in state.iter_mut().zip(&columns) {
                let field = record.get(column).unwrap_or_default();
                let line = record.position().map_or(0, csv::Position::line);
                let number = field.parse().ok().filter(|value: &f64| value.is_finite());
                *x = number
                    .ok_or_else(|| failed(io::Error::other(format!("line {line}: {field:?} is no finite number"))))?;
            }
            all.push(&state);
        }
        Ok(all)
    }

    pub(crate) fn with_capacity(dimension: usize, count: usize) -> Self {
        States { dimension: dimension.max(1), values: Vec::with_capacity(dimension * count) }
    }

    /// The states whose numbers follow one another in `values`; an incomplete last one is left out.
    pub(crate) fn from_values(dimension: usize, mut values: Vec<f64>) -> Self {
        let dimension = dimension.max(1);
        values.truncate(values.len() / dimension * dimension);
        States { dimension, values }
    }

    /// The number of numbers in a state.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.values.len() / self.dimension
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Appends a state. Numbers of `x` beyond the dimension are left out, and missing ones are 0.
    pub fn push(&mut self, x: &[f64]) {
        let end = self.values.len() + self.dimension;
        self.values.extend_from_slice(&x[..x.len().min(self.dimension)]);
        self.values.resize(end, 0.0);
    }

    /// Appends all states of another list.
    pub(crate) fn extend(&mut self, other: &States) {
        self.values.extend_from_slice(&other.values);
    }

    /// About so many of the states, evenly chosen.
    pub(crate) fn evenly(&self, count: usize) -> Self {
        let mut chosen = States::new(self.dimension);
        self.iter().step_by((self.len() / count).max(1)).for_each(|x| chosen.push(x));
        chosen
    }

    /// The least and the largest value of each state.
    pub(crate) fn range(&self) -> [Vec<f64>; 2] {
        let fold = |of: fn(f64, f64) -> f64, start: f64| {
            (0..self.dimension).map(|i| self.iter().map(|x| x[i]).fold(start, of)).collect()
        };
        [fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY)]
    }

    /// The standard deviation along each axis.
    pub(crate) fn deviations(&self) -> Vec<f64> {
        let count = self.len() as f64;
        let along = |i: usize| {
            let mean = self.iter().map(|x| x[i]).sum::<f64>() / count;
            (self.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / count).sqrt()
        };
        (0..self.dimension).map(along).collect()
    }

    pub(crate) fn state(&self, i: usize) -> &[f64] {
        &self.values[i * self.dimension..(i + 1) * self.dimension]
    }

    /// The states in order.
    pub fn iter(&self) -> ChunksExact<'_, f64> {
        self.values.chunks_exact(self.dimension)
    }

    /// The states of one of the runs of `length` states, the last one perhaps shorter, one after the other.
    pub(crate) fn run(&self, run: usize, length: usize) -> &[f64] {
        let length = length * self.dimension;
        &self.values[run * length..self.values.len().min((run + 1) * length)]
    }

    /// Leaves out the states for which `keep` is false.
    pub(crate) fn retain(&mut self, keep: impl Fn(&[f64]) -> bool) {
        let kept = self.iter().filter(|x| keep(x)).flatten().copied().collect();
        self.values = kept;
    }

    /// All numbers, state after state.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

impl Index<usize> for States {
    type Output = [f64];

    fn index(&self, i: usize) -> &[f64] {
        self.state(i)
    }
}

impl<'a> IntoIterator for &'a States {
    type Item = &'a [f64];
    type IntoIter = ChunksExact<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

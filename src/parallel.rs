//! Independent tasks on the current pool of threads.
//!
//! All of them go through one loop over numbers, so that the pool's machinery is compiled once and not for every loop. Results are
//! in the order of the tasks, on any number of threads.

use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Tasks beyond these are dealt in runs of equal length.
const RUNS: usize = 512;

/// Carries out the tasks with the numbers from 0 to `count` − 1.
pub(crate) fn each(count: usize, task: &(dyn Fn(usize) + Sync)) {
    let length = count.div_ceil(RUNS).max(1);
    let run = |first: usize| (first * length..count.min((first + 1) * length)).for_each(task);
    (0..count.div_ceil(length)).into_par_iter().with_max_len(1).for_each(run);
}

/// The results of the tasks with the numbers from 0 to `count` − 1.
pub(crate) fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let length = count.div_ceil(RUNS).max(1);
    let runs: Vec<Mutex<Vec<T>>> = (0..count.div_ceil(length)).map(|_| Mutex::default()).collect();
    each(runs.len(), &|run| {
        let results = (run * length..count.min((run + 1) * length)).map(&of).collect();
        *runs[run].lock().unwrap_or_else(PoisonError::into_inner) = results;
    });
    runs.into_iter().flat_map(|run| run.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// The results of a function for some items.
pub(crate) fn map_into<A: Send, T: Send>(items: Vec<A>, of: impl Fn(usize, A) -> T + Sync) -> Vec<T> {
    let mut places: Vec<(Option<A>, Option<T>)> = items.into_iter().map(|item| (Some(item), None)).collect();
    on_runs(&mut places, 1, |number, place| {
        for (item, result) in place {
            *result = item.take().map(|item| of(number, item));
        }
    });
    places.into_iter().filter_map(|(_, result)| result).collect()
}

/// Visits runs of `length` items, the last one perhaps shorter, each with its number.
pub(crate) fn on_runs<T: Send>(items: &mut [T], length: usize, visit: impl Fn(usize, &mut [T]) + Sync) {
    let runs: Vec<Mutex<&mut [T]>> = items.chunks_mut(length.max(1)).map(Mutex::new).collect();
    each(runs.len(), &|run| visit(run, &mut runs[run].lock().unwrap_or_else(PoisonError::into_inner)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_tasks() {
        for count in [0, 1, 7, RUNS, RUNS + 1, 5 * RUNS + 3] {
            let numbers: Vec<usize> = (0..count).collect();
            assert_eq!(map(count, |k| k), numbers);
            assert_eq!(
                map_into(numbers.clone(), |place, k| (place, k)),
                numbers.iter().map(|&k| (k, k)).collect::<Vec<_>>()
            );
            let mut runs = vec![0; count];
            on_runs(&mut runs, 3, |run, items| items.iter_mut().for_each(|item| *item += run + 1));
            assert_eq!(runs, numbers.iter().map(|k| k / 3 + 1).collect::<Vec<_>>());
        }
    }
}

use crate::closure::pilot::Pilot;
use crate::closure::samples::Sites;
use crate::closure::tuning::pilot::TRAJECTORIES;
use crate::control_variates::products::{LANES, Lane, Products, Scratch, ZERO};
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::Polynomial;
use crate::problem::Problem;
use faer::{Mat, MatMut};
use rayon::prelude::*;
use std::ops::Range;

/// Trajectories are summed in so many lots, each of which the jackknife leaves out once.
pub(super) const LOTS: usize = 32;

/// The pilot's trajectories with functions ψ on them, eight states at a time.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a> {
    pub(super) problem: &'a Problem,
    pub(super) pilot: &'a Pilot,
    pub(super) products: &'a Products,
    /// The states of a trajectory that are used, a whole number of blocks.
    pub(super) used: usize,
}

/// The derivative of an operator by a parameter, f′ and B′.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    drift: Vec<(usize, Polynomial)>,
    diffusion: Vec<(usize, Polynomial)>,
    coupled: Vec<usize>,
}

impl Moved {
    pub(super) fn new(operator: &FokkerPlanck) -> Self {
        let given = |entries: Vec<&Polynomial>| {
            entries.into_iter().cloned().enumerate().filter(|(_, entry)| !entry.is_zero()).collect()
        };
        let diffusion = operator.diffusion().iter().flatten().collect();
        Moved {
            drift: given(operator.drift().iter().collect()),
            diffusion: given(diffusion),
            coupled: operator.coupled(),
        }
    }
}

/// Room for the functions at eight states, and which of a trajectory's states these are.
pub(super) struct Place {
    sites: Sites,
    scratch: Scratch,
    moved: [Vec<Lane>; 2],
    pub(super) rows: Range<usize>,
}

impl<'a> Walk<'a> {
    /// The number of functions, without the constant.
    pub(super) fn functions(&self) -> usize {
        self.products.len() - 1
    }

    /// The first of a trajectory's states among all of them.
    pub(super) fn first(&self, t: usize) -> usize {
        t * self.pilot.samples()
    }

    /// The results of all lots, each of which visits its trajectories one by one, by the numbers of the lot and the trajectory.
    pub(super) fn lots<T: Send>(
        &self,
        zero: impl Fn() -> T + Sync,
        visit: impl Fn(&mut T, [usize; 2], &mut Place) + Sync,
    ) -> Vec<T> {
        let lot = |lot: usize| {
            let n = self.problem.dimension();
            let mut place = Place {
                sites: Sites::new(self.problem, &[]),
                scratch: self.products.scratch(),
                moved: [vec![ZERO; n], vec![ZERO; n * n]],
                rows: 0..0,
            };
            let mut result = zero();
            (lot..TRAJECTORIES).step_by(LOTS).for_each(|t| visit(&mut result, [lot, t], &mut place));
            result
        };
        (0..LOTS).into_par_iter().map(lot).collect()
    }

    /// Visits the states of a trajectory, with the functions placed there.
    pub(super) fn each(&self, t: usize, place: &mut Place, mut visit: impl FnMut(&mut Place)) {
        let n = self.problem.dimension();
        for at in (0..self.used).step_by(LANES) {
            place.rows = at..(at + LANES).min(self.used);
            let [begin, end] = [at, place.rows.end].map(|row| (self.first(t) + row) * n);
            place.sites.place(self.problem, &self.pilot.states.values()[begin..end]);
            self.products.place(&place.sites.x, &mut place.scratch);
            visit(place);
        }
    }

    /// The functions and their images at all states of a trajectory, with a row for each.
    pub(super) fn tables(&self, t: usize, place: &mut Place) -> [Mat<f64>; 2] {
        let [mut values, mut images] = [(); 2].map(|()| Mat::zeros(self.used, self.functions()));
        self.each(t, place, |place| {
            self.enter_values(place, values.as_mut());
            self.enter_images(place, images.as_mut());
        });
        [values, images]
    }

    /// Writes a value of each function into a row for each state.
    fn enter(&self, place: &Place, mut table: MatMut<'_, f64>, of: impl Fn(&Scratch, usize) -> Lane) {
        for k in 0..self.functions() {
            let lane = of(&place.scratch, k + 1);
            place.rows.clone().zip(lane).for_each(|(row, value)| table[(row, k)] = value);
        }
    }

    /// The values of the functions.
    pub(super) fn enter_values(&self, place: &Place, table: MatMut<'_, f64>) {
        self.enter(place, table, |scratch, k| self.products.value(scratch, k));
    }

    /// Their images under the generator.
    pub(super) fn enter_images(&self, place: &mut Place, table: MatMut<'_, f64>) {
        place.scratch.first.copy_from_slice(&place.sites.drift);
        self.products.apply(&place.sites.diffusion, &place.sites.coupled, &mut place.scratch);
        self.enter(place, table, |scratch, k| self.products.image(scratch, k));
    }

    /// The images under the derivative of the generator.
    pub(super) fn enter_moved(&self, moved: &Moved, place: &mut Place, table: MatMut<'_, f64>) {
        let n = self.problem.dimension();
        let mut x = vec![0.0; n];
        let [drift, diffusion] = &mut place.moved;
        drift.iter_mut().chain(diffusion.iter_mut()).for_each(|lane| *lane = ZERO);
        for l in 0..LANES {
            x.iter_mut().zip(&place.sites.x).for_each(|(x, lane)| *x = lane[l]);
            moved.drift.iter().for_each(|(i, f)| drift[*i][l] = f.evaluate(&x));
            moved.diffusion.iter().for_each(|(ij, b)| diffusion[*ij][l] = b.evaluate(&x));
        }
        place.scratch.first.copy_from_slice(drift);
        self.products.apply(diffusion, &moved.coupled, &mut place.scratch);
        self.enter(place, table, |scratch, k| self.products.image(scratch, k));
    }
}

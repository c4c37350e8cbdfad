//! What a mesh does not resolve: of the density, of each of its wells, and of the way between wells.

use super::field::GridField;
use super::shape::Place;
use super::stationary::Stationary;
use super::tree::MeshCell;
use super::wells::Wells;
use crate::grid::KEPT;
use crate::states::States;

/// A well, and the way from one to another, is resolved as if it had this share of the density at least. For the way 0.01
/// would do in most cases; 1 takes half as many cells more.
const LEAST: f64 = 0.1;
/// The least probability between two wells, with one of 1 in each, for which the way between them is resolved: where less is
/// there, beyond barriers of 40 temperatures, rounding decides what the wells exchange.
const BETWEEN: f64 = 1e-15;
/// A cell that no well fills is that of a well without a pin if it has more than this share of the pilot's states.
const MANY: f64 = 0.01;
/// A cell with many of the pilot's states is that of a well without a pin if all wells have less in it than this part of its
/// share of the states.
const MISSED: f64 = 0.01;

impl Stationary {
    /// What is left in the highest degree of each cell. Each well counts as if it had some of the density at least: cells that are
    /// too coarse let out what it keeps, and then say that next to nothing is in it. So does what goes from one well to another:
    /// little is there, and it decides how much is in each, unless symmetry does.
    pub(super) fn unresolved(&self) -> Vec<Place> {
        let mut all = self.density.field.highest();
        let Wells { pins, shares, .. } = &self.wells;
        if pins.len() == 1 {
            return all;
        }
        let wells: Vec<usize> = (0..pins.len()).filter(|well| self.wells.kept(*well) > KEPT[1]).collect();
        let highest: Vec<Vec<Place>> = wells.iter().map(|well| self.wells.well(*well).highest()).collect();
        let mut add = |own: &[Place], factor: &dyn Fn(usize) -> f64| {
            let cells = all.iter_mut().zip(own).enumerate();
            cells.for_each(|(cell, (all, own))| all.iter_mut().zip(own).for_each(|(a, b)| *a += factor(cell) * b));
        };
        for (k, well) in wells.iter().enumerate() {
            add(&highest[k], &|_| (LEAST - shares[*well]).max(0.0));
            for other in wells.iter().filter(|other| *other != well && !self.wells.alike([*well, **other])) {
                let between = self.between([*well, *other]);
                // Each pair comes twice.
                add(&highest[k], &|cell| LEAST * between[cell]);
            }
        }
        all
    }

    /// The part of each cell's density that is on its way from one well to another, for a mass of 1 on that way. With u_i of what comes
    /// from well i, and u of what comes from all, u_i/u is the probability that what is there came from i, and the part is
    /// u_i u_j/u².
    fn between(&self, [from, to]: [usize; 2]) -> Vec<f64> {
        let (wells, mut mass) = (&self.wells, 0.0);
        let part = |(cell, own): (usize, &MeshCell)| {
            let mean = |well: usize| wells.well(well).mean(cell).abs();
            let all = (0..wells.pins.len()).map(mean).sum::<f64>().max(f64::MIN_POSITIVE);
            let part = mean(from) / all * (mean(to) / all);
            mass += part * all * own.root_volume().powi(2);
            part
        };
        let parts: Vec<f64> = self.operator.layout.mesh.cells.iter().enumerate().map(part).collect();
        let scale = if mass > BETWEEN { mass.recip() } else { 0.0 };
        parts.iter().map(|part| scale * part).collect()
    }

    /// The places of the pins of the next mesh, as states: of several that of each well.
    pub(super) fn places(&self) -> Vec<Vec<f64>> {
        let place = |field: &GridField| field.mesh.centre(field.peak());
        let wells: Vec<usize> = (0..self.wells.pins.len()).filter(|well| self.wells.kept(*well) > KEPT[0]).collect();
        match &wells[..] {
            [] | [_] => vec![place(&self.density.field)],
            wells => wells.iter().map(|well| place(self.wells.well(*well))).collect(),
        }
    }

    /// The place of many trajectories' states of which no well has any: there is one more.
    pub(super) fn missed(&self, states: &States) -> Option<Vec<f64>> {
        let mesh = &self.operator.layout.mesh;
        let mut counts = vec![0.0; mesh.cells.len()];
        states.iter().filter_map(|x| mesh.locate(x)).for_each(|cell| counts[cell] += 1.0 / states.len() as f64);
        let within = |cell: usize| -> f64 {
            let volume = mesh.cells[cell].root_volume().powi(2);
            (0..self.wells.pins.len()).map(|well| self.wells.well(well).mean(cell).abs() * volume).sum()
        };
        let missed = |cell: &usize| counts[*cell] > MANY && within(*cell) < MISSED * counts[*cell];
        let most = (0..counts.len()).filter(missed).max_by(|a, b| counts[*a].total_cmp(&counts[*b]));
        most.map(|cell| mesh.centre(cell))
    }
}

//! Sentences of the guide's other pages, and what its examples assert.

use super::{Comparison, Document, cycle_error};
use crate::common::*;
use expoly::models::{Duffing, Solved};
use expoly::statistics::{Crossings, Marginal};
use expoly::{Density, Grid, compare};

#[test]
fn what_is_exceeded_a_thousandth_of_the_time() {
    let (guide, mut found) = (Document::read("src/guide/decisions.md"), Comparison::default());
    let density = closed("Duffing", &problem(duffing()), 4, 0);
    let rare = Marginal::new(&*density, 0).unwrap().upper_quantile(1e-3).unwrap();
    let passage = Crossings::new(&*density, [0, 1]).unwrap().first_passage(rare.value, 100.0).unwrap();
    found.number(&guide.number("(rare.value - "), rare.value, 0.0);
    found.number(&guide.number("(passage.value - "), passage.value, 0.0);
    found.finish(2);
}

#[test]
fn the_grid_beside_another_tool() {
    let (guide, mut found) = (Document::read("src/guide/others.md"), Comparison::default());
    let strength = guide.number("FiPy's numbers were measured with c = D = ").value();
    let duffing = Duffing::new(strength, 1.0, 1.0, strength).unwrap();
    let density = Grid::new().solve(&problem(duffing)).unwrap();
    let distance = compare::l1(&density, &duffing.exact().unwrap()).unwrap().value;
    found.number(&guide.number("cells that are halved where it is needed: by default it is "), distance, 0.0);
    found.number(&guide.number("with an estimate of it, "), density.l1_estimate(), 0.0);
    found.finish(2);
}

#[test]
fn a_limit_cycle_with_little_noise() {
    let (guide, mut found) = (Document::read("src/guide/trust.md"), Comparison::default());
    let [printed, order] = guide.numbers("limit cycles with little noise (");
    found.number(&printed, cycle_error(&order), 0.0);
    found.finish(1);
}

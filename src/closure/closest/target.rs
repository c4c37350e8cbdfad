use crate::closure::closest::{ALONG, TAIL};
use crate::closure::density::cells::{DomainCells, add_nodes};
use crate::density::{Cell, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::numerics::{Rule, legendre};
use crate::parallel;
use crate::problem::Symmetry;
use crate::states::States;

/// The fewest cells in one state to three, so that a density without cells of its own has some where its mass is.
const FEWEST: [usize; 3] = [64, 256, 1000];
/// The factor on the fewest cells where too much of the mass of a density without cells of its own is not on them, or not known.
const MORE: usize = 16;
/// The share of the mass that is not on the cells, or not known, from which on a density without cells of its own gets more of
/// them.
const LOST: f64 = 0.01;
/// The most nodes on all cells, of which each has a row of all functions: a bound on work and memory.
const MOST_NODES: usize = 160_000;
/// The share of the peak that stands for all values that are smaller, or not known: next to nothing.
const FLOOR: f64 = 1e-9;
/// A value of the density is known where its error is below this share of it. Without this limit the error of a grid, which sits in
/// its tails, decides high orders: a distance of 2.8e-3 in place of 5e-4.
const KNOWN: f64 = 0.3;
/// The most divisions of a cell because it lies at the edge of what is known of the density.
const AT_EDGES: usize = 2;
/// A cell is divided while the highest Legendre polynomial that its nodes resolve makes more than this share of its mass.
const ROUGH: f64 = 0.1;
/// A cell with at most this share of the whole mass is not divided for the roughness of the density on it.
const SLIGHT: f64 = 1e-6;

/// A density at Gauss nodes of cells that resolve it, where it can be relied on.
pub(super) struct TargetDensity<'a> {
    density: &'a dyn Density,
    /// Over whose changes p is a mean: the shares of wells that exchange little may not be known better.
    symmetry: &'a Symmetry,
    rule: Rule,
    pieces: Vec<CellValues>,
    /// The largest p at a node.
    peak: f64,
    pub(super) points: States,
    pub(super) weights: Vec<f64>,
    /// ln p at the nodes, where it is too small to be relied on a floor.
    pub(super) logarithm: Vec<f64>,
    /// ∫ p over the cells.
    mass: f64,
    /// What is not known of p, relative to its mass: its error on the cells, and what lies beyond them.
    pub(super) error: f64,
    /// What lies beyond the cells alone.
    pub(super) lost: f64,
}

/// A cell with p and its error at the nodes.
struct CellValues {
    cell: Cell,
    values: Vec<Estimate>,
    /// How often it was divided for its nodes without a good value.
    divided: usize,
}

impl<'a> TargetDensity<'a> {
    /// Down to a share of the peak.
    ///
    /// # Errors
    /// Those of the density's values; [`Error::NotKnown`] where it has no mass on its cells.
    pub(super) fn new(density: &'a dyn Density, symmetry: &'a Symmetry, level: f64) -> Result<Self> {
        let found = Self::on_cells(density, symmetry, level, 1)?;
        // Cells that the density does not name may have missed where its mass is.
        let resolved = found.error < LOST || density.cells().len() > 1;
        if resolved { Ok(found) } else { Self::on_cells(density, symmetry, level, MORE) }
    }

    /// The same from `more` times the fewest cells on.
    fn on_cells(density: &'a dyn Density, symmetry: &'a Symmetry, level: f64, more: usize) -> Result<Self> {
        let mut cells: Vec<Cell> = density.cells().into_iter().map(|limits| Cell { limits }).collect();
        let states = density.dimension();
        // A cell of a grid has more than a cubic in it; in three states it is divided where that shows.
        let least = (more * FEWEST[states - 1]).max(cells.len() + usize::from(states < 3));
        while cells.len() < least {
            cells = cells.iter().flat_map(Cell::children).collect();
        }
        let mut target = TargetDensity {
            density,
            symmetry,
            rule: Rule::legendre(ALONG),
            pieces: Vec::new(),
            peak: 0.0,
            points: States::new(density.dimension()),
            weights: Vec::new(),
            logarithm: Vec::new(),
            mass: 0.0,
            error: 0.0,
            lost: 0.0,
        };
        target.pieces = target.evaluated(cells.into_iter().map(|cell| (cell, 0)))?;
        loop {
            let values = target.pieces.iter().flat_map(|piece| &piece.values);
            target.peak = values.map(|p| p.value).fold(0.0, f64::max);
            let least = level * target.peak;
            target.pieces.retain(|piece| piece.good(least) > 0);
            let roughness: Vec<[f64; 2]> = target.pieces.iter().map(|piece| piece.roughness(&target.rule)).collect();
            let mass: f64 = roughness.iter().map(|[mass, _]| mass).sum();
            let next = |(piece, [own, rough]): (&CellValues, &[f64; 2])| {
                let at_edge = 4 * piece.good(least) < 3 * piece.values.len() && piece.divided < AT_EDGES;
                let coarse = *rough > ROUGH * own && *own > SLIGHT * mass;
                (at_edge || coarse).then_some(piece.divided + usize::from(at_edge))
            };
            let next: Vec<Option<usize>> = target.pieces.iter().zip(&roughness).map(next).collect();
            let count = next.iter().flatten().count();
            if count == 0 || !target.has_room(count) {
                break;
            }
            target.replace(&next)?;
        }
        target.gather()?;
        Ok(target)
    }

    /// Divides some cells, by their numbers.
    ///
    /// # Errors
    /// As [`TargetDensity::new`].
    pub(super) fn divide(&mut self, divided: impl Fn(usize) -> bool) -> Result<()> {
        let next = |(k, piece): (usize, &CellValues)| divided(k).then_some(piece.divided);
        let next: Vec<Option<usize>> = self.pieces.iter().enumerate().map(next).collect();
        self.replace(&next)?;
        self.gather()
    }

    /// Replaces cells by their halves along all states, where there is a number of divisions for these.
    fn replace(&mut self, next: &[Option<usize>]) -> Result<()> {
        let (mut kept, mut halves) = (Vec::new(), Vec::new());
        for (piece, next) in std::mem::take(&mut self.pieces).into_iter().zip(next) {
            match next {
                Some(divided) => halves.extend(piece.cell.children().map(|cell| (cell, *divided))),
                None => kept.push(piece),
            }
        }
        self.pieces = kept;
        let new = self.evaluated(halves.into_iter())?;
        self.pieces.extend(new);
        Ok(())
    }

    /// The number of cells.
    pub(super) fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Whether there is room for the halves of so many cells.
    pub(super) fn has_room(&self, count: usize) -> bool {
        let states = self.density.dimension() as u32;
        (self.len() + count * (2_usize.pow(states) - 1)) * ALONG.pow(states) <= MOST_NODES
    }

    /// Nodes on all cells with more along each side than the target's own, `count` of them.
    pub(super) fn finer(&self, count: usize) -> (States, Vec<f64>) {
        let mut nodes = (States::new(self.density.dimension()), Vec::new());
        let rule = Rule::legendre(count);
        self.pieces.iter().for_each(|piece| add_nodes(&piece.cell.limits, &rule, &mut nodes));
        nodes
    }

    /// The cells with the density on them, normalised, for integrals with a relative error.
    pub(super) fn cells(&self, error: f64) -> DomainCells {
        let density = self.logarithm.iter().map(|log| log.exp() / self.mass).collect();
        DomainCells::new(self.pieces.iter().map(|piece| piece.cell.clone()), ALONG, density, error)
    }

    /// The mean of p over the mirror images of a state.
    fn value(&self, x: &[f64]) -> Result<Estimate> {
        let mut image = vec![0.0; x.len()];
        let mut sum = Estimate::new(0.0, 0.0);
        for change in 0..self.symmetry.count() {
            self.symmetry.reflect(change, x, &mut image);
            let p = self.density.pdf(&image)?;
            sum = Estimate::new(sum.value + p.value, sum.error + p.error);
        }
        let count = self.symmetry.count() as f64;
        Ok(Estimate::new(sum.value / count, sum.error / count))
    }

    /// Cells with their values.
    fn evaluated(&self, cells: impl Iterator<Item = (Cell, usize)>) -> Result<Vec<CellValues>> {
        let TargetDensity { rule, density, .. } = self;
        let piece = |_, (cell, divided): (Cell, usize)| {
            let mut nodes = (States::new(density.dimension()), Vec::new());
            add_nodes(&cell.limits, rule, &mut nodes);
            let values = nodes.0.iter().map(|x| self.value(x)).collect::<Result<Vec<Estimate>>>()?;
            Ok(CellValues { cell, values, divided })
        };
        parallel::map_into(cells.collect(), piece).into_iter().collect()
    }

    /// The box around all cells.
    pub(super) fn bounds(&self) -> Vec<[f64; 2]> {
        self.cells(0.0).bounds()
    }

    /// The share of the mass in the tail.
    pub(super) fn tail(&self) -> f64 {
        let values = self.pieces.iter().flat_map(|piece| &piece.values).zip(&self.weights);
        let tail = values.filter(|(p, _)| p.value < TAIL * self.peak);
        tail.map(|(p, w)| w * p.value).sum::<f64>() / self.mass
    }

    /// Enters the nodes of all cells.
    fn gather(&mut self) -> Result<()> {
        (self.points, self.weights) = self.finer(ALONG);
        let (floor, mut error) = (FLOOR * self.peak, 0.0);
        (self.logarithm, self.mass) = (Vec::with_capacity(self.weights.len()), 0.0);
        for (p, w) in self.pieces.iter().flat_map(|piece| &piece.values).zip(&self.weights) {
            let known = if p.error < KNOWN * p.value { p.value.max(floor) } else { floor };
            self.logarithm.push(known.ln());
            self.mass += w * p.value;
            error += w * p.error;
        }
        let whole = self.density.expectation(&|_| 1.0)?.value;
        if !(self.mass > 0.0 && self.mass.is_finite() && whole > 0.0) {
            let remedy = "its values and its integrals do not agree: take a density that is normalised";
            return Err(Error::NotKnown { what: "a mass of the density on its cells".into(), remedy });
        }
        self.lost = (1.0 - self.mass / whole).clamp(0.0, 1.0);
        self.error = (error + (whole - self.mass).abs()) / whole;
        Ok(())
    }
}

impl CellValues {
    /// The number of nodes with a value above the least one and its own error.
    fn good(&self, least: f64) -> usize {
        let good = |p: &&Estimate| p.value > least && p.error < KNOWN * p.value;
        self.values.iter().filter(good).count()
    }

    /// The mass, and the largest share that the highest Legendre polynomial along a side has in it.
    fn roughness(&self, rule: &Rule) -> [f64; 2] {
        let states = self.cell.limits.len();
        let highest = |t: f64| {
            let mut p = [0.0; ALONG];
            legendre::values(t, &mut p);
            p[ALONG - 1]
        };
        let (mut mass, mut sums) = (0.0, vec![0.0; states]);
        for (k, p) in self.values.iter().enumerate() {
            let node = |axis: usize| k / ALONG.pow((states - 1 - axis) as u32) % ALONG;
            let weight = (0..states).fold(p.value, |weight, axis| weight * rule.weights[node(axis)] / 2.0);
            mass += weight;
            sums.iter_mut().enumerate().for_each(|(axis, sum)| *sum += weight * highest(rule.nodes[node(axis)]));
        }
        let norm = (2 * ALONG - 1) as f64 * self.cell.volume();
        [self.cell.volume() * mass, norm * sums.iter().fold(0.0, |most: f64, sum| most.max(sum.abs()))]
    }
}

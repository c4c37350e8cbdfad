/// One state and its levels, each with the cells around it.
#[derive(Clone, Debug)]
pub(super) struct Levels {
    pub(super) state: usize,
    /// Each level with the width δ of its cells.
    pub(super) levels: Vec<(f64, f64)>,
    /// The levels, and the edges of three cells about each, in rising order.
    edges: Vec<f64>,
}

/// The measurements of one replica.
#[derive(Clone, Debug)]
pub(super) struct ReplicaTally {
    /// The number of instants at which the particles were counted; at each the weights have the sum 1.
    pub(super) instants: f64,
    /// For each of [`Levels`], the weight between neighbouring edges, summed over the instants.
    mass: Vec<Vec<f64>>,
    /// The time over which passages were counted.
    pub(super) time: f64,
    /// The weight of the up-crossings of each level of state 0.
    pub(super) crossings: Vec<f64>,
    /// For each bin of the importance function its weight, and whether it was occupied, summed over the cycles in the first
    /// and in the second half of the time.
    pub(super) halves: [Vec<[f64; 2]>; 2],
}

impl Levels {
    pub(super) fn new(state: usize, levels: Vec<(f64, f64)>) -> Self {
        let marks = |&(y, width): &(f64, f64)| [-1.5, -0.5, 0.0, 0.5, 1.5].map(|k| y + k * width);
        let mut edges: Vec<f64> = levels.iter().flat_map(marks).collect();
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        Levels { state, levels, edges }
    }

    /// The number of edges not above x.
    fn place(&self, x: f64) -> usize {
        self.edges.partition_point(|&edge| edge <= x)
    }

    /// The place of an edge.
    fn edge(&self, y: f64) -> usize {
        self.edges.partition_point(|&edge| edge < y) + 1
    }
}

impl ReplicaTally {
    pub(super) fn new(watched: &[Levels], crossings: usize, bins: usize) -> Self {
        ReplicaTally {
            instants: 0.0,
            mass: watched.iter().map(|levels| vec![0.0; levels.edges.len() + 1]).collect(),
            time: 0.0,
            crossings: vec![0.0; crossings],
            halves: [vec![[0.0; 2]; bins], vec![[0.0; 2]; bins]],
        }
    }

    /// Counts one particle.
    pub(super) fn observe(&mut self, watched: &[Levels], (x, weight): (&[f64], f64)) {
        for (levels, mass) in watched.iter().zip(&mut self.mass) {
            mass[levels.place(x[levels.state])] += weight;
        }
    }

    /// Adds the weight of each bin.
    pub(super) fn occupy(&mut self, half: usize, masses: impl Iterator<Item = f64>) {
        for (sums, mass) in self.halves[half].iter_mut().zip(masses) {
            *sums = [sums[0] + mass, sums[1] + f64::from(u8::from(mass > 0.0))];
        }
    }

    /// P(X ≥ y) for a level.
    pub(super) fn above(&self, k: usize, watched: &[Levels], level: f64) -> f64 {
        self.mass[k][watched[k].edge(level)..].iter().sum::<f64>() / self.instants
    }

    /// P(X < y) for a level.
    pub(super) fn below(&self, k: usize, watched: &[Levels], level: f64) -> f64 {
        self.mass[k][..watched[k].edge(level)].iter().sum::<f64>() / self.instants
    }

    /// The density at a level from three cells of the width δ: p̄₀ − (p̄₊ − 2p̄₀ + p̄₋)/24 with the cells' mean densities, off
    /// by 3/640 δ⁴ p⁗.
    pub(super) fn density(&self, k: usize, watched: &[Levels], (level, width): (f64, f64)) -> f64 {
        let places = [-1.5, -0.5, 0.5, 1.5].map(|m| watched[k].edge(level + m * width));
        let cell = |c: usize| self.mass[k][places[c]..places[c + 1]].iter().sum::<f64>();
        (26.0 * cell(1) - cell(0) - cell(2)) / (24.0 * width * self.instants)
    }
}

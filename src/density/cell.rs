/// A box in the state space.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) limits: Vec<[f64; 2]>,
}

impl Cell {
    /// The cells between lines along each state.
    pub(crate) fn between(lines: &[Vec<f64>]) -> Vec<Self> {
        let mut cells = vec![Cell { limits: Vec::new() }];
        for lines in lines {
            let with = |cell: &Self, ends: &[f64]| {
                let limits = cell.limits.iter().copied().chain([[ends[0], ends[1]]]).collect();
                Cell { limits }
            };
            cells = cells.iter().flat_map(|cell| lines.windows(2).map(|ends| with(cell, ends))).collect();
        }
        cells
    }

    /// The 2^n halves along every state.
    pub(crate) fn children(&self) -> impl Iterator<Item = Self> + '_ {
        (0..1_usize << self.limits.len()).map(|k| {
            let half = |(i, [low, high]): (usize, &[f64; 2])| {
                let middle = low + (high - low) / 2.0;
                if k >> i & 1 == 0 { [*low, middle] } else { [middle, *high] }
            };
            Cell { limits: self.limits.iter().enumerate().map(half).collect() }
        })
    }

    /// The point at shares of the sides.
    pub(crate) fn at(&self, shares: &[f64]) -> Vec<f64> {
        self.limits.iter().zip(shares).map(|([low, high], share)| low + share * (high - low)).collect()
    }

    pub(crate) fn volume(&self) -> f64 {
        self.limits.iter().map(|[low, high]| high - low).product()
    }
}

/// Equal steps over each side of a box, with further lines at the places that `through` gives.
pub(crate) fn lines(bounds: &[[f64; 2]], steps: usize, through: impl Fn(usize) -> Vec<f64>) -> Vec<Vec<f64>> {
    let along = |(i, [low, high]): (usize, &[f64; 2])| {
        let mut lines: Vec<f64> = (0..=steps).map(|k| low + (high - low) * k as f64 / steps as f64).collect();
        lines.extend(through(i).into_iter().filter(|x| low < x && x < high));
        lines.sort_by(f64::total_cmp);
        lines.dedup();
        lines
    };
    bounds.iter().enumerate().map(along).collect()
}

/// A box in the state space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell<const N: usize> {
    pub(crate) limits: [[f64; 2]; N],
}

impl<const N: usize> Cell<N> {
    /// The cells between lines along each state.
    pub(crate) fn between(lines: &[Vec<f64>; N]) -> Vec<Self> {
        let mut cells = vec![Cell { limits: [[0.0; 2]; N] }];
        for (i, lines) in lines.iter().enumerate() {
            let with = |cell: Self, ends: &[f64]| {
                let mut limits = cell.limits;
                limits[i] = [ends[0], ends[1]];
                Cell { limits }
            };
            cells = cells.iter().flat_map(|cell| lines.windows(2).map(|ends| with(*cell, ends))).collect();
        }
        cells
    }

    /// The 2^N halves along every state.
    pub(crate) fn children(&self) -> impl Iterator<Item = Self> + '_ {
        (0..1_usize << N).map(|k| {
            let half = |i: usize| {
                let [low, high] = self.limits[i];
                let middle = low + (high - low) / 2.0;
                if k >> i & 1 == 0 { [low, middle] } else { [middle, high] }
            };
            Cell { limits: std::array::from_fn(half) }
        })
    }

    /// The point at shares of the sides.
    pub(crate) fn at(&self, shares: [f64; N]) -> [f64; N] {
        std::array::from_fn(|i| self.limits[i][0] + shares[i] * (self.limits[i][1] - self.limits[i][0]))
    }

    pub(crate) fn volume(&self) -> f64 {
        self.limits.iter().map(|[low, high]| high - low).product()
    }
}

/// Equal steps over each side of a box, with further lines where `through` asks for them.
pub(crate) fn lines<const N: usize>(
    bounds: &[[f64; 2]; N],
    steps: usize,
    through: impl Fn(usize) -> Vec<f64>,
) -> [Vec<f64>; N] {
    std::array::from_fn(|i| {
        let [low, high] = bounds[i];
        let mut lines: Vec<f64> = (0..=steps).map(|k| low + (high - low) * k as f64 / steps as f64).collect();
        lines.extend(through(i).into_iter().filter(|x| low < *x && *x < high));
        lines.sort_by(f64::total_cmp);
        lines.dedup();
        lines
    })
}

use crate::closure::dynamics::MomentSystem;
use faer::Mat;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;

/// The factors of moment equations, without the constant: of the highest degree and of the one below it.
pub(super) struct MomentFactors([PartialPivLu<f64>; 2]);

impl MomentFactors {
    pub(super) fn new(system: &MomentSystem) -> Self {
        MomentFactors([false, true].map(|below| system.matrix(below).get(1.., 1..).partial_piv_lu()))
    }

    /// d of A d = −source by both, the constant's 0.
    pub(super) fn solved(&self, source: &[f64]) -> [Vec<f64>; 2] {
        self.0.each_ref().map(|factors| {
            let solved = factors.solve(Mat::from_fn(factors.L().ncols(), 1, |k, _| -source[k + 1]));
            std::iter::once(0.0).chain(solved.col(0).iter().copied()).collect()
        })
    }
}

//! A density that is still narrow, in coordinates that move and stretch with it.

use super::hermite::{HermiteProducts, HermiteTable, hermite};
use crate::density::Frame;
use crate::fokker_planck::FokkerPlanck;
use crate::numerics::runge_kutta;
use crate::polynomial::{Gaussian, Polynomial};
use crate::problem::gaussian_after;
use crate::transient::Start;
use nalgebra::{DMatrix, DVector};

/// The longest time step of a moving frame times the rate at which the frame changes.
const FRAME_STEP: f64 = 0.05;
/// Noise makes a Gaussian of a point within this share of the fastest time of its linear motion.
const POINT: f64 = 1e-3;

/// p(x, t) = φ(z)/|L| Σ d_α h_α(z) up to a degree, with x = m + L z, the standard normal density φ and Hermite's polynomials.
///
/// m and LLᵀ follow the density's own mean and covariance. Means of the h_α obey dd_α/dt = E\[Gh_α − (ṁ, L̇ z)·L⁻ᵀ∇h_α\], and
/// polynomials are mapped to polynomials: no node and no domain is needed. Of a density far wider than its force is linear,
/// the degrees that are left out feed the others, and the error grows at once.
#[derive(Clone)]
pub(super) struct MovingFrame<'a> {
    operator: &'a FokkerPlanck,
    degree: usize,
    pub(super) time: f64,
    place: FrameState,
}

/// What changes in time.
#[derive(Clone)]
struct FrameState {
    mean: DVector<f64>,
    scale: DMatrix<f64>,
    density: HermiteTable,
}

impl FrameState {
    /// The place after a time at a rate.
    fn moved(&self, time: f64, rate: &FrameState) -> FrameState {
        let mut density = self.density.clone();
        density.add(time, &rate.density);
        FrameState { mean: &self.mean + &rate.mean * time, scale: &self.scale + &rate.scale * time, density }
    }
}

impl<'a> MovingFrame<'a> {
    /// The frame of a start: a Gaussian, or a point as soon as noise has made it one. None of other densities.
    pub(super) fn new(operator: &'a FokkerPlanck, start: &Start, degree: usize) -> Option<Self> {
        let states = operator.dimension();
        let (time, gaussian) = match start {
            Start::Gaussian(gaussian) => (0.0, gaussian.clone()),
            Start::Point(x) => {
                let slopes = operator.drift().iter().flat_map(|f| f.gradient(x));
                let time = POINT / slopes.fold(f64::MIN_POSITIVE, |most, slope| most.max(slope.abs()));
                let point =
                    Gaussian { mean: DVector::from_column_slice(x), covariance: DMatrix::zeros(states, states) };
                (time, gaussian_after(operator, &point, time))
            }
            Start::Stationary | Start::Density(_) => return None,
        };
        let reach = operator.drift().iter().chain(operator.diffusion().iter().flatten()).map(Polynomial::degree);
        let side = degree + 1 + reach.max().unwrap_or(0) as usize;
        let place =
            FrameState { scale: gaussian.scale().ok()?, mean: gaussian.mean, density: HermiteTable::one(states, side) };
        Some(MovingFrame { operator, degree, time, place })
    }

    /// The coordinates; none once they are not finite.
    pub(super) fn frame(&self) -> Option<Frame> {
        Frame::of(self.place.mean.clone(), self.place.scale.clone())
    }

    /// The density's ratio to the normal one.
    pub(super) fn ratio(&self, z: &[f64]) -> f64 {
        let table = &self.place.density;
        let values: Vec<Vec<f64>> = z.iter().map(|z| hermite(*z, self.degree + 1)).collect();
        let product = |index: usize| (0..z.len()).map(|i| values[i][table.degree(index, i)]).product::<f64>();
        let all = table.values.iter().enumerate().filter(|(_, d)| **d != 0.0);
        all.map(|(index, d)| d * product(index)).sum()
    }

    /// Goes on to a time by the classical Runge-Kutta method, but not farther than `most` steps. None where numbers stop being
    /// finite.
    pub(super) fn advance(&mut self, end: f64, most: usize) -> Option<()> {
        for _ in 0..most {
            if self.time >= end {
                break;
            }
            let left = end - self.time;
            let (first, speed) = self.rate(&self.place)?;
            let longest = FRAME_STEP / speed;
            let h = left / (left / longest).ceil().max(1.0);
            let rate = |place: &FrameState, _: f64| self.rate(place).map(|(rate, _)| rate).ok_or(());
            self.place = runge_kutta(&self.place, &first, h, rate, |place, rate, time| place.moved(time, rate)).ok()?;
            self.time = if h == left { end } else { self.time + h };
        }
        Some(())
    }

    /// The rates of change at a place, and how fast that is.
    fn rate(&self, place: &FrameState) -> Option<(FrameState, f64)> {
        let n = place.mean.len();
        let local = self.operator.in_frame(&Frame::of(place.mean.clone(), place.scale.clone())?);
        let mut products = HermiteProducts::of(place.density.clone());
        let carried: Vec<HermiteTable> = local.drift().iter().map(|f| products.with(f)).collect();
        let spread: Vec<Vec<HermiteTable>> =
            local.diffusion().iter().map(|row| row.iter().map(|b| products.with(b)).collect()).collect();
        let own: Vec<HermiteTable> = Polynomial::variables(n).iter().map(|z| products.with(z)).collect();
        let stride = |i: usize| place.density.stride(i);
        let mean = DVector::from_fn(n, |i, _| carried[i].values[0]);
        let slopes =
            DMatrix::from_fn(n, n, |i, j| carried[i].values[stride(j)] - mean[i] * place.density.values[stride(j)]);
        let noise = DMatrix::from_fn(n, n, |i, j| spread[i][j].values[0]);
        let widening = &slopes + slopes.transpose() + &noise;
        let turn = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => widening[(i, i)] / 2.0,
            std::cmp::Ordering::Greater => widening[(i, j)],
        });
        let mut flow = carried;
        for i in 0..n {
            flow[i].add(-mean[i], &place.density);
            (0..=i).for_each(|j| flow[i].add(-turn[(i, j)], &own[j]));
        }
        let mut density = HermiteTable { values: vec![0.0; place.density.values.len()], ..place.density };
        for index in 1..density.values.len() {
            if density.total(index) > self.degree {
                continue;
            }
            let power = |i: usize| place.density.degree(index, i) as f64;
            let mut sum = 0.0;
            for i in (0..n).filter(|&i| power(i) > 0.0) {
                sum += power(i).sqrt() * flow[i].values[index - stride(i)];
                if power(i) > 1.0 {
                    sum += 0.5 * (power(i) * (power(i) - 1.0)).sqrt() * spread[i][i].values[index - 2 * stride(i)];
                }
                for j in (0..i).filter(|&j| power(j) > 0.0) {
                    sum += (power(i) * power(j)).sqrt() * spread[i][j].values[index - stride(i) - stride(j)];
                }
            }
            density.values[index] = sum;
        }
        let speed = slopes.amax() + noise.amax();
        let rate = FrameState { mean: &place.scale * mean, scale: &place.scale * turn, density };
        let finite = speed.is_finite() && rate.density.values.iter().all(|value| value.is_finite());
        finite.then_some((rate, speed.max(f64::MIN_POSITIVE)))
    }
}

use super::{importance::Importance, resampling::systematic};
use crate::simulation::{
    lanes::Lanes,
    passage::{Course, Passages},
    random::Random,
    scheme::Scheme,
};
use crate::{PolynomialDrift, Result};

/// Particles in lockstep.
pub(super) const WIDTH: usize = 8;

/// Population i owns 2²² streams, one for each place of a particle, from `FIRST` + 2²² i on. The streams below belong to the
/// simulation that makes the starting states.
const STREAMS: u64 = 1 << 22;
const FIRST: u64 = 1 << 36;

/// A state with its weight.
pub(super) type Particle<const N: usize> = ([f64; N], f64);

/// The weighted particles of one replica, sorted into bins of the importance function.
#[derive(Debug)]
pub(super) struct Population<const N: usize> {
    /// The edges between the bins, rising.
    thresholds: Vec<f64>,
    bins: Vec<Bin<N>>,
    /// The number of particles in every bin that is not empty.
    particles: usize,
    seed: u64,
    random: Random,
    first: u64,
    /// The uniform numbers used for resampling so far.
    drawn: u64,
    time: f64,
}

/// Particles of equal weight.
#[derive(Debug)]
struct Bin<const N: usize> {
    groups: Vec<Lanes<N, WIDTH>>,
    /// The weight of each particle; zero for an empty bin.
    weight: f64,
}

/// What moves the particles.
pub(super) struct Motion<'a, T, const N: usize, const M: usize> {
    pub(super) scheme: &'a Scheme<'a, T, N, M>,
    pub(super) importance: &'a Importance<'a, N>,
    /// A state beyond has exploded.
    pub(super) bound: [f64; N],
    /// Time steps between two resamplings.
    pub(super) steps: usize,
}

impl<const N: usize> Population<N> {
    /// Population `index` of a seed, with no particles yet; `particles` is a multiple of [`WIDTH`].
    pub(super) fn new(seed: u64, index: u64, particles: usize) -> Self {
        Population {
            thresholds: Vec::new(),
            bins: Vec::new(),
            particles,
            seed,
            random: Random::new(seed),
            first: FIRST + index * STREAMS,
            drawn: 0,
            time: 0.0,
        }
    }

    /// Takes other thresholds from the next resampling on.
    pub(super) fn set_thresholds(&mut self, thresholds: &[f64]) {
        self.thresholds = thresholds.to_vec();
    }

    /// Sorts weighted states into the bins and resamples them there: each bin keeps its weight.
    pub(super) fn place(&mut self, importance: &Importance<'_, N>, states: &[Particle<N>]) -> Result<()> {
        while self.bins.len() <= self.thresholds.len() {
            let first = self.first + (self.bins.len() * self.particles) as u64;
            let places = first..first + self.particles as u64;
            let groups = places.clone().step_by(WIDTH).map(|place| Lanes::new(self.seed, place..places.end, |z| z));
            let groups = groups.collect();
            self.bins.push(Bin { groups, weight: 0.0 });
        }
        let mut sorted: Vec<Vec<Particle<N>>> = vec![Vec::new(); self.bins.len()];
        for &(x, weight) in states {
            let xi = importance.at(&x)?;
            sorted[self.thresholds.partition_point(|&edge| edge <= xi)].push((x, weight));
        }
        for (bin, states) in self.bins.iter_mut().zip(sorted) {
            bin.weight = states.iter().map(|&(_, w)| w).sum::<f64>() / self.particles as f64;
            if bin.weight > 0.0 {
                let kept = systematic(
                    states.iter().map(|&(_, w)| w),
                    self.particles,
                    self.random.uniform(self.first, self.drawn),
                );
                self.drawn += 1;
                for (group, kept) in bin.groups.iter_mut().zip(kept.chunks_exact(WIDTH)) {
                    for (l, &k) in kept.iter().enumerate() {
                        group.set_state(l, states[k].0);
                    }
                }
            }
        }
        Ok(())
    }

    /// All particles move on for one cycle, until [`Population::place`] resamples them. The weight of the up-crossings of
    /// each level of `course` is added to `crossings`.
    pub(super) fn advance<T: PolynomialDrift<N, M>, const M: usize>(
        &mut self,
        motion: &Motion<'_, T, N, M>,
        course: &Course,
        crossings: &mut [f64],
    ) -> Result<Vec<Particle<N>>> {
        let step = motion.scheme.step;
        self.time += motion.steps as f64 * step;
        let mut states = Vec::new();
        for bin in self.bins.iter_mut().filter(|bin| bin.weight > 0.0) {
            let mut passages = Passages::new(course.levels.len());
            for group in &mut bin.groups {
                group.advance(motion.scheme, course, motion.steps, &mut passages);
                group.check(&motion.bound, self.time, step)?;
                states.extend(group.states().map(|x| (x, bin.weight)));
            }
            for (sum, [count, ..]) in crossings.iter_mut().zip(&passages.crossings) {
                *sum += bin.weight * count;
            }
        }
        Ok(states)
    }

    /// The particles beyond the last threshold.
    pub(super) fn last(&self) -> Vec<Particle<N>> {
        let weighted = |bin: &Bin<N>| bin.groups.iter().flat_map(Lanes::states).map(|x| (x, bin.weight)).collect();
        self.bins.get(self.thresholds.len()).filter(|bin| bin.weight > 0.0).map(weighted).unwrap_or_default()
    }

    /// The weight in each bin.
    pub(super) fn masses(&self) -> impl Iterator<Item = f64> + '_ {
        self.bins.iter().map(|bin| bin.weight * self.particles as f64)
    }
}

use super::{importance::Importance, resampling::systematic};
use crate::simulation::{
    boundaries::Boundaries,
    group::{Group, Workspace},
    random::Random,
    scheme::Scheme,
};
use crate::{error::Result, field::LANES, states::States};

/// Population i owns 2²² streams, one for each place of a particle, from `FIRST` + 2²² i on. The streams below belong to the
/// simulation that makes the starting states.
const STREAMS: u64 = 1 << 22;
const FIRST: u64 = 1 << 36;

/// States, each with its weight.
pub(super) struct Particles {
    states: States,
    weights: Vec<f64>,
}

impl Particles {
    fn new(dimension: usize) -> Self {
        Particles { states: States::new(dimension), weights: Vec::new() }
    }

    /// Equal weights, the states' numbers one behind another.
    pub(super) fn equal(dimension: usize, states: &[f64]) -> Self {
        let states = States::from_values(dimension, states.to_vec());
        let weights = vec![1.0 / states.len() as f64; states.len()];
        Particles { states, weights }
    }

    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&[f64], f64)> {
        self.states.iter().zip(self.weights.iter().copied())
    }

    /// Appends the particles of a bin.
    fn push(&mut self, group: &Group, weight: f64) {
        self.states.extend(&group.states());
        self.weights.resize(self.states.len(), weight);
    }
}

/// The weighted particles of one replica, sorted into bins of the importance function.
pub(super) struct Population {
    /// The edges between the bins, rising.
    thresholds: Vec<f64>,
    bins: Vec<Bin>,
    /// The number of particles in every bin that is not empty.
    particles: usize,
    seed: u64,
    random: Random,
    first: u64,
    /// The uniform numbers used for resampling so far.
    drawn: u64,
    time: f64,
    work: Workspace,
}

/// Particles of equal weight.
struct Bin {
    groups: Vec<Group>,
    /// The weight of each particle; zero for an empty bin.
    weight: f64,
}

/// The motion of the particles: the scheme, the boundaries, and the steps between two resamplings.
pub(super) struct ParticleMotion<'a> {
    pub(super) scheme: &'a Scheme<'a>,
    pub(super) importance: &'a Importance<'a>,
    /// The moduli beyond which a state has exploded.
    pub(super) bounds: Vec<f64>,
    /// Time steps between two resamplings.
    pub(super) steps: usize,
}

impl Population {
    /// Population `index` of a seed, with no particles yet, so many to a bin.
    pub(super) fn new(scheme: &Scheme<'_>, seed: u64, index: u64, particles: usize) -> Self {
        Population {
            thresholds: Vec::new(),
            bins: Vec::new(),
            particles,
            seed,
            random: Random::new(seed),
            first: FIRST + index * STREAMS,
            drawn: 0,
            time: 0.0,
            work: Workspace::new(scheme),
        }
    }

    /// Takes other thresholds from the next resampling on.
    pub(super) fn set_thresholds(&mut self, thresholds: &[f64]) {
        self.thresholds = thresholds.to_vec();
    }

    /// Sorts weighted states into the bins and resamples them there: each bin keeps its weight.
    pub(super) fn place(&mut self, importance: &Importance<'_>, particles: &Particles) -> Result<()> {
        let dimension = particles.states.dimension();
        while self.bins.len() <= self.thresholds.len() {
            let first = self.first + (self.bins.len() * self.particles) as u64;
            let end = first + self.particles as u64;
            let group = |place| Group::new(self.seed, place..end, dimension, |_| ());
            let groups = (first..end).step_by(LANES).map(group).collect();
            self.bins.push(Bin { groups, weight: 0.0 });
        }
        let mut sorted: Vec<Vec<usize>> = vec![Vec::new(); self.bins.len()];
        for (i, x) in particles.states.iter().enumerate() {
            let xi = importance.at(x)?;
            sorted[self.thresholds.partition_point(|&edge| edge <= xi)].push(i);
        }
        for (bin, inside) in self.bins.iter_mut().zip(sorted) {
            let weights = inside.iter().map(|&i| particles.weights[i]);
            bin.weight = weights.clone().sum::<f64>() / self.particles as f64;
            if bin.weight > 0.0 {
                let kept = systematic(weights, self.particles, self.random.uniform(self.first, self.drawn));
                self.drawn += 1;
                for (group, kept) in bin.groups.iter_mut().zip(kept.chunks(LANES)) {
                    for (l, &k) in kept.iter().enumerate() {
                        group.set_state(l, particles.states.state(inside[k]));
                    }
                }
            }
        }
        Ok(())
    }

    /// All particles move on for one cycle, until [`Population::place`] resamples them. The weight of the up-crossings of
    /// each level of `boundaries` is added to `crossings`.
    pub(super) fn advance(
        &mut self,
        motion: &ParticleMotion<'_>,
        boundaries: &Boundaries,
        crossings: &mut [f64],
    ) -> Result<Particles> {
        let step = motion.scheme.step;
        self.time += motion.steps as f64 * step;
        let mut particles = Particles::new(motion.scheme.states);
        for bin in self.bins.iter_mut().filter(|bin| bin.weight > 0.0) {
            let mut passages = boundaries.passages();
            for group in &mut bin.groups {
                group.advance(motion.scheme, boundaries, motion.steps, &mut passages, &mut self.work);
                group.check(&motion.bounds, self.time, step)?;
                particles.push(group, bin.weight);
            }
            for (sum, [count, ..]) in crossings.iter_mut().zip(&passages.crossings) {
                *sum += bin.weight * count;
            }
        }
        Ok(particles)
    }

    /// The particles beyond the last threshold.
    pub(super) fn last(&self, dimension: usize) -> Particles {
        let mut particles = Particles::new(dimension);
        if let Some(bin) = self.bins.get(self.thresholds.len()).filter(|bin| bin.weight > 0.0) {
            bin.groups.iter().for_each(|group| particles.push(group, bin.weight));
        }
        particles
    }

    /// The weight in each bin.
    pub(super) fn masses(&self) -> impl Iterator<Item = f64> + '_ {
        self.bins.iter().map(|bin| bin.weight * self.particles as f64)
    }
}

//! Poisson impulses: when they come in a time step, and how large they are.

use super::normal::{exponential, pair};
use super::random::Random;
use crate::field::{Addition, LANES};
use crate::fokker_planck::Impulse;
use crate::numerics::EIGHT;
use crate::polynomial::Polynomial;
use crate::problem::Problem;
use crate::system::Amplitude;
use std::ops::Range;

/// The sources of impulses, for time steps of one length.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources(Vec<Source>);

#[derive(Clone, Debug)]
struct Source {
    field: Vec<Polynomial>,
    /// H with its states, where it is the same at all states.
    direction: Option<Vec<(usize, f64)>>,
    amplitude: Amplitude,
    rate: f64,
    /// The mean number μ of impulses in a span, and exp(−μ).
    mean: f64,
    none: f64,
}

/// An impulse of one lane in a time step.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimedImpulse {
    pub(super) lane: usize,
    /// The part of the step that is over.
    pub(super) time: f64,
    source: usize,
    size: f64,
}

/// The halves of a time step.
pub(super) const FIRST_HALF: Range<f64> = 0.0..0.5;
pub(super) const SECOND_HALF: Range<f64> = 0.5..1.0;
/// The time steps whose impulses are held: a span and the next one.
const HELD: usize = 2 * SPAN as usize;

/// The time steps that impulses are drawn for at once.
pub(super) const SPAN: u64 = 8;
/// The most impulses of one source in a span: a multiple of what the length of a step allows on average.
const MOST: u64 = 1 << 8;

impl Sources {
    /// Those of a problem, all amplitudes times `amplitude`, for steps of the length `step`.
    pub(super) fn new(problem: &Problem, amplitude: f64, step: f64) -> Self {
        let source = |impulse: &Impulse| {
            let process = impulse.process();
            let mean = process.rate() * step * SPAN as f64;
            let listed = |direction: Vec<f64>| direction.into_iter().enumerate().filter(|(_, h)| *h != 0.0).collect();
            Source {
                field: impulse.field().to_vec(),
                direction: impulse.direction().map(listed),
                amplitude: process.amplitude().each(|size| size * amplitude),
                rate: process.rate(),
                mean,
                none: (-mean).exp(),
            }
        };
        Sources(problem.impulses().iter().map(source).collect())
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Moves a state by an impulse, x + H(x) Y.
    pub(super) fn apply(&self, impulse: &TimedImpulse, x: &mut [f64]) {
        let Source { field, direction, .. } = &self.0[impulse.source];
        match direction {
            Some(direction) => direction.iter().for_each(|(i, h)| x[*i] += h * impulse.size),
            None => {
                let moves: Vec<f64> = field.iter().map(|h| h.evaluate(x) * impulse.size).collect();
                x.iter_mut().zip(moves).for_each(|(x, by)| *x += by);
            }
        }
    }

    /// λ (E\[Y\] H v + ½ E\[Y²\] H²), the mean power that impulses bring to a velocity v.
    pub(super) fn power(&self, x: &[f64], v: usize) -> f64 {
        let of = |Source { field, amplitude, rate, .. }: &Source| {
            let h = field[v].evaluate(x);
            rate * (amplitude.moment(1) * h * x[v] + amplitude.moment(2) * h * h / 2.0)
        };
        self.0.iter().map(of).sum()
    }

    /// Whether H is the same at all states, for every source.
    pub(super) fn are_additive(&self) -> bool {
        self.0.iter().all(|source| source.direction.is_some())
    }

    /// Adds what an impulse that is the same at all states and comes the time `ago` before the end of a straight piece changes
    /// there.
    #[inline(always)]
    fn additions_of(
        &self,
        (kick, impulse): (usize, &TimedImpulse),
        ago: f64,
        pairs: &[(usize, usize)],
        additions: &mut Vec<Addition>,
    ) {
        let TimedImpulse { lane, source, size, .. } = *impulse;
        for (velocity, h) in self.0[source].direction.as_deref().unwrap_or_default() {
            let by = h * size;
            additions.push(Addition { kick, state: *velocity, lane, by });
            for (displacement, _) in pairs.iter().filter(|(_, v)| v == velocity) {
                additions.push(Addition { kick, state: *displacement, lane, by: ago * by });
            }
        }
    }

    /// The number of impulses of each lane in a span, by the inverse of Poisson's distribution, their sizes and their times, as
    /// parts of the span; `add` takes them.
    #[inline(always)]
    fn draw(
        &self,
        (random, first): (Random, u64),
        span: u64,
        drawn: &mut Vec<(usize, u64)>,
        mut add: impl FnMut(f64, TimedImpulse),
    ) {
        for (source, Source { amplitude, mean, none, .. }) in self.0.iter().enumerate() {
            let mut words = [0; LANES];
            for l in 0..LANES {
                words[l] = random.impulse_count(first + l as u64, source as u64, span);
            }
            drawn.clear();
            for (lane, word) in words.iter().enumerate() {
                let uniform = unit(*word);
                let (mut count, mut chance, mut below) = (0, *none, *none);
                while uniform >= below && count < MOST {
                    drawn.push((lane, count));
                    count += 1;
                    chance *= mean / count as f64;
                    below += chance;
                }
            }
            // Some at a time, which share wide registers.
            for part in drawn.chunks(EIGHT) {
                let [mut streams, mut numbers, mut first_words, mut second_words, mut times] = [[0; EIGHT]; 5];
                for (k, (lane, number)) in part.iter().enumerate() {
                    (streams[k], numbers[k]) = (first + *lane as u64, 2 * (source as u64 * MOST + number));
                }
                for k in 0..EIGHT {
                    [first_words[k], second_words[k]] = random.impulse(streams[k], numbers[k], span);
                }
                for k in 0..EIGHT {
                    times[k] = random.impulse(streams[k], numbers[k] + 1, span)[0];
                }
                let sizes = amplitudes(amplitude, &first_words, &second_words);
                for (k, (lane, _)) in part.iter().enumerate() {
                    add(unit(times[k]), TimedImpulse { lane: *lane, time: 0.0, source, size: sizes[k] });
                }
            }
        }
    }
}

/// A number in [0, 1) from 64 random bits.
#[inline(always)]
fn unit(word: u64) -> f64 {
    (word >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Amplitudes from two words of random bits each.
#[inline(always)]
fn amplitudes(amplitude: &Amplitude, a: &[u64; EIGHT], b: &[u64; EIGHT]) -> [f64; EIGHT] {
    match *amplitude {
        Amplitude::Normal { mean, deviation } => std::array::from_fn(|k| mean + deviation * pair([a[k], b[k]])[0]),
        Amplitude::Exponential { mean } => a.map(|a| mean * exponential(a)),
        Amplitude::Uniform { low, high } => a.map(|a| low + (high - low) * unit(a)),
        Amplitude::TwoPoint { a: first, b: second } => a.map(|a| if a & 1 == 0 { first } else { second }),
        Amplitude::Laplace { mean, scale } => {
            std::array::from_fn(|k| mean + if b[k] & 1 == 0 { scale } else { -scale } * exponential(a[k]))
        }
    }
}

/// The impulses of some lanes in a few successive time steps.
#[derive(Clone, Debug, Default)]
pub(super) struct TimedImpulses {
    /// By the number of the step, those of each in order of time.
    steps: [Vec<TimedImpulse>; HELD],
    /// The span that is drawn next; unknown before the first.
    next: Option<u64>,
    /// Lanes with the numbers of their impulses.
    drawn: Vec<(usize, u64)>,
    additions: Vec<Addition>,
}

impl TimedImpulses {
    /// Forgets what was drawn, for lanes that may be others.
    pub(super) fn clear(&mut self) {
        self.next = None;
    }

    /// Draws those of all time steps up to one, from the one after the last on.
    #[inline(always)]
    pub(super) fn draw(&mut self, sources: &Sources, lanes: (Random, u64), step: u64) {
        let last = step / SPAN;
        for span in self.next.unwrap_or(last)..=last {
            self.draw_span(sources, lanes, span);
        }
        self.next = Some(last + 1);
    }

    #[inline(always)]
    fn draw_span(&mut self, sources: &Sources, lanes: (Random, u64), span: u64) {
        let TimedImpulses { steps, drawn, .. } = self;
        let place = |step: u64| (span * SPAN + step) as usize % HELD;
        (0..SPAN).for_each(|step| steps[place(step)].clear());
        sources.draw(lanes, span, drawn, |time, impulse| {
            let time = time * SPAN as f64;
            steps[place(time as u64)].push(TimedImpulse { time: time.fract(), ..impulse });
        });
        for list in (0..SPAN).map(place) {
            steps[list].sort_unstable_by(|a, b| a.time.total_cmp(&b.time));
        }
    }

    /// Those in a part of a step that was drawn.
    #[inline(always)]
    pub(super) fn within(&self, step: u64, part: Range<f64>) -> impl Iterator<Item = &TimedImpulse> {
        self.steps[step as usize % HELD].iter().filter(move |impulse| part.contains(&impulse.time))
    }

    /// What impulses that are the same at all states change in the straight pieces behind some kicks, of which that of time step
    /// `first` is the first, for time steps of the length `h`.
    #[inline(always)]
    pub(super) fn additions(
        &mut self,
        sources: &Sources,
        (first, count): (u64, usize),
        h: f64,
        pairs: &[(usize, usize)],
    ) -> &[Addition] {
        if sources.is_empty() {
            return &[];
        }
        let mut additions = std::mem::take(&mut self.additions);
        additions.clear();
        for kick in 0..count {
            let step = first + kick as u64;
            // From the middle of the step of the kick to that of the next one.
            for (step, part, end) in [(step, SECOND_HALF, 1.5), (step + 1, FIRST_HALF, 0.5)] {
                for impulse in self.within(step, part) {
                    sources.additions_of((kick, impulse), (end - impulse.time) * h, pairs, &mut additions);
                }
            }
        }
        self.additions = additions;
        &self.additions
    }
}

//! A system whose white noise rises and fades.

use crate::envelope::{Envelope, Piece};
use crate::error::Result;
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::Gaussian;
use crate::problem::{ModulatedMoments, Problem, gaussian_after};
use std::borrow::Cow;

/// A problem with the envelope of its white noise; without one the noise is as it stands.
#[derive(Clone, Copy)]
pub(super) struct Modulated<'a> {
    pub(super) problem: &'a Problem,
    pub(super) envelope: Option<&'a Envelope>,
}

/// A stretch of time on which the envelope is smooth.
#[derive(Clone, Copy)]
pub(super) struct Stretch<'a> {
    problem: &'a Problem,
    piece: Option<&'a Piece>,
}

impl<'a> Modulated<'a> {
    /// The largest e, 1 without an envelope.
    pub(super) fn peak(&self) -> f64 {
        self.envelope.map_or(1.0, Envelope::peak)
    }

    /// The problem under the strongest noise.
    pub(super) fn strongest(&self) -> Result<Cow<'a, Problem>> {
        let peak = self.peak();
        if peak == 1.0 { Ok(Cow::Borrowed(self.problem)) } else { self.problem.amplified(peak).map(Cow::Owned) }
    }

    /// The stretch from `time` on.
    pub(super) fn stretch(&self, time: f64) -> Stretch<'a> {
        Stretch { problem: self.problem, piece: self.envelope.map(|envelope| envelope.piece(time)) }
    }
}

impl Modulated<'_> {
    /// A narrow Gaussian after a time, by its moments.
    pub(super) fn gaussian_after(&self, start: &Gaussian, time: f64) -> Gaussian {
        match self.envelope {
            None => gaussian_after(self.problem.operator(), start, time),
            Some(envelope) => {
                let piece = envelope.piece(0.0);
                ModulatedMoments::new(self.problem).after(start, piece, [0.0, time.min(piece.until)])
            }
        }
    }
}

impl<'a> Stretch<'a> {
    /// Where it ends.
    pub(super) fn until(&self) -> f64 {
        self.piece.map_or(f64::INFINITY, |piece| piece.until)
    }

    /// e², the share of the intensities.
    pub(super) fn share(&self, time: f64) -> f64 {
        self.piece.map_or(1.0, |piece| piece.squared(time)[0])
    }

    /// The operator at a time within.
    pub(super) fn operator(&self, time: f64) -> Cow<'a, FokkerPlanck> {
        if self.piece.is_none() {
            Cow::Borrowed(self.problem.operator())
        } else {
            Cow::Owned(self.problem.under_noise(self.share(time)))
        }
    }
}

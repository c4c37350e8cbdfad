//! Envelopes of modulated noise.

use crate::checks::{finite, positive, require};
use crate::error::{Error, Result};

/// The envelope e(t) ≥ 0 of modulated noise: every column of G is multiplied by it, so that B becomes e(t)² B.
///
/// In Stratonovich's sense the drift that the noise induces is multiplied by e(t)² as well. Times count from the start of a
/// transient.
///
/// ```
/// use expoly::Envelope;
/// let earthquake = Envelope::exponentials(2.32, 0.09, 1.49)?;
/// assert!(earthquake.value(0.0) == 0.0 && (earthquake.value(2.0) - 1.819988).abs() < 1e-6);
/// let burst = Envelope::steps([(0.0, 1.0), (10.0, 0.0)])?;
/// assert_eq!([5.0, 10.0].map(|t| burst.value(t)), [1.0, 0.0]);
/// let ramp = Envelope::table([(0.0, 0.0), (4.0, 1.0)])?;
/// assert_eq!([1.0, 9.0].map(|t| ramp.value(t)), [0.25, 1.0]);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// By rising time; the first one begins at −∞.
    pieces: Vec<Piece>,
}

/// A stretch of time on which an envelope is smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Where it begins.
    from: f64,
    /// Where the next one begins.
    pub(crate) until: f64,
    shape: PieceShape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PieceShape {
    /// value + slope (t − from); the slope is 0 where `from` is −∞.
    Line { value: f64, slope: f64 },
    /// amplitude (e^(−slow t) − e^(−fast t)).
    Exponentials { amplitude: f64, slow: f64, fast: f64 },
}

impl Envelope {
    /// e(t) = `amplitude` (e^(−`slow` t) − e^(−`fast` t)) for t ≥ 0: the noise rises within 1/`fast` and fades within 1/`slow`,
    /// as that of an earthquake does.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless all are finite, the amplitude is positive and 0 ≤ `slow` < `fast`.
    ///
    /// # Reference
    /// M. Shinozuka and Y. Sato, Simulation of nonstationary random process, Journal of the Engineering Mechanics Division 93
    /// (1967) 11-40.
    pub fn exponentials(amplitude: f64, slow: f64, fast: f64) -> Result<Self> {
        positive("amplitude of an envelope", amplitude, "it must be finite and above zero")?;
        require(
            slow.is_finite() && slow >= 0.0,
            "slow rate of an envelope",
            slow,
            "it must be finite and not negative",
        )?;
        let remedy = "it must be finite and above the slow rate, which the noise fades at";
        require(fast.is_finite() && fast > slow, "fast rate of an envelope", fast, remedy)?;
        let still = Piece { from: f64::NEG_INFINITY, until: 0.0, shape: PieceShape::Line { value: 0.0, slope: 0.0 } };
        let shape = PieceShape::Exponentials { amplitude, slow, fast };
        Ok(Envelope { pieces: vec![still, Piece { from: 0.0, until: f64::INFINITY, shape }] })
    }

    /// Steps: each of the points (time, value) holds until the next one, the last for ever. There is no noise before the first.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless times rise and values are finite and not negative, at least one of them above zero.
    pub fn steps(points: impl IntoIterator<Item = (f64, f64)>) -> Result<Self> {
        let points = checked(points.into_iter().collect())?;
        let before = (f64::NEG_INFINITY, 0.0);
        Ok(Self::joined(std::iter::once(before).chain(points).map(|(from, value)| (from, value, 0.0))))
    }

    /// A table of points (time, value) with straight lines between them. The first value holds before, the last one for ever.
    ///
    /// # Errors
    /// As [`Envelope::steps`].
    pub fn table(points: impl IntoIterator<Item = (f64, f64)>) -> Result<Self> {
        let points = checked(points.into_iter().collect())?;
        let before = (f64::NEG_INFINITY, points[0].1, 0.0);
        let lines = (0..points.len()).map(|k| {
            let (from, value) = points[k];
            let slope = points.get(k + 1).map_or(0.0, |(to, next)| (next - value) / (to - from));
            (from, value, slope)
        });
        Ok(Self::joined(std::iter::once(before).chain(lines)))
    }

    /// Lines (from, value, slope), each until the next one.
    fn joined(lines: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        let lines: Vec<_> = lines.collect();
        let until = |k: usize| lines.get(k + 1).map_or(f64::INFINITY, |line| line.0);
        let piece = |(k, &(from, value, slope)): (usize, &(f64, f64, f64))| Piece {
            from,
            until: until(k),
            shape: PieceShape::Line { value, slope },
        };
        Envelope { pieces: lines.iter().enumerate().map(piece).collect() }
    }

    /// e(t); at a step the value after it.
    pub fn value(&self, time: f64) -> f64 {
        self.piece(time).value(time)[0]
    }

    /// The largest value from time 0 on.
    pub fn peak(&self) -> f64 {
        let pieces = self.pieces.iter().filter(|piece| piece.until > 0.0);
        pieces.map(Piece::highest).fold(0.0, f64::max)
    }

    /// The piece that holds from `time` on.
    pub(crate) fn piece(&self, time: f64) -> &Piece {
        let after = self.pieces.partition_point(|piece| piece.from <= time);
        &self.pieces[after.saturating_sub(1)]
    }
}

impl Piece {
    /// e and its derivative; at the end of the piece, from within.
    pub(crate) fn value(&self, time: f64) -> [f64; 2] {
        match self.shape {
            PieceShape::Line { value, slope: 0.0 } => [value, 0.0],
            PieceShape::Line { value, slope } => [value + slope * (time - self.from), slope],
            PieceShape::Exponentials { amplitude, slow, fast } => {
                let [a, b] = [slow, fast].map(|rate| amplitude * (-rate * time).exp());
                // Where both are nearly equal, their difference without cancellation.
                [-a * (-(fast - slow) * time).exp_m1(), fast * b - slow * a]
            }
        }
    }

    /// e² and its derivative; at the end of the piece, from within.
    pub(crate) fn squared(&self, time: f64) -> [f64; 2] {
        let [value, slope] = self.value(time);
        [value * value, 2.0 * value * slope]
    }

    /// The largest value at t ≥ 0.
    fn highest(&self) -> f64 {
        match self.shape {
            PieceShape::Exponentials { slow, fast, .. } if slow > 0.0 => {
                let ratio = (fast - slow) / slow;
                let log = if ratio.is_finite() { ratio.ln_1p() } else { fast.ln() - slow.ln() };
                self.value(log / (fast - slow))[0]
            }
            PieceShape::Exponentials { amplitude, .. } => amplitude,
            PieceShape::Line { value, slope: 0.0 } => value,
            PieceShape::Line { .. } => {
                [self.from.max(0.0), self.until].map(|t| self.value(t)[0]).into_iter().fold(0.0, f64::max)
            }
        }
    }
}

/// Points of an envelope, once they have a meaning.
fn checked(points: Vec<(f64, f64)>) -> Result<Vec<(f64, f64)>> {
    for &(time, value) in &points {
        finite("time of an envelope", time)?;
        require(
            value.is_finite() && value >= 0.0,
            "value of an envelope",
            value,
            "it must be finite and not negative: only its square counts",
        )?;
    }
    for pair in points.windows(2) {
        positive(
            "time to the next point of an envelope",
            pair[1].0 - pair[0].0,
            "give points in rising order of time",
        )?;
    }
    let highest = points.iter().fold(0.0, |highest: f64, point| highest.max(point.1));
    let remedy = "give at least one point with a value above zero";
    if highest == 0.0 {
        return Err(Error::OutOfRange { name: "highest value of an envelope", value: highest, remedy });
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The derivative of e² by central differences, whose error is h²/6 times the third derivative, and the order of times.
    #[test]
    fn pieces_join_and_have_their_own_slopes() -> Result<()> {
        let h = 1e-5;
        let shapes = [
            (Envelope::exponentials(2.32, 0.09, 1.49)?, 1.3),
            (Envelope::exponentials(1.0, 0.0, 2.0)?, 0.4),
            (Envelope::table([(-1.0, 0.2), (1.0, 0.7), (2.5, 0.1)])?, 1.9),
            (Envelope::steps([(0.0, 0.5), (2.0, 1.5)])?, 1.0),
        ];
        for (envelope, t) in &shapes {
            let piece = envelope.piece(*t);
            let difference = (piece.squared(t + h)[0] - piece.squared(t - h)[0]) / (2.0 * h);
            assert!((piece.squared(*t)[1] - difference).abs() < 1e-8, "{envelope:?}");
            assert!((0..900).all(|k| envelope.value(0.01 * f64::from(k)) <= envelope.peak() + 1e-12));
        }
        // At a step the piece before keeps its own value.
        let steps = &shapes[3].0;
        assert_eq!((steps.piece(1.0).until, steps.piece(1.0).squared(2.0)[0], steps.value(2.0)), (2.0, 0.25, 1.5));
        assert_eq!((steps.value(-1.0), shapes[2].0.value(-3.0), shapes[2].0.value(7.0)), (0.0, 0.2, 0.1));
        assert!((shapes[0].0.peak() - 1.819_990_336).abs() < 1e-8 && shapes[1].0.peak() == 1.0);
        Ok(())
    }

    #[test]
    fn envelopes_without_a_meaning_are_refused() {
        let refused = [
            Envelope::exponentials(0.0, 0.1, 1.0),
            Envelope::exponentials(f64::NAN, 0.1, 1.0),
            Envelope::exponentials(1.0, -0.1, 1.0),
            Envelope::exponentials(1.0, 1.0, 1.0),
            Envelope::exponentials(1.0, 0.1, f64::INFINITY),
            Envelope::steps([]),
            Envelope::steps([(0.0, 0.0), (1.0, 0.0)]),
            Envelope::steps([(1.0, 1.0), (1.0, 2.0)]),
            Envelope::table([(f64::NEG_INFINITY, 1.0), (1.0, 2.0)]),
            Envelope::table([(0.0, 1.0), (1.0, -2.0)]),
            Envelope::table([(0.0, f64::NAN)]),
        ];
        for envelope in refused {
            assert!(matches!(envelope, Err(Error::OutOfRange { .. })), "{envelope:?}");
        }
    }
}

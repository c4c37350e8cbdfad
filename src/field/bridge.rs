//! The motion of a state across a place where its drift jumps, or next to an end that reflects it, drawn exactly.

/// A place of a state at which noise and a jump of the drift, or a reflecting end, act together.
///
/// With s the distance from the place, ds = −μ sgn(s) dt + σ dW has a |s| that is Y_t − min(0, min Y) with Y = |s₀| − μ t + σ W, and as
/// long as Y has no zero the sign of s₀; afterwards either sign is as likely. Given its end, the least value of Y is drawn by the law of
/// a Brownian bridge (T. K. Caughey and J. K. Dienes, Journal of Applied Physics 32 (1961) 2476-2479, have the density of s). A split step that takes the
/// friction apart from the noise is of the weak order 1 to 1.5 there. At a reflecting end s itself is that |s|.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bridge {
    pub(crate) state: usize,
    pub(crate) place: f64,
    pub(crate) kind: BridgeKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BridgeKind {
    /// The drift jumps.
    Jump,
    /// The motion is reflected above the place, or below.
    Above,
    Below,
}

/// Where the exponent of the probability that a bridge comes to 0 is larger than this, it does not.
const NEVER: f64 = 40.0;

impl Bridge {
    /// The state at the end of a step, given that at its beginning and the noise's part in it; half of the jump of the drift above the
    /// place over that below, or the drift at the end, times the step; and the variance of the noise.
    pub(super) fn moved(&self, begin: f64, noise: f64, push: f64, variance: f64) -> f64 {
        let s = begin - self.place;
        let side = match self.kind {
            BridgeKind::Jump if s < 0.0 => -1.0,
            BridgeKind::Below => -1.0,
            _ => 1.0,
        };
        // At an end the drift points to one side; the halves of a jump point both away or both back.
        let along = if self.kind == BridgeKind::Jump { push } else { side * push };
        let from = (side * s).max(0.0);
        let to = from + along + side * noise;
        if to > 0.0 && 2.0 * from * to > NEVER * variance {
            return self.place + side * to;
        }
        let bits = scrambled(noise.to_bits());
        let uniform = ((bits >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
        let least = 0.5 * (from + to - ((to - from).powi(2) - 2.0 * variance * uniform.ln()).sqrt());
        if least > 0.0 {
            return self.place + side * to;
        }
        let turned = self.kind == BridgeKind::Jump && bits & 1 == 1;
        self.place + (if turned { -side } else { side }) * (to - least)
    }
}

/// Bits that are as good as independent of the number whose bits they are made from (the finalizer of SplitMix64; G. L. Steele, D. Lea
/// and C. H. Flood, 2014, doi:10.1145/2714064.2660195): further random numbers of the step that the number was drawn for.
fn scrambled(bits: u64) -> u64 {
    let mut z = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

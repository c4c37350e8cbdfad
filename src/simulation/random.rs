use super::normal::pair;
use serde::{Deserialize, Serialize};

/// The generator of a seed's random numbers: Philox4x32-10, a bijection of 128-bit counters under a 64-bit key (J. K. Salmon,
/// M. A. Moraes, R. O. Dror and D. E. Shaw, 2011, doi:10.1145/2063384.2063405).
///
/// The key is the seed. The counter identifies the number: its place in its sequence (64 bits), the purpose (24 bits) and the
/// stream, one for each trajectory (40 bits). So there is no state to keep: every number can be computed at any time, in any
/// order, in any number of lanes, and a trajectory that is resumed needs nothing but its place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct Random {
    seed: u64,
}

/// The first of the streams of a simulation's pilot, which are beyond those of all sampled trajectories.
pub(super) const PILOT: u64 = 1 << 32;
/// Purposes above those of the noises, which have their own numbers.
const COINS: u64 = 1 << 12;
const START: u64 = COINS + 1;
const UNIFORM: u64 = COINS + 2;
const GRAZING: u64 = 1 << 13;
const ARRIVALS: u64 = 1 << 22;
const IMPULSES: u64 = 1 << 23;

/// The steps that one word of coins serves.
const COINS_PER_DRAW: u64 = 128;

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Random { seed }
    }

    /// The 128 bits at `place` of a stream's sequence for `purpose`.
    #[inline(always)]
    fn bits(self, stream: u64, purpose: u64, place: u64) -> [u64; 2] {
        let counter = [place & LOW, place >> 32, stream & LOW, stream >> 32 << 24 | purpose];
        let [a, b, c, d] = philox(counter, [self.seed & LOW, self.seed >> 32]);
        [b << 32 | a, d << 32 | c]
    }

    /// The standard normal numbers of noise `k` in the time steps 2 `place` and 2 `place` + 1.
    #[inline(always)]
    pub(super) fn normals(self, stream: u64, k: u64, place: u64) -> [f64; 2] {
        pair(self.bits(stream, k, place))
    }

    /// Two standard normal numbers for the start of a trajectory.
    pub(super) fn start(self, stream: u64, place: u64) -> [f64; 2] {
        pair(self.bits(stream, START, place))
    }

    /// A uniform number in [0, 1), of 53 bits.
    pub(super) fn uniform(self, stream: u64, place: u64) -> f64 {
        (self.bits(stream, UNIFORM, place)[0] >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// The fair coin of a time step.
    #[inline(always)]
    pub(super) fn coin(self, stream: u64, step: u64) -> bool {
        let bits = self.bits(stream, COINS, step / COINS_PER_DRAW);
        let at = step % COINS_PER_DRAW;
        (if at < 64 { bits[0] >> at } else { bits[1] >> (at - 64) }) & 1 == 1
    }

    /// 64 bits for the number of impulses of a source in a span of time steps.
    #[inline(always)]
    pub(super) fn impulse_count(self, stream: u64, source: u64, span: u64) -> u64 {
        self.bits(stream, ARRIVALS + source, span)[0]
    }

    /// 128 bits for an impulse in a span.
    #[inline(always)]
    pub(super) fn impulse(self, stream: u64, number: u64, span: u64) -> [u64; 2] {
        self.bits(stream, IMPULSES + number, span)
    }

    /// The `count`-th 128 bits for the shorter steps inside a time step.
    pub(super) fn grazing(self, stream: u64, step: u64, count: u64) -> [u64; 2] {
        self.bits(stream, GRAZING + count, step)
    }
}

const LOW: u64 = 0xffff_ffff;

/// Ten rounds of Philox4x32. Words of 32 bits travel in the lower halves of words of 64, so that many of them can be
/// multiplied at once; the contents of the upper halves are never read.
#[inline(always)]
fn philox(mut counter: [u64; 4], mut key: [u64; 2]) -> [u64; 4] {
    for _ in 0..10 {
        let first = (counter[0] & LOW) * 0xD251_1F53;
        let second = (counter[2] & LOW) * 0xCD9E_8D57;
        counter = [second >> 32 ^ counter[1] ^ key[0], second, first >> 32 ^ counter[3] ^ key[1], first];
        key = [key[0].wrapping_add(0x9E37_79B9) & LOW, key[1].wrapping_add(0xBB67_AE85) & LOW];
    }
    counter.map(|word| word & LOW)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers that come with the authors' own code.
    #[test]
    fn philox_gives_its_known_answers() {
        assert_eq!(philox([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox([LOW; 4], [LOW; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        let counter = [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344];
        let key = [0xa409_3822, 0x299f_31d0];
        assert_eq!(philox(counter, key), [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]);
    }
}

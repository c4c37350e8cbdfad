//! Damage to texts and files.

use crate::draw::Draw;

/// Words with a meaning in one of the formats, and numbers that are too large or too long.
const WORDS: [&str; 24] = [
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e308",
    "1e-320",
    "0",
    "-1",
    "18446744073709551616",
    "^",
    "^61",
    "^4294967296",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "\n",
    "*x",
    "null",
    "=",
    ",",
];

/// One to three accidents.
pub(super) fn mutant(draw: &mut Draw, original: &[u8]) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..1 + draw.below(3) {
        let (from, at) = (draw.below(bytes.len() + 1), draw.below(bytes.len()));
        match draw.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << draw.below(8),
            1 if at < bytes.len() => drop(bytes.remove(at)),
            2 => bytes.insert(from, draw.below(256) as u8),
            3 => {
                let to = (at + 1 + draw.below(60)).min(bytes.len());
                let piece = bytes[at.min(to)..to].to_vec();
                bytes.splice(from..from, piece);
            }
            4 => bytes.truncate(at),
            5 if at < bytes.len() => bytes[at] = b'0' + draw.below(10) as u8,
            _ => {
                // A recursive parser needs a limit for brackets.
                let times = if draw.with(0.9) { 1 } else { draw.of([100, 10_000, 100_000]) };
                let word = draw.of(WORDS).repeat(times);
                bytes.splice(from..from, word.bytes());
            }
        }
    }
    bytes
}

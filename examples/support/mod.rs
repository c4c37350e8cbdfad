//! What several examples need: figures, files, numbers in JSON, progress bars.

// Each example compiles its own copy of this folder and uses only part of it.
#![allow(dead_code, unreachable_pub)]

pub mod figure;
pub mod file;
pub mod json;
pub mod progress;

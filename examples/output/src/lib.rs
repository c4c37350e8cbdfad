//! What programs show: figures, files that are written whole, and progress bars.

pub mod figure;
pub mod file;
pub mod progress;

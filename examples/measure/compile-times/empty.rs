//! Nothing, linked against the library: what every program costs.

use expoly as _;

fn main() {}

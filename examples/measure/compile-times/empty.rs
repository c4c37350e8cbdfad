//! An empty program, linked against the library: the cost that every program has.

use expoly as _;

fn main() {}

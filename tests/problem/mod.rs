//! Problems: their parts, their equations, problems as text, other units, and input that is refused.

mod definition;
mod hostile;
mod impulses;
mod operator;
mod parameters;
mod questions;
mod text;
mod units;

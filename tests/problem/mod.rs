//! Problems: what they are made of, their equations, problems as text, and input that is refused.

mod definition;
mod hostile;
mod operator;
mod questions;
mod text;

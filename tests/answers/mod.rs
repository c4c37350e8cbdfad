//! The uses of a density: statistics, comparisons, studies, and closed forms for other programs.

mod closed_form;
mod densities;
mod parts;
mod sampling_errors;
mod study;

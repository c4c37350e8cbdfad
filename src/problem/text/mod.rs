//! Problems as text: `read` parses a document once, `written` has its values for any parameters.

mod family;
mod impulse;
mod read;
mod write;
mod written;

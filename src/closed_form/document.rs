//! The JSON document: its format and version, the library that wrote it, the density, and a checksum.

use super::{ClosedDensity, ClosedForm, names};
use crate::density::Density;
use crate::record::{Read, checksum};
use serde::{Deserialize, Serialize};
use serde_json::Value;

const FORMAT: &str = "expoly closed form";
/// Raised whenever the meaning of a document changes.
const VERSION: u32 = 3;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    version: u32,
    /// The version of the library that wrote it.
    library: String,
    states: Vec<String>,
    density: Value,
    /// Of the states and the density, in hexadecimal.
    checksum: String,
}

/// What is read first: a document of another format or version has these two entries as well.
#[derive(Deserialize)]
struct Heading {
    format: String,
    version: u32,
}

pub(super) fn write(form: &ClosedForm) -> Read<String> {
    let density = serde_json::to_value(&form.density).map_err(|error| error.to_string())?;
    // A number that JSON cannot hold, infinite or NaN, has become null, which cannot be read back as a number.
    ClosedDensity::deserialize(&density).map_err(|error| format!("a number is not finite: {error}"))?;
    let states = form.names.clone();
    let checksum = digest(&states, &density)?;
    let (format, library) = (FORMAT.to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    let document = Document { format, version: VERSION, library, states, density, checksum };
    serde_json::to_string(&document).map_err(|error| error.to_string())
}

pub(super) fn read(text: &str) -> Read<ClosedForm> {
    let heading: Heading = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if heading.format != FORMAT {
        return Err(format!("its format is {:?}, not {FORMAT:?}", heading.format));
    }
    if heading.version != VERSION {
        return Err(format!("it is of version {}, and this library reads version {VERSION}", heading.version));
    }
    let document: Document = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let Document { states: names, density, checksum, .. } = document;
    let found = digest(&names, &density)?;
    if found != checksum {
        return Err(format!("its content has the checksum {found}, not {checksum}: it was altered"));
    }
    names::check(&names).map_err(|error| error.to_string())?;
    let density = ClosedDensity::deserialize(&density).map_err(|error| error.to_string())?;
    let form = ClosedForm { names, density };
    if form.names.len() != form.dimension() {
        return Err(format!("it names {} states, {:?}, of {}", form.names.len(), form.names, form.dimension()));
    }
    Ok(form)
}

fn digest(states: &[String], density: &Value) -> Read<String> {
    let bytes = serde_json::to_vec(&(states, density)).map_err(|error| error.to_string())?;
    Ok(format!("{:016x}", checksum(&bytes)))
}

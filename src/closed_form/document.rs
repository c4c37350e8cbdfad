//! The JSON document: what it is, who wrote it, the density, and a checksum.

use super::{ClosedDensity, ClosedForm, names};
use crate::closure::ClosureRecord;
use crate::density::ExpRecord;
use crate::record::{Read, checksum};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

const FORMAT: &str = "expoly closed form";
/// Raised whenever a document would be read otherwise than before.
const VERSION: u32 = 1;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    version: u32,
    /// The version of the library that wrote it.
    library: String,
    states: Vec<String>,
    density: DensityRecord,
    /// Of the states and the density, in hexadecimal.
    checksum: String,
}

/// What is read first, whatever else there may be.
#[derive(Deserialize)]
struct Heading {
    format: String,
    version: u32,
    states: Vec<String>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
enum DensityRecord {
    Closure(Box<ClosureRecord>),
    ExpPolynomial(ExpRecord),
}

impl<const N: usize> From<&ClosedDensity<N>> for DensityRecord {
    fn from(density: &ClosedDensity<N>) -> Self {
        match density {
            ClosedDensity::Closure(density) => DensityRecord::Closure(Box::new((&**density).into())),
            ClosedDensity::ExpPolynomial(density) => DensityRecord::ExpPolynomial((&**density).into()),
        }
    }
}

pub(super) fn write<const N: usize>(form: &ClosedForm<N>) -> Result<String> {
    let refused = |problem| Error::NotAClosedForm { problem };
    let (states, density) = (form.names.to_vec(), DensityRecord::from(&form.density));
    let checksum = digest(&states, &density).map_err(refused)?;
    let (format, library) = (FORMAT.to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    let document = Document { format, version: VERSION, library, states, density, checksum };
    let text = serde_json::to_string(&document).map_err(|error| refused(error.to_string()))?;
    // A number that JSON has no sign for has become a gap, which no reader takes for a number.
    serde_json::from_str::<Document>(&text).map_err(|error| refused(format!("a number is not finite: {error}")))?;
    Ok(text)
}

pub(super) fn read<const N: usize>(text: &str) -> Result<ClosedForm<N>> {
    parse(text).map_err(|problem| Error::NotAClosedForm { problem })
}

fn parse<const N: usize>(text: &str) -> Read<ClosedForm<N>> {
    let heading: Heading = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if heading.format != FORMAT {
        return Err(format!("its format is {:?}, not {FORMAT:?}", heading.format));
    }
    if heading.version != VERSION {
        return Err(format!("it is of version {}, and this library reads version {VERSION}", heading.version));
    }
    let states: &[String; N] =
        heading.states.as_slice().try_into().map_err(|_| {
            format!("it has {} states, {:?}, and {N} were asked for", heading.states.len(), heading.states)
        })?;
    let Document { density, checksum, .. } = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let found = digest(&heading.states, &density)?;
    if found != checksum {
        return Err(format!("its content has the checksum {found}, not {checksum}: it was altered"));
    }
    names::check(&states.each_ref().map(String::as_str)).map_err(|error| error.to_string())?;
    let density = match &density {
        DensityRecord::Closure(record) => record.density()?.into(),
        DensityRecord::ExpPolynomial(record) => record.density()?.into(),
    };
    Ok(ClosedForm { names: states.clone(), density })
}

fn digest(states: &[String], density: &DensityRecord) -> Read<String> {
    let bytes = serde_json::to_vec(&(states, density)).map_err(|error| error.to_string())?;
    Ok(format!("{:016x}", checksum(&bytes)))
}

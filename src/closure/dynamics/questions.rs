//! What questions of time and of parameters of a density are answered by.

use super::{Dynamics, MomentSystem, served};
use crate::closure::candidates::Origin;
use crate::closure::density::ClosureDensity;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::problem::Problem;
use std::sync::Arc;

impl ClosureDensity {
    /// The problem that this is a density of.
    pub(in crate::closure) fn problem(&self) -> Result<&Problem> {
        Ok(&self.origin()?.problem)
    }

    pub(in crate::closure) fn origin(&self) -> Result<&Arc<Dynamics>> {
        let (what, remedy) = if matches!(self.candidates()[0].origin, Origin::Closest { .. }) {
            ("the motion behind a density that no moment equations gave", "take the grid")
        } else {
            ("the motion behind a density from a document", "solve the problem again")
        };
        self.dynamics.as_ref().ok_or(Error::NotKnown { what: what.into(), remedy })
    }

    /// What the closure is made from, and its moment equations.
    pub(in crate::closure) fn motion(&self) -> Result<(&Arc<Dynamics>, &MomentSystem)> {
        let dynamics = self.origin()?;
        served(self.dimension() > 2, &dynamics.problem)?;
        let reason = "its moment equations have a growing mode at every degree: take the grid, or the simulation";
        let refusal = Error::NotClosed { order: self.provenance().order.unwrap_or(0), reason };
        Ok((dynamics, dynamics.system().ok_or(refusal)?))
    }
}

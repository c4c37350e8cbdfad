//! What a march begins with: the density of a start on a mesh.

use super::field::GridField;
use super::mesh::{Mesh, Side};
use super::narrow::Narrow;
use super::operator::Layout;
use super::refinement::{Finer, finer};
use super::shape::Shape;
use super::start::Ground;
use crate::checks::require;
use crate::density::Density;
use crate::envelope::Envelope;
use crate::error::Result;
use crate::memory::MemoryLimit;
use crate::numerics::Rule;
use crate::polynomial::{Frame, Gaussian};
use crate::states::States;
use crate::transient::Start;
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The smallest standard deviation of a Gaussian start over the width of the domain: cells are a few thousandths of the
/// deviation, and must not lose their width to rounding.
const THINNEST: f64 = 1e-9;

/// A start, at the time from which on it has a density that a mesh holds.
#[derive(Clone)]
pub(super) struct Initial {
    pub(super) time: f64,
    law: InitialLaw,
    /// Its distance from the true density in L¹, at most.
    pub(super) error: f64,
}

/// The density at that time.
#[derive(Clone)]
enum InitialLaw {
    Stationary,
    Gaussian(Gaussian),
    Density(Arc<dyn Density>),
}

impl Initial {
    /// A start, before the `first` time that is asked for; what spreads from a point may be off by `accuracy` in L¹.
    pub(super) fn new(
        start: &Start,
        ground: &Ground<'_>,
        envelope: Option<&Envelope>,
        (first, accuracy): (f64, f64),
    ) -> Result<Self> {
        let states = ground.domain.len();
        start.check(states)?;
        let at_once = |law| Ok(Initial { time: 0.0, law, error: 0.0 });
        let x = match start {
            Start::Stationary => return at_once(InitialLaw::Stationary),
            Start::Gaussian(gaussian) => return at_once(InitialLaw::Gaussian(gaussian.clone())),
            Start::Density(density) => return at_once(InitialLaw::Density(Arc::clone(density))),
            Start::Point(x) => x.clone(),
        };
        let narrow = Narrow::spread(ground, envelope, &x, (first, accuracy))?;
        Ok(Initial { time: narrow.time, law: InitialLaw::Gaussian(narrow.gaussian), error: narrow.error })
    }

    /// The mesh that holds it to `aim`, with the field there, and whether the memory ended before.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if it reaches beyond a wall or an edge, or is too narrow.
    pub(super) fn held(
        &self,
        ground: &Ground<'_>,
        stationary: &GridField,
        (shape, memory): (Shape, MemoryLimit),
        aim: f64,
    ) -> Result<(Layout, GridField, bool)> {
        if let InitialLaw::Gaussian(gaussian) = &self.law {
            for (axis, [low, high]) in ground.domain.iter().enumerate() {
                let deviation = gaussian.covariance[(axis, axis)].sqrt();
                let remedy =
                    "next to the domain it is too narrow for double precision: take a later time or a wider start";
                require(deviation > THINNEST * (high - low), "deviation of the start", deviation, remedy)?;
            }
        }
        let mut layout = Layout::new(ground.mesh_for(self.sample().as_ref().unwrap_or(&ground.pilot.states)));
        loop {
            let field = self.field(stationary, &layout.mesh, shape)?;
            let next = finer(&field, aim, memory);
            let exhausted = matches!(next, Finer::Exhausted);
            if let Finer::Layout(finer) = next {
                layout = finer;
                continue;
            }
            self.require_held(&field)?;
            return Ok((layout, field, exhausted));
        }
    }

    /// States that a Gaussian has.
    fn sample(&self) -> Option<States> {
        const POINTS: i32 = 10;
        const REACH: f64 = 3.0;
        let InitialLaw::Gaussian(gaussian) = &self.law else { return None };
        let root = gaussian.covariance.clone().cholesky()?.l();
        let mut sample = States::new(gaussian.mean.len());
        let along = (2 * POINTS + 1) as usize;
        let states = gaussian.mean.len();
        for k in 0..along.pow(states as u32) {
            let place = |axis: usize| (k / along.pow((states - 1 - axis) as u32) % along) as f64 - f64::from(POINTS);
            let z = DVector::from_fn(states, |axis, _| REACH * place(axis) / f64::from(POINTS));
            sample.push((&gaussian.mean + &root * z).as_slice());
        }
        Some(sample)
    }

    /// The density on a mesh; of the stationary density, `stationary` is the solution of the same degree.
    pub(super) fn field(&self, stationary: &GridField, mesh: &Arc<Mesh>, shape: Shape) -> Result<GridField> {
        Ok(match &self.law {
            InitialLaw::Stationary => stationary.carried(mesh, shape),
            InitialLaw::Gaussian(gaussian) => GridField::projected(mesh, shape, normal(gaussian)?),
            // What is not known makes a mass that is refused.
            InitialLaw::Density(density) => {
                GridField::projected(mesh, shape, |x| density.log_pdf(x).map_or(f64::NAN, f64::exp))
            }
        })
    }

    /// Refuses a mesh that does not hold the start.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if it reaches beyond a wall or an edge.
    fn require_held(&self, field: &GridField) -> Result<()> {
        let mass = field.mass();
        let expected = match &self.law {
            InitialLaw::Stationary => return Ok(()),
            InitialLaw::Gaussian(gaussian) => inside(gaussian, &field.mesh),
            // Between levels, what lies beyond them is not known.
            InitialLaw::Density(_) if field.mesh.sides[0].contains(&Side::Level) => mass.clamp(0.0, 1.0),
            InitialLaw::Density(_) => 1.0,
        };
        let remedy = "the start must lie inside the domain, away from walls";
        require((mass - expected).abs() <= 1e-3, "mass of the start on the mesh", mass, remedy)?;
        Ok(())
    }
}

/// The values of a normal density.
fn normal(gaussian: &Gaussian) -> Result<impl Fn(&[f64]) -> f64 + Sync> {
    let frame = Frame::new(gaussian)?;
    let states = gaussian.mean.len();
    let volume = (TAU.ln() * states as f64 / 2.0 + frame.log_volume()).exp();
    Ok(move |x: &[f64]| {
        let (origin, inverse) = (frame.origin(), frame.inverse());
        // The inverse of the scale is lower triangular.
        let coordinate = |i: usize| (0..=i).map(|j| inverse[(i, j)] * (x[j] - origin[j])).sum::<f64>();
        let square: f64 = (0..states).map(|i| coordinate(i).powi(2)).sum();
        (-square / 2.0).exp() / volume
    })
}

/// The probability of a Gaussian between the levels that absorb.
fn inside(gaussian: &Gaussian, mesh: &Mesh) -> f64 {
    const REACH: f64 = 9.0;
    let (mean, deviation) = (gaussian.mean[0], gaussian.covariance[(0, 0)].sqrt());
    let limit = |side: usize| {
        let z = (mesh.domain()[0][side] - mean) / deviation;
        if mesh.sides[0][side] == Side::Level { z.clamp(-REACH, REACH) } else { (2.0 * side as f64 - 1.0) * REACH }
    };
    let (low, high) = (limit(0), limit(1));
    let rule = Rule::legendre(64);
    rule.on(low, high).iter().map(|(z, weight)| weight * (-z * z / 2.0).exp()).sum::<f64>() / TAU.sqrt()
}

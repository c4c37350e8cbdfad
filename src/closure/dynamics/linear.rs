//! The transients of a linear system in one state and two, which from a normal start are normal at all times.

use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Content;
use crate::closure::density::exact::exact_about;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::method::Closure;
use crate::closure::pilot::normal_density;
use crate::closure::projection::exactness::quadratic;
use crate::closure::space::nested_spaces::Smooth;
use crate::polynomial::Gaussian;
use crate::problem::{Problem, linear_after};
use crate::provenance::Provenance;
use crate::transient::{Course, Start, Transient};
use std::time::Instant;

/// The half-width of the region about which a normal density is integrated, and of the box of its polynomial, in standard deviations.
const REACH: f64 = 6.0;

impl Closure {
    /// The exact densities. None for systems that are not linear or have noise that depends on the state, other starts, and times at
    /// which the density has no width yet.
    pub(super) fn normal_transient(
        &self,
        problem: &Problem,
        Course { start, envelope }: &Course,
        times: &[f64],
    ) -> Option<Vec<Transient<ClosureDensity>>> {
        let begin = Instant::now();
        let stationary = normal_density(problem).filter(|_| envelope.is_none())?;
        let start = match start {
            Start::Point(x) => Gaussian::point(x),
            Start::Gaussian(gaussian) => gaussian.clone(),
            Start::Stationary => stationary,
            Start::Density(_) => return None,
        };
        let at = |(time, gaussian): (&f64, Gaussian)| {
            let mut content = self.normal(&gaussian)?;
            let seconds = begin.elapsed().as_secs_f64();
            content.provenance = Provenance { order: Some(self.lowest()), seconds, ..Provenance::default() };
            Some(Transient { time: *time, density: ClosureDensity::new(content), step_error: 0.0 })
        };
        times.iter().zip(linear_after(problem.operator(), &start, times)).map(at).collect()
    }

    fn normal(&self, gaussian: &Gaussian) -> Option<Content> {
        let centre = gaussian.mean.as_slice().to_vec();
        let deviation: Vec<f64> = gaussian.covariance.diagonal().iter().map(|v| v.sqrt()).collect();
        let half_width: Vec<f64> = deviation.iter().map(|s| REACH * s).collect();
        let space =
            Smooth { degrees: self.degrees.clone(), ..Smooth::complete(centre.clone(), half_width) }.functions(2);
        exact_about(quadratic(&space, gaussian)?, &TrustDomain::whole(centre, deviation, REACH))
    }
}

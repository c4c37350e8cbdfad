use super::{SimulatedDensity, distribution::Distribution, passage::POWERS, plan::same_level};
use crate::checks::{coordinate, dimension, point, require, state_index};
use crate::density::{Counted, CountedImpacts, Crossing, Density, Evidence, Sampled, central, pair, summary};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::polynomial::of_one;
use crate::provenance::Provenance;
use crate::walls::{Wall, limits};
use std::fmt;
use std::sync::Arc;

/// The density behind a wall.
const NOTHING: Estimate = Estimate { value: 0.0, error: 0.0 };

impl Density for SimulatedDensity {
    fn dimension(&self) -> usize {
        self.layout.axes.len()
    }

    /// The density by the histogram's quadratic reconstruction, for one state and for two.
    ///
    /// # Errors
    /// [`Error::Dimension`] unless x has one number for each state, [`Error::NotKnown`] for more than two states, whose
    /// histogram would be empty almost everywhere. Marginals are there for any number of states.
    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        point(x, self.dimension())?;
        let histogram = self.whole("the density at a state")?;
        if (0..self.dimension()).any(|state| self.is_behind_wall(state, x[state])) {
            return Ok(NOTHING);
        }
        Ok(self.histograms[histogram].at(x))
    }

    /// ln p; −∞ also where bins are nearly empty and the reconstruction is not positive.
    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        let p = self.pdf(x)?.value;
        Ok(if p <= 0.0 { f64::NEG_INFINITY } else { p.ln() })
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, self.dimension())?;
        if self.is_behind_wall(state, x) {
            return Ok(NOTHING);
        }
        Ok(self.histograms[state].at(&[x]))
    }

    /// The range of the histograms.
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.layout.axes.iter().map(|axis| [axis.edge(0), axis.edge(axis.bins())]).collect()
    }

    /// E[g(X)] over the cells of the histogram, for one state and for two. Each sample counts as spread over its cell; the
    /// error includes the effect of g's curvature within a cell.
    ///
    /// # Errors
    /// [`Error::NotKnown`] for more states.
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        let histogram = self.whole("the mean of a function")?;
        Ok(self.histograms[histogram].mean(g))
    }

    /// Of states 0 and 1, and of those named by [`Simulation::joint`](crate::Simulation::joint) before the run.
    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let [first, second] = pair(states, x, self.dimension())?;
        if self.is_behind_wall(first, x[0]) || self.is_behind_wall(second, x[1]) {
            return Ok(NOTHING);
        }
        let x = if first < second { x } else { [x[1], x[0]] };
        match (self.plane(), first + second) {
            (Some(histogram), 1) => Ok(histogram.at(&x)),
            _ => Ok(self.joint([first, second])?.at(&x)),
        }
    }

    /// The raw moment. Tracked are all total degrees up to 4 for up to three states; for more states all up to 2, and the
    /// powers of a single state up to 4.
    ///
    /// # Errors
    /// [`Error::NotKnown`] for any other.
    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("the exponents of a moment", powers.len(), self.dimension())?;
        let place = self.tracked(powers).ok_or_else(|| Error::NotKnown {
            what: format!("the moment of the exponents {powers:?}"),
            remedy: "name it in `Simulation::moments` before the run",
        })?;
        Ok(self.of_tracked([&[0], &[place]], |[n, sum]| sum / n))
    }

    /// The flux moment from counted passages, for the powers 1, 2 and 3: Σ|v|^(power − 1) per unit time. Up-crossings of
    /// the levels named before the run; at a wall the impacts, and the rebounds, whose speeds are r times as large.
    ///
    /// # Errors
    /// [`Error::NotKnown`] for any other level or direction, [`Error::NotADisplacement`] if the crossing is not that of
    /// state 0 with its velocity, [`Error::OutOfRange`] for other powers.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let [displacement, velocity] = crossing.states(self.dimension())?;
        let Crossing { level, upward, .. } = crossing;
        let remedy = "passages are counted with the powers 1, 2 and 3 of the velocity";
        require((1..=POWERS as u32).contains(&power), "power of a flux", f64::from(power), remedy)?;
        let pair = self.plan.displacements.contains(&(displacement, velocity));
        let at =
            |wall: &&Wall| wall.state() == displacement && wall.other().is_none() && same_level(wall.offset(), level);
        if let Some(k) = self.plan.walls.iter().position(|wall| pair && at(&wall)) {
            let wall = &self.plan.walls[k];
            let impacts = self.rate(&self.gates(&[k]), power as usize);
            let slowed = wall.restitution().powi(power as i32 - 1);
            return Ok(if upward == wall.is_above() { impacts.scaled(slowed) } else { impacts });
        }
        if displacement != 0 || !pair {
            return Err(Error::NotADisplacement { state: displacement });
        }
        if !upward {
            let what = format!("the crossings of the level {level} from above");
            return Err(Error::NotKnown { what, remedy: "a simulation counts those from below" });
        }
        let place = self.level(level)?;
        Ok(self.rate(&[place], power as usize))
    }

    fn variance(&self, state: usize) -> Result<Estimate> {
        // Control variates and rounding may put that of a state that hardly moves below zero.
        self.of_moments(state, &|raw| central(raw)[0].max(0.0))
    }

    fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let velocity = self.plan.velocity().ok_or(Error::NotADisplacement { state: 0 })?;
        self.flux(Crossing { velocity, ..Crossing::upward(level) }, 1)
    }

    /// Seed, counts, times.
    fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    fn impact_rate(&self) -> Option<Estimate> {
        CountedImpacts::impact_flux(self, &self.walls(), 1)
    }

    fn evidence(&self) -> &dyn Evidence {
        self
    }
}

impl Evidence for SimulatedDensity {
    fn sampled(&self) -> Option<&dyn Sampled> {
        Some(self)
    }

    fn counted_impacts(&self) -> Option<&dyn CountedImpacts> {
        Some(self)
    }
}

impl Sampled for SimulatedDensity {
    fn of_moments(&self, state: usize, statistic: &dyn Fn(&[f64]) -> f64) -> Result<Estimate> {
        let states = self.dimension();
        let state = state_index("a state's index", state, states)?;
        let places = [0, 1, 2, 3, 4].map(|power| Vec::from_iter(self.tracked(&of_one(states, state, power))));
        let places = places.each_ref().map(Vec::as_slice);
        Ok(self.of_tracked(places, |sums| statistic(&sums.map(|sum| sum / sums[0]))))
    }

    fn distribution(&self, state: usize) -> Result<Arc<dyn Counted>> {
        state_index("a state's index", state, self.dimension())?;
        Ok(Arc::new(Distribution::new(&self.histograms[state])))
    }

    fn bins(&self, state: usize) -> Result<Vec<([f64; 2], Estimate)>> {
        self.histogram(state)?.along()
    }
}

impl CountedImpacts for SimulatedDensity {
    fn impact_speeds(&self, walls: &[usize]) -> Option<Arc<dyn Counted>> {
        Some(Arc::new(Distribution::new(&self.speeds_at(walls)?)))
    }

    fn impact_flux(&self, walls: &[usize], power: u32) -> Option<Estimate> {
        let known = !walls.is_empty() && walls.iter().all(|&wall| wall < self.plan.walls.len());
        (known && (1..=POWERS as u32).contains(&power)).then(|| self.rate(&self.gates(walls), power as usize))
    }

    fn mean_impact_speed(&self, walls: &[usize], power: u32) -> Option<Estimate> {
        self.impact_flux(walls, power + 1)?;
        let places = [1, power as usize + 1]
            .map(|power| self.gates(walls).into_iter().map(|gate| self.passages(gate, power)).collect::<Vec<_>>());
        Some(self.of_tracked(places.each_ref().map(Vec::as_slice), |[count, speeds]| speeds / count))
    }
}

impl SimulatedDensity {
    fn is_behind_wall(&self, state: usize, x: f64) -> bool {
        let [low, high] = limits(&self.plan.walls, state);
        x < low || x > high
    }

    /// The place of the histogram of all states together.
    fn whole(&self, what: &str) -> Result<usize> {
        let states = self.dimension();
        if states <= 2 {
            return Ok(2 * (states - 1));
        }
        let remedy = "a simulation of more than two states counts marginals and moments; take these, or a closure";
        Err(Error::NotKnown { what: what.to_owned(), remedy })
    }
}

impl fmt::Display for SimulatedDensity {
    /// How it was made, its domain, moments and rates, and its estimate of the error, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        summary(self, f)
    }
}

//! The integrals of a closure's density, on Gauss nodes, on a lattice or on draws, each with its distance from that of the
//! reference.

use super::cells::DomainCells;
use super::content::{Content, Integrals};
use super::impacts::{Combination, POWERS, WallImpacts};
use crate::checks::{coordinate, dimension, point};
use crate::closure::candidates::Origin;
use crate::closure::density::ClosureDensity;
use crate::closure::samples::ImportanceRule;
use crate::density::{Counted, CountedImpacts, Crossing, Density, Evidence, moderate, pair, placed};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::functions::Corner;
use crate::polynomial::power;
use crate::provenance::Provenance;
use crate::states::States;
use crate::walls::Wall;
use std::sync::Arc;

impl ClosureDensity {
    /// ∫ g p dx over all states but those held, on draws: with its distance from that of the reference, if there is one.
    fn drawn_section(
        &self,
        rule: &ImportanceRule,
        held: &[(usize, f64)],
        g: &(dyn Fn(&[f64]) -> f64 + Sync),
    ) -> Result<Estimate> {
        let section = rule.section(held, g)?;
        let Some(reference) = &self.content.reference else { return Ok(section) };
        let beyond = |x: &[f64]| g(x) * ((reference.value(x) - self.content.exponent.value(x)).exp() - 1.0);
        let distance = rule.section(held, &beyond)?.value.abs() + reference.error * section.value.abs();
        Ok(Estimate::new(section.value, section.error.hypot(distance)))
    }

    /// ∫ g p dx over all states but those held, on cells.
    fn section_of_cells(&self, cells: &DomainCells, held: &[(usize, f64)], g: &dyn Fn(&[f64]) -> f64) -> Estimate {
        let part = |[own, known]: [f64; 2], (point, w): (Vec<f64>, f64)| {
            let value = w * g(&point);
            [own + value * self.content.exponent.value(&point).exp(), known + value * cells.density(&point)]
        };
        let [own, known] = cells.section(held).into_iter().fold([0.0; 2], part);
        Estimate::new(own, (own - known).abs() + self.reference_error() * known.abs())
    }

    /// ∫ g p dx over all states but one, which is `x`.
    pub(in crate::closure) fn section(
        &self,
        state: usize,
        x: f64,
        g: impl Fn(&[f64]) -> f64 + Sync,
    ) -> Result<Estimate> {
        let Content { exponent, reference, domain, integrals, .. } = &self.content;
        let lines = match integrals {
            Integrals::Panels { lines, .. } => lines,
            Integrals::Cells(cells) => return Ok(self.section_of_cells(cells, &[(state, x)], &g)),
            Integrals::Draws(rule) => return self.drawn_section(rule, &[(state, x)], &g),
        };
        let mut point = vec![0.0; lines.len()];
        point[state] = x;
        let mut sums = [0.0; 2];
        let mut add = |point: &[f64], w: f64| {
            let value = g(point);
            if value != 0.0 && domain.contains(point) {
                let log = exponent.value(point);
                sums[0] += w * value * log.exp();
                sums[1] += w * value * reference.as_ref().map_or(log, |reference| reference.value(point)).exp();
            }
        };
        if lines.len() == 1 {
            add(&point, 1.0);
        } else {
            let other = usize::from(state == 0);
            for (t, w) in lines[other].iter() {
                point[other] = t;
                add(&point, w);
            }
        }
        Ok(Estimate::new(sums[0], (sums[0] - sums[1]).abs() + self.reference_error() * sums[1].abs()))
    }
}

impl Density for ClosureDensity {
    fn dimension(&self) -> usize {
        self.content.dimension()
    }

    fn provenance(&self) -> &Provenance {
        &self.content.provenance
    }

    /// The distance from the reference and the reference's own error, as far as it shows in its highest degrees. Of an exact density it
    /// is what two rules of its integrals differ by.
    fn l1_estimate(&self) -> f64 {
        self.content.candidates[0].l1_estimate
    }

    fn impact_rate(&self) -> Option<Estimate> {
        if !self.content.impacts.is_empty() {
            return self.impact_flux(&(0..self.content.impacts.len()).collect::<Vec<_>>(), 1);
        }
        let walls = self.content.exponent.space.corners().iter().map(Corner::wall);
        let rates = walls.map(|wall| {
            let crossing = if wall.is_above() { Crossing::downward } else { Crossing::upward };
            self.flux(crossing(wall.offset()), 1)
        });
        rates.filter_map(Result::ok).reduce(Estimate::plus)
    }

    fn evidence(&self) -> &dyn Evidence {
        self
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        let p = self.log_pdf(x)?.exp();
        Ok(match (&self.content.reference, &self.content.integrals) {
            (_, Integrals::Cells(cells)) => Estimate::new(p, (p - cells.density(x)).abs() + cells.error * p),
            (Some(reference), _) if self.trusts(x) => Estimate::new(p, (p - reference.value(x).exp()).abs()),
            // Without a better estimate, the error in the mean.
            _ => Estimate::new(p, p * self.l1_estimate()),
        })
    }

    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        point(x, self.dimension())?;
        Ok(self.log_density(x))
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, self.dimension())?;
        self.section(state, x, |_| 1.0)
    }

    /// The box around the trust domain.
    fn bounds(&self) -> Vec<[f64; 2]> {
        match &self.content.integrals {
            Integrals::Cells(cells) => cells.bounds(),
            _ => self.content.domain.bounds(),
        }
    }

    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        if let (Integrals::Draws(rule), true) = (&self.content.integrals, self.nodes.is_empty()) {
            return rule.mean(g);
        }
        let (mut sums, mut square) = ([0.0; 2], 0.0);
        for (x, masses) in self.nodes.iter().zip(&self.masses) {
            let value = g(x);
            sums[0] += value * masses[0];
            sums[1] += value * masses[1];
            square += value * value * masses[1];
        }
        Ok(Estimate::new(sums[0], (sums[0] - sums[1]).abs() + self.reference_error() * square.sqrt()))
    }

    /// In three states and more the moments of Q's own functions are the pilot's calibrated ones, with their standard errors, and those
    /// that the system's symmetry makes zero are zero; where exp(Q) is the closest to a known density, they are that one's.
    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("a list of powers", powers.len(), self.dimension())?;
        if matches!(&self.content.integrals, Integrals::Draws(rule) if !rule.copula.keeps(powers)) {
            return Ok(Estimate::exact(0.0));
        }
        let own = || self.expectation(&|x| power(x, powers));
        match self.content.moments.iter().find(|moment| moment.powers == powers) {
            Some(moment) => {
                let known = Estimate::new(moment.value, moment.error);
                let exact = self.content.candidates[0].origin == Origin::Exact;
                Ok(if exact { own().ok().filter(|own| own.error < known.error).unwrap_or(known) } else { known })
            }
            None => own(),
        }
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair(states, x, self.dimension())?;
        match &self.content.integrals {
            Integrals::Cells(cells) if self.dimension() > 2 => {
                Ok(self.section_of_cells(cells, &[0, 1].map(|k| (states[k], x[k])), &|_| 1.0))
            }
            Integrals::Panels { .. } | Integrals::Cells(_) => self.pdf(&placed(states, x, self.dimension())),
            Integrals::Draws(rule) => self.drawn_section(rule, &[0, 1].map(|k| (states[k], x[k])), &|_| 1.0),
        }
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let [displacement, velocity] = crossing.states(self.dimension())?;
        let power = moderate(power)?;
        self.section(displacement, crossing.level, |x| {
            let speed = if crossing.upward { x[velocity] } else { -x[velocity] };
            if speed > 0.0 { speed.powi(power) } else { 0.0 }
        })
    }
}

impl Evidence for ClosureDensity {
    /// The draws that integrals are taken on, in more than two states.
    fn weighted_states(&self) -> Option<(States, Vec<f64>)> {
        match &self.content.integrals {
            Integrals::Panels { .. } | Integrals::Cells(_) => None,
            Integrals::Draws(rule) => rule.drawn().ok(),
        }
    }

    fn integrates_on_draws(&self) -> bool {
        matches!(self.content.integrals, Integrals::Draws(_))
    }

    fn grazed_walls(&self) -> Vec<(Wall, f64)> {
        let known = if self.dimension() == 2 { &self.content.exponent.known[..] } else { &[] };
        known.iter().map(|corner| (*corner.wall(), corner.intensity())).collect()
    }

    fn counted_impacts(&self) -> Option<&dyn CountedImpacts> {
        (!self.content.impacts.is_empty()).then_some(self as &dyn CountedImpacts)
    }
}

impl ClosureDensity {
    /// None where there is no such wall, or none was counted.
    fn impacts_on(&self, walls: &[usize]) -> Option<Combination> {
        let chosen: Option<Vec<WallImpacts>> = walls.iter().map(|&k| self.content.impacts.get(k).cloned()).collect();
        chosen.filter(|chosen| !chosen.is_empty()).map(|chosen| Combination::of(&chosen))
    }
}

impl CountedImpacts for ClosureDensity {
    fn impact_speeds(&self, walls: &[usize]) -> Option<Arc<dyn Counted>> {
        Some(Arc::new(self.impacts_on(walls)?))
    }

    fn impact_flux(&self, walls: &[usize], power: u32) -> Option<Estimate> {
        let place = (power as usize).checked_sub(1).filter(|place| *place < POWERS)?;
        Some(self.impacts_on(walls)?.estimate(&[(place, 1.0)]))
    }

    fn mean_impact_speed(&self, walls: &[usize], power: u32) -> Option<Estimate> {
        let place = (power as usize).min(POWERS);
        (place < POWERS).then(|| Some(self.impacts_on(walls)?.of_one_impact(&[(place, 1.0)])))?
    }
}

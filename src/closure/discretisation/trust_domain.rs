use crate::closure::pilot::Pilot;
use crate::parallel;
use crate::problem::Symmetry;
use crate::record::{Read, positive_states, states};
use crate::states::States;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// A guess that rises again so far below its peak, in ln p, is not followed any farther.
const RISING: f64 = 5.0;
/// The least slope of the fall of ln p at the edge of the domain, per length of its reach, by which the mass beyond is
/// estimated.
const STEEP: f64 = 20.0;

/// Angular sectors in two states.
const SECTORS: usize = 48;

/// States that a thread takes at a time.
const CHUNK: usize = 1024;

/// Steps along a ray in the search for its end.
const RAY: usize = 128;

/// The part of the state space on which a closure is defined: the region that the pilot has visited, slightly widened.
///
/// It is star-shaped about its centre. In one state it is an interval, in two its reach depends on the direction, by 48
/// sectors, and in more it is an ellipsoid along the states' axes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrustDomain {
    pub(crate) centre: Vec<f64>,
    /// The scales of the states, in which directions and distances are measured.
    pub(crate) scale: Vec<f64>,
    /// The reach by direction, in units of the scales.
    pub(crate) reach: Vec<f64>,
    /// The limits of state 0 where walls stand.
    pub(crate) walls: [Option<f64>; 2],
}

impl TrustDomain {
    /// The hull of the pilot's states about `centre`, in one state and two with their mirror images, with all distances multiplied
    /// by `widening`. Walls at state 0, if any, stay where they are.
    pub(in crate::closure) fn new(
        pilot: &Pilot,
        symmetry: &Symmetry,
        centre: Vec<f64>,
        walls: [Option<f64>; 2],
        widening: f64,
    ) -> Self {
        // About their centre mirror images are as far, and an ellipsoid has no sectors.
        let images = if centre.len() > 2 { 1 } else { symmetry.count() };
        // The largest numbers that `enter` meets over all states and their images.
        let largest = |count: usize, enter: &(dyn Fn(&[f64], &mut [f64]) + Sync)| -> Vec<f64> {
            let part = |states: &[f64]| {
                let (mut image, mut most) = (vec![0.0; centre.len()], vec![0.0; count]);
                for x in states.chunks_exact(centre.len()) {
                    for change in 0..images {
                        symmetry.reflect(change, x, &mut image);
                        enter(&image, &mut most);
                    }
                }
                most
            };
            let greater = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a.max(b)).collect();
            let parts = parallel::map(pilot.states.len().div_ceil(CHUNK), |run| part(pilot.states.run(run, CHUNK)));
            parts.into_iter().fold(vec![0.0; count], greater)
        };
        let scale = largest(centre.len(), &|x, scale| {
            scale.iter_mut().zip(x.iter().zip(&centre)).for_each(|(s, (x, c))| *s = s.max((x - c).abs()));
        });
        let reach = vec![0.0; sectors(centre.len())];
        let mut domain = TrustDomain { centre: centre.clone(), scale, reach, walls };
        let reach = largest(domain.reach.len(), &|x, reach| {
            let sector = domain.sector(x).0;
            reach[sector] = reach[sector].max(domain.distance(x));
        });
        domain.reach = match centre.len() {
            // A sector with few states reaches at least as far as the mean of its neighbours.
            2 => (0..SECTORS)
                .map(|k| reach[k].max((reach[k] + reach[(k + 1) % SECTORS] + reach[(k + SECTORS - 1) % SECTORS]) / 3.0))
                .collect(),
            _ => reach,
        };
        domain.reach.iter_mut().for_each(|r| *r *= widening);
        domain
    }

    /// Everything within so many `scale`s of a centre.
    pub(in crate::closure) fn whole(centre: Vec<f64>, scale: Vec<f64>, reach: f64) -> Self {
        let reach = vec![reach; sectors(centre.len())];
        TrustDomain { centre, scale, reach, walls: [None, None] }
    }

    /// The domain that reaches, in each direction, as far as this one or another with the same scales, or as either does in the sectors
    /// beside it.
    pub(in crate::closure) fn joined(&self, other: &Self) -> Self {
        let farther: Vec<f64> = self.reach.iter().zip(&other.reach).map(|(own, other)| own.max(*other)).collect();
        let reach = match self.dimension() {
            2 => (0..SECTORS)
                .map(|k| farther[k].max(farther[(k + 1) % SECTORS]).max(farther[(k + SECTORS - 1) % SECTORS]))
                .collect(),
            _ => farther,
        };
        TrustDomain { reach, ..self.clone() }
    }

    /// The same with all distances from the centre multiplied by a factor; walls stay where they are.
    pub(in crate::closure) fn widened(&self, factor: f64) -> Self {
        TrustDomain { reach: self.reach.iter().map(|reach| factor * reach).collect(), ..self.clone() }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, count: usize) -> Read<Self> {
        let sectors = sectors(count);
        if self.reach.len() != sectors || !self.reach.iter().all(|reach| reach.is_finite() && *reach >= 0.0) {
            return Err(format!("the trust domain reaches {:?}, and not {sectors} distances", self.reach));
        }
        if self.walls.iter().flatten().any(|wall| !wall.is_finite()) {
            return Err(format!("the walls of the trust domain stand at {:?}", self.walls));
        }
        states("the centre of the trust domain", &self.centre, count)?;
        positive_states("the scale of the trust domain", &self.scale, count)?;
        Ok(self)
    }

    fn dimension(&self) -> usize {
        self.centre.len()
    }

    /// The limits of state 0.
    pub(crate) fn limits(&self) -> [f64; 2] {
        [self.walls[0].unwrap_or(f64::NEG_INFINITY), self.walls[1].unwrap_or(f64::INFINITY)]
    }

    /// The domain as far as a logarithmic density `log` falls: in each direction from three quarters of the present reach
    /// outwards, until it is `drop` below its highest value anywhere, begins to rise again, or the reach has grown by
    /// `most`.
    pub(in crate::closure) fn following(&self, log: impl Fn(&States) -> Vec<f64>, drop: f64, most: f64) -> Self {
        let logs = log(&self.on_rays(0..=RAY, most));
        let rays = || logs.chunks_exact(RAY + 1);
        let inner = (0.75 / most * RAY as f64) as usize;
        let highest = rays().flat_map(|ray| &ray[..=inner]).copied().fold(f64::NEG_INFINITY, f64::max);
        let mut domain = self.clone();
        for (reach, ray) in domain.reach.iter_mut().zip(rays()) {
            let mut step = inner;
            while step < RAY
                && ray[step] > highest - drop
                && !(ray[step + 1] > ray[step] && ray[step] < highest - RISING)
            {
                step += 1;
            }
            *reach *= most * step as f64 / RAY as f64;
        }
        if self.dimension() == 2 && self.limits().contains(&self.centre[0]) {
            // Behind a wall at the centre there is the mirror image.
            let behind = |sector: &usize| !self.between_walls(self.free_ray(*sector, 1, most)[0]);
            for sector in (0..SECTORS).filter(behind) {
                domain.reach[sector] = domain.reach[(3 * SECTORS / 2 - 1 - sector) % SECTORS];
            }
        }
        domain
    }

    /// The points at some steps of all rays, sector after sector.
    fn on_rays(&self, steps: RangeInclusive<usize>, most: f64) -> States {
        let mut points = States::with_capacity(self.dimension(), self.reach.len() * (RAY + 1));
        for sector in 0..self.reach.len() {
            steps.clone().for_each(|step| points.push(&self.on_ray(sector, step, most)));
        }
        points
    }

    /// The point at `step` of `RAY` on the way from the centre through the middle of a sector to `most` times its reach;
    /// beyond a wall, the point of the wall at the same height.
    fn on_ray(&self, sector: usize, step: usize, most: f64) -> Vec<f64> {
        let mut x = self.free_ray(sector, step, most);
        let [low, high] = self.limits();
        x[0] = x[0].clamp(low, high);
        x
    }

    fn free_ray(&self, sector: usize, step: usize, most: f64) -> Vec<f64> {
        let r = self.reach[sector] * most * step as f64 / RAY as f64;
        let phi = (sector as f64 + 0.5) / SECTORS as f64 * std::f64::consts::TAU;
        let direction = |i: usize| match (self.dimension(), i) {
            (1, _) => [-1.0, 1.0][sector],
            (2, 0) => phi.cos(),
            (2, 1) => phi.sin(),
            _ => 0.0,
        };
        (0..self.dimension()).map(|i| self.centre[i] + self.scale[i] * r * direction(i)).collect()
    }

    /// Whether a state lies inside.
    pub(in crate::closure) fn contains(&self, x: &[f64]) -> bool {
        self.between_walls(x[0]) && self.distance(x) <= self.reach_towards(x)
    }

    /// The box around the domain.
    pub(in crate::closure) fn bounds(&self) -> Vec<[f64; 2]> {
        let widest = self.reach.iter().copied().fold(0.0, f64::max);
        let along = |i: usize| {
            let half = self.scale[i] * self.extent(i).min(widest);
            [self.centre[i] - half, self.centre[i] + half]
        };
        let mut bounds: Vec<[f64; 2]> = (0..self.dimension()).map(along).collect();
        let [low, high] = self.limits();
        bounds[0] = [bounds[0][0].max(low), bounds[0][1].min(high)];
        bounds
    }

    /// The middle and the half widths of that box.
    pub(in crate::closure) fn box_around(&self) -> (Vec<f64>, Vec<f64>) {
        self.bounds().iter().map(|[low, high]| ((low + high) / 2.0, (high - low) / 2.0)).unzip()
    }

    /// The domain cut back, in each direction, to the outermost point where a logarithmic density is not yet `drop` below
    /// its highest value on any ray, the centre itself left out: above a wall the density may be infinite there. Points of
    /// the wall that a ray behind it reaches beyond the domain do not count either.
    ///
    /// In three states and more it stays as it is.
    pub(in crate::closure) fn above(&self, log: impl Fn(&States) -> Vec<f64>, drop: f64) -> Self {
        if self.dimension() > 2 {
            return self.clone();
        }
        let points = self.on_rays(1..=RAY, 1.0);
        let mut logs = log(&points);
        for (log, _) in logs.iter_mut().zip(&points).filter(|(_, x)| !self.contains(x)) {
            *log = f64::NEG_INFINITY;
        }
        let highest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut domain = self.clone();
        for (reach, ray) in domain.reach.iter_mut().zip(logs.chunks_exact(RAY)) {
            let outermost = ray.iter().rposition(|log| *log > highest - drop);
            *reach *= outermost.map_or(0.0, |step| (step + 1) as f64 / RAY as f64);
        }
        domain
    }

    /// The part of the domain about a mean, star-shaped, up to where a logarithmic density first falls `drop` below its highest
    /// value on any ray, from the highest point of each ray outwards; at most `most` standard deviations away.
    pub(in crate::closure) fn to_first_fall(
        &self,
        mean: &[f64],
        deviation: &[f64],
        log: impl Fn(&States) -> Vec<f64>,
        drop: f64,
        most: f64,
    ) -> Self {
        let (centre, scale) = (mean.to_vec(), deviation.to_vec());
        let mut part = TrustDomain { centre, scale, reach: vec![1.0; self.reach.len()], walls: self.walls };
        let points = part.on_rays(0..=RAY, most);
        let mut logs = log(&points);
        for (log, _) in logs.iter_mut().zip(&points).filter(|(_, x)| !self.contains(x)) {
            *log = f64::NEG_INFINITY;
        }
        let least = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max) - drop;
        for (reach, ray) in part.reach.iter_mut().zip(logs.chunks_exact(RAY + 1)) {
            let peak = (0..=RAY).max_by(|a, b| ray[*a].total_cmp(&ray[*b])).unwrap_or(0);
            let beyond = (peak + 1..=RAY).find(|step| ray[*step] < least).unwrap_or(RAY);
            // The place between two steps where a straight line falls below.
            let (inner, outer) = (ray[beyond - 1], ray[beyond]);
            let share = if outer.is_finite() && inner > outer {
                ((inner - least) / (inner - outer)).clamp(0.0, 1.0)
            } else {
                0.0
            };
            *reach = most * ((beyond - 1) as f64 + share) / RAY as f64;
        }
        part
    }

    /// The mass beyond the edge, in one state or two, if a logarithmic density falls on at the rate that it has there.
    pub(in crate::closure) fn mass_beyond(&self, log: impl Fn(&[f64]) -> f64) -> f64 {
        let area: f64 = self.scale.iter().product();
        let angle = std::f64::consts::TAU / SECTORS as f64;
        (0..self.reach.len())
            .filter(|&k| self.reach[k] > 0.0 && self.between_walls(self.free_ray(k, RAY, 1.0)[0]))
            .map(|k| {
                let edge = self.on_ray(k, RAY, 1.0);
                let s = self.fall(&edge, &log);
                let volume = area
                    * if self.dimension() == 1 {
                        self.reach[k] / s
                    } else {
                        self.reach[k].powi(2) * angle * (1.0 + 1.0 / s) / s
                    };
                volume * log(&edge).exp()
            })
            .sum()
    }

    /// The slope at which a logarithmic density falls outwards at a point of the edge, for each reach; at least `STEEP`.
    fn fall(&self, edge: &[f64], log: impl Fn(&[f64]) -> f64) -> f64 {
        let near = 0.99;
        let inner: Vec<f64> = self.centre.iter().zip(edge).map(|(c, edge)| c + near * (edge - c)).collect();
        ((log(&inner) - log(edge)) / (1.0 - near)).max(STEEP)
    }

    fn between_walls(&self, x: f64) -> bool {
        let [low, high] = self.limits();
        (low..=high).contains(&x)
    }

    /// The extent of the domain along one state, in units of its scale.
    fn extent(&self, state: usize) -> f64 {
        if self.dimension() != 2 {
            return self.reach.iter().copied().fold(0.0, f64::max);
        }
        // Between the middles of two sectors the reach is interpolated: the farther of both bounds it.
        let angle = |k: usize| (k as f64 + 0.5) / SECTORS as f64 * std::f64::consts::TAU;
        let along = |phi: f64| if state == 0 { phi.cos().abs() } else { phi.sin().abs() };
        (0..8 * SECTORS)
            .map(|fine| {
                let at = fine as f64 / 8.0;
                let (k, share) = (at as usize, at.fract());
                let reach = self.reach[k] * (1.0 - share) + self.reach[(k + 1) % SECTORS] * share;
                reach * along(angle(0) + at / SECTORS as f64 * std::f64::consts::TAU)
            })
            .fold(0.0, f64::max)
            * 1.001
    }

    /// The distance from the centre, in units of the scales.
    fn distance(&self, x: &[f64]) -> f64 {
        let squares = (0..self.dimension()).map(|i| ((x[i] - self.centre[i]) / self.scale[i]).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// The sector of a state's direction, and how far it lies past the sector's middle, in sectors.
    fn sector(&self, x: &[f64]) -> (usize, f64) {
        match self.dimension() {
            1 => (usize::from(x[0] > self.centre[0]), 0.0),
            2 => {
                let z = [0, 1].map(|i| (x[i] - self.centre[i]) / self.scale[i]);
                let turn = (z[1].atan2(z[0]) / std::f64::consts::TAU).rem_euclid(1.0) * SECTORS as f64;
                let sector = (turn as usize).min(SECTORS - 1);
                (sector, turn - sector as f64 - 0.5)
            }
            _ => (0, 0.0),
        }
    }

    fn reach_towards(&self, x: &[f64]) -> f64 {
        let (sector, past) = self.sector(x);
        if self.dimension() != 2 {
            return self.reach[sector];
        }
        let neighbour = if past > 0.0 { (sector + 1) % SECTORS } else { (sector + SECTORS - 1) % SECTORS };
        self.reach[sector] * (1.0 - past.abs()) + self.reach[neighbour] * past.abs()
    }
}

/// The directions that are distinguished in so many states.
fn sectors(states: usize) -> usize {
    match states {
        1 => 2,
        2 => SECTORS,
        _ => 1,
    }
}

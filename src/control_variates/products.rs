//! Products of Legendre polynomials, and of functions of a plane, at eight points at a time.

use super::impulses::{ImpulseImages, images};
use super::planes::{PlaneLanes, Planes};
use crate::fokker_planck::ImpulseTerm;
use crate::numerics::legendre::recurrence;
use crate::numerics::{EIGHT, PointLane, ZEROS};
use std::collections::HashMap;

/// A product that is to be listed: one of the functions of planes, by its number among all of them, or none, times Legendre
/// polynomials of these degrees in the states.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProductFactors {
    pub(crate) plane: Option<usize>,
    pub(crate) degrees: Vec<u32>,
}

/// Products of Legendre polynomials in each state, scaled to a box, and perhaps of a function of a plane, each built from a
/// shorter one by a single multiplication.
///
/// A product P_a(x₁) P_b(x₂) P_c(x₃) needs P_a P_b anyway: the products form a tree, and its sweeps cost a few operations
/// a function in any number of states. A function that is only there as a part of others has no place in the list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Products {
    centre: Vec<f64>,
    half_width: Vec<f64>,
    /// The root of the tree is 1; their functions follow it.
    planes: Planes,
    /// Every other product follows its shorter one.
    steps: Vec<Step>,
    /// Where function k stands in the tree; the constant is function 0.
    places: Vec<usize>,
    /// Degrees of each state's table.
    degrees: usize,
    /// States in which a function of a plane and its factor change together.
    shared: Vec<usize>,
    /// The part of the images of functions 1, 2, … that impulses make; empty without any.
    impulses: ImpulseImages,
}

#[derive(Clone, Copy, Debug)]
struct Step {
    shorter: usize,
    state: usize,
    degree: usize,
}

/// Room for the sweeps of one thread.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    /// The coefficients b of the first-order part of what [`Products::apply`] applies.
    pub(crate) first: Vec<PointLane>,
    /// The result of [`Products::gradient`].
    pub(crate) gradient: Vec<PointLane>,
    /// The functions of planes.
    planes: Vec<PlaneLanes>,
    /// P_k, P_k′, P_k″ by state and degree.
    table: Vec<[PointLane; 3]>,
    /// b P_k′ + ½ B P_k″.
    moved: Vec<PointLane>,
    /// The sensitivity of a sum to each entry of the table.
    entries: Vec<PointLane>,
    values: Vec<PointLane>,
    rates: Vec<PointLane>,
    /// ∂_c of the products, for each coupled state c.
    slopes: Vec<Vec<PointLane>>,
}

impl Products {
    /// After the constant those with these degrees in the states, on the box `centre` ± `half_width`.
    pub(crate) fn on_box(centre: &[f64], half_width: &[f64], exponents: &[Vec<u32>]) -> Self {
        let plain = |degrees: &Vec<u32>| ProductFactors { plane: None, degrees: degrees.clone() };
        let listed: Vec<ProductFactors> = exponents.iter().map(plain).collect();
        Products::with_planes([centre, half_width], Planes::default(), &listed)
    }

    /// The same for any products of polynomials and one function of a plane.
    pub(crate) fn with_planes([centre, half_width]: [&[f64]; 2], planes: Planes, listed: &[ProductFactors]) -> Self {
        let n = centre.len();
        let first = 1 + planes.len();
        let (mut steps, mut known, mut places) = (Vec::new(), HashMap::new(), vec![0]);
        for ProductFactors { plane, degrees } in listed {
            let mut part = vec![0; n];
            let mut place = plane.map_or(0, |plane| 1 + plane);
            let root = place;
            for state in (0..n).filter(|&i| degrees[i] > 0) {
                part[state] = degrees[state];
                place = *known.entry((root, part.clone())).or_insert_with(|| {
                    steps.push(Step { shorter: place, state, degree: degrees[state] as usize });
                    first + steps.len() - 1
                });
            }
            places.push(place);
        }
        let degrees = steps.iter().map(|s| s.degree).max().unwrap_or(0) + 1;
        let meets = |state: &usize| {
            let met = |factors: &ProductFactors| factors.plane.is_some_and(|plane| planes.changes_with(plane, *state));
            listed.iter().any(|factors| factors.degrees[*state] > 0 && met(factors))
        };
        let shared = (0..n).filter(meets).collect();
        Products {
            centre: centre.to_vec(),
            half_width: half_width.to_vec(),
            planes,
            steps,
            places,
            degrees,
            shared,
            impulses: Vec::new(),
        }
    }

    /// The same with impulses in the images of its functions.
    pub(crate) fn struck(self, impulses: ImpulseImages) -> Self {
        Products { impulses, ..self }
    }

    /// The images of its functions under impulses' terms; nothing without any. None where these images are no combinations of its
    /// functions.
    pub(crate) fn images(&self, terms: &[ImpulseTerm]) -> Option<ImpulseImages> {
        if terms.is_empty() {
            return Some(Vec::new());
        }
        let exponents = |place: &usize| {
            let (mut alpha, mut place) = (vec![0; self.dimension()], *place);
            while let Some(step) = place.checked_sub(self.first()).map(|k| self.steps[k]) {
                alpha[step.state] = step.degree as u32;
                place = step.shorter;
            }
            alpha
        };
        let all: Vec<Vec<u32>> = self.places[1..].iter().map(exponents).collect();
        images(terms, (&self.centre, &self.half_width), &all)
    }

    /// The part of the images of functions 1, 2, … that impulses make; empty without any.
    pub(crate) fn impulses(&self) -> &ImpulseImages {
        &self.impulses
    }

    /// The place of the first product in the tree that follows a shorter one by a polynomial.
    fn first(&self) -> usize {
        1 + self.planes.len()
    }

    /// The number of states.
    pub(crate) fn dimension(&self) -> usize {
        self.centre.len()
    }

    /// The number of functions, the constant included.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    pub(crate) fn scratch(&self) -> Scratch {
        let (n, first) = (self.dimension(), self.first());
        let size = first + self.steps.len();
        let entries = n * self.degrees;
        Scratch {
            first: vec![ZEROS; n],
            gradient: vec![ZEROS; n],
            planes: vec![[ZEROS; 6]; first - 1],
            table: vec![[ZEROS; 3]; entries],
            moved: vec![ZEROS; entries],
            entries: vec![ZEROS; entries],
            values: vec![ZEROS; size],
            rates: vec![ZEROS; size],
            slopes: vec![vec![ZEROS; size]; n],
        }
    }

    /// Places eight points: fills the tables and the values.
    #[inline(always)]
    pub(crate) fn place(&self, x: &[PointLane], scratch: &mut Scratch) {
        self.planes.place(x, &mut scratch.planes);
        self.place_products(x, scratch);
        self.place_slopes(scratch);
    }

    /// Fills the tables of P_k′ and P_k″, where those of P_k are filled.
    #[inline(always)]
    fn place_slopes(&self, scratch: &mut Scratch) {
        for i in 0..self.dimension() {
            let scale = self.half_width[i].recip();
            let rows = &mut scratch.table[i * self.degrees..(i + 1) * self.degrees];
            rows[0] = [[1.0; EIGHT], ZEROS, ZEROS];
            if let Some(row) = rows.get_mut(1) {
                (row[1], row[2]) = ([scale; EIGHT], ZEROS);
            }
            let t = rows.get(1).map_or(ZEROS, |row| row[0]);
            // The recurrence, differentiated; whole lanes, which registers hold.
            for k in 1..self.degrees - 1 {
                let [a, b] = recurrence(k);
                let ([p, d, s], [_, d0, s0]) = (rows[k], rows[k - 1]);
                rows[k + 1][1] = std::array::from_fn(|l| a * (t[l] * d[l] + scale * p[l]) - b * d0[l]);
                rows[k + 1][2] = std::array::from_fn(|l| a * (t[l] * s[l] + 2.0 * scale * d[l]) - b * s0[l]);
            }
        }
    }

    /// Places eight points where only values are needed.
    #[inline(always)]
    pub(crate) fn place_values(&self, x: &[PointLane], scratch: &mut Scratch) {
        self.planes.place_values(x, &mut scratch.planes);
        self.place_products(x, scratch);
    }

    /// Fills the values, where those of the functions of planes are filled.
    #[inline(always)]
    fn place_products(&self, x: &[PointLane], scratch: &mut Scratch) {
        self.place_tables(x, scratch);
        scratch.values[0] = [1.0; EIGHT];
        for (value, jet) in scratch.values[1..].iter_mut().zip(&scratch.planes) {
            *value = jet[0];
        }
        for (k, step) in (self.first()..).zip(&self.steps) {
            // Copies of lanes are apart from what is written, so that a lane is a few instructions; here and below.
            let factor = scratch.table[step.state * self.degrees + step.degree][0];
            let shorter = scratch.values[step.shorter];
            scratch.values[k] = std::array::from_fn(|l| shorter[l] * factor[l]);
        }
    }

    /// Fills the tables of P_k.
    #[inline(always)]
    fn place_tables(&self, x: &[PointLane], scratch: &mut Scratch) {
        for i in 0..self.dimension() {
            let scale = self.half_width[i].recip();
            let rows = &mut scratch.table[i * self.degrees..(i + 1) * self.degrees];
            rows[0][0] = [1.0; EIGHT];
            if let Some(row) = rows.get_mut(1) {
                for l in 0..EIGHT {
                    row[0][l] = (x[i][l] - self.centre[i]) * scale;
                }
            }
            let t = rows.get(1).map_or(ZEROS, |row| row[0]);
            for k in 1..self.degrees - 1 {
                let [a, b] = recurrence(k);
                let (p, p0) = (rows[k][0], rows[k - 1][0]);
                rows[k + 1][0] = std::array::from_fn(|l| a * t[l] * p[l] - b * p0[l]);
            }
        }
    }

    /// The value of function k at the points placed.
    #[inline(always)]
    pub(crate) fn value(&self, scratch: &Scratch, k: usize) -> PointLane {
        scratch.values[self.places[k]]
    }

    /// The image of function k under the operator of the last [`Products::apply`], and under impulses.
    #[inline(always)]
    pub(crate) fn image(&self, scratch: &Scratch, k: usize) -> PointLane {
        self.image_under(&self.impulses, scratch, k)
    }

    /// The same under other impulses.
    #[inline(always)]
    pub(crate) fn image_under(&self, impulses: &ImpulseImages, scratch: &Scratch, k: usize) -> PointLane {
        let mut image = scratch.rates[self.places[k]];
        for (place, c) in k.checked_sub(1).and_then(|k| impulses.get(k)).into_iter().flatten() {
            let value = self.value(scratch, *place);
            (0..EIGHT).for_each(|l| image[l] += c * value[l]);
        }
        image
    }

    /// Applies b·∇ + ½ B:∇∇ to all functions at the points placed: b is `first` of `scratch`, and B, by rows, is `second`.
    /// `coupled` lists the states i with some B_ij ≠ 0, j ≠ i.
    #[inline(always)]
    pub(crate) fn apply(&self, second: &[PointLane], coupled: &[usize], scratch: &mut Scratch) {
        self.apply_to_factors(second, scratch);
        let missing = |c: &&usize| !coupled.contains(c);
        if self.shared.iter().any(|c| missing(&c)) {
            let all: Vec<usize> = coupled.iter().chain(self.shared.iter().filter(missing)).copied().collect();
            self.apply_to_products(second, &all, scratch);
        } else {
            self.apply_to_products(second, coupled, scratch);
        }
    }

    /// Fills the tables of b P_k′ + ½ B P_k″.
    #[inline(always)]
    fn apply_to_factors(&self, second: &[PointLane], scratch: &mut Scratch) {
        let n = self.dimension();
        for i in 0..n {
            for k in 0..self.degrees {
                let at = i * self.degrees + k;
                let [_, d, s] = scratch.table[at];
                let (b, c) = (scratch.first[i], second[i * n + i]);
                scratch.moved[at] = std::array::from_fn(|l| b[l] * d[l] + 0.5 * c[l] * s[l]);
            }
        }
    }

    /// Fills the images of the products, with slopes in the states `coupled`.
    #[inline(always)]
    fn apply_to_products(&self, second: &[PointLane], coupled: &[usize], scratch: &mut Scratch) {
        let n = self.dimension();
        scratch.rates[0] = ZEROS;
        for &c in coupled {
            scratch.slopes[c][0] = ZEROS;
        }
        let Scratch { first, planes, rates, slopes, .. } = scratch;
        self.planes.apply((first, second), planes, &mut rates[1..]);
        self.planes.slopes(coupled, planes, slopes);
        for (k, step) in (self.first()..).zip(&self.steps) {
            let at = step.state * self.degrees + step.degree;
            let ([p, d, _], moved) = (scratch.table[at], scratch.moved[at]);
            let (value, rate) = (scratch.values[step.shorter], scratch.rates[step.shorter]);
            let mut sum = ZEROS;
            for l in 0..EIGHT {
                sum[l] = rate[l] * p[l] + value[l] * moved[l];
            }
            for &c in coupled {
                let slope = scratch.slopes[c][step.shorter];
                let mixed = second[c * n + step.state];
                for l in 0..EIGHT {
                    // Of the shorter product only a function of a plane may contain this state, so that each pair is met once.
                    sum[l] += mixed[l] * slope[l] * d[l];
                }
                let own = if c == step.state { 1.0 } else { 0.0 };
                scratch.slopes[c][k] = std::array::from_fn(|l| slope[l] * p[l] + own * value[l] * d[l]);
            }
            scratch.rates[k] = sum;
        }
    }

    /// Σ a_k φ_k at the points placed, a₀ the constant's.
    pub(crate) fn sum(&self, a: &[f64], scratch: &Scratch) -> PointLane {
        let mut sum = ZEROS;
        for (a, &place) in a.iter().zip(&self.places) {
            let value = scratch.values[place];
            (0..EIGHT).for_each(|l| sum[l] += a * value[l]);
        }
        sum
    }

    /// Leaves ∇ Σ a_k φ_k at the points placed in `gradient` of `scratch`, by one sweep back through the tree. Overwrites
    /// what [`Products::apply`] left.
    pub(crate) fn gradient(&self, a: &[f64], scratch: &mut Scratch) {
        let sensitivity = &mut scratch.rates;
        sensitivity.fill(ZEROS);
        scratch.entries.fill(ZEROS);
        for (&a, &place) in a.iter().zip(&self.places) {
            sensitivity[place] = [a; EIGHT];
        }
        let first = self.first();
        for (k, step) in self.steps.iter().enumerate().rev() {
            let k = first + k;
            let at = step.state * self.degrees + step.degree;
            let (own, factor, value) = (sensitivity[k], scratch.table[at][0], scratch.values[step.shorter]);
            let (shorter, entry) = (sensitivity[step.shorter], scratch.entries[at]);
            sensitivity[step.shorter] = std::array::from_fn(|l| shorter[l] + own[l] * factor[l]);
            scratch.entries[at] = std::array::from_fn(|l| entry[l] + own[l] * value[l]);
        }
        for (i, sum) in scratch.gradient.iter_mut().enumerate() {
            *sum = ZEROS;
            for at in i * self.degrees..(i + 1) * self.degrees {
                (0..EIGHT).for_each(|l| sum[l] += scratch.entries[at][l] * scratch.table[at][1][l]);
            }
        }
        self.planes.add_gradient(&sensitivity[1..], &scratch.planes, &mut scratch.gradient);
    }
}

//! The functions of a list at a point, or at several at a time, as a tree of products.

use super::impulses::ImpulseImages;
use super::kink::Radius;
use super::list::Block;
use super::{Corner, Fold, Functions, Kink, PlaneJet, PlaneOperator};
use crate::numerics::Number;
use crate::numerics::legendre::recurrence;
use std::collections::HashMap;

/// How the functions of a list are built, each from a shorter one by a single multiplication.
///
/// A product P_a(x₁) P_b(x₂) P_c(x₃) needs P_a P_b anyway: the products form a tree, and its sweeps cost a few operations
/// a function in any number of states. A function that is only there as a part of others has no place in the list.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tree {
    /// The root of the tree is 1; the kinks at each wall follow it.
    kinks: Vec<Vec<Kink>>,
    /// Every other product follows its shorter one.
    steps: Vec<Step>,
    /// The place of the first of them.
    first: usize,
    /// Where φ₁ … φ_K stand in the tree, after the constant.
    places: Vec<usize>,
    /// Entries of each state's table: Legendre polynomials, and after these `folded` products of them with each fold.
    degrees: usize,
    folded: usize,
    /// States in which a kink and its factor change together.
    shared: Vec<usize>,
    /// The highest powers of u, w, A and 1/A in kinks.
    highest: [usize; 4],
}

/// A product: a shorter one times a polynomial of one state, by its place in the state's table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    shorter: usize,
    state: usize,
    degree: usize,
}

/// The places of Legendre polynomials and of their products with folds in a table.
fn tabled(blocks: &[Block]) -> (usize, usize, impl Fn(u32) -> usize) {
    let all = || blocks.iter().flat_map(|block| block.factors.exponents()).flatten().map(|&e| Fold::decoded(e));
    let plain = all().map(|(_, degree)| degree as usize + 1).max().unwrap_or(1);
    let folded = all().filter(|(fold, _)| fold.is_some()).map(|(_, degree)| degree as usize + 1).max().unwrap_or(0);
    let place = move |exponent: u32| match Fold::decoded(exponent) {
        (None, degree) => degree as usize,
        (Some(fold), degree) => plain + fold * folded + degree as usize,
    };
    (plain, folded, place)
}

impl Tree {
    pub(super) fn new(corners: &[Corner], blocks: &[Block]) -> Self {
        let mut kinks: Vec<Vec<Kink>> = vec![Vec::new(); corners.len()];
        for (wall, kink) in blocks.iter().flat_map(Block::each).flatten() {
            if !kinks[wall].contains(&kink) {
                kinks[wall].push(kink);
            }
        }
        let before = |wall: usize| 1 + kinks[..wall].iter().map(Vec::len).sum::<usize>();
        let root = |(wall, kink): (usize, Kink)| {
            before(wall) + kinks[wall].iter().position(|known| *known == kink).unwrap_or(0)
        };
        let first = before(corners.len());
        let (plain, folded, place_of) = tabled(blocks);
        let folds = blocks.first().map_or(0, |block| block.factors.folds().len());
        let (mut steps, mut known, mut places, mut shared) = (Vec::new(), HashMap::new(), vec![0], Vec::new());
        for block in blocks {
            for kink in block.each() {
                let root = kink.map_or(0, root);
                let moves = |state: usize| {
                    let forms = kink.map(|(wall, _)| corners[wall].forms());
                    forms.iter().flatten().any(|form| form.parts().any(|(own, _)| own == state))
                };
                for degrees in block.factors.exponents() {
                    let (mut part, mut place) = (vec![0; degrees.len()], root);
                    for state in (0..degrees.len()).filter(|&i| degrees[i] > 0) {
                        part[state] = degrees[state];
                        place = *known.entry((root, part.clone())).or_insert_with(|| {
                            steps.push(Step { shorter: place, state, degree: place_of(degrees[state]) });
                            first + steps.len() - 1
                        });
                        if moves(state) && !shared.contains(&state) {
                            shared.push(state);
                        }
                    }
                    places.push(place);
                }
            }
        }
        let degrees = plain + folds * folded;
        let powers = |k: usize| kinks.iter().flatten().map(|kink| kink.powers()[k]).max().unwrap_or(0);
        let highest = std::array::from_fn(powers);
        Tree { kinks, steps, first, places, degrees, folded, shared, highest }
    }
}

/// Room for the functions of any list at a point, or at several.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<T> {
    /// The result of [`Functions::gradient`].
    pub(crate) gradient: Vec<T>,
    kinks: Vec<PlaneJet<T>>,
    /// P_k, P_k′, P_k″ by state and degree.
    table: Vec<[T; 3]>,
    /// b P_k′ + ½ B P_k″.
    moved: Vec<T>,
    /// The sensitivity of a sum to each entry of the table.
    entries: Vec<T>,
    values: Vec<T>,
    /// Images, or the sensitivity of a sum to each product.
    rates: Vec<T>,
    /// ∂_c of the products, for each coupled state c.
    slopes: Vec<Vec<T>>,
}

impl<T> Default for Scratch<T> {
    fn default() -> Self {
        let [gradient, moved, entries, values, rates] = [(); 5].map(|()| Vec::new());
        Scratch { gradient, kinks: Vec::new(), table: Vec::new(), moved, entries, values, rates, slopes: Vec::new() }
    }
}

impl Functions {
    /// Places a point, or several: fills the values and what [`Functions::apply`] and [`Functions::gradient`] need.
    #[inline(always)]
    pub(crate) fn place<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) {
        scratch.values.resize(self.tree.first + self.tree.steps.len(), T::everywhere(0.0));
        let Scratch { kinks, values, .. } = scratch;
        kinks.clear();
        self.each_kink(x, |at, radius, kink| {
            let jet = radius.jet(kink);
            values[at] = jet.value;
            kinks.push(jet);
        });
        self.place_products(x, scratch);
        self.place_slopes(x, scratch);
    }

    /// The same where only values are needed.
    #[inline(always)]
    pub(crate) fn place_values<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) {
        scratch.values.resize(self.tree.first + self.tree.steps.len(), T::everywhere(0.0));
        self.each_kink(x, |at, radius, kink| scratch.values[at] = radius.value(kink));
        self.place_products(x, scratch);
    }

    /// Visits the kinks, each by its place in the tree with what it is made of.
    #[inline(always)]
    fn each_kink<T: Number>(&self, x: &[T], mut visit: impl FnMut(usize, &Radius<T>, &Kink)) {
        let mut at = 1;
        for (corner, kinks) in self.corners.iter().zip(&self.tree.kinks).filter(|(_, kinks)| !kinks.is_empty()) {
            let radius = Radius::new(corner, x, self.tree.highest);
            for kink in kinks {
                visit(at, &radius, kink);
                at += 1;
            }
        }
    }

    /// Fills the tables of P_k, and the values where those of the kinks are filled.
    #[inline(always)]
    fn place_products<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) {
        let (tree, [zero, one]) = (&self.tree, [0.0, 1.0].map(T::everywhere));
        let plain = self.plain();
        let Scratch { table, values, .. } = scratch;
        table.resize(self.dimension() * tree.degrees, [zero; 3]);
        let [centre, half_width] = self.box_around();
        for (i, rows) in table.chunks_exact_mut(tree.degrees).enumerate() {
            rows[0][0] = one;
            let t = (x[i] - centre[i]) / T::everywhere(half_width[i]);
            if let Some(row) = rows.get_mut(1).filter(|_| plain > 1) {
                row[0] = t;
            }
            for k in 1..plain - 1 {
                let [a, b] = recurrence(k);
                rows[k + 1][0] = t * a * rows[k][0] - rows[k - 1][0] * b;
            }
            for (fold, first) in self.folds_of(i) {
                let [value, ..] = fold.jet(x[i], half_width[i]);
                (0..tree.folded).for_each(|k| rows[first + k][0] = value * rows[k][0]);
            }
        }
        values[0] = one;
        for (k, step) in (tree.first..).zip(&tree.steps) {
            values[k] = values[step.shorter] * table[step.state * tree.degrees + step.degree][0];
        }
    }

    /// The Legendre polynomials in each state's table.
    fn plain(&self) -> usize {
        self.tree.degrees - self.folds().len() * self.tree.folded
    }

    /// The folds of a state, with the place of the first of their products.
    fn folds_of(&self, state: usize) -> impl Iterator<Item = (&Fold, usize)> {
        let places = (self.plain()..).step_by(self.tree.folded.max(1));
        self.folds().iter().zip(places).filter(move |(fold, _)| fold.state == state)
    }

    /// Fills the tables of P_k′ and P_k″ by the recurrence, differentiated, where those of P_k are filled.
    #[inline(always)]
    fn place_slopes<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) {
        let (degrees, plain, [zero, one]) = (self.tree.degrees, self.plain(), [0.0, 1.0].map(T::everywhere));
        let [_, half_width] = self.box_around();
        for (i, rows) in scratch.table.chunks_exact_mut(degrees).enumerate() {
            let scale = half_width[i].recip();
            rows[0] = [one, zero, zero];
            if let Some(row) = rows.get_mut(1).filter(|_| plain > 1) {
                (row[1], row[2]) = (T::everywhere(scale), zero);
            }
            let t = rows.get(1).filter(|_| plain > 1).map_or(zero, |row| row[0]);
            for k in 1..plain - 1 {
                let [a, b] = recurrence(k);
                let ([p, d, s], [_, d0, s0]) = (rows[k], rows[k - 1]);
                rows[k + 1][1] = (t * d + p * scale) * a - d0 * b;
                rows[k + 1][2] = (t * s + d * (2.0 * scale)) * a - s0 * b;
            }
            for (fold, first) in self.folds_of(i) {
                let [value, slope, bend] = fold.jet(x[i], half_width[i]);
                for k in 0..self.tree.folded {
                    let [p, d, s] = rows[k];
                    rows[first + k] = [value * p, slope * p + value * d, bend * p + slope * d * 2.0 + value * s];
                }
            }
        }
    }

    /// φ_k at the points placed; the constant is φ₀.
    #[inline(always)]
    pub(crate) fn value<T: Number>(&self, scratch: &Scratch<T>, k: usize) -> T {
        scratch.values[self.tree.places[k]]
    }

    /// The image of φ_k under the operator of the last [`Functions::apply`], and under impulses.
    #[inline(always)]
    pub(crate) fn image<T: Number>(&self, scratch: &Scratch<T>, k: usize) -> T {
        self.image_under(&self.impulses, scratch, k)
    }

    /// The same under other impulses.
    #[inline(always)]
    pub(crate) fn image_under<T: Number>(&self, impulses: &ImpulseImages, scratch: &Scratch<T>, k: usize) -> T {
        let image = scratch.rates[self.tree.places[k]];
        let of_impulses = k.checked_sub(1).and_then(|k| impulses.get(k));
        of_impulses.map_or(image, |terms| self.added(image, terms, scratch))
    }

    /// A sum with terms after it. Not inlined, so that what needs none of it is a few instructions.
    #[inline(never)]
    fn added<T: Number>(&self, mut sum: T, terms: &[(usize, f64)], scratch: &Scratch<T>) -> T {
        terms.iter().for_each(|(place, c)| sum += self.value(scratch, *place) * *c);
        sum
    }

    /// Σ a_k φ_k, without the constant, over as many functions as there are a_k.
    #[inline(always)]
    pub(crate) fn sum<T: Number>(&self, a: &[f64], scratch: &Scratch<T>) -> T {
        self.combined(a, &scratch.values)
    }

    /// The same of the images under the operator of the last [`Functions::apply`], without impulses.
    #[inline(always)]
    pub(crate) fn sum_of_images<T: Number>(&self, a: &[f64], scratch: &Scratch<T>) -> T {
        self.combined(a, &scratch.rates)
    }

    #[inline(always)]
    fn combined<T: Number>(&self, a: &[f64], products: &[T]) -> T {
        let mut sum = T::everywhere(0.0);
        for (a, &place) in a.iter().zip(&self.tree.places[1..]) {
            sum += products[place] * *a;
        }
        sum
    }

    /// Applies b·∇ + ½ B:∇∇ to all functions at the points placed, B by rows. `coupled` lists the states i with some B_ij ≠ 0,
    /// j ≠ i.
    #[inline(always)]
    pub(crate) fn apply<T: Number>(&self, operator: (&[T], &[T]), coupled: &[usize], scratch: &mut Scratch<T>) {
        let missing = |c: &&usize| !coupled.contains(c);
        if self.tree.shared.iter().any(|c| missing(&c)) {
            let all: Vec<usize> = coupled.iter().chain(self.tree.shared.iter().filter(missing)).copied().collect();
            self.apply_to_products(operator, &all, scratch);
        } else {
            self.apply_to_products(operator, coupled, scratch);
        }
    }

    /// Fills the tables of b P_k′ + ½ B P_k″ and the images, with slopes in the states `coupled`.
    #[inline(always)]
    fn apply_to_products<T: Number>(&self, (first, second): (&[T], &[T]), coupled: &[usize], scratch: &mut Scratch<T>) {
        let (n, tree, zero) = (first.len(), &self.tree, T::everywhere(0.0));
        let Scratch { kinks, table, moved, values, rates, slopes, .. } = scratch;
        moved.resize(table.len(), zero);
        let rows = moved.chunks_exact_mut(tree.degrees).zip(table.chunks_exact(tree.degrees));
        for (i, (moved, row)) in rows.enumerate() {
            let (f, b) = (first[i], second[i * n + i] * 0.5);
            moved.iter_mut().zip(row).for_each(|(moved, [_, d, s])| *moved = f * *d + b * *s);
        }
        rates.resize(values.len(), zero);
        rates[0] = zero;
        slopes.resize(n, Vec::new());
        for &c in coupled {
            slopes[c].resize(values.len(), zero);
            slopes[c][..tree.first].fill(zero);
        }
        let mut at = 1;
        for (corner, own) in self.corners.iter().zip(&tree.kinks) {
            let forms = corner.forms();
            let on_plane = PlaneOperator::new(&forms, first, second);
            for _ in own {
                let jet = kinks[at - 1];
                rates[at] = on_plane.image(&jet);
                for (form, slope) in forms.iter().zip(jet.gradient) {
                    for (c, sign) in form.parts().filter(|(c, _)| coupled.contains(c)) {
                        slopes[c][at] += slope * sign;
                    }
                }
                at += 1;
            }
        }
        for (k, step) in (tree.first..).zip(&tree.steps) {
            // Copies are apart from what is written, so that they stay in registers.
            let at = step.state * tree.degrees + step.degree;
            let ([p, d, _], moved) = (table[at], moved[at]);
            let (value, rate) = (values[step.shorter], rates[step.shorter]);
            let mut sum = rate * p + value * moved;
            for &c in coupled {
                let slope = slopes[c][step.shorter];
                // Of the shorter product only a kink may contain this state, so that each pair is met once.
                sum += second[c * n + step.state] * slope * d;
                slopes[c][k] = if c == step.state { slope * p + value * d } else { slope * p };
            }
            rates[k] = sum;
        }
    }

    /// Leaves ∇ Σ a_k φ_k at the points placed in `gradient` of `scratch`, by one sweep back through the tree. Overwrites
    /// what [`Functions::apply`] left.
    #[inline(always)]
    pub(crate) fn gradient<T: Number>(&self, a: &[f64], scratch: &mut Scratch<T>) {
        let (tree, zero) = (&self.tree, T::everywhere(0.0));
        let Scratch { gradient, kinks, table, entries, values, rates: sensitivity, .. } = scratch;
        sensitivity.clear();
        sensitivity.resize(values.len(), zero);
        entries.clear();
        entries.resize(table.len(), zero);
        for (a, &place) in a.iter().zip(&tree.places[1..]) {
            sensitivity[place] = T::everywhere(*a);
        }
        for (k, step) in tree.steps.iter().enumerate().rev() {
            let at = step.state * tree.degrees + step.degree;
            let (own, factor, value) = (sensitivity[tree.first + k], table[at][0], values[step.shorter]);
            sensitivity[step.shorter] += own * factor;
            entries[at] += own * value;
        }
        gradient.clear();
        let rows = entries.chunks_exact(tree.degrees).zip(table.chunks_exact(tree.degrees));
        gradient.extend(rows.map(|(entries, row)| {
            let mut sum = zero;
            entries.iter().zip(row).for_each(|(entry, [_, slope, _])| sum += *entry * *slope);
            sum
        }));
        let mut own = kinks.iter().zip(&sensitivity[1..]);
        for (corner, kinks) in self.corners.iter().zip(&tree.kinks) {
            let forms = corner.forms();
            own.by_ref().take(kinks.len()).for_each(|(jet, factor)| jet.add_gradient(&forms, *factor, gradient));
        }
    }
}

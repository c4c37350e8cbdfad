use crate::closure::samples::{OperatorParts, PilotWalk, WalkBuffers};
use crate::closure::space::sweep::enter;
use crate::functions::{Functions, ImpulseImages};
use crate::numerics::{EIGHT, Eight};
use crate::polynomial::Polynomial;
use crate::problem::StillMotion;
use crate::simulation::Impact;
use crate::walls::Contact;
use faer::{Mat, MatMut};

/// The derivative of an operator by a parameter, f′ and B′, and the images of functions under that of impulses; and of impacts, r′ and the
/// slope η′ of the shift at each wall.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    drift: Vec<(usize, Polynomial)>,
    diffusion: Vec<(usize, Polynomial)>,
    coupled: Vec<usize>,
    impulses: ImpulseImages,
    walls: Vec<[f64; 2]>,
}

impl Moved {
    /// None where the images under impulses are no combinations of the functions.
    pub(super) fn new(motion: &StillMotion, contacts: &[Contact], space: &Functions) -> Option<Self> {
        let operator = &motion.operator;
        let given = |entries: Vec<&Polynomial>| {
            entries.into_iter().cloned().enumerate().filter(|(_, entry)| !entry.is_zero()).collect()
        };
        let diffusion = operator.diffusion().iter().flatten().collect();
        Some(Moved {
            drift: given(operator.drift().iter().collect()),
            diffusion: given(diffusion),
            coupled: operator.coupled(),
            impulses: space.images(&operator.impulse_terms())?,
            walls: contacts
                .iter()
                .zip(&motion.restitution)
                .map(|(contact, rate)| [*rate, motion.shift[contact.wall.state()][1]])
                .collect(),
        })
    }

    /// The images under the derivative of the generator in all rows of a trajectory.
    pub(super) fn images(&self, walk: &PilotWalk<'_>, t: usize, place: &mut WalkBuffers) -> Mat<f64> {
        let n = walk.problem.dimension();
        let [mut drift, mut diffusion] = [n, n * n].map(|size| vec![Eight::ZERO; size]);
        let states = |place: &mut WalkBuffers, table: MatMut<'_, f64>| {
            self.enter_moved(walk, [&mut drift, &mut diffusion], place, table);
        };
        let still = self.walls.iter().all(|rates| *rates == [0.0; 2]);
        walk.tabulated(t, place, states, |place, impacts, table| {
            if !still {
                self.enter_struck(walk, impacts, place, table);
            }
        })
    }

    /// How jumps move: ψ₊ as the velocities there do, by r′ ∂x₊/∂r; and by −η′ their rate, as the time of a stretched coordinate.
    fn enter_struck(
        &self,
        walk: &PilotWalk<'_>,
        impacts: &[Impact],
        place: &mut WalkBuffers,
        mut table: MatMut<'_, f64>,
    ) {
        let n = walk.problem.dimension();
        let (mut drift, diffusion) = (vec![Eight::ZERO; n], vec![Eight::ZERO; n * n]);
        let mut stretching = Eight::ZERO;
        for (l, impact) in impacts.iter().enumerate() {
            let [restitution, slope] = self.walls[impact.wall];
            let before: Vec<f64> = place.ends[0].iter().map(|lane| lane[l]).collect();
            // The velocities after an impact are linear in r.
            let [elastic, lost] = [1.0, 0.0].map(|r| {
                let mut x = before.clone();
                walk.contacts[impact.wall].collide(r, &mut x);
                x
            });
            drift.iter_mut().zip(elastic.iter().zip(&lost)).for_each(|(lane, (x, y))| lane[l] = restitution * (x - y));
            stretching[l] = slope;
        }
        walk.space.place(&place.ends[1], &mut place.scratch);
        walk.space.apply((&drift, &diffusion), &[], &mut place.scratch);
        enter(&mut table, place.rows.clone(), |k| {
            let (scratch, k) = (&place.scratch, 1 + k);
            let (image, value) = (walk.space.image(scratch, k), walk.space.value(scratch, k));
            image - stretching * value
        });
        walk.space.place_values(&place.ends[0], &mut place.scratch);
        for k in 0..walk.functions() {
            let value = walk.space.value(&place.scratch, k + 1);
            place.rows.clone().enumerate().for_each(|(l, row)| table[(row, k)] += stretching[l] * value[l]);
        }
    }

    /// The images under the derivative of the generator.
    fn enter_moved(
        &self,
        walk: &PilotWalk<'_>,
        [drift, diffusion]: [&mut Vec<Eight>; 2],
        place: &mut WalkBuffers,
        table: MatMut<'_, f64>,
    ) {
        let WalkBuffers { x, scratch, rows, arch, .. } = place;
        drift.iter_mut().chain(diffusion.iter_mut()).for_each(|lane| *lane = Eight::ZERO);
        let mut state = vec![0.0; x.len()];
        for l in 0..EIGHT {
            state.iter_mut().zip(x.iter()).for_each(|(x, lane)| *x = lane[l]);
            self.drift.iter().for_each(|(i, f)| drift[*i][l] = f.evaluate(&state));
            self.diffusion.iter().for_each(|(ij, b)| diffusion[*ij][l] = b.evaluate(&state));
        }
        let operator: OperatorParts<'_> = ((&drift[..], &diffusion[..]), &self.coupled[..], &self.impulses);
        walk.enter_rows(*arch, x, Some(operator), (scratch, rows), table);
    }
}

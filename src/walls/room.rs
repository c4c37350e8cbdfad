//! The room that walls leave.

use super::{Contact, Wall};

/// Passes over all walls, after which a state is taken as it is.
const PASSES: usize = 1000;

/// Whether walls leave an open set of displacements.
///
/// Every wall bounds the difference of two displacements, a single one that to a displacement that is always 0. There is
/// room where the bounds add up to more than 0 round every closed way (R. Bellman, 1958, doi:10.1090/qam/102435); the shortest
/// ways are found by R. W. Floyd's algorithm (1962, doi:10.1145/367766.368168).
pub(crate) fn is_room(walls: &[Wall]) -> bool {
    let mut bodies: Vec<Option<usize>> = walls.iter().flat_map(|wall| [Some(wall.state()), wall.other()]).collect();
    bodies.sort_unstable();
    bodies.dedup();
    let place = |body: Option<usize>| bodies.iter().position(|other| *other == body).unwrap_or(0);
    let n = bodies.len();
    // Entry (p, q) bounds y_p − y_q from above.
    let mut bounds = vec![f64::INFINITY; n * n];
    for wall in walls {
        let (first, second) = (place(Some(wall.state())), place(wall.other()));
        let (entry, bound) =
            if wall.is_above() { (second * n + first, -wall.offset()) } else { (first * n + second, wall.offset()) };
        bounds[entry] = bounds[entry].min(bound);
    }
    for k in 0..n {
        for p in 0..n {
            for q in 0..n {
                bounds[p * n + q] = bounds[p * n + q].min(bounds[p * n + k] + bounds[k * n + q]);
            }
        }
    }
    (0..n).all(|p| bounds[p * n + p] > 0.0)
}

/// Moves the displacements of a state from behind walls, back by as much as they are beyond.
pub(crate) fn reflect(contacts: &[Contact], x: &mut [f64]) {
    inside(contacts, x, Contact::mirror);
}

/// Moves a state by `put` while it is behind walls.
pub(crate) fn inside(contacts: &[Contact], x: &mut [f64], put: impl Fn(&Contact, &mut [f64])) {
    for _ in 0..PASSES {
        let mut moved = false;
        for contact in contacts {
            if contact.is_behind(x) {
                put(contact, x);
                moved = true;
            }
        }
        if !moved {
            return;
        }
    }
}

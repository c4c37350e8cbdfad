//! Items in the order of their numbers.

/// Sorts items by a number that each of them has, equal ones as they stand. Places are sorted, not the items themselves, so that one
/// sort is compiled for all types.
pub(crate) fn sort_by_number<T>(items: &mut Vec<T>, number: impl Fn(&T) -> f64) {
    let mut places: Vec<(f64, usize)> = items.iter().map(number).zip(0..).collect();
    places.sort_unstable_by(by_number);
    let mut all: Vec<Option<T>> = items.drain(..).map(Some).collect();
    items.extend(places.into_iter().filter_map(|(_, place)| all[place].take()));
}

fn by_number(a: &(f64, usize), b: &(f64, usize)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_items_stay_in_their_order() {
        let mut items: Vec<(i32, usize)> = [3, -1, 3, 2, -1, 7].into_iter().zip(0..).collect();
        sort_by_number(&mut items, |(number, _)| f64::from(*number));
        assert_eq!(items, [(-1, 1), (-1, 4), (2, 3), (3, 0), (3, 2), (7, 5)]);
    }
}

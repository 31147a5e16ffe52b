//! Sorting of short lists, in little flash.

use core::cmp::Ordering;

/// Sorts a list of a few dozen items by insertion; equals keep their order. The library's sorts are faster on
/// long lists, but every kind of list costs up to 7 KB of flash there, and a tenth of that here.
pub fn sort_short<T>(items: &mut [T], mut compare: impl FnMut(&T, &T) -> Ordering) {
    for end in 1..items.len() {
        for place in (0..end).rev() {
            match items.get_mut(place..) {
                Some([one, next, ..]) if compare(one, next) == Ordering::Greater => core::mem::swap(one, next),
                _ => break,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The order is that of the library's stable sort, so equals stay in their order as well.
        #[test]
        fn agrees_with_the_library_s_stable_sort(mut items: Vec<(u8, u16)>) {
            let mut expected = items.clone();
            expected.sort_by_key(|(key, _)| *key % 8);
            sort_short(&mut items, |one, other| (one.0 % 8).cmp(&(other.0 % 8)));
            prop_assert_eq!(items, expected);
        }
    }
}

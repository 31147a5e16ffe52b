//! Fixed-size texts that are cut rather than lost, and the nearest known name to a misspelt one.

use core::fmt::{self, Write};
use heapless::String;

/// Formats into a fixed text; what does not fit is cut off.
pub(crate) fn cut<const N: usize>(arguments: fmt::Arguments<'_>) -> String<N> {
    struct Cut<'a, const N: usize>(&'a mut String<N>);
    impl<const N: usize> Write for Cut<'_, N> {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            text.chars().try_for_each(|character| self.0.push(character)).map_err(|_| fmt::Error)
        }
    }
    let mut text = String::new();
    // The only error is a full text.
    let _ = Cut(&mut text).write_fmt(arguments);
    text
}

/// Longest name that is compared; longer ones are no near miss of anything.
const LONGEST: usize = 40;

/// Returns the candidate most like `text`, when it is near enough to be meant.
pub(crate) fn nearest<'c>(text: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    candidates
        .filter_map(|candidate| Some((distance(text, candidate)?, candidate)))
        .filter(|&(distance, candidate)| distance <= (candidate.len() / 3).clamp(1, 3))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Returns the number of letters to add, leave out, change or swap with their neighbour; case does not count.
fn distance(a: &str, b: &str) -> Option<usize> {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() > LONGEST || b.len() > LONGEST {
        return None;
    }
    let mut before_last = [0_usize; LONGEST + 1];
    let mut last: [usize; LONGEST + 1] = core::array::from_fn(|i| i);
    let mut previous_a = 0;
    for (i, &a) in a.iter().enumerate() {
        let mut row = [i + 1; LONGEST + 1];
        let mut previous_b = 0;
        let mut left = i + 1;
        for (j, &b) in b.iter().enumerate() {
            let at = |row: &[usize; LONGEST + 1], j: usize| row.get(j).copied().unwrap_or(usize::MAX - LONGEST);
            let differs = usize::from(!a.eq_ignore_ascii_case(&b));
            let mut best = (at(&last, j) + differs).min(at(&last, j + 1) + 1).min(left + 1);
            let is_swap = a.eq_ignore_ascii_case(&previous_b) && b.eq_ignore_ascii_case(&previous_a);
            if is_swap && let Some(before) = j.checked_sub(1) {
                best = best.min(at(&before_last, before) + 1);
            }
            if let Some(place) = row.get_mut(j + 1) {
                *place = best;
            }
            left = best;
            previous_b = b;
        }
        before_last = last;
        last = row;
        previous_a = a;
    }
    last.get(b.len()).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_slip_is_recognised_and_another_word_is_not() {
        let keys = ["max_rate", "max_temp", "steps_per_mm", "enable", "pin"];
        for (slip, meant) in [
            ("max_rat", Some("max_rate")),
            ("Max_Temp", Some("max_temp")),
            ("steps_pre_mm", Some("steps_per_mm")),
            ("enabel", Some("enable")),
            ("pn", Some("pin")),
            ("colour", None),
            ("x", None),
        ] {
            assert_eq!(nearest(slip, keys.into_iter()), meant, "{slip}");
        }
    }

    #[test]
    fn too_long_a_text_is_cut_at_a_character() {
        assert_eq!(cut::<7>(format_args!("{}", "grüße an")).as_str(), "grüße");
    }

    proptest! {
        #[test]
        fn distance_is_a_metric_of_its_ends(a in "[a-c_]{0,12}", b in "[a-c_]{0,12}") {
            prop_assert_eq!(distance(&a, &b), distance(&b, &a));
            prop_assert_eq!(distance(&a, &b) == Some(0), a == b);
            prop_assert!(distance(&a, &b).unwrap() <= a.len().max(b.len()));
        }
    }
}

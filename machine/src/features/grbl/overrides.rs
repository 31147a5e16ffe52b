//! GRBL's overrides: percentages that bytes change, within its bounds (`config.h` of Grbl 1.1).

use gcode::realtime::Realtime;

/// Least override of feed rates and spindle speed, percent.
const LEAST: f64 = 10.0;
/// Greatest override of feed rates and spindle speed, percent.
const MOST: f64 = 200.0;

/// Whether a byte changes an override or an output.
pub(crate) const fn are_changed_by(request: Realtime) -> bool {
    use Realtime as R;
    matches!(
        request,
        R::FeedReset
            | R::FeedUp10
            | R::FeedDown10
            | R::FeedUp1
            | R::FeedDown1
            | R::RapidFull
            | R::RapidHalf
            | R::RapidQuarter
            | R::SpindleReset
            | R::SpindleUp10
            | R::SpindleDown10
            | R::SpindleUp1
            | R::SpindleDown1
            | R::SpindleStop
            | R::Flood
            | R::Mist
    )
}

/// Returns the percent by which a byte changes its override; 0 sets it to 100.
const fn step(request: Realtime) -> f64 {
    match request {
        Realtime::FeedUp10 | Realtime::SpindleUp10 => 10.0,
        Realtime::FeedDown10 | Realtime::SpindleDown10 => -10.0,
        Realtime::FeedUp1 | Realtime::SpindleUp1 => 1.0,
        Realtime::FeedDown1 | Realtime::SpindleDown1 => -1.0,
        _ => 0.0,
    }
}

/// Returns the override after a byte, percent.
pub(crate) fn changed(percent: f64, request: Realtime) -> f64 {
    match step(request) {
        0.0 => 100.0,
        step => (percent + step).clamp(LEAST, MOST),
    }
}

/// Returns the override of rapids that a byte asks for, percent.
pub(crate) const fn rapid(request: Realtime) -> f64 {
    match request {
        Realtime::RapidHalf => 50.0,
        Realtime::RapidQuarter => 25.0,
        _ => 100.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_percent_stays_within_its_bounds_and_comes_back(bytes in proptest::collection::vec(0..4_usize, 0..60)) {
            let steps = [Realtime::FeedUp10, Realtime::FeedDown10, Realtime::FeedUp1, Realtime::FeedDown1];
            let percent = bytes.iter().fold(100.0, |percent, byte| changed(percent, steps[*byte]));
            prop_assert!((LEAST..=MOST).contains(&percent) && percent == libm::round(percent));
            prop_assert_eq!(changed(percent, Realtime::FeedReset), 100.0);
            let up = changed(percent, Realtime::SpindleUp1);
            prop_assert!(up == percent + 1.0 || percent == MOST);
        }
    }
}

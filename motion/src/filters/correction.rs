//! Transition of an extruder whose trajectory was taken back after it had been used.
//!
//! An extruder with pressure advance usually looks ahead farthest and matters least. An extruder that moves
//! along with X, Y or Z does not hold them up: its output goes over to that of the new trajectory. The
//! difference in place and speed at that moment ([`Correction`]) fades to nothing over one latency, by the
//! cubic that begins with both and ends without either. The extruder's speed differs by less than `1.5 c / L`
//! plus the difference in speed meanwhile, c being the difference in place and L the latency.

use units::PerAxis;

use super::{
    advance::Window,
    history::{History, MAX_EXTRUDERS, is_before, seconds},
};

/// Fading difference between two outputs: place and speed at its beginning.
#[derive(Clone, Copy, Debug)]
struct Correction {
    from: u64,
    place: f64,
    rate: f64,
}

impl Correction {
    /// Returns place and speed of the difference left at `time`: nothing after `fade` seconds.
    fn at(&self, time: u64, fade: f64) -> (f64, f64) {
        let x = seconds(time.wrapping_sub(self.from)) / fade;
        if x >= 1.0 {
            return (0.0, 0.0);
        }
        let y = 1.0 - x;
        let place = y * y * (self.place * (1.0 + 2.0 * x) + self.rate * fade * x);
        let rate = y * (self.rate * (1.0 - 3.0 * x) - 6.0 * x * self.place / fade);
        (place, rate)
    }
}

/// Corrections of the extruders.
#[derive(Debug)]
pub(super) struct Corrections {
    /// Duration of a correction.
    span: u64,
    /// Whether the next output begins the corrections: until then `None` says nothing.
    wanted: bool,
    each: [Option<Correction>; MAX_EXTRUDERS],
}

impl Corrections {
    /// No corrections, of no duration.
    pub const NONE: Self = Self { span: 0, wanted: false, each: [None; MAX_EXTRUDERS] };

    /// Sets the duration of corrections from now on.
    pub const fn configure(&mut self, span: u64) {
        *self = Self { span, ..Self::NONE };
    }

    /// Drops all of the corrections.
    pub const fn clear(&mut self) {
        self.configure(self.span);
    }

    /// Returns the time from `now` until the last correction is over.
    pub fn left(&self, now: u64) -> Option<u64> {
        let left = |correction: &Correction| correction.from.wrapping_add(self.span).wrapping_sub(now);
        let left = self.each.iter().flatten().map(left).max();
        if self.wanted { Some(self.span) } else { left }
    }

    /// Returns the correction of an axis at `time`: place and speed.
    pub fn at(&self, axis: usize, time: u64) -> Option<(f64, f64)> {
        let correction = self.each.get(axis.wrapping_sub(3))?.as_ref()?;
        Some(correction.at(time, seconds(self.span)))
    }

    /// Delays all corrections by `by`.
    pub fn shift(&mut self, by: u64) {
        for correction in self.each.iter_mut().flatten() {
            correction.from = correction.from.wrapping_add(by);
        }
    }

    /// Makes the next output begin the corrections.
    pub const fn want(&mut self) {
        self.wanted = true;
    }

    /// Begins the corrections if they are wanted, once the trajectory has been settled anew: from the output
    /// so far, `point` and `velocity`, to that of the windows over the new trajectory. True if they were.
    pub fn begin(
        &mut self,
        now: u64,
        (history, windows): (&History, &[Option<Window>; MAX_EXTRUDERS]),
        (point, velocity): (&PerAxis<f64>, &PerAxis<f64>),
    ) -> bool {
        if !core::mem::take(&mut self.wanted) {
            return false;
        }
        for (window, slot) in windows.iter().zip(&mut self.each) {
            let Some(window) = window else { continue };
            let (place, rate) = window.output(history, now);
            let axis = window.axis;
            let was = |of: &PerAxis<f64>| of.0.get(axis).copied().unwrap_or_default();
            *slot = Some(Correction { from: now, place: was(point) - place, rate: was(velocity) - rate });
        }
        true
    }

    /// Drops the corrections that are over.
    pub fn end(&mut self, now: u64) {
        let span = self.span;
        for slot in &mut self.each {
            if slot.is_some_and(|correction| !is_before(now, correction.from.wrapping_add(span))) {
                *slot = None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Units of time in a second.
    const UNITS: f64 = units::STEP_CLOCK_HZ as f64 * 4_294_967_296.0;

    proptest! {
        #[test]
        fn a_correction_begins_with_both_differences_and_ends_without(
            place in -1.0..1.0_f64, rate in -50.0..50.0_f64, fade in 0.01..0.2_f64, share in 0.01..0.99_f64,
        ) {
            let from = 12_345 << 32;
            let correction = Correction { from, place, rate };
            let at = |seconds: f64| correction.at(from + (seconds * UNITS) as u64, fade);
            prop_assert_eq!(at(0.0), (place, rate));
            let (end, end_rate) = at(fade * (1.0 - 1e-9));
            prop_assert!(end.abs() < 1e-6 && end_rate.abs() < 1e-4, "ends with {end} mm, {end_rate} mm/s");
            prop_assert_eq!(at(fade * 1.01), (0.0, 0.0));
            let (middle, step) = (share * fade, 1e-4 * fade);
            let slope = (at(middle + step).0 - at(middle - step).0) / (2.0 * step);
            let scale = rate.abs() + place.abs() / fade;
            prop_assert!((at(middle).1 - slope).abs() < 1e-5 * scale + 1e-6, "the rate is the slope of the place");
        }
    }

    #[test]
    fn corrections_last_one_latency_and_can_be_delayed() {
        let mut corrections = Corrections::NONE;
        corrections.configure(1_000);
        assert_eq!((corrections.left(0), corrections.at(3, 0)), (None, None));
        corrections.want();
        assert_eq!(corrections.left(0), Some(1_000), "until the next output begins them");
        corrections.each[0] = Some(Correction { from: 100, place: 1.0, rate: 0.0 });
        corrections.wanted = false;
        corrections.shift(50);
        assert_eq!(corrections.left(200), Some(950));
        corrections.end(1_149);
        assert!(corrections.at(3, 1_149).is_some() && corrections.at(4, 1_149).is_none());
        corrections.end(1_150);
        assert_eq!(corrections.left(1_150), None);
    }
}

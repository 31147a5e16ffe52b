//! Correction of the homed position by the phase at the switch.

use base::failure::{Failure, ShortText, short};
use base::reason::{Alarm, Reason};
use config::EndstopPhaseConfig;
use units::Axis;

use super::cycle::{CYCLE, FULL_STEP, nearest, within};
use super::readings::Unread;
use crate::endstop_phase::PhaseHands;

/// Facts about the approach of an axis to its switch.
#[derive(Clone, Copy, Debug)]
pub struct Came {
    /// Whether the axis' position was known before this homing began.
    pub was_homed: bool,
    /// Whether the fast approach stopped the motors at once, which may have lost steps.
    pub was_cut: bool,
}

/// Corrects a homed axis: its switch closed at `hit`, mm, and is to be at `place`. Returns the nearest place
/// with the expected phase instead of `hit`, and `place` as zero is aligned.
///
/// # Errors
/// An alarm when the phase is too far off or cannot be read, and the configuration says that this halts.
pub fn at_switch<'c>(
    hands: &mut impl PhaseHands<'c>,
    axis: Axis,
    hit: f64,
    place: f64,
    came: Came,
) -> Result<[f64; 2], Failure> {
    let config = hands.config();
    let Some(settings) = config.homing_endstop(axis).map(|stop| stop.phase) else { return Ok([hit, place]) };
    let calibrated = hands.tuning().phases[axis];
    let record = hands.phases().of(axis);
    let fast_made = record.fast_made.take();
    let before = record.home_made.take().filter(|_| came.was_homed);
    let reading = match record.reading.take() {
        Some(Ok(reading)) => reading,
        Some(Err(unread)) => return warn_or_halt(hands, &settings, &why_unread(axis, unread)).map(|()| [hit, place]),
        None => return Ok([hit, place]),
    };
    // The mean of several approaches lies a little off the last.
    let (mm, past) = (reading.mm, (hit - reading.hit) / reading.mm);
    let phase = within(reading.phase + past, CYCLE);
    (record.mm, record.is_absolute) = (mm, reading.is_absolute);
    record.collect(phase);
    let first = *record.first.get_or_insert(phase);
    let wanted = calibrated.filter(|_| reading.is_absolute).unwrap_or(first);
    let off = nearest(phase - wanted, CYCLE);
    let tolerance = settings.tolerance.map_or(FULL_STEP * mm, |tolerance| tolerance.0);
    let is_good = libm::fabs(off) * mm <= tolerance;
    let made = reading.made.and(past - if is_good { off } else { 0.0 });
    record.home_made = Some(made);
    // A hard stop in the fast approach may lose steps, so the fast travel then does not count as lost before.
    let made_there = fast_made.or((!came.was_cut).then_some(made));
    if let Some(way) = before.zip(made_there).and_then(|(before, now)| now.since(before)) {
        say_lost(hands, axis, way, mm);
    }
    let place = if settings.align_zero { aligned(place, wanted, mm) } else { place };
    if is_good {
        return Ok([hit - off * mm, place]);
    }
    let letter = axis.letter();
    let why = short(format_args!(
        "{letter}: the switch closed {:+.4} mm from its phase, allowed are {tolerance:.4}: is it loose, or a pulley?",
        off * mm
    ));
    warn_or_halt(hands, &settings, &why).map(|()| [hit, place])
}

/// Returns the switch's place, moved so that the zero of the axis is at a full step: there a single coil has
/// the whole current, and a motor without current rests there too.
fn aligned(place: f64, wanted: f64, mm: f64) -> f64 {
    place + nearest(wanted - place / mm, FULL_STEP) * mm
}

/// Reports whole cycles lost between two homings: a motor that loses its field's hold falls into the next
/// cycle.
fn say_lost<'c>(hands: &mut impl PhaseHands<'c>, axis: Axis, places: f64, mm_per_place: f64) {
    let cycles = libm::floor(places / CYCLE + 0.5);
    if cycles != 0.0 {
        let (letter, lost) = (axis.letter(), libm::fabs(cycles));
        let (full_steps, mm) = (4.0 * lost, CYCLE * lost * mm_per_place);
        hands.announce(format_args!(
            "WARNING: {letter}: {full_steps} full steps ({mm:.3} mm) were lost since it was homed before\n"
        ));
    }
}

fn why_unread(axis: Axis, unread: Unread) -> ShortText {
    let letter = axis.letter();
    match unread {
        Unread::Silent(motor) => short(format_args!(
            "{letter}: driver {} does not say its phase at the switch: check its supply and wiring",
            motor.name()
        )),
        Unread::Uneven => short(format_args!(
            "{letter}: does not follow its motors evenly, so their phases say nothing: delete phase_check"
        )),
    }
}

fn warn_or_halt<'c>(
    hands: &mut impl PhaseHands<'c>,
    settings: &EndstopPhaseConfig,
    why: &ShortText,
) -> Result<(), Failure> {
    if settings.halts {
        return Err(hands
            .texts()
            .alarm(format_args!("{why}"))
            .with_reason(Reason::Locked)
            .with_alarm(Alarm::HomingSearch));
    }
    hands.announce(format_args!("WARNING: {why}; homed to the switch alone\n"));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn zero_comes_to_a_full_step_by_the_shortest_way(
            place in -300.0..300.0_f64, wanted in 0.0..CYCLE, mm in 1e-5..1e-2_f64,
        ) {
            let moved = aligned(place, wanted, mm);
            prop_assert!((moved - place).abs() <= FULL_STEP / 2.0 * mm + 1e-9);
            let phase_at_zero = wanted - moved / mm;
            prop_assert!(nearest(phase_at_zero, FULL_STEP).abs() < 1e-4, "{phase_at_zero}");
        }
    }
}

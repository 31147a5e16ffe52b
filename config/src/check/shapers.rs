//! Checks of the input shapers.

use super::findings::Checks;

const FREQUENCY: [&str; 3] = ["shaper_freq_x", "shaper_freq_y", "shaper_freq_z"];
const DAMPING: [&str; 3] = ["damping_ratio_x", "damping_ratio_y", "damping_ratio_z"];
/// Below this (Hz) a shaper would delay the machine by half a second.
const LOWEST_FREQUENCY: f64 = 5.0;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let shapers = checks.config.input_shapers;
    for ((shaper, frequency_key), damping_key) in shapers.into_iter().zip(FREQUENCY).zip(DAMPING) {
        let Some(frequency) = shaper.frequency_hz else { continue };
        if frequency < LOWEST_FREQUENCY {
            let reason = format_args!("{frequency} Hz is too slow to shape");
            checks.error(
                ("input shaper", 0, frequency_key),
                reason,
                format_args!("write {LOWEST_FREQUENCY} to 1000 Hz, or 0 to leave the axis as it is"),
            );
        }
        if shaper.damping_ratio > shaper.shaper.max_damping() {
            let reason = format_args!("{} is more than this shaper is made for", shaper.damping_ratio);
            checks.error(
                ("input shaper", 0, damping_key),
                reason,
                format_args!("write at most {}, or take zv, mzv or zvd", shaper.shaper.max_damping()),
            );
        }
    }
}

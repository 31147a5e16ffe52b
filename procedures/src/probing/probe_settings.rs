//! M670: settings of the probe that may change at run time, and their line in M500.

use core::fmt::{self, Write};

use base::failure::{Answer, Outcome};
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use program::Words;
use units::Micros;

/// M670: sets S, K and R, speeds in mm/s, Z and H, lengths in mm, D, seconds; I inverts the contact, I0
/// leaves it. Reports the resulting settings. The bounds of the words are those of the table of codes.
pub fn probe_settings(tuning: &mut Tuning, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    if !tuning.probe.enable {
        return Ok(Answer::Unknown);
    }
    let probe = &mut tuning.probe;
    let set = |letter: char, value: &mut f64| *value = words.get(letter).unwrap_or(*value);
    set('S', &mut probe.slow_rate.0);
    set('K', &mut probe.fast_rate.0);
    set('Z', &mut probe.max_travel.0);
    set('H', &mut probe.height.0);
    set('R', &mut probe.return_rate.0);
    if words.get('R') == Some(0.0) {
        probe.return_rate = probe.usual_return_rate();
    }
    if let Some(seconds) = words.get('D') {
        probe.dwell = Micros((seconds * 1e6) as u64);
    }
    tuning.probe_inverted ^= words.has('I') && words.get('I') != Some(0.0);
    let probe = &tuning.probe;
    reply.say(format_args!(
        "S:{:.2} K:{:.2} R:{:.2} Z:{:.2} H:{:.2} D:{:.2} inverted:{}\n",
        probe.slow_rate.0,
        probe.fast_rate.0,
        probe.return_rate.0,
        probe.max_travel.0,
        probe.height.0,
        probe.dwell.seconds(),
        u8::from(tuning.probe_inverted)
    ));
    Ok(Answer::Ok)
}

/// Writes the line of the probe that M500 saves.
///
/// # Errors
/// When the line does not fit.
pub fn write_probe(text: &mut impl Write, config: &MachineConfig, tuning: &Tuning) -> fmt::Result {
    if !config.probe.enable {
        return Ok(());
    }
    let probe = &tuning.probe;
    writeln!(
        text,
        ";Probe feedrates slow, fast, return (mm/s), max travel, height (mm), dwell (s):\n\
         M670 S{:.5} K{:.5} R{:.5} Z{:.5} H{:.5} D{:.5}",
        probe.slow_rate.0,
        probe.fast_rate.0,
        probe.return_rate.0,
        probe.max_travel.0,
        probe.height.0,
        probe.dwell.seconds()
    )
}

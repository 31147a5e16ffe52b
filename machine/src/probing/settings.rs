//! M670: what may be changed about the probe at run time, and how M500 saves it.

use core::fmt::Write;

use gcode::Block;
use units::Micros;

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;

/// Longest pause before a search, s; as in the configuration.
const LONGEST_DWELL: f64 = 60.0;

impl<P: Ports> Controller<P> {
    /// M670 S K R Z H D, I; says what holds afterwards.
    pub(super) fn probe_settings_code(&mut self, block: &Block<'_>) -> Outcome {
        let mut probe = self.config.probe;
        let above_zero = |letter, value: &mut f64| take(block, letter, f64::MIN_POSITIVE, f64::MAX, value);
        above_zero('S', &mut probe.slow_rate.0)?;
        above_zero('K', &mut probe.fast_rate.0)?;
        above_zero('Z', &mut probe.max_travel.0)?;
        take(block, 'R', 0.0, f64::MAX, &mut probe.return_rate.0)?;
        if block.get('R') == Some(0.0) {
            probe.return_rate = probe.usual_return_rate();
        }
        take(block, 'H', 0.0, f64::MAX, &mut probe.height.0)?;
        let mut dwell = seconds(probe.dwell);
        take(block, 'D', 0.0, LONGEST_DWELL, &mut dwell)?;
        probe.dwell = Micros((dwell * 1e6) as u64);
        self.probing.inverted ^= block.has('I');
        self.config.probe = probe;
        self.say(format_args!(
            "S:{:.2} K:{:.2} R:{:.2} Z:{:.2} H:{:.2} D:{:.2} inverted:{}\n",
            probe.slow_rate.0,
            probe.fast_rate.0,
            probe.return_rate.0,
            probe.max_travel.0,
            probe.height.0,
            seconds(probe.dwell),
            u8::from(self.probing.inverted)
        ));
        Ok(Answer::Ok)
    }

    /// The line M500 saves of this.
    pub(crate) fn write_probe(&self, text: &mut impl Write) -> core::fmt::Result {
        let probe = &self.config.probe;
        if !probe.enable {
            return Ok(());
        }
        writeln!(
            text,
            ";Probe feedrates slow, fast, return (mm/s), max travel, height (mm), dwell (s):\n\
             M670 S{:.5} K{:.5} R{:.5} Z{:.5} H{:.5} D{:.5}",
            probe.slow_rate.0,
            probe.fast_rate.0,
            probe.return_rate.0,
            probe.max_travel.0,
            probe.height.0,
            seconds(probe.dwell)
        )
    }
}

fn seconds(time: Micros) -> f64 {
    time.0 as f64 * 1e-6
}

/// The word's value, if it is there and within these bounds.
fn take(block: &Block<'_>, letter: char, least: f64, most: f64, value: &mut f64) -> Result<(), Failure> {
    let Some(word) = block.get(letter) else { return Ok(()) };
    if !(word >= least && word <= most) {
        let column = block.column_of(letter);
        let bound = if least > 0.0 { "above zero" } else { "zero or more" };
        let text = if most < f64::MAX {
            message(format_args!("M670: {letter} is 0 to {most:.0}, column {column}"))
        } else {
            message(format_args!("M670: {letter} must be {bound}, column {column}"))
        };
        return Err(Failure::Refused(text));
    }
    *value = word;
    Ok(())
}

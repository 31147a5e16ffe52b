//! What a file comes to, in words.

use core::fmt;

use units::Axis;

use super::state::Totals;

/// Lines that [`Told`] has at most.
pub const TOLD_LINES: usize = 5;

/// One of the lines that say what a file comes to; one may be empty.
#[derive(Clone, Copy, Debug)]
pub struct Told<'t> {
    /// What it comes to.
    pub totals: &'t Totals,
    /// Which line, from 0.
    pub line: usize,
}

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let totals = self.totals;
        match self.line {
            0 => {
                let (lines, stops, warnings) = (totals.lines, totals.stops, totals.warnings);
                writeln!(f, "{lines} lines: {stops} stop the job, {warnings} warnings")
            }
            1 => time(f, totals),
            2 if totals.lost_seconds > 0.05 => {
                writeln!(f, "speeds cut by limits cost {}", Clock(totals.lost_seconds))
            }
            3 => {
                let (filament, printed, travelled) = (totals.filament, totals.printed, totals.travelled);
                writeln!(f, "filament: {filament:.1} mm, path: {printed:.1} mm and {travelled:.1} mm without")
            }
            4 => extents(f, totals),
            _ => Ok(()),
        }
    }
}

fn time(f: &mut fmt::Formatter<'_>, totals: &Totals) -> fmt::Result {
    let moving = totals.even_seconds + totals.ramp_seconds;
    let share = if moving > 0.0 { 100.0 * totals.ramp_seconds / moving } else { 0.0 };
    writeln!(
        f,
        "time: {} without heating (moving {moving:.1} s, {share:.0} % of it changing speed; waiting {:.1} s; homing about \
         {:.1} s; {} waits for heaters)",
        Clock(totals.seconds()),
        totals.waiting_seconds,
        totals.homing_seconds,
        totals.heat_waits
    )
}

fn extents(f: &mut fmt::Formatter<'_>, totals: &Totals) -> fmt::Result {
    let Some([least, most]) = totals.extents else { return Ok(()) };
    for axis in Axis::PRIMARY {
        let end = if axis == Axis::Z { " mm\n" } else { ", " };
        write!(f, "{} {:.3} to {:.3}{end}", axis.letter(), least[axis], most[axis])?;
    }
    Ok(())
}

/// Seconds as `hh:mm:ss`.
#[derive(Clone, Copy, Debug)]
pub struct Clock(pub f64);

impl fmt::Display for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whole = libm::round(self.0) as u64;
        write!(f, "{:02}:{:02}:{:02}", whole / 3_600, whole / 60 % 60, whole % 60)
    }
}

//! Totals of a file, in words.

use core::fmt;

use base::clock_time::Clock;
use config::MachineConfig;
use units::Axis;

use super::limits::Limit;
use super::state::Totals;

/// Greatest number of lines that [`Told`] has.
pub const TOLD_LINES: usize = 6;

/// Least time that is worth telling, seconds.
const WORTH_TELLING: f64 = 0.05;

/// A line about the totals of a file, which may be empty.
#[derive(Clone, Copy, Debug)]
pub struct Told<'t> {
    /// Configuration of the heaters that are waited for.
    pub config: &'t MachineConfig,
    /// Totals of the file.
    pub totals: &'t Totals,
    /// Number of the line, from 0.
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
            2 => heating(f, totals, self.config),
            3 => limits(f, totals),
            4 => {
                let (filament, printed, travelled) = (totals.filament, totals.printed, totals.travelled);
                writeln!(f, "filament: {filament:.1} mm, path: {printed:.1} mm and {travelled:.1} mm without")
            }
            5 => extents(f, totals),
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
         {:.1} s)",
        Clock(totals.seconds()),
        totals.waiting_seconds,
        totals.homing_seconds
    )
}

/// Writes the waits for heat, without their time, for nothing says how fast a heater heats.
fn heating(f: &mut fmt::Formatter<'_>, totals: &Totals, config: &MachineConfig) -> fmt::Result {
    if totals.heat_waits == 0 {
        return Ok(());
    }
    let waits = if totals.heat_waits == 1 { "wait" } else { "waits" };
    write!(f, "heating, whose time is not foreseen: {} {waits}", totals.heat_waits)?;
    let heats = config.heaters().filter_map(|(id, heater)| Some((heater, totals.heats.get(id.index())?)));
    for (place, (heater, (times, most))) in heats.filter(|(_, (times, _))| *times > 0).enumerate() {
        let (mark, name, celsius) = (if place == 0 { ":" } else { "," }, heater.name.as_str(), most.0);
        write!(f, "{mark} {name} {times}x, up to {celsius:.0} C")?;
    }
    writeln!(f)
}

/// Writes the cost of limits, the costliest first; nothing where that is not worth telling.
fn limits(f: &mut fmt::Formatter<'_>, totals: &Totals) -> fmt::Result {
    let mut costs: heapless::Vec<_, { Limit::COUNT }> = totals.limits.into_iter().zip(Limit::ALL).collect();
    units::sort_short(&mut costs, |(a, _), (b, _)| b.total_cmp(a));
    let lost = totals.lost_seconds();
    if lost < WORTH_TELLING {
        return Ok(());
    }
    write!(f, "limits cost {lost:.1} s of {:.1} s", totals.seconds())?;
    for (place, (seconds, limit)) in costs.into_iter().filter(|(seconds, _)| *seconds >= WORTH_TELLING).enumerate() {
        write!(f, "{} {limit} {seconds:.1} s", if place == 0 { ":" } else { "," })?;
    }
    writeln!(f)
}

fn extents(f: &mut fmt::Formatter<'_>, totals: &Totals) -> fmt::Result {
    let Some([least, most]) = totals.extents else { return Ok(()) };
    for axis in Axis::PRIMARY {
        let end = if axis == Axis::Z { " mm\n" } else { ", " };
        write!(f, "{} {:.3} to {:.3}{end}", axis.letter(), least[axis], most[axis])?;
    }
    Ok(())
}

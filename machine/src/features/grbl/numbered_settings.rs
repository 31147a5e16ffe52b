//! GRBL's numbered settings, in one table: the setting of this firmware that each number reads and writes.
//!
//! Settings that a code changes at run time are changed by that code with `$n=`: at once, within the code's
//! bounds. Settings of `config.ini` alone are read only: wiring and homing are read once, at boot.

use base::failure::{Failure, ShortText, Texts, short};
use base::laser::LaserScale;
use base::reason::Reason;
use config::{HomingDirection, MachineConfig};
use motion::MotionConfig;
use units::{Actuator, Axis, PerAxis};

use crate::features::grbl::state::Own;

/// Sources of the values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources<'m> {
    /// Steps, limits and corners in force.
    pub motion: &'m MotionConfig,
    /// Configuration as it was read.
    pub config: &'m MachineConfig,
    /// The dialect's own settings.
    pub own: &'m Own,
    /// Whether moves are held against the travel.
    pub soft_limits: bool,
    /// Scale of the laser's power, and whether moves have power; `None` without a laser.
    pub laser: Option<(LaserScale, bool)>,
    /// Ends of the axes, machine position in mm.
    pub ends: &'m [PerAxis<f64>; 2],
}

/// Way of changing a setting.
#[derive(Clone, Copy, Debug)]
enum Write {
    /// By this setting of `config.ini` only.
    Config(&'static str),
    /// By this code, whose word has the axis's letter or this one; its value is the setting's times a factor.
    Code(&'static str, Option<char>, f64),
    /// By this function of the dialect's own settings.
    Own(fn(&mut Own, f64)),
    /// By this code, which switches something on or off.
    Switch(&'static str),
    /// By M452 with this word on a machine with a laser, else by this setting of `config.ini` only, if any.
    Laser(char, Option<&'static str>),
}

/// Row of the table, or three rows: one for each of X, Y and Z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Number of the (first) setting.
    number: u16,
    /// Whether X, Y and Z have a number each.
    of_axes: bool,
    /// Meaning of the setting, with its unit.
    meaning: &'static str,
    decimals: usize,
    read: fn(&Sources<'_>, Axis) -> f64,
    write: Write,
}

const fn row(
    number: u16,
    decimals: usize,
    meaning: &'static str,
    read: fn(&Sources<'_>, Axis) -> f64,
    write: Write,
) -> Row {
    Row { number, of_axes: number >= 100, meaning, decimals, read, write }
}

fn flag(is_so: bool) -> f64 {
    f64::from(u8::from(is_so))
}

/// Returns one bit for each of X, Y and Z.
fn mask(is_so: impl Fn(Axis) -> bool) -> f64 {
    f64::from((0..).zip(Axis::PRIMARY).filter(|(_, axis)| is_so(*axis)).fold(0_u8, |bits, (bit, _)| bits | 1 << bit))
}

fn motor(axis: Axis) -> Actuator {
    Actuator::from_index(axis as usize).unwrap_or(Actuator::Alpha)
}

/// Picks a value of the first axis that homes.
fn homing(config: &MachineConfig, pick: fn(&config::EndstopConfig) -> f64) -> f64 {
    Axis::PRIMARY.into_iter().find_map(|axis| config.homing_endstop(axis)).map_or(0.0, pick)
}

fn homes(config: &MachineConfig) -> bool {
    Axis::PRIMARY.into_iter().any(|axis| config.homing_endstop(axis).is_some())
}

/// Returns the least and greatest S of the laser, or of a spindle that has a scale.
fn scale(of: &Sources<'_>) -> Option<[f64; 2]> {
    let scale = match of.laser {
        Some((LaserScale { least_s, most_s, .. }, _)) => Some([least_s, most_s]),
        None => parts::outputs::spindle_scale(of.config),
    };
    scale.map(|scale| scale.map(f64::from))
}

fn travel(of: &Sources<'_>, axis: Axis) -> f64 {
    let [least, most] = of.ends;
    let length = most[axis] - least[axis];
    if length.is_finite() { length } else { of.config.homing_endstop(axis).map_or(0.0, |stop| stop.max_travel.0) }
}

/// Table of all settings.
pub(crate) const ROWS: &[Row] = &[
    row(
        0,
        0,
        "step pulse, us",
        |of, _| f64::from(of.config.system.step_pulse_us),
        Write::Config("[system] step_pulse_us"),
    ),
    row(1, 0, "step idle delay, ms: 255, motors keep their current", |_, _| 255.0, Write::Config("[current control]")),
    row(
        2,
        0,
        "step pins inverted, mask",
        |of, _| mask(|axis| of.config.actuators[motor(axis)].step_pin.is_some_and(|pin| pin.inverted)),
        Write::Config("[actuator] step_pin"),
    ),
    row(
        3,
        0,
        "directions inverted, mask",
        |of, _| mask(|axis| of.config.actuators[motor(axis)].direction_inverted()),
        Write::Config("[actuator] dir_pin"),
    ),
    row(
        4,
        0,
        "enable pins inverted",
        |of, _| flag(of.config.actuators().any(|(_, motor)| motor.en_pin.is_some_and(|pin| pin.inverted))),
        Write::Config("[actuator] en_pin"),
    ),
    row(
        5,
        0,
        "limit pins inverted",
        |of, _| flag(of.config.endstops.iter().any(|stop| stop.pin.is_some_and(|pin| pin.inverted))),
        Write::Config("[endstops] pin"),
    ),
    row(
        6,
        0,
        "probe pin inverted",
        |of, _| flag(of.config.probe.pin.is_some_and(|pin| pin.inverted)),
        Write::Config("[zprobe] probe_pin"),
    ),
    row(
        10,
        0,
        "status report, mask",
        |of, _| f64::from(of.own.report_mask),
        Write::Own(|own, value| own.report_mask = value as u8),
    ),
    row(
        11,
        3,
        "junction deviation, mm",
        |of, _| of.motion.limits.junction_deviation.0,
        Write::Code("M205", Some('X'), 1.0),
    ),
    row(
        12,
        3,
        "arc tolerance, mm: 0, arcs are exact",
        |of, _| of.config.motion.arcs.max_error,
        Write::Config("[motion control] mm_max_arc_error"),
    ),
    row(13, 0, "reports in inches", |of, _| flag(of.own.inches), Write::Own(|own, value| own.inches = value != 0.0)),
    row(20, 0, "soft limits", |of, _| flag(of.soft_limits), Write::Switch("M211 S")),
    row(
        21,
        0,
        "hard limits",
        |of, _| flag(of.config.endstops.iter().any(|stop| stop.limit_enable && stop.pin.is_some())),
        Write::Config("[endstops] limit_enable"),
    ),
    row(22, 0, "homing", |of, _| flag(homes(of.config)), Write::Config("[endstops] homing_direction")),
    row(
        23,
        0,
        "homing towards the minimum, mask",
        |of, _| {
            let config = of.config;
            let is_down =
                |axis| config.homing_endstop(axis).is_some_and(|stop| stop.homing_direction == HomingDirection::ToMin);
            mask(is_down)
        },
        Write::Config("[endstops] homing_direction"),
    ),
    row(
        24,
        3,
        "homing feed rate, mm/min",
        |of, _| homing(of.config, |stop| stop.slow_rate.per_minute()),
        Write::Config("[endstops] slow_rate"),
    ),
    row(
        25,
        3,
        "homing seek rate, mm/min",
        |of, _| homing(of.config, |stop| stop.fast_rate.per_minute()),
        Write::Config("[endstops] fast_rate"),
    ),
    row(
        26,
        0,
        "homing debounce, ms",
        |of, _| of.config.homing.debounce.0 as f64 / 1_000.0,
        Write::Config("[endstops] common.debounce_ms"),
    ),
    row(
        27,
        3,
        "homing pull-off, mm",
        |of, _| homing(of.config, |stop| stop.retract.0),
        Write::Config("[endstops] retract"),
    ),
    row(
        30,
        0,
        "S of full power",
        |of, _| scale(of).map_or(100.0, |[_, most]| most),
        Write::Laser('R', Some("[switch] max_rpm")),
    ),
    row(
        31,
        0,
        "least S",
        |of, _| scale(of).map_or(0.0, |[least, _]| least),
        Write::Laser('L', Some("[switch] min_rpm")),
    ),
    row(32, 0, "laser mode", |of, _| flag(of.laser.is_some_and(|(_, is_on)| is_on)), Write::Laser('S', None)),
    row(
        100,
        3,
        "steps per mm",
        |of, axis| of.motion.actuators[motor(axis)].map_or(0.0, |motor| motor.steps_per_mm),
        Write::Code("M92", None, 1.0),
    ),
    row(
        110,
        3,
        "greatest rate, mm/min",
        |of, axis| {
            let own = of.motion.limits.axis_speed.get(axis as usize).copied().flatten();
            own.unwrap_or(of.motion.limits.actuator_rate[motor(axis)]).per_minute()
        },
        Write::Code("M203", None, 1.0 / 60.0),
    ),
    row(
        120,
        3,
        "acceleration, mm/s^2",
        |of, axis| of.motion.limits.actuator_acceleration[motor(axis)].unwrap_or(of.motion.limits.acceleration).0,
        Write::Code("M204", None, 1.0),
    ),
    row(130, 3, "travel, mm", travel, Write::Config("[soft endstop] x_min ... z_max")),
];

/// Setting, with its row and its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    row: &'static Row,
    axis: Axis,
}

/// Effect of setting a new value.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    /// The setting has that value already.
    Nothing,
    /// A code makes the change, and must be followed by saving what M500 saves.
    Code(ShortText),
    /// A code makes the change, until the next reset.
    Switch(ShortText),
    /// The dialect makes the change itself.
    Own(fn(&mut Own, f64), f64),
}

impl Setting {
    /// Returns all settings, in order.
    pub fn all() -> impl Iterator<Item = Self> {
        let axes = |row: &'static Row| Axis::PRIMARY.into_iter().take(if row.of_axes { 3 } else { 1 });
        ROWS.iter().flat_map(move |row| axes(row).map(move |axis| Self { row, axis }))
    }

    /// Returns the setting of a number.
    #[must_use]
    pub fn of(number: u16) -> Option<Self> {
        Self::all().find(|setting| setting.number() == number)
    }

    /// Returns the meaning of the setting, with its unit.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        self.row.meaning
    }

    /// Returns the number of printed decimals.
    #[must_use]
    pub const fn decimals(self) -> usize {
        self.row.decimals
    }

    /// Returns the setting's axis, where each axis has a number.
    #[must_use]
    pub fn axis(self) -> Option<Axis> {
        self.row.of_axes.then_some(self.axis)
    }

    /// Returns the number of the setting.
    #[must_use]
    pub const fn number(self) -> u16 {
        self.row.number + if self.row.of_axes { self.axis as u16 } else { 0 }
    }

    /// Returns the value, and the number of printed decimals.
    #[must_use]
    pub fn value(self, of: &Sources<'_>) -> (f64, usize) {
        ((self.row.read)(of, self.axis), self.row.decimals)
    }

    /// Returns the effect of setting a new value.
    ///
    /// # Errors
    /// When the text is no number that the setting takes, or the setting is read only.
    pub fn change(self, texts: &Texts, text: &str, of: &Sources<'_>) -> Result<Change, Failure> {
        let wanted = gcode::read_f64(text.trim()).filter(|value| value.is_finite() && value.abs() < 1e9);
        let wanted = wanted.ok_or_else(|| Failure::refused(&"a setting takes a number").with_reason(Reason::Number))?;
        if wanted < 0.0 {
            return Err(Failure::refused(&"a setting is not negative").with_reason(Reason::Negative));
        }
        let (value, decimals) = self.value(of);
        // Compared as far as decimals are printed.
        let step = (0..decimals).fold(1.0, |step, _| step / 10.0);
        if (wanted - value).abs() < step / 2.0 {
            return Ok(Change::Nothing);
        }
        match self.row.write {
            Write::Config(key) => {
                let text = format_args!("{}: change {key} in config.ini and reset", self.row.meaning);
                Err(texts.refused(text).with_reason(Reason::Statement))
            }
            Write::Code(code, letter, factor) => {
                let letter = letter.unwrap_or(self.axis.letter());
                Ok(Change::Code(short(format_args!("{code} {letter}{:.9}", wanted * factor))))
            }
            Write::Switch(_) if wanted != 0.0 && !homes(of.config) => {
                Err(Failure::refused(&"soft limits need homing: no endstop has a homing_direction")
                    .with_reason(Reason::NeedsHoming))
            }
            Write::Switch(code) => Ok(Change::Switch(short(format_args!("{code}{}", u8::from(wanted != 0.0))))),
            Write::Own(set) => Ok(Change::Own(set, wanted)),
            Write::Laser(letter, _) if of.laser.is_some() => {
                let wanted = if letter == 'S' { flag(wanted != 0.0) } else { wanted };
                Ok(Change::Code(short(format_args!("M452 {letter}{wanted}"))))
            }
            Write::Laser(_, Some(key)) => {
                let text = format_args!("{}: change {key} in config.ini and reset", self.row.meaning);
                Err(texts.refused(text).with_reason(Reason::Statement))
            }
            Write::Laser(_, None) => {
                Err(Failure::refused(&"laser mode needs a laser: see [laser]").with_reason(Reason::NoLaserOutput))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grbls_in_order() {
        let numbers: Vec<u16> = Setting::all().map(Setting::number).collect();
        let expected = (0..=6).chain(10..=13).chain(20..=27).chain(30..=32);
        let axes = [100, 110, 120, 130].into_iter().flat_map(|first| first..first + 3);
        assert_eq!(numbers, expected.chain(axes).collect::<Vec<_>>());
        assert!(numbers.iter().all(|number| Setting::of(*number).map(Setting::number) == Some(*number)));
        assert!(Setting::of(7).is_none() && Setting::of(103).is_none());
    }

    #[test]
    fn the_page_has_every_setting() {
        let page = include_str!("../../../../docs/grbl.md");
        for row in ROWS {
            let numbers =
                if row.of_axes { format!("{}-{}", row.number, row.number + 2) } else { format!("{}", row.number) };
            let by = match row.write {
                Write::Config(key) => format!("read only: `{key}`"),
                Write::Code(code, ..) => code.to_string(),
                Write::Switch(code) => format!("{} until the reset", code.trim_end_matches(" S")),
                Write::Own(_) => "kept in `grbl-settings`".into(),
                Write::Laser(letter, Some(key)) => format!("M452 {letter}; without a laser read only: `{key}`"),
                Write::Laser(letter, None) => format!("M452 {letter}; without a laser refused, error 17"),
            };
            let line = format!("| ${numbers} | {} | {by} |", row.meaning);
            assert!(page.contains(&line), "docs/grbl.md has no `{line}`");
        }
    }
}

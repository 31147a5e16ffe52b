//! Events that the firmware records, and their texts.

use core::fmt;

use crate::{DateTime, Text};

/// Cause of the firmware's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Cause {
    /// The power was switched on.
    PowerOn,
    /// The board's own supply had sagged.
    BrownOut,
    /// The reset pin: the button, or a debug probe.
    Pin,
    /// The firmware asked for the reset; the event before tells why.
    Software,
    /// The independent watchdog was not fed.
    Watchdog,
    /// None of the other causes.
    Unknown,
}

impl Cause {
    /// List of all causes, by their numbers.
    pub const ALL: [Self; 6] =
        [Self::PowerOn, Self::BrownOut, Self::Pin, Self::Software, Self::Watchdog, Self::Unknown];
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PowerOn => "power came",
            Self::BrownOut => "the board's own supply had sagged",
            Self::Pin => "the reset line: button or debug probe",
            Self::Software => "the firmware reset itself",
            Self::Watchdog => "the watchdog reset the board",
            Self::Unknown => "no known reason",
        })
    }
}

/// The tasks that the watchdog waits for, in the order of the bits of [`Event::Silent`].
pub const SILENT_TASKS: [&str; 5] =
    ["heat control", "the step feed", "the planner", "the watch over drivers and supplies", "the executor"];

/// Event that the firmware records.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// The firmware has started.
    Started {
        /// Cause of the start.
        cause: Cause,
        /// The date, when somebody has set the clock.
        date: Option<DateTime>,
    },
    /// The firmware ended itself: a panic, a fault of the processor, a clock that stopped.
    Ended(Text),
    /// Somebody asked for a reset.
    ResetAsked,
    /// The watchdog will not be fed: the tasks that were silent, a bit each, see [`SILENT_TASKS`].
    Silent(u8),
    /// The configuration was read and is in force.
    ConfigurationRead {
        /// Time that reading took, ms.
        took_ms: u32,
        /// Number of findings about it, none of which is fatal.
        findings: u32,
    },
    /// The configuration cannot be used, the machine stays locked.
    ConfigurationFlawed {
        /// Number of errors in it.
        errors: u32,
    },
    /// The configuration could not be read.
    ConfigurationUnreadable(Text),
    /// The machine changed its state.
    State(Text),
    /// The machine halted; the reason.
    Halted(Text),
    /// A halt was cleared.
    Released,
    /// A file is played.
    JobBegan(Text),
    /// The job was suspended at this line.
    JobSuspended {
        /// Number of the last line that was read.
        line: u32,
    },
    /// The job goes on after a suspension.
    JobResumed {
        /// Number of the last line that was read.
        line: u32,
    },
    /// The job is over.
    JobEnded {
        /// Whether the job went through to its end.
        complete: bool,
        /// Number of the last line that was read.
        line: u32,
    },
    /// The target of a heater was set.
    Target {
        /// Name of the heater.
        heater: Text,
        /// Target in degrees Celsius; 0 is off.
        celsius: f32,
    },
    /// A motor driver reported trouble.
    Driver {
        /// The letter of its axis.
        motor: char,
        /// Text of the trouble.
        trouble: Text,
    },
    /// The supply of the motors came or went.
    MotorSupply {
        /// Whether the supply is there.
        on: bool,
    },
    /// The supply of heaters and fans came or went.
    HeaterSupply {
        /// Whether the supply is there.
        on: bool,
    },
    /// The card was mounted.
    CardMounted,
    /// The card failed, or is gone.
    CardFailed(Text),
    /// Axes were homed, a bit each: X Y Z A B C.
    Homed {
        /// The homed axes, as bits.
        axes: u8,
    },
    /// A console was opened.
    SessionOpened {
        /// Number of the session.
        session: u8,
    },
    /// A console was closed.
    SessionClosed {
        /// Number of the session.
        session: u8,
    },
    /// A warning that every console was told.
    Warned(Text),
    /// Something else worth knowing.
    Noted(Text),
    /// Other firmware was asked for; its name.
    UpdateAsked(Text),
    /// The firmware that was asked for was not installed; the reason.
    UpdateRefused(Text),
    /// New firmware was started, and has not confirmed itself yet.
    FirmwareTried {
        /// Number of the start.
        start: u8,
    },
    /// New firmware has run for long enough, and stays.
    FirmwareConfirmed,
    /// New firmware failed, and the previous firmware is back; the reason.
    FirmwareFellBack(Text),
}

impl Event {
    /// Returns whether the firmware started anew: the events before belong to an earlier start.
    #[must_use]
    pub const fn is_start(&self) -> bool {
        matches!(self, Self::Started { .. })
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_on = |on: &bool| if *on { "is on" } else { "is off" };
        match self {
            Self::Started { cause, date: None } => write!(f, "started: {cause}"),
            Self::Started { cause, date: Some(date) } => write!(f, "started: {cause}; {date}"),
            Self::Ended(words) => write!(f, "the firmware ended itself: {words}"),
            Self::ResetAsked => f.write_str("a reset was asked for"),
            Self::Silent(tasks) => silent(*tasks, f),
            Self::ConfigurationRead { took_ms, findings: 0 } => write!(f, "config.ini was read in {took_ms} ms"),
            Self::ConfigurationRead { took_ms, findings } => {
                write!(f, "config.ini was read in {took_ms} ms, {findings} findings")
            }
            Self::ConfigurationFlawed { errors } => write!(f, "config.ini cannot be used, {errors} errors"),
            Self::ConfigurationUnreadable(why) => write!(f, "config.ini cannot be read: {why}"),
            Self::State(state) => write!(f, "state: {state}"),
            Self::Halted(why) => write!(f, "halted: {why}"),
            Self::Released => f.write_str("the halt was cleared"),
            Self::JobBegan(file) => write!(f, "job began: {file}"),
            Self::JobSuspended { line } => write!(f, "job suspended at line {line}"),
            Self::JobResumed { line } => write!(f, "job goes on at line {line}"),
            Self::JobEnded { complete: true, .. } => f.write_str("job done"),
            Self::JobEnded { complete: false, line } => write!(f, "job ended early at line {line}"),
            Self::Target { heater, celsius } if *celsius <= 0.0 => write!(f, "{heater} switched off"),
            Self::Target { heater, celsius } => write!(f, "{heater} to reach {celsius:.0} C"),
            Self::Driver { motor, trouble } => write!(f, "motor driver {motor}: {trouble}"),
            Self::MotorSupply { on } => write!(f, "motor supply {}", is_on(on)),
            Self::HeaterSupply { on } => write!(f, "heater supply {}", is_on(on)),
            Self::CardMounted => f.write_str("card mounted"),
            Self::CardFailed(why) => write!(f, "card: {why}"),
            Self::Homed { axes: 0 } => f.write_str("no axis is homed any more"),
            Self::Homed { axes } => {
                f.write_str("homed ")?;
                let letters = ['X', 'Y', 'Z', 'A', 'B', 'C'];
                let homed = letters.iter().enumerate().filter(|(axis, _)| axes & 1 << axis != 0);
                homed.map(|(_, letter)| *letter).try_for_each(|letter| fmt::Write::write_char(f, letter))
            }
            Self::SessionOpened { session } => write!(f, "somebody came to console {session}"),
            Self::SessionClosed { session } => write!(f, "console {session} was left"),
            Self::Warned(words) | Self::Noted(words) => fmt::Display::fmt(words, f),
            Self::UpdateAsked(which) => write!(f, "other firmware was asked for: {which}"),
            Self::UpdateRefused(why) => write!(f, "the firmware that was asked for was not installed: {why}"),
            Self::FirmwareTried { start } => write!(f, "new firmware, start {start}"),
            Self::FirmwareConfirmed => f.write_str("the new firmware stays"),
            Self::FirmwareFellBack(why) => write!(f, "the new firmware failed, the previous one is back: {why}"),
        }
    }
}

fn silent(tasks: u8, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str("the watchdog is not fed: nothing is heard of ")?;
    let names = SILENT_TASKS.iter().enumerate().filter(|(task, _)| tasks & 1 << task != 0);
    for (place, (_, name)) in names.enumerate() {
        write!(f, "{}{name}", if place > 0 { ", " } else { "" })?;
    }
    Ok(())
}

//! Parts that stay off because of an error in the configuration: whoever asks for one is told where the error is.
//!
//! Nothing of such a part is wired (`config` takes its pins away), so this is the message, not the safety.

use config::OffModule;
use gcode::{Block, Letter};

use crate::controller::Controller;
use crate::failure::{Failure, Message, message};
use crate::ports::Ports;

/// Codes that only one part can carry out, by its section.
const CODES: &[(Letter, core::ops::RangeInclusive<u16>, &str)] = &[
    (Letter::G, 29..=32, "zprobe"),
    (Letter::G, 38..=38, "zprobe"),
    (Letter::M, 48..=48, "zprobe"),
    (Letter::M, 670..=670, "zprobe"),
    (Letter::G, 33..=33, "lathe"),
    (Letter::G, 81..=83, "drillingcycles"),
    (Letter::M, 3..=4, "laser"),
    (Letter::M, 23..=24, "player"),
    (Letter::M, 32..=32, "player"),
    (Letter::M, 600..=601, "player"),
];

fn told(off: &OffModule) -> Message {
    match (off.key.is_empty(), off.line) {
        (_, 0) => message(format_args!("{off} is off: see {} in config.ini", off.key)),
        (true, line) => message(format_args!("{off} is off: see config.ini, line {line}")),
        (false, line) => message(format_args!("{off} is off: see {} in config.ini, line {line}", off.key)),
    }
}

impl<P: Ports> Controller<P> {
    /// Refuses what needs a part that stays off. A file being played must not go on without it: a spindle that does not
    /// turn breaks the tool, a nozzle that stays cold grinds the filament.
    pub(crate) fn needs(&self, section: &str, name: &str) -> Result<(), Failure> {
        match self.config.off(section, name).map(told) {
            None => Ok(()),
            Some(text) if self.player.is_playing() => Err(Failure::Alarm(text)),
            Some(text) => Err(Failure::Refused(text)),
        }
    }

    /// The same for a code that belongs to one section.
    pub(crate) fn needs_for(&self, block: &Block<'_>) -> Result<(), Failure> {
        let Some(code) = block.code else { return Ok(()) };
        let part = CODES.iter().find(|(letter, numbers, _)| *letter == code.letter && numbers.contains(&code.number));
        part.map_or(Ok(()), |(_, _, section)| self.needs(section, ""))
    }

    /// At boot: what stays off, in one line.
    pub(crate) fn tell_what_is_off(&mut self) {
        let Self { consoles, config, target, .. } = self;
        if config.off.is_empty() {
            return;
        }
        consoles.write(*target, format_args!("WARNING: until config.ini is mended these stay off: "));
        for (index, off) in config.off.iter().enumerate() {
            consoles.write(*target, format_args!("{}{off}", if index == 0 { "" } else { ", " }));
        }
        consoles.write(*target, format_args!("\n"));
    }
}

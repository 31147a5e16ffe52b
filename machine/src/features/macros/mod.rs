//! Klipper's macros: `[gcode_macro]` and `[delayed_gcode]` of a printer.cfg on the card, docs/macros.md.
//!
//! A macro is rendered whole by crate `macros` before its first line is carried out ([`calls`]). Its lines
//! go on as a step on the stack of frames, so pauses and aborts act between them. What macros see of the
//! machine is in [`look`] and [`objects`].

pub(crate) mod calls;
mod commands;
mod hands;
mod homing;
mod kept_modes;
mod look;
mod looks;
mod objects;
pub(crate) mod reload;
mod saved;
mod shown;
pub(crate) mod state;
mod status;
mod z_offset;

use base::failure::{Failure, Outcome};
use base::ports::Viewers as _;
use base::sessions::{LineBytes, Recipient};
use config::Command;
use gcode::{Block, Extended};
use units::{AxisSet, Micros};

use crate::machine::moments::{JobBegins, Moments};
use crate::machine::source::Source;
use calls::Shares;
use hands::MacroHands;

/// Macros, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: MacroHands<'c>> Moments<M> for Feature {
    fn read_files(hands: &mut M) {
        reload::at_start(hands);
    }

    fn each_10_ms(hands: &mut M, now: Micros) {
        if hands.macros().memory.store.sections() > 0 {
            commands::follow_time(hands, now);
        }
        if hands.world().ports.wants_macro().is_some() {
            shown::tell(hands);
        }
    }

    // Not while a sequence waits, deep on the stack: a macro is rendered.
    fn idle(hands: &mut M) -> bool {
        looks::serve(hands)
    }

    fn line(hands: &M) -> Option<&str> {
        hands.is_due().then_some(commands::DUE)
    }

    fn take_line(hands: &mut M) -> Option<Command> {
        hands.is_due().then_some(commands::DUE).and_then(|line| Command::try_from(line).ok())
    }

    fn session_line_begins(hands: &mut M) {
        hands.macros().is_idle = false;
    }

    fn job_begins(hands: &mut M, _from: JobBegins) {
        hands.macros().is_idle = false;
    }

    fn shows(hands: &mut M, text: &str) {
        let message = &mut hands.macros().message;
        message.clear();
        // A display shows the beginning of a long text too.
        text.chars().take_while(|letter| message.push(*letter).is_ok()).for_each(drop);
    }

    fn run_named(hands: &mut M, line: &str, source: Source) -> Option<Outcome> {
        let command = Extended::new(line);
        calls::run_named(hands, &command, source).or_else(|| commands::run(hands, &command, source))
    }

    fn begin_template(hands: &mut M, line: &str, is_first: bool) -> Option<Result<usize, Failure>> {
        commands::begin_on_the_spot(hands, line, if is_first { Shares::First } else { Shares::Further })
    }

    fn template_line(hands: &mut M, above: usize, line: &mut LineBytes) -> Option<Result<(), Failure>> {
        line.clear();
        calls::take_line(hands, above as u8, line).transpose().map(|taken| taken.map(drop))
    }

    fn end_templates(hands: &mut M, above: usize) {
        hands.macros().memory.store.end_calls(above);
    }

    fn homes(hands: &mut M, named: AxisSet, to: Recipient) -> Option<Outcome> {
        homing::home(hands, named, to)
    }

    fn has_homing(hands: &M) -> bool {
        hands.has_homing()
    }

    fn run_code(hands: &mut M, block: &Block<'_>, source: Source) -> Option<Outcome> {
        calls::run_code(hands, block, source)
    }
}

//! Interpretation of lines as by the executor: blocks in their order, commands by name, O words.

use core::fmt::Write as _;

use base::failure::{Failure, ShortText, short};
use base::needs::{cannot_level, failure_of, makes_another_part, needs};
use base::program_setup::PartNames;
use gcode::{Block, Blocks, Extended, Line, Refusal, SyntaxError, WholeLine};
use jobs::player::line_numbers::decoder_expecting;
use motion::Motion;
use program::extended::CodeLine;
use program::{CodeInfo, Dialect, Fault, Meaning, MotionMode, Next, Place, Problem, Remark};

use super::finding::{Kind, MOST_ALIKE, Severity};
use super::kept_modes::Kept;
use super::macro_calls::{Called, MacroCall};
use super::power;
use super::state::{Listener, Preflight};
use super::turns::end_turn;

/// A line being read.
pub(super) struct Reading<'p, 'c> {
    pub preflight: &'p mut Preflight<'c>,
    pub motion: &'p mut Motion,
    pub listener: &'p mut dyn Listener,
    /// Place at which the next line begins.
    pub after: Place,
    /// Line that is read next.
    pub next: Next,
    /// A code of the line has called a macro.
    pub has_called: bool,
}

/// Mark that the rest of a line is not looked at, as its fault has been said.
pub(super) struct Said;

impl<'p, 'c> Reading<'p, 'c> {
    /// Begins a line behind which its file goes on at this place.
    pub fn new(
        preflight: &'p mut Preflight<'c>,
        motion: &'p mut Motion,
        listener: &'p mut dyn Listener,
        after: Place,
    ) -> Self {
        Self { preflight, motion, listener, after, next: Next::Following, has_called: false }
    }
}

impl Reading<'_, '_> {
    // --- saying ---

    /// Reports a fault of this line.
    pub fn say(&mut self, kind: Kind, what: ShortText) -> Said {
        let kind = self.preflight.kind_here(kind);
        let preflight = &mut *self.preflight;
        let what = match &preflight.within {
            Some(within) => short(format_args!("{} line {}: {what}", within.name, within.row)),
            None => what,
        };
        let alike = match kind {
            Kind::OutOfTravel => Some(&mut preflight.once.out_of_travel),
            Kind::PassedOver => Some(&mut preflight.once.passed_over),
            Kind::Unforeseen => Some(&mut preflight.once.guesses),
            _ => None,
        };
        let count = if kind.severity() == Severity::Stop {
            &mut preflight.totals.stops
        } else {
            &mut preflight.totals.warnings
        };
        *count = count.saturating_add(1);
        let too_many = alike.is_some_and(|alike| {
            *alike += 1;
            *alike > MOST_ALIKE
        });
        if !too_many {
            self.listener.found(&preflight.finding(preflight.line, kind, what));
        }
        Said
    }

    /// Says a failure that the machine would refuse, or halt with.
    pub fn failed(&mut self, kind: Kind, failure: Failure) -> Said {
        let what = self.preflight.texts.copy_of(failure);
        if failure.has_text() { self.say(kind, what) } else { Said }
    }

    fn wrong(&mut self, fault: &Fault) -> Said {
        let kind = match fault.problem {
            _ if fault.halts => Kind::Halts,
            Problem::NoSuchTool(_) | Problem::NoExtruder => Kind::Tool,
            Problem::PartIsOff(_) => Kind::Off,
            Problem::Needs(..) => Kind::Unknown,
            _ => Kind::Word,
        };
        let failure = failure_of(self.preflight.texts, self.preflight.config, fault, true);
        self.failed(kind, failure)
    }

    // --- lines ---

    /// Reads a whole line.
    pub async fn line(&mut self, line: &[u8], here: Place) {
        let text = line.trim_ascii_start();
        if text.first() == Some(&b'%')
            && self.preflight.within.is_none()
            && core::mem::replace(&mut self.preflight.has_begun, true)
        {
            // The second `%` ends the program (NIST RS-274/NGC, 3.3).
            self.preflight.has_ended = true;
            return;
        }
        let passes_over = self.preflight.program.flow().passes_over();
        match decoder_expecting(line).decode(line) {
            Ok(Line::Flow(_)) if self.is_left_in_macros("O words") => {}
            Ok(Line::Flow(flow)) => match self.preflight.program.flow_line(&flow, here, self.after) {
                Ok(next) => {
                    self.next = next;
                    let _said = self.what_follows().await;
                }
                Err(fault) => {
                    self.say(Kind::Flow, short(format_args!("{fault}")));
                }
            },
            _ if passes_over => {}
            Ok(Line::Code(blocks)) => self.codes(blocks).await,
            Ok(Line::Extended(command)) => self.named(&command).await,
            Ok(Line::Blank) => {}
            Ok(Line::Console(text)) => self.console(text).await,
            Err(Refusal::Resend { .. }) => {
                self.say(Kind::Damage, short(format_args!("checksum does not match")));
            }
            Err(Refusal::Syntax(error)) => {
                self.unreadable(error);
            }
        }
    }

    /// Reports subroutines and loops that are still open.
    pub fn end_of_file(&mut self) {
        if let (Err(fault), false) = (self.preflight.program.end_file(), self.preflight.has_ended) {
            self.say(Kind::Flow, short(format_args!("the file ends, and {fault}")));
        }
    }

    /// Reads a command of the console, or one by name in lower case.
    async fn console(&mut self, text: &str) {
        let command = Extended::new(text);
        if program::commands::find(command.name()).is_none() {
            if program::extended::find(command.name()).is_some() {
                return self.named(&command).await;
            }
            if !matches!(self.calls(MacroCall::Named(command)).await, Ok(false)) {
                return;
            }
        }
        if let Err(what) = self.listener.commands(text) {
            self.say(Kind::Unknown, what);
        }
    }

    /// Reads a command by name.
    async fn named(&mut self, command: &Extended<'_>) {
        if !matches!(self.calls(MacroCall::Named(*command)).await, Ok(false)) {
            return;
        }
        let mut codes = CodeLine::new();
        if command.is("SAVE_GCODE_STATE") || command.is("RESTORE_GCODE_STATE") {
            for step in 0..3 {
                self.keep_modes(command, step, &mut codes);
                self.codes(Blocks::new(codes.as_bytes())).await;
                codes.clear();
            }
            return;
        }
        let names = PartNames { config: self.preflight.config, dialect: self.preflight.dialect };
        match program::extended::translate(command, &names, &mut codes) {
            Ok(program::extended::Asked::Codes) => self.codes(Blocks::new(codes.as_bytes())).await,
            Ok(_) => {}
            Err(fault) => {
                self.say(Kind::Unknown, short(format_args!("{} {fault}", command.name())));
            }
        }
    }

    /// Whether a line or a code calls a macro, whose lines come next.
    async fn calls(&mut self, call: MacroCall<'_>) -> Result<bool, Said> {
        if self.preflight.config.macros.file.is_empty() {
            return Ok(false);
        }
        let called = loop {
            match self.listener.called(call) {
                Some(called) => break called,
                None => end_turn().await,
            }
        };
        match called {
            Called::Nothing => return Ok(false),
            Called::Macro { is_sure } => {
                self.preflight.calls_macros = true;
                // The macro may leave out what it will not leave out then.
                self.preflight.guesses |= !is_sure;
            }
            Called::Refused(failure) => return Err(self.failed(Kind::Macro, failure)),
            Called::Unknown(failure) => self.is_not_looked_into(&call.name(), failure),
        }
        self.has_called = true;
        Ok(true)
    }

    /// Remarks that it is not known what a macro does. Most home and heat: what follows is not held against
    /// that.
    pub(super) fn is_not_looked_into(&mut self, what: &str, failure: Failure) {
        let preflight = &mut *self.preflight;
        preflight.homed = preflight.homed.or(preflight.can_home);
        (preflight.guesses, preflight.may_be_hot) = (true, true);
        let why = preflight.texts.copy_of(failure);
        self.say(Kind::Unforeseen, short(format_args!("{what} could not be looked into: {why}")));
    }

    /// Whether a line of a macro stands there that is not looked at in macros, and remarks that.
    pub fn is_left_in_macros(&mut self, what: &str) -> bool {
        if self.preflight.within.is_some() {
            self.say(Kind::Unforeseen, short(format_args!("{what} in macros are not looked at")));
        }
        self.preflight.within.is_some()
    }

    /// Keeps modes or comes back to them, in three steps: the place, the extruder, the modes. The codes of a
    /// step are written into an empty line.
    fn keep_modes(&mut self, command: &Extended<'_>, step: u8, codes: &mut CodeLine) {
        let name = command.get("NAME").filter(|name| !name.is_empty()).unwrap_or("default");
        let now = self.preflight.modes_as(name);
        if command.is("SAVE_GCODE_STATE") {
            return self.preflight.kept.keep(now);
        }
        let Some(Kept { modes, at: [x, y, z], extruder, .. }) = self.preflight.kept.find(now.name) else {
            if step == 0 {
                self.say(Kind::Unforeseen, short(format_args!("RESTORE_GCODE_STATE: no state is kept here as {name}")));
            }
            return;
        };
        let number = |key: &str| command.get(key).and_then(|text| gcode::read_f64(text.trim()));
        // There is room for either.
        let _ = match step {
            0 if number("MOVE").is_some_and(|moves| moves != 0.0) => {
                let rate = number("MOVE_SPEED").unwrap_or(self.preflight.program.modal().feed_rate.0) * 60.0;
                write!(codes, "G21 G90 G53 G1 X{x} Y{y} Z{z} F{rate}")
            }
            1 if now.extruder != extruder => write!(codes, "G92 E{extruder}"),
            2 => {
                program::come_back_to_modes(self.preflight.program, &modes);
                Ok(())
            }
            _ => Ok(()),
        };
    }

    /// Reads the codes of a line; those behind a fault are left.
    async fn codes(&mut self, blocks: Blocks<'_>) {
        let read = match self.in_order(&blocks).await {
            Some(read) => read,
            None => self.as_written(blocks).await,
        };
        let ended = read.is_ok().then(|| self.preflight.program.end_line());
        match ended {
            Some(Ok(())) => {}
            Some(Err(fault)) => {
                self.wrong(&fault);
            }
            None => self.preflight.program.drop_line(),
        }
    }

    async fn as_written(&mut self, mut blocks: Blocks<'_>) -> Result<(), Said> {
        blocks.set_stops_say(self.preflight.dialect.stops_say());
        let mut block = Block::new(None, 0);
        loop {
            let read = blocks.read(&mut block, self.preflight.program);
            self.remark(blocks.take_remark());
            if !read.map_err(|error| self.unreadable(error))? {
                return Ok(());
            }
            self.block(&block).await?;
            if self.has_called {
                let has_more = blocks.read(&mut block, self.preflight.program).unwrap_or(true);
                return self.macro_comes(has_more);
            }
        }
    }

    /// Reads a line whose codes have an order of their own; `None` when it is not read so.
    async fn in_order(&mut self, blocks: &Blocks<'_>) -> Option<Result<(), Said>> {
        if !self.preflight.dialect.orders_lines() {
            return None;
        }
        let (mut ahead, mut whole) = (blocks.clone(), WholeLine::default());
        let read = ahead.read_whole(&mut whole, self.preflight.program);
        let Some(parts) = read.ok().and_then(|()| program::arrange(&whole)) else {
            self.preflight.program.drop_line();
            return None;
        };
        self.remark(ahead.take_remark());
        let parts = match parts {
            Ok(parts) => parts,
            Err(fault) => return Some(Err(self.wrong(&fault))),
        };
        for (place, part) in parts.iter().enumerate() {
            let block = whole.part(part.code, part.letters).clone();
            if let Err(said) = self.block(&block).await {
                return Some(Err(said));
            }
            if self.has_called {
                return Some(self.macro_comes(place + 1 < parts.len()));
            }
        }
        Some(Ok(()))
    }

    /// Leaves the rest of a line whose code has called a macro: that comes first.
    fn macro_comes(&mut self, has_more: bool) -> Result<(), Said> {
        if has_more {
            self.preflight.guesses = true;
            return Err(self.say(Kind::Unforeseen, short(format_args!("codes behind a macro's are not looked at"))));
        }
        Ok(())
    }

    fn remark(&mut self, comment: Option<&[u8]>) {
        if let Some(remark) = comment.and_then(Remark::read) {
            self.listener.remarks(remark, self.preflight.program);
        }
    }

    /// Reports a line that cannot be read: a slip, or bytes that no text has.
    fn unreadable(&mut self, error: SyntaxError) -> Said {
        let kind = if error.problem.is_damage() { Kind::Damage } else { Kind::Text };
        self.say(kind, short(format_args!("{error}")))
    }

    async fn block(&mut self, block: &Block<'_>) -> Result<(), Said> {
        let dialect: Dialect = self.preflight.dialect;
        if block.code.is_some_and(|code| self.preflight.taken.may_have(code))
            && self.calls(MacroCall::Coded(block)).await?
        {
            return Ok(());
        }
        let Some(row) = self.preflight.program.row(block, dialect) else { return self.not_done(None, block) };
        if let Some(part) = row.part
            && let Err(failure) = needs(self.preflight.texts, self.preflight.config, part, true)
        {
            return Err(self.failed(Kind::Off, failure));
        }
        if cannot_level(self.preflight.config, row) && !self.preflight.reads_settings {
            return self.goes_on_unleveled(row);
        }
        let facts = self.preflight.facts();
        let meaning = match self.preflight.program.run(block, row, facts, dialect) {
            Ok(meaning) => meaning,
            Err(fault) => {
                return Err(self.wrong(&fault));
            }
        };
        let is_rapid = self.preflight.program.modal().motion == MotionMode::Rapid;
        self.preflight.asks_of_rapids |= is_rapid && block.has('F');
        if let Some((kind, text)) = power::of_rapid(self.preflight, row, block) {
            self.say(kind, text);
        }
        if matches!(meaning, Meaning::PassedOver | Meaning::Unknown) {
            self.effects()?;
            return self.not_done(Some(row), block);
        }
        self.effects()?;
        if let Meaning::Action(action) = meaning {
            self.action(&action).await?;
        }
        self.actions().await
    }

    fn effects(&mut self) -> Result<(), Said> {
        while let Some(effect) = self.preflight.program.next_effect() {
            if self.listener.acts_on_the_way(effect) {
                self.effect(effect)?;
            }
        }
        Ok(())
    }

    async fn actions(&mut self) -> Result<(), Said> {
        while let Some(action) = self.preflight.program.next_action() {
            self.action(&action).await?;
        }
        Ok(())
    }

    /// Carries out the effects and actions that are left at the end of a subroutine (M73).
    async fn what_follows(&mut self) -> Result<(), Said> {
        self.effects()?;
        self.actions().await
    }

    /// Reports a code that levels the bed, which this machine cannot.
    fn goes_on_unleveled(&mut self, row: &CodeInfo) -> Result<(), Said> {
        let code = row.code;
        if self.preflight.config.player.unleveled_pauses {
            let text = format_args!("{code}: there is no probe and no leveling here");
            return Err(self.say(Kind::Unknown, short(text)));
        }
        let text = format_args!("{code}: there is no probe and no leveling here, the job goes on without");
        self.say(Kind::Unleveled, short(text));
        Ok(())
    }

    /// Reports a code that is not carried out.
    fn not_done(&mut self, row: Option<&CodeInfo>, block: &Block<'_>) -> Result<(), Said> {
        let Some(code) = block.code else { return Ok(()) };
        if !self.listener.leaves_out(row, code).map_err(|what| self.say(Kind::Unknown, what))? {
            return Ok(());
        }
        if let Some(failure) = makes_another_part(self.preflight.texts, row, block) {
            return Err(self.failed(Kind::Unknown, failure));
        }
        self.say(Kind::PassedOver, short(format_args!("{code} is passed over: the part is the same without")));
        Ok(())
    }
}

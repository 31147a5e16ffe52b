//! Text to machine description, line by line.
//!
//! The format is Smoothieware's: `[section]`, `key = value`, `name.key = value`, `#` comments. Text that
//! Smoothieware ignores silently (an unknown key, a word that is no number, a line without `=`) is reported
//! here.

mod settings;

use crate::diagnostic::{Severity, Sink};
use crate::ledger::{Ledger, Span};
use crate::machine::{BoardId, MachineConfig};
use crate::module::Module;
use crate::report::{At, Reporter, Summary};
use crate::schema::{Section, section};
use crate::suggest;
use crate::{check, derive};
use heapless::Vec;

/// Memory that reading takes, in bytes: fixed, whatever the file. The description itself, and while reading
/// what is remembered of the file for the checks.
pub const READING_BYTES: usize = core::mem::size_of::<MachineConfig>() + core::mem::size_of::<Reader<'_>>();

/// Longest line without its comment. Comments may be of any length.
const MAX_LINE: usize = 250;
/// Largest file, in lines; line numbers are kept in 16 bits.
const MAX_LINES: u32 = 65_535;
const BYTE_ORDER_MARK: &[u8] = &[0xEF, 0xBB, 0xBF];

/// Reads a configuration fed in pieces. See [`parse`] for a whole text.
pub struct Reader<'a> {
    config: &'a mut MachineConfig,
    board: BoardId,
    ledger: Ledger,
    reporter: Reporter<'a>,
    line: Vec<u8, MAX_LINE>,
    number: u32,
    state: LineState,
    current: Current,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum LineState {
    Text,
    Comment,
    TooLong,
}

/// The section that lines now belong to.
#[derive(Clone, Copy)]
enum Current {
    /// No section header read yet.
    Nothing,
    /// A section the schema does not have; its header has been reported, so its lines are not.
    Unknown,
    Known(usize, &'static Section),
}

/// Never inlined: the defaults are on the stack meanwhile, and are large.
#[inline(never)]
fn reset(config: &mut MachineConfig) {
    *config = MachineConfig::default();
}

impl<'a> Reader<'a> {
    /// Starts reading into `config`, which is overwritten with the board's defaults.
    pub fn new(config: &'a mut MachineConfig, board: BoardId, sink: &'a mut dyn Sink) -> Self {
        reset(config);
        let mut reader = Self {
            config,
            board,
            ledger: Ledger::default(),
            reporter: Reporter::new(sink),
            line: Vec::new(),
            number: 0,
            state: LineState::Text,
            current: Current::Nothing,
        };
        reader.fill_in_defaults();
        reader
    }

    /// Parses the next bytes of the file, in pieces of any size.
    pub fn feed(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match (byte, self.state) {
                (b'\n', _) => self.end_line(),
                (b'#', LineState::Text) => self.state = LineState::Comment,
                (_, LineState::Text) if self.line.push(byte).is_err() => self.state = LineState::TooLong,
                _ => {}
            }
        }
    }

    /// Ends the file: checks the whole, fills in derived defaults, and returns the summary.
    pub fn finish(mut self) -> Summary {
        if !self.line.is_empty() || self.state != LineState::Text {
            self.end_line();
        }
        self.assume_drivers();
        derive::fill_in(self.config, &self.ledger);
        check::check(self.config, &self.ledger, &mut self.reporter);
        let summary = self.reporter.summary;
        self.config.off = self.reporter.into_off();
        derive::switch_off(self.config, &self.ledger);
        derive::keep_enabled(self.config);
        summary
    }

    fn end_line(&mut self) {
        self.number += 1;
        let state = core::mem::replace(&mut self.state, LineState::Text);
        let line = core::mem::take(&mut self.line);
        let whole = Span { line: self.line_number(), column: 1, length: 1 };
        if self.number == MAX_LINES {
            let reason = format_args!("the file has more than {MAX_LINES} lines");
            self.reporter.report(
                Severity::Fatal,
                At::new(whole, "", Module::MACHINE),
                reason,
                format_args!("shorten it"),
            );
        } else if let Current::Unknown = self.current
            && line.first() != Some(&b'[')
        {
            // The section's header has been reported.
        } else if state == LineState::TooLong {
            let reason = format_args!("the line has more than {MAX_LINE} characters");
            let at = At::new(whole, "", self.whole_section());
            self.reporter.report(Severity::Error, at, reason, format_args!("split or shorten it"));
        } else if self.number < MAX_LINES {
            match core::str::from_utf8(self.without_mark(&line)) {
                Ok(text) => self.read_line(text),
                Err(error) => {
                    let span = Span { column: column(error.valid_up_to()), ..whole };
                    let at = At::new(span, "", self.whole_section());
                    let reason = format_args!("the text is not UTF-8 outside comments");
                    self.reporter.report(Severity::Error, at, reason, format_args!("save the file as UTF-8"));
                }
            }
        }
    }

    /// Removes the byte order mark that some editors put before the first line.
    fn without_mark<'l>(&self, line: &'l [u8]) -> &'l [u8] {
        if self.number == 1 { line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line) } else { line }
    }

    fn line_number(&self) -> u16 {
        u16::try_from(self.number).unwrap_or(u16::MAX)
    }

    /// Returns the span of a part of the present line.
    fn span(&self, line: &str, part: &str) -> Span {
        // `part` is a slice of `line`, so the difference of their addresses is its offset.
        let offset = (part.as_ptr() as usize).saturating_sub(line.as_ptr() as usize);
        let length = u8::try_from(part.len().max(1)).unwrap_or(u8::MAX);
        Span { line: self.line_number(), column: column(offset), length }
    }

    fn read_line(&mut self, line: &str) {
        let text = line.trim();
        if text.is_empty() {
        } else if let Some(header) = text.strip_prefix('[') {
            self.open_section(line, header);
        } else if let Some((key, value)) = text.split_once('=') {
            self.read_setting(line, key.trim(), value.trim());
        } else {
            let span = self.span(line, text);
            let fix = match text.as_bytes().first() {
                Some(b';') => "comments begin with #",
                _ => "write key = value, or put # before a comment",
            };
            let reason = format_args!("the line has no =");
            // `fan.enable true`: the name says whose line it is.
            let module = match (self.current, text.split_once('.')) {
                (Current::Known(_, section), Some((name, _))) => Module::new(section, name),
                _ => self.whole_section(),
            };
            self.reporter.report(Severity::Error, At::new(span, "", module), reason, format_args!("{fix}"));
        }
    }

    /// Returns the part of the machine that an unreadable line might have been about.
    const fn whole_section(&self) -> Module<'static> {
        match self.current {
            Current::Known(_, section) => Module::whole(section),
            Current::Nothing | Current::Unknown => Module::MACHINE,
        }
    }

    fn open_section(&mut self, line: &str, header: &str) {
        self.current = Current::Unknown;
        let Some((name, _)) = header.split_once(']') else {
            let span = self.span(line, header);
            let fix = format_args!("write [{}]", header.trim());
            let meant = section(header.trim()).or_else(|| section(suggest::section(header)?));
            let at = At::new(span, "", meant.map_or(Module::MACHINE, |(_, meant)| Module::whole(meant)));
            return self.reporter.report(Severity::Error, at, format_args!("the section name has no ]"), fix);
        };
        let span = self.span(line, name);
        if let Some((index, found)) = section(name) {
            if self.ledger.sections & (1 << index) != 0 {
                let reason =
                    format_args!("[{name}] is here again; Smoothieware ignores this second part, Velvet reads it");
                let at = At::new(span, "", Module::whole(found));
                self.reporter.report(Severity::Warning, at, reason, format_args!("move its lines to the first one"));
            }
            self.ledger.sections |= 1 << index;
            self.current = Current::Known(index, found);
            return;
        }
        let reason = format_args!("there is no section [{name}]");
        match suggest::section(name) {
            Some(meant) => {
                let module = section(meant).map_or(Module::MACHINE, |(_, meant)| Module::whole(meant));
                let fix = format_args!("did you mean [{meant}]?");
                self.reporter.report(Severity::Error, At::new(span, "", module), reason, fix);
            }
            None => {
                let at = At::new(span, "", Module::MACHINE);
                let mut warn = |fix| self.reporter.report(Severity::Warning, at, reason, fix);
                match suggest::klipper_section(name) {
                    Some(home) => warn(format_args!("it is Klipper's, and its lines are ignored: look under [{home}]")),
                    None => warn(format_args!("its lines are ignored; delete it")),
                }
            }
        }
    }
}

fn column(offset: usize) -> u8 {
    u8::try_from(offset + 1).unwrap_or(u8::MAX)
}

/// Reads a whole configuration. The result is only to be used when the summary [is
/// usable](Summary::is_usable).
pub fn parse(text: &[u8], board: BoardId, sink: &mut dyn Sink) -> (MachineConfig, Summary) {
    let mut config = MachineConfig::default();
    let mut reader = Reader::new(&mut config, board, sink);
    reader.feed(text);
    let summary = reader.finish();
    (config, summary)
}

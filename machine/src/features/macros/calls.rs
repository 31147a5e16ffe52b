//! Calls of macros: rendered whole, then carried out line by line.

use core::fmt::Write as _;
use core::mem::take;

use base::Ports;
use base::failure::{Answer, Failure, Outcome};
use base::own_frame::apart;
use base::sessions::{LineBytes, Recipient};
use gcode::{Block, Code, Extended};
use heapless::String;
use printer_cfg::{Call, Section, Trouble};
use program::Dialect;

use super::hands::{MacroHands, Seen, refused};
use super::homing;
use super::look::{Acts, Look, Parameters};
use crate::features::state::Step;
use crate::features::viewers;
use crate::machine::Machine;
use crate::machine::frames::{Frame, Then};
use crate::machine::source::{Origin, Source};

/// A line that calls a macro.
type Text = String<{ gcode::MAX_LINE_LENGTH }>;

/// Frame that a macro goes on by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shares {
    /// That of its caller, which has nothing else to do in its line.
    Yes,
    /// One of its own.
    No,
    /// None: a probe's script is carried out on the spot. The first of it.
    First,
    /// None: a further macro of the script.
    Further,
}

impl Shares {
    const fn has_frame(self) -> bool {
        matches!(self, Self::Yes | Self::No)
    }
}

/// Runs a command by name: a macro, or what a macro has replaced. None: it is neither.
pub(super) fn run_named<'c>(
    hands: &mut impl MacroHands<'c>,
    command: &Extended<'_>,
    source: Source,
) -> Option<Outcome> {
    if !source.looks_up_names() {
        return None;
    }
    let store = &hands.macros().memory.store;
    let (named, renamed) = (store.named("gcode_macro", command.name()), store.renamed(command.name()));
    if let Some(section) = named {
        return Some(call(hands, section, "gcode", &Parameters::Named(*command), source.to, Shares::Yes));
    }
    Some(call_replaced(hands, renamed?, command.rest(), source.to, Shares::Yes))
}

/// Runs a code that a macro has taken, or under whose name goes what a macro has taken.
pub(super) fn run_code<'c>(hands: &mut impl MacroHands<'c>, block: &Block<'_>, source: Source) -> Option<Outcome> {
    let code = block.code?;
    let mut name = String::<12>::new();
    write!(name, "{code}").ok()?;
    let store = &hands.macros().memory.store;
    let (named, renamed) = (store.named("gcode_macro", &name), store.renamed(&name));
    let mut line = Text::new();
    if write!(line, "{block}").is_err() {
        return Some(Err(Failure::refused(&"the line is too long")));
    }
    let words = line.get(name.len()..).unwrap_or("").trim_start();
    match (named, renamed) {
        (Some(section), _) => Some(call(hands, section, "gcode", &Parameters::Coded(words), source.to, Shares::No)),
        (None, Some(section)) => Some(call_replaced(hands, section, words, source.to, Shares::No)),
        (None, None) if code == Code::g(28) => homing::begin(hands, words, source.to),
        (None, None) => None,
    }
}

/// Renders a macro, and has its lines carried out next.
///
/// # Errors
/// When the macro cannot be rendered: then nothing of it is carried out.
pub(super) fn call<'c>(
    hands: &mut impl MacroHands<'c>,
    section: Section,
    key: &str,
    parameters: &Parameters<'_>,
    to: Recipient,
    shares: Shares,
) -> Outcome {
    begin(hands, section, shares)?;
    if hands.macros().memory.store.is_called(section) {
        let name = name_of(hands, section)?;
        return Err(hands
            .world()
            .texts
            .refused(format_args!("{name}: a macro that is under way is called recursively")));
    }
    let memory = &mut hands.macros().memory;
    let (code, lines) = (take(&mut memory.code), take(&mut memory.lines));
    let from = memory.store.lines_end();
    let room = lines.get_mut(from..).unwrap_or(&mut []);
    let rendered = render(hands, (section, key), parameters, (code, room), Acts::AtOnce);
    let memory = &mut hands.macros().memory;
    (memory.code, memory.lines) = (code, lines);
    if rendered.is_err() {
        // Nobody knows how far it has come.
        memory.store.looks().lose();
    }
    let (length, _) = rendered.map_err(|(failure, _)| failure)?;
    start(hands, (section, length, to, false), shares)
}

/// Has what a macro has replaced carried out with these words.
fn call_replaced<'c>(
    hands: &mut impl MacroHands<'c>,
    section: Section,
    words: &str,
    to: Recipient,
    shares: Shares,
) -> Outcome {
    let name = name_of(hands, section)?;
    if name.eq_ignore_ascii_case("G28")
        && let Some(outcome) = homing::begin(hands, words, to)
    {
        return outcome;
    }
    run_text(hands, section, [&name, words], to, shares)
}

/// Has lines carried out that are no macro: two texts with a blank between them.
pub(super) fn run_text<'c>(
    hands: &mut impl MacroHands<'c>,
    section: Section,
    [first, second]: [&str; 2],
    to: Recipient,
    shares: Shares,
) -> Outcome {
    begin(hands, section, shares)?;
    let memory = &mut hands.macros().memory;
    let from = memory.store.lines_end();
    let (length, room) = (first.len() + 1 + second.len(), memory.lines.get_mut(from..).unwrap_or(&mut []));
    if room.len() < length {
        return Err(Failure::refused(&"the macros under way have too many lines"));
    }
    let text = first.bytes().chain([b' ']).chain(second.bytes());
    room.iter_mut().zip(text).for_each(|(place, byte)| *place = byte);
    start(hands, (section, length, to, true), shares)
}

/// Makes sure that one more macro can be called.
fn begin<'c>(hands: &mut impl MacroHands<'c>, section: Section, shares: Shares) -> Result<(), Failure> {
    if shares.has_frame() {
        forget_dropped(hands);
    }
    if hands.macros().memory.store.may_call() {
        return Ok(());
    }
    let name = name_of(hands, section)?;
    Err(hands.world().texts.refused(format_args!("{name}: macros call each other more than 12 deep")))
}

/// Ends macros whose frames were dropped without a word.
pub(super) fn forget_dropped<'c>(hands: &mut impl MacroHands<'c>) {
    if !hands.frames().steps().any(|step| matches!(step, Step::Macros { .. })) {
        hands.macros().memory.store.end_calls(0);
    }
}

/// Adds a macro whose lines have been written.
fn start<'c>(
    hands: &mut impl MacroHands<'c>,
    (section, length, to, is_plain): (Section, usize, Recipient, bool),
    shares: Shares,
) -> Outcome {
    let above = hands.macros().memory.store.calls() as u8;
    let is_caller_next = matches!(hands.frames().next_step(), Some(Step::Macros { .. }));
    // A macro may share the frame of its caller, which has nothing else to do in its line.
    let has_step = is_caller_next && shares == Shares::Yes || !shares.has_frame();
    if !has_step && !hands.frames().push(Frame::Then(Then::Step(Step::Macros { above }))) {
        return Err(Failure::refused(&"scripts and macros start each other without end"));
    }
    hands.macros().memory.store.call(section, length, to, is_plain);
    Ok(Answer::Ok)
}

/// Length of the lines of a rendered macro, bytes, and whether they depend on no state of the machine.
pub(super) type Rendered = (usize, bool);

/// Reason why a macro was not rendered, and whether that is so in any state of the machine.
pub(super) type NotRendered = (Failure, bool);

/// Renders a macro.
///
/// # Errors
/// When the template is wrong, or the macro cannot be rendered as the machine is now.
pub(super) fn render<'c>(
    hands: &mut impl MacroHands<'c>,
    (section, key): (Section, &str),
    parameters: &Parameters<'_>,
    (code, lines): (&mut [u8], &mut [u8]),
    acts: Acts,
) -> Result<Rendered, NotRendered> {
    let Seen { macros, world, .. } = hands.seen();
    let compiled = macros.memory.store.read((section, key), &mut world.ports, |text| ::macros::compile(text, code));
    let program = match compiled {
        Ok(Some(Ok(program))) => program,
        Ok(Some(Err(error))) => return Err((placed(hands, section, key, &error), true)),
        Ok(None) => {
            let name = name_of(hands, section).map_err(|failure| (failure, false))?;
            return Err((hands.world().texts.refused(format_args!("[{name}] has no option {key}")), true));
        }
        Err(trouble) => return Err((refused(hands, &trouble), false)),
    };
    let now = base::ports::Clock::now(&hands.world().ports);
    let snapshot = viewers::snapshot(hands, now);
    let mut look = Look::new(hands, section, parameters, &snapshot, acts);
    let rendered = program.render(code, lines, &mut look);
    let (trouble, is_sure) = (look.take_trouble(), !look.depends_on_state);
    match rendered {
        _ if hands.is_halted() => Err((Failure::HALTED, false)),
        _ if let Some(failure) = trouble => Err((failure, false)),
        Ok(length) => Ok((length, is_sure)),
        Err(error) => Err((placed(hands, section, key, &error), false)),
    }
}

/// Makes a refusal of an error in a macro, with its place in the file.
#[cold]
fn placed<'c>(hands: &mut impl MacroHands<'c>, section: Section, key: &str, error: &::macros::Error) -> Failure {
    let Seen { macros, world, .. } = hands.seen();
    let (path, line, indent) = macros.memory.store.line_of(section, key, error.line, &mut world.ports);
    let file = path.rsplit_once('/').map_or(path, |(_, name)| name);
    let column = error.column.saturating_add(indent);
    let (between, detail) = if error.detail.is_empty() { ("", "") } else { (": ", error.detail.as_str()) };
    world.texts.refused(format_args!("{file} line {line} column {column}{between}{detail}: {}", error.words))
}

/// Returns a macro's name.
pub(super) fn name_of<'c>(hands: &mut impl MacroHands<'c>, section: Section) -> Result<printer_cfg::Name, Failure> {
    let Seen { macros, world, .. } = hands.seen();
    let name: Result<_, Trouble> = macros.memory.store.name(section, &mut world.ports);
    name.map_err(|trouble| refused(hands, &trouble))
}

/// Carries out the next line of the innermost macro, as long as there are more than so many.
///
/// # Errors
/// When the line is too long.
pub(crate) fn go_on<'c>(hands: &mut impl MacroHands<'c>, above: u8) -> Result<(), Failure> {
    let mut line = LineBytes::new();
    let Some(call) = apart(|| take_line(hands, above, &mut line))? else { return Ok(()) };
    // The frame that was taken left room for this one.
    let _ = hands.frames().push(Frame::Then(Then::Step(Step::Macros { above })));
    let to = if hands.frames().are_answered() { Recipient::Nobody } else { call.to };
    hands.run_line(&line, Source { origin: Origin::Macro(!call.is_plain), to, dialect: Dialect::Klipper });
    Ok(())
}

/// Takes the next line of the innermost macro. None: there are no more macros than so many.
///
/// # Errors
/// When the line is too long.
pub(super) fn take_line<'c>(
    hands: &mut impl MacroHands<'c>,
    above: u8,
    line: &mut LineBytes,
) -> Result<Option<Call>, Failure> {
    let memory = &mut hands.macros().memory;
    let range = loop {
        if memory.store.calls() <= usize::from(above) {
            return Ok(None);
        }
        match memory.store.take_line(memory.lines) {
            Some(range) => break range,
            None => memory.store.end_calls(memory.store.calls() - 1),
        }
    };
    let bytes = memory.lines.get(range).unwrap_or(&[]);
    let is_whole = line.extend_from_slice(bytes).is_ok();
    let Some(call) = memory.store.innermost().filter(|_| !is_whole) else { return Ok(memory.store.innermost()) };
    let name = name_of(hands, call.section)?;
    Err(hands.world().texts.refused(format_args!("{name}: a line has more than 255 bytes")))
}

/// Ends macros that cannot go on.
pub(crate) fn give_up<P: Ports>(machine: &mut Machine<'_, P>, above: u8, why: Failure) {
    let store = &mut machine.features.macros.memory.store;
    let ended = store.innermost().filter(|call| why.is_refusal() && !call.is_plain);
    store.end_calls(usize::from(above));
    if let Some(call) = ended
        && let Ok(name) = store.name(call.section, &mut machine.world.ports)
    {
        machine.announce(format_args!("// the macro {name} has ended at a line that was not carried out\n"));
    }
}

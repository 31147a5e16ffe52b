//! Reads the configuration with the macros: at boot, and by `macros reload`; lists them.

use base::failure::{Answer, Failure, Outcome};
use base::paths;
use base::ports::Clock as _;
use base::sessions::Recipient;
use base::taken_codes::TakenCodes;
use printer_cfg::{Loaded, Section, Use};
use units::Micros;

use super::hands::{MacroHands, Seen, refused};

/// Reads the macros at boot, where there are some.
pub(super) fn at_start<'c>(hands: &mut impl MacroHands<'c>) {
    if !hands.world().config.macros.file.is_empty() {
        let loaded = read(hands);
        if let Some(trouble) = loaded.trouble {
            let failure = refused(hands, &trouble);
            let text = hands.world().texts.copy_of(failure);
            hands.announce(format_args!("WARNING: macros: {text}\n"));
        }
    }
}

/// Reads the configuration anew.
fn read<'c>(hands: &mut impl MacroHands<'c>) -> Loaded {
    let Seen { macros, world, .. } = hands.seen();
    let path = paths::absolute(paths::CARD, &world.config.macros.file);
    let now = world.ports.now();
    macros.memory.variables.clear();
    let loaded = macros.memory.store.reload(&mut world.ports, &path, now.0);
    (macros.idle_since, macros.is_idle, macros.readings) = (now, false, macros.readings.wrapping_add(1));
    let timeout = idle_timeout(hands);
    hands.macros().idle_timeout = timeout;
    hands.take_codes(match loaded.codes {
        [false, false] => TakenCodes::None,
        [false, true] => TakenCodes::ButMoves,
        [true, _] => TakenCodes::Any,
    });
    loaded
}

/// Returns the time of `[idle_timeout]`, where there is such a section.
fn idle_timeout<'c>(hands: &mut impl MacroHands<'c>) -> Option<Micros> {
    let Seen { macros, world, .. } = hands.seen();
    let memory = &mut macros.memory;
    let section = memory.store.section("idle_timeout")?;
    let read = memory.store.read((section, "timeout"), &mut world.ports, |text| memory.text.fill(text));
    let written = read.ok().flatten().and_then(|_| gcode::read_f64(memory.text.text()?));
    let seconds = written.unwrap_or(600.0);
    (seconds > 0.0).then_some(Micros((seconds * 1e6) as u64))
}

/// Runs `macros`, which lists them, and `macros reload`.
pub(crate) fn run<'c>(hands: &mut impl MacroHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    if hands.world().config.macros.file.is_empty() {
        return Err(Failure::refused(&"there are no macros: [macros] file in config.ini names their file"));
    }
    match arguments {
        "reload" => reload(hands, to),
        "" => list(hands, to),
        _ => Err(Failure::refused(&"macros lists them, macros reload reads their file anew")),
    }
}

fn reload<'c>(hands: &mut impl MacroHands<'c>, to: Recipient) -> Outcome {
    if hands.frames().steps().any(|step| matches!(step, crate::features::state::Step::Macros { .. })) {
        return Err(Failure::refused(&"macros are under way: reload when they have ended"));
    }
    let loaded = read(hands);
    hands.say(to, format_args!("{} macros in {} sections\n", loaded.macros, loaded.sections));
    match loaded.trouble {
        Some(trouble) => Err(refused(hands, &trouble)),
        None => Ok(Answer::Ok),
    }
}

/// Says the names of all macros with what they say of themselves.
fn list<'c>(hands: &mut impl MacroHands<'c>, to: Recipient) -> Outcome {
    for place in 0..hands.macros().memory.store.sections() {
        let section = Section(place as u16);
        let Seen { macros, world, .. } = hands.seen();
        let memory = &mut macros.memory;
        if !memory.store.has(section, Use::Macro) {
            continue;
        }
        let name = match memory.store.name(section, &mut world.ports) {
            Ok(name) => name,
            Err(trouble) => return Err(refused(hands, &trouble)),
        };
        memory.text.fill(core::iter::empty());
        let _ = memory.store.read((section, "description"), &mut world.ports, |text| memory.text.fill(text));
        let about = memory.text.text().unwrap_or("");
        let between = if about.is_empty() { "" } else { " - " };
        world.say(to, format_args!("{name}{between}{about}\n"));
        hands.wait_until_heard(to);
    }
    Ok(Answer::Ok)
}

//! Files that a program writes: see [`jobs::files::logs`].

use core::fmt::Write as _;

use base::failure::{Failure, Texts};
use base::{Ports, World};
use gcode::{Parameter, Parameters as _};
use jobs::files::Files;
use jobs::files::logs::{LogFlaw, Logs};
use program::{Interpreter, Remark};

/// Characters of a line of a log; longer lines are cut.
const LINE: usize = 256;

/// Carries out `(LOGOPEN, ...)`, `(LOG, ...)` and the others.
///
/// # Errors
/// The fault of the file, by its name.
pub(crate) fn carry_out<P: Ports>(
    logs: &mut Logs,
    files: &Files,
    program: &Interpreter,
    world: &mut World<'_, P>,
    remark: &Remark<'_>,
) -> Result<(), Failure> {
    let World { ports, texts, .. } = world;
    match *remark {
        Remark::OpenLog { name, appends } => {
            logs.text.open(&files.absolute(name), appends, ports).map_err(|flaw| named(texts, name, flaw))
        }
        Remark::OpenProbe(name) => {
            logs.contacts.open(&files.absolute(name), false, ports).map_err(|flaw| named(texts, name, flaw))
        }
        Remark::Log(text) if logs.text.is_open() => {
            let mut line = heapless::String::<LINE>::new();
            // Text that does not fit is cut.
            let _ = program::write_values(program, text, &mut line);
            logs.text.write_line(&line, ports).map_err(|flaw| named(texts, "the log file", flaw))
        }
        Remark::CloseLog => logs.text.close(ports).map_err(|flaw| named(texts, "the log file", flaw)),
        Remark::CloseProbe => logs.contacts.close(ports).map_err(|flaw| named(texts, "the file of contacts", flaw)),
        _ => Ok(()),
    }
}

fn named(texts: &Texts, name: &str, flaw: LogFlaw) -> Failure {
    texts.refused(format_args!("{name}: {}", flaw.text()))
}

/// Logs a contact that G38 has found: its X Y Z A B C U V W, as the program reads them.
pub(crate) fn contact_found<P: Ports>(logs: &mut Logs, program: &Interpreter, world: &mut World<'_, P>) {
    if !logs.contacts.is_open() {
        return;
    }
    let mut line = heapless::String::<LINE>::new();
    for number in 5_061..=5_069 {
        let value = program.get(&Parameter::Numbered(number)).unwrap_or(0.0);
        let blank = if line.is_empty() { "" } else { " " };
        // Nine numbers fit in a line.
        let _ = write!(line, "{blank}{value:.6}");
    }
    if let Err(flaw) = logs.contacts.write_line(&line, &mut world.ports) {
        world.announce(format_args!("WARNING: a contact was not written down: {}\n", flaw.text()));
    }
}

/// Closes the logs of a program that has ended, or will not go on.
pub(crate) fn close<P: Ports>(logs: &mut Logs, world: &mut World<'_, P>) {
    if let Err(flaw) = logs.close(&mut world.ports) {
        world.announce(format_args!("WARNING: what the program wrote is not all on the card: {}\n", flaw.text()));
    }
}

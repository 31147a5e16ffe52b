//! The parameters `#31` to `#5000` on the card, so that they outlast a power cycle: LinuxCNC's file of
//! parameters, a number and a value a line.

use core::fmt::Write as _;

use gcode::{Gathered, LineBuffer};
use heapless::String;

use super::Machine;
use crate::files::safe_file::{self, Draft};
use crate::ports::{OpenMode, Ports, StorageError};
use crate::wait::yield_once;

/// Where they are.
const PATH: &str = "/sd/parameters.var";

/// Reads them at boot. There need not be any.
pub(super) fn load<P: Ports>(machine: &mut Machine<'_, P>) {
    match read(machine) {
        Ok(0) | Err(StorageError::NotFound | StorageError::NoCard) => {}
        Ok(bad) => machine.announce(format_args!("WARNING: {PATH}: {bad} lines are no parameters and were left out\n")),
        Err(error) => machine.announce(format_args!("WARNING: {PATH} was not read: {}\n", error.text())),
    }
}

/// How many lines are no parameters.
fn read<P: Ports>(machine: &mut Machine<'_, P>) -> Result<u32, StorageError> {
    let Machine { ports, program, .. } = machine;
    safe_file::settle(ports, PATH)?;
    let file = ports.open(PATH, OpenMode::Read)?;
    let (mut gathering, mut chunk, mut bad) = (LineBuffer::new(), [0; 512], 0);
    let mut take = |gathered: Gathered<'_>| {
        let line = if let Gathered::Line(line) = gathered { line } else { &[] };
        let parameter = parse(line).map(|(number, value)| program.restore_parameter(number, value));
        bad += u32::from(parameter != Some(true) && !line.trim_ascii().is_empty());
    };
    let read = loop {
        match ports.read(file, &mut chunk) {
            Ok(0) => break Ok(()),
            Ok(count) => {
                let bytes = chunk.get(..count).unwrap_or(&[]);
                for byte in bytes {
                    if let Some(gathered) = gathering.push(*byte) {
                        take(gathered);
                    }
                }
            }
            Err(error) => break Err(error),
        }
    };
    if let Some(gathered) = gathering.finish() {
        take(gathered);
    }
    // It was only read: a failing close loses nothing.
    let _ = ports.close(file);
    read.map(|()| bad)
}

fn parse(line: &[u8]) -> Option<(u16, f64)> {
    let mut words = core::str::from_utf8(line).ok()?.split_ascii_whitespace();
    let (number, value) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
    words.next().is_none().then_some((number, value))
}

/// Writes them when a program has ended that has changed some. Whatever moment the power goes, the file is
/// the old one or the new one.
pub(super) async fn save<P: Ports>(machine: &mut Machine<'_, P>) {
    if !machine.program.take_parameters_changed() {
        return;
    }
    if let Err(error) = write(machine).await {
        machine.announce(format_args!("WARNING: the parameters were not saved in {PATH}: {}\n", error.text()));
    }
}

async fn write<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), StorageError> {
    let mut draft = Draft::begin(&mut machine.ports, PATH)?;
    let mut place = 0;
    while let Some((number, value)) = machine.program.parameter_at(place) {
        let mut line = String::<64>::new();
        let written = match writeln!(line, "{number}\t{value}") {
            Ok(()) => draft.write(&mut machine.ports, line.as_bytes()).map(|_| ()),
            Err(_) => Err(StorageError::Full),
        };
        if let Err(error) = written {
            draft.give_up(&mut machine.ports);
            return Err(error);
        }
        place += 1;
        machine.serve();
        yield_once().await;
    }
    draft.finish(&mut machine.ports)
}

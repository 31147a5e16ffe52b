//! Dialect of a file, by what its slicer says of it in comments.
//!
//! Cura says it in the first lines (`;FLAVOR:Marlin`); PrusaSlicer, OrcaSlicer and Slic3r name themselves
//! there, and write `; gcode_flavor = klipper` at the end of the file, among their settings. So the head is
//! read, and the end where the head names the slicer. Each step reads one chunk, so that nobody waits for it.

use base::ports::{FileHandle, Storage, StorageError};
use gcode::{Gathered, LineBuffer};
use program::Dialect;

use super::lines::{FileLines, Next};
use base::slicer::SlicerTimes;

/// Length of the head that is read, bytes.
const HEAD: u32 = 2_048;
/// Length of the end that is read, bytes: settings of newer slicers take some 40 kB.
const TAIL: u32 = 65_536;
/// Bytes read at a time: one sector.
const CHUNK: usize = 512;

/// State of the search after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing is known yet.
    Reading,
    /// The card has not brought the next chunk.
    Waiting,
    /// The dialect; `None`: the file does not say.
    Known(Option<Dialect>),
}

/// Search for the dialect of a file.
#[derive(Debug)]
pub struct Lookup {
    at: u32,
    /// Offset at which to stop, bytes.
    end: u32,
    size: u32,
    gathering: LineBuffer,
    /// Dialect of a slicer that writes its settings at the end, unless those say otherwise.
    slicer: Option<Dialect>,
    is_tail: bool,
    /// Times that the slicer has stated.
    times: SlicerTimes,
}

impl Lookup {
    /// Begins at the beginning of a file of this size.
    pub fn new(size: u32) -> Self {
        Self {
            at: 0,
            end: size.min(HEAD),
            size,
            gathering: LineBuffer::new(),
            slicer: None,
            is_tail: false,
            times: SlicerTimes::default(),
        }
    }

    /// Reads one more chunk. The file's position is undefined afterwards.
    ///
    /// # Errors
    /// When the card does not answer.
    pub fn step(&mut self, file: FileHandle, storage: &mut impl Storage) -> Result<Step, StorageError> {
        if self.at >= self.end {
            return match self.slicer {
                Some(_) if !self.is_tail => {
                    self.is_tail = true;
                    self.at = self.size.saturating_sub(TAIL);
                    self.end = self.size;
                    self.gathering = LineBuffer::new();
                    Ok(Step::Reading)
                }
                slicer => Ok(Step::Known(slicer)),
            };
        }
        storage.seek(file, self.at)?;
        if !storage.is_at_hand(file) {
            return Ok(Step::Waiting);
        }
        let mut bytes = [0; CHUNK];
        let count = storage.read(file, &mut bytes)?;
        self.at = if count == 0 { self.end } else { self.at.saturating_add(count as u32) };
        for byte in bytes.get(..count).unwrap_or(&[]) {
            if let Some(Gathered::Line(line)) = self.gathering.push(*byte) {
                self.times.read(line);
                match said_by(line) {
                    Some(Said::Dialect(dialect)) => return Ok(Step::Known(Some(dialect))),
                    Some(Said::Slicer(dialect)) => self.slicer = Some(dialect),
                    // The settings stand at the beginning.
                    Some(Said::SettingsFollow) if !self.is_tail => self.end = self.size.min(TAIL),
                    _ => {}
                }
            }
        }
        Ok(Step::Reading)
    }
}

/// Goes on with the search for the dialect of a file whose lines begin once that is known.
#[cold]
#[inline(never)]
pub(super) fn look(
    lookup: &mut Option<Lookup>,
    dialect: &mut Option<Dialect>,
    times: &mut SlicerTimes,
    lines: &mut FileLines,
    storage: &mut impl Storage,
) -> Next {
    let step = lookup.as_mut().map_or(Ok(Step::Known(None)), |lookup| lookup.step(lines.file(), storage));
    let known = match step {
        Ok(Step::Reading) => return Next::Nothing,
        Ok(Step::Waiting) => return Next::NotYet,
        Ok(Step::Known(known)) => known,
        Err(error) => return Next::Failed(error.text()),
    };
    *times = lookup.as_ref().map(|lookup| lookup.times).unwrap_or_default();
    (*lookup, *dialect) = (None, known);
    match lines.restart(storage) {
        Ok(()) => known.map_or(Next::Nothing, Next::Dialect),
        Err(error) => Next::Failed(error.text()),
    }
}

/// Returns the dialect that a whole text states, read as [`Lookup`] reads a file.
#[must_use]
pub fn of_text(text: &[u8]) -> Option<Dialect> {
    let head = text.get(..text.len().min(HEAD as usize)).unwrap_or(text);
    let mut slicer = None;
    let mut end = head.len();
    let mut at = 0;
    for line in text.split_inclusive(|byte| *byte == b'\n') {
        if at >= end {
            break;
        }
        at += line.len();
        match said_by(line.trim_ascii_end()) {
            Some(Said::Dialect(dialect)) => return Some(dialect),
            Some(Said::Slicer(dialect)) => slicer = Some(dialect),
            Some(Said::SettingsFollow) => end = text.len().min(TAIL as usize),
            None => {}
        }
    }
    slicer.map(|slicer| {
        let tail = text.get(text.len().saturating_sub(TAIL as usize)..).unwrap_or(&[]);
        let said = tail.split(|byte| *byte == b'\n').find_map(|line| match said_by(line.trim_ascii_end()) {
            Some(Said::Dialect(dialect)) => Some(dialect),
            _ => None,
        });
        said.unwrap_or(slicer)
    })
}

/// Statement of a line about the dialect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Said {
    Dialect(Dialect),
    /// Slicer that wrote the file, by the dialect it writes where nothing else is said.
    Slicer(Dialect),
    /// The slicer's settings come now.
    SettingsFollow,
}

fn said_by(line: &[u8]) -> Option<Said> {
    let text = core::str::from_utf8(line.strip_prefix(b";")?).ok()?.trim();
    if let Some(name) = text.strip_prefix("FLAVOR:") {
        return Dialect::named(name).map(Said::Dialect);
    }
    if let Some((_, value)) = text.split_once('=').filter(|(key, _)| key.trim() == "gcode_flavor") {
        // The slicers of this family call the firmwares before RepRapFirmware so.
        let value = if value.trim() == "reprap" { "reprap/sprinter" } else { value };
        return Dialect::named(value).map(Said::Dialect);
    }
    if text == "CONFIG_BLOCK_START" {
        return Some(Said::SettingsFollow);
    }
    let slicer = text.strip_prefix("generated by ").unwrap_or(text);
    let writes_settings = ["PrusaSlicer", "OrcaSlicer", "SuperSlicer", "Slic3r", "BambuStudio"];
    writes_settings.iter().any(|name| slicer.starts_with(name)).then_some(Said::Slicer(Dialect::Marlin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::player::{Jobs, Starter};
    use base::bench::Card;
    use base::ports::OpenMode;
    use base::sessions::LineBytes;

    fn next(jobs: &mut Jobs, card: &mut Card) -> (Next, String) {
        let mut line = LineBytes::new();
        let mut next = jobs.next_line(card, &mut line);
        while matches!(next, Next::Nothing) {
            next = jobs.next_line(card, &mut line);
        }
        (next, String::from_utf8(line.to_vec()).unwrap())
    }

    fn dialect_of(text: &str) -> Option<Dialect> {
        let mut card = Card::with(&[("/sd/a.g", text)]);
        let file = card.open("/sd/a.g", OpenMode::Read).unwrap();
        let mut lookup = Lookup::new(text.len() as u32);
        for _ in 0..1_000 {
            if let Step::Known(dialect) = lookup.step(file, &mut card).unwrap() {
                return dialect;
            }
        }
        panic!("it does not end");
    }

    const BAMBU: &str = concat!(
        "; HEADER_BLOCK_START\n; BambuStudio 01.10.01.50\n; HEADER_BLOCK_END\n\n; CONFIG_BLOCK_START\n",
        "; gcode_flavor = klipper\n",
    );

    #[test]
    fn slicers_say_what_they_write_for() {
        let body = "G1 X1 Y1 E0.1\n".repeat(3_000);
        let padding = "; other_setting = 1\n".repeat(2_000);
        assert_eq!(dialect_of("G28\n; gcode_flavor = klipper\n"), Some(Dialect::Klipper), "a short file is all head");
        for (head, tail, dialect) in [
            (";FLAVOR:Marlin\n;TIME:1\n", "", Some(Dialect::Marlin)),
            ("M140 S60\n;FLAVOR:RepRap\r\n", "", Some(Dialect::RepRapFirmware)),
            ("; generated by PrusaSlicer 2.7.4 on 2024\n", "; gcode_flavor = klipper\n", Some(Dialect::Klipper)),
            (
                "; generated by PrusaSlicer 2.7.4 on 2024\n",
                "; gcode_flavor = reprapfirmware\n",
                Some(Dialect::RepRapFirmware),
            ),
            ("; generated by Slic3r 1.3.0\n", "; gcode_flavor = smoothie", Some(Dialect::Marlin)),
            ("; generated by Slic3r 1.3.0\n", "; gcode_flavor = smoothie\n", Some(Dialect::Smoothie)),
            ("; generated by Slic3r 1.3.0\n", "; gcode_flavor = reprap\n", Some(Dialect::Marlin)),
            ("; generated by OrcaSlicer 2.1.1\n", "; gcode_flavor = mach3\n", Some(Dialect::Marlin)),
            ("; G-Code generated by Simplify3D(R) Version 4.1.2\n", "", None),
            (BAMBU, "", Some(Dialect::Klipper)),
            ("G28\n", "; gcode_flavor = klipper\n", None),
            ("", "", None),
        ] {
            assert_eq!(dialect_of(&format!("{head}{body}{tail}{padding}")), dialect, "{head}{tail}");
        }
    }

    #[test]
    fn the_dialect_is_what_the_file_says_or_what_it_is_forced_to_be() {
        let text = ";FLAVOR:RepRap\nG28\n";
        for (forced, said) in [(None, None), (Some(Dialect::Klipper), None), (None, Some(Dialect::Marlin))] {
            let (mut jobs, mut card) = (Jobs::new(forced), Card::with(&[("/sd/a.g", text)]));
            jobs.open(&base::failure::Texts::new(), "/sd/a.g", Starter::default(), &mut card, units::Micros(0))
                .unwrap();
            said.into_iter().for_each(|dialect| jobs.read_as(dialect));
            let wanted = said.or(forced).unwrap_or(Dialect::RepRapFirmware);
            let mut gave = next(&mut jobs, &mut card);
            if wanted == Dialect::RepRapFirmware {
                assert_eq!(gave.0, Next::Dialect(wanted));
                gave = next(&mut jobs, &mut card);
            }
            assert_eq!((gave.1.as_str(), jobs.dialect()), (";FLAVOR:RepRap", Some(wanted)));
        }
    }
}

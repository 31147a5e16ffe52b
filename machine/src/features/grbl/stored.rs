//! State that the dialect keeps on the card: one file, written as soon as something in it changes, as GRBL
//! writes its EEPROM. The lines are the commands that set the same values.

use core::fmt::Write as _;

use base::ports::{OpenMode, Storage, StorageError};
use base::safe_file::{self, Draft};

use crate::features::grbl::state::{Own, Text};

/// Path of the file.
pub(crate) const PATH: &str = "/sd/grbl-settings";
/// Longest possible file, bytes: five lines.
const BYTES: usize = 512;

/// Returns the whole state as text.
fn text(own: &Own) -> heapless::String<BYTES> {
    let mut text = heapless::String::new();
    let Own { report_mask, inches, startup, build } = own;
    // Five lines of less than a hundred characters fit.
    let _ = writeln!(text, "$10={report_mask}\n$13={}", u8::from(*inches));
    for (index, line) in startup.iter().enumerate() {
        let _ = writeln!(text, "$N{index}={line}");
    }
    let _ = writeln!(text, "$I={build}");
    text
}

/// Parses the text of a file. A meaningless line is left out.
fn parsed(text: &str) -> Own {
    let mut own = Own::default();
    for (key, value) in text.lines().filter_map(|line| line.trim_end().split_once('=')) {
        let kept = || Text::try_from(value).unwrap_or_default();
        match key {
            "$10" => own.report_mask = value.parse().unwrap_or(own.report_mask),
            "$13" => own.inches = value == "1",
            "$N0" => own.startup[0] = kept(),
            "$N1" => own.startup[1] = kept(),
            "$I" => own.build = kept(),
            _ => {}
        }
    }
    own
}

/// Writes the state. A power cut at any moment leaves the old file or the new one.
///
/// # Errors
/// When the card refuses.
pub(crate) fn write(storage: &mut impl Storage, own: &Own) -> Result<(), StorageError> {
    let mut draft = Draft::begin(storage, PATH)?;
    if let Err(error) = draft.write(storage, text(own).as_bytes()) {
        draft.give_up(storage);
        return Err(error);
    }
    draft.finish(storage)
}

/// Reads the state; missing values are GRBL's defaults.
///
/// # Errors
/// When the card refuses.
pub(crate) fn read(storage: &mut impl Storage) -> Result<Own, StorageError> {
    safe_file::settle(storage, PATH)?;
    let file = match storage.open(PATH, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(Own::default()),
        opened => opened?,
    };
    let mut bytes = [0; BYTES];
    let mut length = 0;
    let read = loop {
        match storage.read(file, bytes.get_mut(length..).unwrap_or(&mut [])) {
            Ok(0) => break Ok(()),
            Ok(count) => length += count,
            Err(error) => break Err(error),
        }
    };
    storage.close(file)?;
    read?;
    let text = core::str::from_utf8(bytes.get(..length).unwrap_or(&[])).unwrap_or("");
    Ok(parsed(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_written_reads_back(mask: u8, inches: bool, lines in proptest::array::uniform3("[ -~]{0,80}")) {
            let [first, second, build] = lines.map(|line| Text::try_from(line.trim()).unwrap());
            let own = Own { report_mask: mask, inches, startup: [first, second], build };
            let text = text(&own);
            prop_assert!(text.ends_with('\n') && text.lines().count() == 5);
            prop_assert_eq!(parsed(&text), own);
        }

        #[test]
        fn no_file_makes_it_panic(text: String) {
            let _own = parsed(&text);
        }
    }
}

//! The image's log: defmt frames from RTT, decoded with the texts in the image; plain text when it has none.

use std::io::Write;
use std::path::Path;

use defmt_decoder::{DecodeError, StreamDecoder, Table};

/// Turns the bytes of RTT channel 0 into lines.
pub struct Log<'a> {
    decoder: Option<Box<dyn StreamDecoder + Send + Sync + 'a>>,
}

/// The texts of an image's log; `None` when it logs plain text.
///
/// # Errors
/// When the image cannot be read, or its log format is another version's.
pub fn texts(elf: &Path) -> Result<Option<Table>, String> {
    let bytes = std::fs::read(elf).map_err(|error| format!("{}: {error}", elf.display()))?;
    Table::parse(&bytes).map_err(|error| format!("{}: {error}", elf.display()))
}

impl<'a> Log<'a> {
    /// A log with these texts.
    #[must_use]
    pub fn new(texts: Option<&'a Table>) -> Self {
        Self { decoder: texts.map(Table::new_stream_decoder) }
    }

    /// Writes out the lines that these bytes complete.
    pub fn take(&mut self, bytes: &[u8], out: &mut dyn Write) {
        if bytes.is_empty() {
            return;
        }
        let Some(decoder) = &mut self.decoder else {
            let _ = out.write_all(bytes);
            return;
        };
        decoder.received(bytes);
        loop {
            match decoder.decode() {
                Ok(frame) => {
                    let _ = writeln!(out, "{}", frame.display(false));
                }
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => {
                    let _ = writeln!(out, "(a malformed log frame)");
                }
            }
        }
    }
}

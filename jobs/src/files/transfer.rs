//! Files that a console sends as bytes: `ry` by YModem, `upload` as plain bytes up to Ctrl-D or Ctrl-Z, `dl`
//! by their number, whatever they are. Meanwhile every byte of that console belongs to the file, and none is
//! a command.

use base::failure::{Failure, Texts};
use base::paths::Path;
use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use base::sessions::Consoles;
use base::sessions::{Received, Reply, SessionId};
use units::Micros;

use super::ymodem::{Broken, Event, Receiver};

/// Time that `ry` leaves the person at the other end to start a sender.
const BEFORE: Micros = Micros::from_seconds(2);
/// Bytes of a console taken in one turn.
const MOST_BYTES: usize = 1_100;
/// Time that `dl` waits for its next byte, and, when the file cannot be kept, for the end of the bytes.
const BETWEEN: Micros = Micros::from_seconds(20);
const TO_THE_END: Micros = Micros::from_seconds(1);
/// Bytes of `upload` and `dl` that go to the card together.
const CHUNK: usize = 1_024;
const CTRL_D: u8 = 0x04;
const CTRL_X: u8 = 0x18;
const CTRL_Y: u8 = 0x19;
const CTRL_Z: u8 = 0x1A;

/// Way in which a file comes.
#[derive(Debug)]
enum Way {
    /// YModem: blocks that are checked.
    YModem(Receiver),
    /// Plain bytes; those that wait to be written.
    Plain(heapless::Vec<u8, CHUNK>),
    /// Plain bytes of a known number.
    Counted(Counted),
}

/// File of known length.
#[derive(Debug)]
struct Counted {
    /// Number of bytes to come.
    left: u32,
    /// Bytes that wait to be written.
    waiting: heapless::Vec<u8, CHUNK>,
    /// Time at which the file is given up without another byte.
    until: Micros,
    /// Error because of which the file cannot be kept. The rest is taken all the same, as it is no lines.
    failed: Option<StorageError>,
}

/// File, or several, on their way from a console.
#[derive(Debug)]
struct Transfer {
    way: Way,
    /// Open file, and its path.
    file: Option<(FileHandle, Path)>,
    /// Whether to send nothing beside the protocol.
    silent: bool,
    /// Files received, or bytes of `upload`.
    count: u32,
    /// Whether all has come, and is on its way to the card.
    is_complete: bool,
}

/// Progress of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// More is to come: the console's bytes are the file's.
    Receiving,
    /// All has come, and is on its way to the card. The console sends lines again.
    Saving,
    /// The transfer has ended, which has been reported.
    Ended,
}

/// End of a transfer, with Smoothieware's numbers of errors.
enum Ending {
    Whole,
    Broken(i8),
    /// The console was faster than the card.
    Lost,
    Failed(StorageError),
    /// Nothing came for long.
    Silent,
}

/// Transfers of bytes from consoles: one at a time.
#[derive(Debug, Default)]
pub struct Transfers {
    current: Option<Transfer>,
}

impl Transfers {
    /// `ry [silent]`: receives files by YModem.
    ///
    /// # Errors
    /// While another console sends a file.
    pub fn receive(&mut self, silent: bool, now: Micros, reply: &mut Reply<'_>) -> Result<(), Failure> {
        self.is_free()?;
        if !silent {
            reply.say(format_args!("start ymodem transfer\n"));
        }
        let way = Way::YModem(Receiver::new(now.plus(BEFORE)));
        self.current = Some(Transfer { way, file: None, silent, count: 0, is_complete: false });
        Ok(())
    }

    /// `upload file`: receives a file up to Ctrl-D or Ctrl-Z.
    ///
    /// # Errors
    /// When the file cannot be opened, or another console sends one.
    pub fn receive_plain(
        &mut self,
        texts: &Texts,
        name: &str,
        path: Path,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Result<(), Failure> {
        self.is_free()?;
        if name.is_empty() {
            return Err(Failure::refused(&"the name of a file is missing"));
        }
        let file = storage.open(&path, OpenMode::Write);
        let file = file.map_err(|error| texts.about_file(&path, error.text()))?;
        reply.say(format_args!("uploading to file: {name}, send control-D or control-Z to finish\n"));
        let way = Way::Plain(heapless::Vec::new());
        self.current = Some(Transfer { way, file: Some((file, path)), silent: false, count: 0, is_complete: false });
        Ok(())
    }

    /// `dl file bytes`: receives a file of so many bytes.
    ///
    /// # Errors
    /// The reason, in words for the sending program.
    pub fn receive_counted(
        &mut self,
        path: Path,
        size: u32,
        now: Micros,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Result<(), &'static str> {
        if self.current.is_some() {
            return Err("another console sends a file");
        }
        let file = storage.open(&path, OpenMode::Write).map_err(StorageError::text)?;
        reply.say(format_args!("READY - {size}\n"));
        let waiting = heapless::Vec::new();
        let way = Way::Counted(Counted { left: size, waiting, until: now.plus(BETWEEN), failed: None });
        self.current = Some(Transfer { way, file: Some((file, path)), silent: false, count: 0, is_complete: false });
        Ok(())
    }

    fn is_free(&self) -> Result<(), Failure> {
        if self.current.is_some() { Err(Failure::refused(&"another console sends a file")) } else { Ok(()) }
    }

    /// Takes this console's bytes until its count of bytes received was `end`.
    pub fn go_on(
        &mut self,
        directory: &str,
        (from, end): (SessionId, u32),
        now: Micros,
        ports: &mut (impl Storage + Consoles),
        reply: &mut Reply<'_>,
    ) -> Progress {
        let Some(transfer) = &mut self.current else { return Progress::Ended };
        let ending = if transfer.is_complete {
            is_saved(ports)
        } else {
            match transfer.go_on(directory, (from, end), now, ports, reply) {
                Some(Ending::Whole) => transfer.complete(ports),
                other => other,
            }
        };
        let Some(ending) = ending else {
            return if transfer.is_complete { Progress::Saving } else { Progress::Receiving };
        };
        if let Some(transfer) = self.current.take() {
            transfer.end(&ending, ports, reply);
        }
        Progress::Ended
    }

    /// Discards the file when its sender has gone: it is not whole, and does not stay.
    pub fn break_off(&mut self, storage: &mut impl Storage) {
        if let Some(transfer) = self.current.take() {
            transfer.discard(storage);
        }
    }
}

impl Transfer {
    fn go_on(
        &mut self,
        directory: &str,
        (from, end): (SessionId, u32),
        now: Micros,
        ports: &mut (impl Storage + Consoles),
        reply: &mut Reply<'_>,
    ) -> Option<Ending> {
        for _ in 0..MOST_BYTES {
            let byte = match ports.inbox(from).take(end) {
                Some(Received::Byte(byte)) => byte,
                // The bytes that mark lines belong to the file.
                Some(Received::ForgetLine) => CTRL_X,
                Some(Received::LoseLine) => CTRL_Y,
                None => break,
            };
            let ended = match &mut self.way {
                Way::YModem(_) => self.hear(byte, directory, now, ports, reply),
                Way::Plain(_) => self.keep(byte, ports),
                Way::Counted(_) => self.count(byte, now, ports),
            };
            if ended.is_some() {
                return ended;
            }
        }
        let receiver = match &mut self.way {
            Way::YModem(receiver) => receiver,
            _ if ports.inbox(from).take_lost() > 0 => return Some(Ending::Lost),
            Way::Counted(Counted { until, failed, .. }) if now >= *until => {
                return Some(failed.map_or(Ending::Silent, Ending::Failed));
            }
            _ => return None,
        };
        // The lost bytes of a block are asked for again.
        ports.inbox(from).take_lost();
        let event = receiver.wait(now);
        let broken = if let Event::Breaks(broken) = event { Some(broken) } else { None };
        say_bytes(&receiver.take_answer(), reply);
        broken.map(|broken| Ending::Broken(broken as i8))
    }

    /// Takes a byte of YModem.
    fn hear(
        &mut self,
        byte: u8,
        directory: &str,
        now: Micros,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Option<Ending> {
        let Way::YModem(receiver) = &mut self.way else { return None };
        let done = match receiver.hear(byte, now) {
            Event::Nothing => Ok(None),
            Event::Begins(name, _) => {
                let path = base::paths::absolute(directory, name);
                storage.open(&path, OpenMode::Write).map(|file| {
                    self.file = Some((file, path));
                    receiver.accept();
                    None
                })
            }
            Event::Data(bytes) => {
                let written = match &self.file {
                    Some((file, _)) => Storage::write(storage, *file, bytes),
                    None => Ok(()),
                };
                written.map(|()| {
                    receiver.accept();
                    None
                })
            }
            Event::FileEnds => {
                self.count += 1;
                self.file.take().map_or(Ok(()), |(file, _)| storage.close(file)).map(|()| None)
            }
            Event::Ends => Ok(Some(Ending::Whole)),
            Event::Breaks(broken) => Ok(Some(Ending::Broken(broken as i8))),
        };
        let ending = done.unwrap_or_else(|error| {
            receiver.cancel();
            Some(Ending::Failed(error))
        });
        say_bytes(&receiver.take_answer(), reply);
        ending
    }

    /// Takes a byte of `upload`.
    fn keep(&mut self, byte: u8, storage: &mut impl Storage) -> Option<Ending> {
        let Way::Plain(waiting) = &mut self.way else { return None };
        let ends = matches!(byte, CTRL_D | CTRL_Z);
        if byte == CTRL_X {
            return Some(Ending::Broken(Broken::Cancelled as i8));
        }
        if !ends {
            // A full buffer is written below.
            let _ = waiting.push(byte);
            self.count += 1;
        }
        if ends || waiting.is_full() {
            let (file, _) = self.file.as_ref()?;
            if let Err(error) = Storage::write(storage, *file, waiting) {
                return Some(Ending::Failed(error));
            }
            waiting.clear();
        }
        ends.then_some(Ending::Whole)
    }

    /// Takes a byte of `dl`.
    fn count(&mut self, byte: u8, now: Micros, storage: &mut impl Storage) -> Option<Ending> {
        let (Way::Counted(counted), Some((file, _))) = (&mut self.way, &self.file) else { return None };
        let Counted { left, waiting, until, failed } = counted;
        // A full buffer is written below.
        let _ = waiting.push(byte);
        *left -= 1;
        if *left == 0 || waiting.is_full() {
            if failed.is_none() {
                *failed = Storage::write(storage, *file, waiting).err();
            }
            waiting.clear();
            *until = now.plus(if failed.is_some() { TO_THE_END } else { BETWEEN });
        }
        (*left == 0).then(|| failed.map_or(Ending::Whole, Ending::Failed))
    }

    /// Closes the file once all has come.
    fn complete(&mut self, storage: &mut impl Storage) -> Option<Ending> {
        self.is_complete = true;
        match self.file.take().map_or(Ok(()), |(file, _)| storage.close(file)) {
            Ok(()) => is_saved(storage),
            Err(error) => Some(Ending::Failed(error)),
        }
    }

    fn end(self, ending: &Ending, storage: &mut impl Storage, reply: &mut Reply<'_>) {
        let (silent, count) = (self.silent, self.count);
        let (is_ymodem, is_counted) = (matches!(self.way, Way::YModem(_)), matches!(self.way, Way::Counted(_)));
        self.discard(storage);
        if is_counted {
            return match ending {
                Ending::Whole => reply.say(format_args!("SUCCESS\n")),
                Ending::Failed(error) => reply.say(format_args!("FAIL - {}\n", error.text())),
                Ending::Lost => reply.say(format_args!("FAIL - bytes were lost\n")),
                Ending::Broken(_) | Ending::Silent => {
                    reply.say(format_args!("FAIL - nothing came for {} s\n", BETWEEN.seconds()));
                }
            };
        }
        match ending {
            Ending::Whole if !is_ymodem => reply.say(format_args!("uploaded {count} bytes\n")),
            Ending::Whole if !silent => reply.say(format_args!("downloaded {count} file(s) ok\n")),
            Ending::Whole => {}
            Ending::Broken(number) if is_ymodem => reply.say(format_args!("download failed with error {number}\n")),
            Ending::Broken(_) | Ending::Silent => reply.say(format_args!("upload cancelled\n")),
            Ending::Lost => reply.say(format_args!("upload failed: bytes were lost, send more slowly\n")),
            Ending::Failed(error) => reply.say(format_args!("download failed with error -5: {}\n", error.text())),
        }
    }

    /// Removes a file that is still open, as it is not whole.
    fn discard(self, storage: &mut impl Storage) {
        if let Some((file, path)) = self.file {
            // A card that does not answer keeps it.
            let _ = storage.close(file);
            let _ = storage.remove(&path);
        }
    }
}

/// Returns the end of the transfer once all that was written is on the card, or the error.
fn is_saved(storage: &mut impl Storage) -> Option<Ending> {
    match storage.is_kept() {
        Ok(true) => Some(Ending::Whole),
        Ok(false) => None,
        Err(error) => Some(Ending::Failed(error)),
    }
}

fn say_bytes(bytes: &[u8], reply: &mut Reply<'_>) {
    bytes.iter().for_each(|byte| reply.say(format_args!("{}", char::from(*byte))));
}

#[cfg(test)]
mod tests;

//! Files that a console sends as bytes: `ry` by YModem, `upload` as they are up to Ctrl-D or Ctrl-Z, `dl` so
//! many bytes, whatever they are. Meanwhile every byte of that console belongs to the file, and nothing of it
//! acts.

use units::Micros;

use super::paths::Path;
use super::ymodem::{Broken, Event, Receiver};
use crate::failure::{Failure, Texts};
use crate::ports::{Consoles, FileHandle, OpenMode, Storage, StorageError};
use crate::sessions::{Received, Reply, SessionId};

/// How long `ry` leaves the person at the other end to start a sender.
const BEFORE: Micros = Micros::from_seconds(2);
/// Bytes of a console taken in one turn.
const MOST_BYTES: usize = 1_100;
/// How long `dl` waits for its next byte, and, when the file cannot be kept, for the end of what is sent.
const BETWEEN: Micros = Micros::from_seconds(20);
const TO_THE_END: Micros = Micros::from_seconds(1);
/// Bytes of `upload` and `dl` that go to the card together.
const CHUNK: usize = 1_024;
const CTRL_D: u8 = 0x04;
const CTRL_X: u8 = 0x18;
const CTRL_Y: u8 = 0x19;
const CTRL_Z: u8 = 0x1A;

/// How a file comes.
#[derive(Debug)]
enum Way {
    /// In blocks that are checked.
    YModem(Receiver),
    /// As it is; what waits to be written.
    Plain(heapless::Vec<u8, CHUNK>),
    /// As it is, so many bytes.
    Counted(Counted),
}

/// A file of known length.
#[derive(Debug)]
struct Counted {
    /// Bytes to come.
    left: u32,
    /// What waits to be written.
    waiting: heapless::Vec<u8, CHUNK>,
    /// When it is given up, should nothing come.
    until: Micros,
    /// Why it cannot be kept. The rest is taken all the same, as it is no lines.
    failed: Option<StorageError>,
}

/// A file, or several, on their way from a console.
#[derive(Debug)]
struct Transfer {
    way: Way,
    /// The one that is open, and its path.
    file: Option<(FileHandle, Path)>,
    /// Says nothing but what the protocol says.
    silent: bool,
    /// Files received, or bytes of `upload`.
    count: u32,
    /// All has come, and is on its way to the card.
    is_complete: bool,
}

/// How far a transfer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// More is to come: what the console sends is the file's.
    Receiving,
    /// All has come, and is on its way to the card. What the console sends is lines again.
    Saving,
    /// It has ended, and that has been said.
    Ended,
}

/// How a transfer ended, as Smoothieware numbers what went wrong.
enum Ending {
    Whole,
    Broken(i8),
    /// The console was faster than the card.
    Lost,
    Failed(StorageError),
    /// Nothing came for long.
    Silent,
}

/// What consoles send as bytes: one at a time.
#[derive(Debug, Default)]
pub(crate) struct Transfers {
    current: Option<Transfer>,
}

impl Transfers {
    /// `ry [silent]`: receives files by YModem.
    ///
    /// # Errors
    /// While another console sends one.
    pub fn receive(&mut self, silent: bool, now: Micros, reply: &mut Reply<'_>) -> Result<(), Failure> {
        self.is_free()?;
        if !silent {
            reply.say(format_args!("start ymodem transfer\n"));
        }
        let way = Way::YModem(Receiver::new(now.plus(BEFORE)));
        self.current = Some(Transfer { way, file: None, silent, count: 0, is_complete: false });
        Ok(())
    }

    /// `upload file`: what comes is the file, up to Ctrl-D or Ctrl-Z.
    ///
    /// # Errors
    /// When it cannot be opened, or another console sends one.
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

    /// `dl file bytes`: so many bytes are the file.
    ///
    /// # Errors
    /// What is wrong, in words for the program that sends.
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

    /// Goes on with what this console has sent until its count of bytes received was `end`.
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

    /// Whoever sent it has gone: the file is not whole, and does not stay.
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
                // The bytes that mark lines are some of the file's.
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
        // What was lost of a block is asked for again.
        ports.inbox(from).take_lost();
        let event = receiver.wait(now);
        let broken = if let Event::Breaks(broken) = event { Some(broken) } else { None };
        say_bytes(&receiver.take_answer(), reply);
        broken.map(|broken| Ending::Broken(broken as i8))
    }

    /// A byte of YModem.
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
                let path = super::paths::absolute(directory, name);
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

    /// A byte of `upload`.
    fn keep(&mut self, byte: u8, storage: &mut impl Storage) -> Option<Ending> {
        let Way::Plain(waiting) = &mut self.way else { return None };
        let ends = matches!(byte, CTRL_D | CTRL_Z);
        if byte == CTRL_X {
            return Some(Ending::Broken(Broken::Cancelled as i8));
        }
        if !ends {
            // A full one is written below.
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

    /// A byte of `dl`.
    fn count(&mut self, byte: u8, now: Micros, storage: &mut impl Storage) -> Option<Ending> {
        let (Way::Counted(counted), Some((file, _))) = (&mut self.way, &self.file) else { return None };
        let Counted { left, waiting, until, failed } = counted;
        // A full one is written below.
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

    /// All has come.
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

    /// A file that is still open is not whole.
    fn discard(self, storage: &mut impl Storage) {
        if let Some((file, path)) = self.file {
            // A card that does not answer keeps it.
            let _ = storage.close(file);
            let _ = storage.remove(&path);
        }
    }
}

/// Whether all that was written is on the card, or why it is not.
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

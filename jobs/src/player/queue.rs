//! Jobs that wait for their turn.

use base::failure::{Failure, Texts};
use base::paths::Path;
use base::ports::{OpenMode, Storage};
use base::sessions::{Reply, Rights};
use heapless::Vec;

/// Greatest number of files that can wait.
const MOST: usize = 16;

/// Files in the order in which they are to be played. Forgotten at a reset.
#[derive(Debug, Default)]
pub struct Queue {
    files: Vec<(Path, Rights), MOST>,
}

impl Queue {
    /// Returns the next file to play.
    #[must_use]
    pub fn next(&self) -> Option<&Path> {
        self.files.first().map(|(path, _)| path)
    }

    /// Returns the rights of whoever added the next file; all without one.
    #[must_use]
    pub fn rights_of_next(&self) -> Rights {
        self.files.first().map_or(Rights::Own, |(_, rights)| *rights)
    }

    /// Takes the next file out.
    pub fn take(&mut self) -> Option<Path> {
        (!self.files.is_empty()).then(|| self.files.remove(0).0)
    }

    /// Edits or lists the queue: `add file [times]`, `remove place`, `clear`; nothing: lists them.
    ///
    /// # Errors
    /// When there is no such file, or no room.
    pub fn command(
        &mut self,
        texts: &Texts,
        arguments: &str,
        absolute: impl Fn(&str) -> Path,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Result<(), Failure> {
        let (word, rest) = arguments.trim().split_once(' ').unwrap_or((arguments.trim(), ""));
        let rest = rest.trim();
        match word {
            "" | "list" => {}
            "add" => self.add(texts, rest, absolute, storage, reply.rights())?,
            "remove" => {
                let place = rest.parse::<usize>().ok().and_then(|place| place.checked_sub(1));
                let place = place.filter(|place| *place < self.files.len());
                self.files.remove(place.ok_or_else(|| Failure::refused(&"no file waits at this place: see queue"))?);
            }
            "clear" => self.files.clear(),
            _ => return Err(Failure::refused(&"queue takes: add file [times], list, next, remove place, clear")),
        }
        if self.files.is_empty() {
            reply.say(format_args!("no file waits\n"));
        }
        for (place, (file, _)) in self.files.iter().enumerate() {
            reply.say(format_args!("{}: {file}\n", place + 1));
        }
        Ok(())
    }

    fn add(
        &mut self,
        texts: &Texts,
        rest: &str,
        absolute: impl Fn(&str) -> Path,
        storage: &mut impl Storage,
        rights: Rights,
    ) -> Result<(), Failure> {
        let whole = absolute(rest);
        // A name may end in a number.
        let (path, times) = match rest.rsplit_once(' ') {
            Some((name, times)) if storage.open(&whole, OpenMode::Read).map(|file| storage.close(file)).is_err() => {
                (absolute(name.trim()), times.parse::<usize>().ok().filter(|times| *times > 0))
            }
            _ => (whole, Some(1)),
        };
        let times = times.ok_or_else(|| Failure::refused(&"how often? queue add file times"))?;
        let file = storage.open(&path, OpenMode::Read);
        let file = file.map_err(|error| texts.about_file(&path, error.text()))?;
        // The file was only opened: a failing close loses nothing.
        let _ = storage.close(file);
        if self.files.len() + times > MOST {
            return Err(Failure::refused(&"sixteen files can wait, no more"));
        }
        for _ in 0..times {
            // Room was checked above.
            let _ = self.files.push((path.clone(), rights));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Files;
    use base::bench::{Card, Desk};

    struct Table {
        queue: Queue,
        card: Card,
        desk: Desk,
    }

    impl Table {
        fn new() -> Self {
            let card = Card::with(&[("/sd/a.g", "G28\n"), ("/sd/part 2", "G28\n")]);
            Self { queue: Queue::default(), card, desk: Desk::new() }
        }

        fn ask(&mut self, arguments: &str) -> (bool, String) {
            let (Self { queue, card, desk }, mut went) = (self, false);
            let absolute = |name: &str| Files::default().absolute(name);
            let said =
                desk.hears(|reply| went = queue.command(&Texts::new(), arguments, absolute, card, reply).is_ok());
            (went, said)
        }
    }

    #[test]
    fn files_wait_in_order() {
        let mut table = Table::new();
        assert_eq!(table.ask(""), (true, "no file waits\n".into()));
        assert_eq!(table.ask("add a.g"), (true, "1: /sd/a.g\n".into()));
        assert_eq!(table.ask("add part 2").1, "1: /sd/a.g\n2: /sd/part 2\n", "a name that ends in a number");
        assert_eq!(table.ask("add a.g 2").1.lines().count(), 4);
        assert_eq!(table.ask("remove 1").1.lines().next(), Some("1: /sd/part 2"));
        assert_eq!(table.queue.take().as_deref(), Some("/sd/part 2"));
        assert_eq!(table.queue.next().map(|path| path.as_str()), Some("/sd/a.g"));
        assert_eq!(table.ask("clear"), (true, "no file waits\n".into()));
        assert_eq!(table.card.open_files(), 0);
    }

    #[test]
    fn what_cannot_be_is_refused_and_changes_nothing() {
        let mut table = Table::new();
        for wrong in ["add", "add no.g", "add a.g 0", "add a.g 17", "add no.g 2", "remove", "remove 1", "next time"] {
            assert!(!table.ask(wrong).0, "{wrong}");
        }
        assert!(table.queue.next().is_none());
        assert_eq!(table.card.open_files(), 0);
    }
}

//! File commands that are done at once: `rm`, `mv`, `mkdir`, `cd`, M21 and M30.

use base::failure::{Answer, Outcome, Texts};
use base::paths::words;
use base::ports::{Storage, StorageError};
use base::secrets::is_secret;
use base::sessions::Reply;

use super::Files;

/// M21: mounts the card again.
///
/// # Errors
/// When there is no card, or it cannot be read.
pub fn mount(texts: &Texts, storage: &mut impl Storage, reply: &mut Reply<'_>) -> Outcome {
    storage.mount().map_err(|error| texts.because(error.text()))?;
    reply.say(format_args!("SD card ok\n"));
    Ok(Answer::Ok)
}

impl Files {
    /// M30: removes a file, and prints whether it worked.
    ///
    /// # Errors
    /// None.
    pub fn remove(&self, name: &str, storage: &mut impl Storage, reply: &mut Reply<'_>) -> Outcome {
        match storage.remove(&self.absolute(name)) {
            Ok(()) => reply.say(format_args!("deleted {name}\n")),
            Err(error) => reply.say(format_args!("Could not delete {name}: {}\n", error.text())),
        }
        Ok(Answer::Ok)
    }

    /// `rm a b ...`: removes files.
    ///
    /// # Errors
    /// None.
    pub fn remove_command(&self, arguments: &str, storage: &mut impl Storage, reply: &mut Reply<'_>) -> Outcome {
        for name in words(arguments) {
            self.remove(name, storage, reply)?;
        }
        Ok(Answer::Said)
    }

    /// `mv from to`, `mkdir name`, `cd name`; `cd` alone goes to the card.
    ///
    /// # Errors
    /// None: failures are printed.
    pub fn directory_command(
        &mut self,
        command: &str,
        arguments: &str,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Outcome {
        let mut words = words(arguments);
        let (first, second) = (words.next(), words.next());
        match (command, first, second) {
            ("mv", Some(from), Some(to)) => {
                let (old, new) = (self.absolute(from), self.absolute(to));
                let moved = if is_secret(&old) { Err(StorageError::Secret) } else { storage.rename(&old, &new) };
                if let Err(error) = moved {
                    reply.say(format_args!("Could not rename {from} to {to}: {}\n", error.text()));
                }
            }
            ("mv", ..) => reply.say(format_args!("from and to files required\n")),
            ("mkdir", None, _) => reply.say(format_args!("directory name required\n")),
            ("mkdir", Some(name), _) => {
                let path = self.absolute(name);
                if let Err(error) = storage.make_directory(&path) {
                    reply.say(format_args!("failed to make directory {path}: {}\n", error.text()));
                }
            }
            _ => {
                let path = self.absolute(first.unwrap_or("/"));
                if let Err(error) = self.change_directory(path.clone(), storage) {
                    reply.say(format_args!("failed to change to directory {path}: {}\n", error.text()));
                }
            }
        }
        Ok(Answer::Ok)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{Card, Desk};

    /// Returns the text printed by a command.
    fn said(files: &mut Files, card: &mut Card, command: &str, arguments: &str) -> String {
        Desk::new().hears(|reply| {
            let (outcome, expected) = match command {
                "rm" => (files.remove_command(arguments, card, reply), Answer::Said),
                _ => (files.directory_command(command, arguments, card, reply), Answer::Ok),
            };
            assert_eq!(outcome, Ok(expected));
        })
    }

    #[test]
    fn files_are_removed_one_by_one_and_each_is_told() {
        let mut card = Card::with(&[("/sd/a.g", ""), ("/sd/with space.g", "")]);
        let said = said(&mut Files::default(), &mut card, "rm", "a.g \"with space.g\" a.g");
        assert_eq!(said, "deleted a.g\ndeleted with space.g\nCould not delete a.g: no such file\n");
    }

    #[test]
    fn what_is_moved_has_its_new_name() {
        let (mut card, mut files) = (Card::with(&[("/sd/a.g", "G28\n")]), Files::default());
        assert_eq!(said(&mut files, &mut card, "mv", "a.g \"b c.g\""), "");
        assert_eq!(card.text("/sd/b c.g"), "G28\n");
        assert_eq!(said(&mut files, &mut card, "mv", "a.g b.g"), "Could not rename a.g to b.g: no such file\n");
    }

    #[test]
    fn names_start_from_the_current_directory() {
        let (mut card, mut files) = (Card::default(), Files::default());
        assert_eq!(
            said(&mut files, &mut card, "cd", "parts"),
            "failed to change to directory /sd/parts: no such file\n"
        );
        assert_eq!(files.absolute("x.g"), "/sd/x.g", "it stays where it was");
        assert_eq!(said(&mut files, &mut card, "mkdir", "parts"), "");
        assert_eq!(said(&mut files, &mut card, "cd", "parts"), "");
        assert_eq!(files.absolute("x.g"), "/sd/parts/x.g");
        assert_eq!(said(&mut files, &mut card, "cd", ""), "");
        assert_eq!(files.absolute("x.g"), "/sd/x.g");
    }
}

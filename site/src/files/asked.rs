//! Calls about files: carried out in steps, each when the card is at rest.

use base::paths::CARD;
use base::ports::{OpenMode, Storage, StorageError};
use heapless::String;
use http::json::{Next, Writer};
use http::{Role, Status};

use super::directory::{Shape, Walk, write_facts};
use super::metadata::Scan;
use super::place;
use super::refusal::Refusal;
use super::{Files, LIST_PATIENCE_MS, Visitor};
use crate::calls::SCRIPT_BYTES;

/// Paths of a call, then those on the card.
pub type Text = String<SCRIPT_BYTES>;

/// Marks of the parameters in the text of a call that has several.
pub const SOURCE: char = '\u{1}';
pub const TARGET: char = '\u{2}';

/// Question or change that a call asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Files below a root, as a plain list.
    List,
    /// Folder with its entries.
    Directory,
    /// Metadata that a slicer has written into a file.
    Metadata,
    MakeFolder,
    Move,
    RemoveFile,
    /// Folder; whether with all that it holds.
    RemoveFolder(bool),
}

impl Ask {
    const fn action(self) -> &'static str {
        match self {
            Self::MakeFolder => "create_dir",
            Self::Move => "move_file",
            Self::RemoveFile => "delete_file",
            Self::RemoveFolder(_) => "delete_dir",
            Self::List | Self::Directory | Self::Metadata => "",
        }
    }
}

/// Call about files, as far as it has come. Its paths stand in the text of the call.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    ask: Ask,
    /// Whether the text has paths on the card, and where the second of them begins.
    is_plain: bool,
    second: u16,
    walk: Walk,
    /// Whether the call is carried out, and being answered.
    pub is_answered: bool,
}

impl Question {
    /// Makes a question that has not begun.
    #[must_use]
    pub const fn new(ask: Ask) -> Self {
        let shape = if matches!(ask, Ask::List) { Shape::List } else { Shape::Directory };
        Self { ask, is_plain: false, second: 0, walk: Walk::new(shape), is_answered: false }
    }

    /// Goes on with the call. None while there is more to do; the answer then is told by [`Telling`].
    ///
    /// # Errors
    /// Why it is refused.
    pub fn go_on(
        &mut self,
        (visitor, role): (Visitor, Role),
        text: &mut Text,
        files: &mut Files,
        card: &mut impl Storage,
        now_ms: u64,
    ) -> Option<Result<(), Refusal>> {
        if !self.is_plain {
            if let Err(refusal) = self.make_plain(text, role) {
                return Some(Err(refusal));
            }
            self.is_plain = true;
        }
        if self.ask == Ask::Metadata && !files.scans.take(visitor.number(), now_ms, LIST_PATIENCE_MS)
            || !files.has_card(visitor, now_ms, card)
        {
            return None;
        }
        let done = match self.ask {
            Ask::List | Ask::Directory => {
                files.want_space();
                is_folder(text, card).map(|()| true)
            }
            Ask::Metadata => files.scan_on(visitor, text, card),
            Ask::MakeFolder | Ask::Move | Ask::RemoveFile | Ask::RemoveFolder(_) => self.change(text, card),
        };
        match done {
            Ok(false) => None,
            Ok(true) => {
                if !self.ask.action().is_empty() {
                    files.note(self.ask.action(), self.target(text));
                }
                Some(Ok(()))
            }
            Err(refusal) => {
                if self.ask == Ask::Metadata {
                    files.end_question(visitor, card);
                }
                Some(Err(refusal))
            }
        }
    }

    /// Makes paths on the card of those of the call.
    fn make_plain(&mut self, text: &mut Text, role: Role) -> Result<(), Refusal> {
        let part = |mark: char| {
            let behind = text.split_once(mark).map(|(_, behind)| behind);
            behind.map(|behind| behind.split([SOURCE, TARGET]).next().unwrap_or_default())
        };
        let (first, second) = match self.ask {
            Ask::Move => {
                let missing = Refusal::bad("source or dest is missing");
                (place::of(part(SOURCE).ok_or(missing)?)?, Some(place::of(part(TARGET).ok_or(missing)?)?))
            }
            Ask::Metadata => (place::below(CARD, text)?, None),
            Ask::List if text.is_empty() => (place::of(place::ROOT)?, None),
            Ask::List | Ask::Directory | Ask::MakeFolder | Ask::RemoveFile | Ask::RemoveFolder(_) => {
                (place::of(text)?, None)
            }
        };
        if !matches!(self.ask, Ask::List | Ask::Directory) {
            place::admit(&first, role)?;
        }
        text.clear();
        self.second = first.len() as u16;
        // Two paths have as much room as a script.
        let _fits = text.push_str(&first);
        if let Some(second) = second {
            place::admit(&second, role)?;
            let _fits = text.push_str(&second);
        }
        Ok(())
    }

    /// Returns the path that the answer names.
    fn target<'t>(&self, text: &'t str) -> &'t str {
        let from = if self.ask == Ask::Move { usize::from(self.second) } else { 0 };
        text.get(from..).unwrap_or_default()
    }

    /// Takes a step of a change. True when it is done.
    fn change(&mut self, text: &mut Text, card: &mut impl Storage) -> Result<bool, Refusal> {
        let (first, second) = text.split_at_checked(usize::from(self.second)).unwrap_or((text, ""));
        match self.ask {
            Ask::MakeFolder => card.make_directory(first)?,
            Ask::Move => card.rename(first, second)?,
            Ask::RemoveFile if card.facts(first)?.is_directory => {
                return Err(Refusal::new(Status::Conflict, "this is a folder"));
            }
            Ask::RemoveFile => card.remove(first)?,
            Ask::RemoveFolder(_) if !card.facts(first)?.is_directory => {
                return Err(Refusal::new(Status::Conflict, "this is no folder"));
            }
            Ask::RemoveFolder(false) => card.remove(first)?,
            Ask::RemoveFolder(true) => return self.empty_folder(text, card),
            Ask::List | Ask::Directory | Ask::Metadata => {}
        }
        Ok(true)
    }

    /// Removes the first thing in a folder, or goes into it where it is a folder itself. The text is the path
    /// of the folder that is being emptied; its first bytes are the one that is to be removed.
    fn empty_folder(&self, text: &mut Text, card: &mut impl Storage) -> Result<bool, Refusal> {
        let Some(entry) = card.entry(text, 0)? else {
            card.remove(text)?;
            if text.len() <= usize::from(self.second) {
                return Ok(true);
            }
            let parent = text.rfind('/').unwrap_or_default();
            text.truncate(parent);
            return Ok(false);
        };
        let folder = text.len();
        let fits = text.push('/').and_then(|()| text.push_str(&entry.name));
        fits.map_err(|_| Refusal::bad("a path in the folder is too long"))?;
        if !entry.is_directory {
            let removed = card.remove(text);
            text.truncate(folder);
            removed?;
        }
        Ok(false)
    }
}

/// Refuses what is no folder.
fn is_folder(path: &str, card: &mut impl Storage) -> Result<(), Refusal> {
    if path == CARD {
        // The card itself has no entry.
        return Ok(card.entry(CARD, 0).map(drop)?);
    }
    let is_directory = card.facts(path)?.is_directory;
    if is_directory { Ok(()) } else { Err(Refusal::new(Status::NotFound, "this is no folder")) }
}

impl Files {
    /// Goes on to look for what a slicer has written. True when all is found.
    fn scan_on(&mut self, visitor: Visitor, path: &str, card: &mut impl Storage) -> Result<bool, Refusal> {
        if let Some((_, scan)) = self.scan.as_mut().filter(|(number, _)| *number == visitor.number()) {
            return scan.go_on(card).map_err(|error| match error {
                StorageError::NotFound => Refusal::new(Status::Conflict, "the file is being changed"),
                error => error.into(),
            });
        }
        let facts = card.facts(path)?;
        if facts.is_directory {
            return Err(Refusal::new(Status::NotFound, "this is a folder"));
        }
        // The visitor before slept, and has lost his turn.
        self.close_scan(card);
        let scan = Scan::new(card.open(path, OpenMode::Beside)?, facts.size_bytes, facts.written);
        self.scan = Some((visitor.number(), scan));
        Ok(false)
    }

    fn scan_of(&self, visitor: Visitor) -> Option<&Scan> {
        self.scan.as_ref().filter(|(number, _)| *number == visitor.number()).map(|(_, scan)| scan)
    }

    fn close_scan(&mut self, card: &mut impl Storage) {
        if let Some((_, scan)) = self.scan.take() {
            // A file that was only read has nothing to lose.
            let _ = card.close(scan.file());
        }
    }

    /// Ends a visitor's search and list, done or not.
    pub fn end_question(&mut self, visitor: Visitor, card: &mut impl Storage) {
        self.lists.end(visitor.number());
        self.card.end(visitor.number());
        if self.scans.end(visitor.number()) {
            self.close_scan(card);
        }
    }
}

/// Answer to a call about files, as it is made.
pub struct Telling<'t, S> {
    /// Call that is answered, and its text.
    pub question: &'t mut Question,
    pub text: &'t str,
    /// Visitor who has asked.
    pub visitor: Visitor,
    /// Files, and the card.
    pub files: &'t mut Files,
    pub card: &'t mut S,
    /// Time since the start, milliseconds.
    pub now_ms: u64,
}

impl<S: Storage> Telling<'_, S> {
    /// Writes a part of the answer.
    pub fn write(&mut self, part: u32, json: &mut Writer<'_, '_>) -> Next {
        let Self { question, text, visitor, files, card, now_ms } = self;
        let number = visitor.number();
        match question.ask {
            Ask::List | Ask::Directory => {
                // One folder at a time: the card remembers where one of them goes on.
                if !files.lists.take(number, *now_ms, LIST_PATIENCE_MS) || !files.has_card(*visitor, *now_ms, *card) {
                    return Next::Later;
                }
                let next = question.walk.write(part, text, files.space.known, *card, json);
                if next == Next::End {
                    files.lists.end(number);
                }
                next
            }
            Ask::Metadata => write_metadata(part, text, files.scan_of(*visitor), json),
            Ask::MakeFolder | Ask::Move | Ask::RemoveFile | Ask::RemoveFolder(_) => {
                json.begin_object();
                json.key("item");
                write_item(place::shown(question.target(text)), json);
                json.key("action");
                json.text(question.ask.action());
                json.end_object();
                Next::End
            }
        }
    }
}

/// Writes a path with its root.
pub fn write_item(path: &str, json: &mut Writer<'_, '_>) {
    json.begin_object();
    json.key("root");
    json.text(place::ROOT);
    json.key("path");
    json.text(path);
    json.end_object();
}

fn write_metadata(part: u32, path: &str, scan: Option<&Scan>, json: &mut Writer<'_, '_>) -> Next {
    let thumbnails = scan.map_or(&[][..], |scan| &scan.found.thumbnails);
    if part == 0 {
        json.begin_object();
        json.key("filename");
        json.text(place::shown(path));
        if let Some(scan) = scan {
            write_facts(scan.size, scan.written, json);
            scan.found.write(json);
        }
        json.key("thumbnails");
        json.begin_array();
        return Next::Part;
    }
    let Some(picture) = thumbnails.get(part as usize - 1) else {
        json.end_array();
        json.end_object();
        return Next::End;
    };
    json.begin_object();
    for (key, number) in
        [("width", u32::from(picture.width)), ("height", u32::from(picture.height)), ("size", picture.length / 4 * 3)]
    {
        json.key(key);
        json.number(u64::from(number));
    }
    let name = path.rsplit('/').next().unwrap_or_default();
    json.key("relative_path");
    json.begin_text();
    json.more_text(".thumbs/");
    json.more_text(name);
    json.more_text("-");
    json.more_number(u64::from(picture.width));
    json.more_text("x");
    json.more_number(u64::from(picture.height));
    json.more_text(".");
    json.more_text(picture.ending());
    json.end_text();
    json.end_object();
    Next::Part
}

//! A file that comes as a form (Moonraker's `POST /server/files/upload`): fields in any order, the file
//! streamed to the card, its SHA-256 made on the way.

use base::paths::{CARD, Path};
use base::ports::{FileHandle, Storage, StorageError};
use heapless::{String, Vec};
use http::multipart::{Error, Item, Multipart};
use http::{Role, Status};
use sha2::{Digest as _, Sha256};

use super::directory::unix_s;
use super::keeping::{self, DIGEST_BYTES, Digest, Part, Step};
use super::place;
use super::refusal::Refusal;

/// Bytes of the card's blocks: whole ones are written without being read before.
pub const BLOCK: usize = 512;
/// Most blocks that are read at a time.
const READS: usize = 8;
/// Refusal of a form that does not go on where the file ends.
pub const OTHER_SIZE: Refusal =
    Refusal::new(Status::Conflict, "this is not where what has come of the file ends: ask where it does");
/// Longest text of a field: a digest in hexadecimal digits.
const TEXT_BYTES: usize = 64;
/// Field of the form that comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Field {
    /// Something that slicers send and nobody needs here.
    Other,
    File,
    Folder,
    Root,
    Print,
    Checksum,
}

/// Folder and name of a file, whichever comes first.
#[derive(Clone, Debug, Default)]
struct Names {
    /// Folder with a slash behind it, then the name.
    text: Vec<u8, { base::ports::PATH_BYTES }>,
    folder_bytes: usize,
}

impl Names {
    /// Adds to the folder. False if there is no room.
    fn add_folder(&mut self, bytes: &[u8]) -> bool {
        let at = self.folder_bytes;
        let has_room = self.text.extend_from_slice(bytes).is_ok();
        if has_room && let Some(behind) = self.text.get_mut(at..) {
            behind.rotate_right(bytes.len());
            self.folder_bytes += bytes.len();
        }
        has_room
    }

    fn path(&self) -> Result<Path, Refusal> {
        let text = core::str::from_utf8(&self.text).map_err(|_| Refusal::bad("the path is no text"))?;
        place::below(CARD, text)
    }
}

/// Bytes that fill a block of the file before they are written.
#[derive(Debug, Default)]
struct Gathered(Vec<u8, BLOCK>);

/// File that is written, as far as it has come.
#[derive(Debug)]
struct Written {
    file: Option<FileHandle>,
    size: u32,
    hash: Sha256,
}

impl Written {
    /// Takes bytes: whole blocks at once, the rest into `gathered`.
    fn put(&mut self, gathered: &mut Gathered, mut bytes: &[u8], card: &mut impl Storage) -> Result<(), StorageError> {
        while !bytes.is_empty() {
            let room = BLOCK - (self.size as usize + gathered.0.len()) % BLOCK;
            let (now, later) = bytes.split_at_checked(room).unwrap_or((bytes, &[]));
            if gathered.0.is_empty() && now.len() == room {
                self.write(now, card)?;
            } else {
                // The bytes lie in one block.
                let _fits = gathered.0.extend_from_slice(now);
                if now.len() == room {
                    self.flush(gathered, card)?;
                }
            }
            bytes = later;
        }
        Ok(())
    }

    fn flush(&mut self, gathered: &mut Gathered, card: &mut impl Storage) -> Result<(), StorageError> {
        let written = if gathered.0.is_empty() { Ok(()) } else { self.write(&gathered.0, card) };
        gathered.0.clear();
        written
    }

    fn write(&mut self, bytes: &[u8], card: &mut impl Storage) -> Result<(), StorageError> {
        let file = self.file.ok_or(StorageError::NotFound)?;
        let size = self.size.checked_add(bytes.len() as u32).ok_or(StorageError::Full)?;
        card.write(file, bytes)?;
        self.hash.update(bytes);
        self.size = size;
        Ok(())
    }
}

/// Stage of an upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The form is still coming.
    Form,
    /// The form is whole, which has not been looked at yet.
    Whole,
    /// The file came in two goes, and is read for its digest.
    Reading,
    /// The file is put in place.
    Keeping(Step),
    /// The file is not wanted any more.
    Over,
}

/// Facts that the answer tells of an upload in place.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// Size in bytes, and SHA-256.
    pub size: u32,
    pub digest: Digest,
    /// Time of the file, seconds since 1970.
    pub modified: u64,
    /// Whether the file is to be played, and whether it has taken the place of another.
    pub prints: bool,
    pub is_in_place: bool,
}

impl Told {
    /// Returns what was done, in Moonraker's words.
    #[must_use]
    pub const fn action(&self) -> &'static str {
        if self.is_in_place { "modify_file" } else { "create_file" }
    }
}

/// A file that comes.
#[derive(Debug)]
pub struct Upload {
    role: Role,
    form: Multipart,
    field: Field,
    names: Names,
    text: String<TEXT_BYTES>,
    written: Written,
    /// Digest that the file is to have; once it is whole, the one that it has.
    digest: Option<Digest>,
    /// Place in the file at which this form goes on; none if its sender cannot go on with it.
    from: Option<u32>,
    /// Whether the file is to be played.
    pub prints: bool,
    stage: Stage,
    /// Whether another file had the name.
    is_in_place: bool,
    modified: u64,
}

impl Upload {
    /// Begins with a form of this type, from a visitor of this role. `part` is what the form goes on with, or
    /// begins, where its sender can go on with it after it broke off.
    ///
    /// # Errors
    /// The type is that of no form.
    pub fn new(content_type: &str, role: Role, part: Option<Part>) -> Result<Self, Refusal> {
        let form = Multipart::new(content_type).map_err(of_form)?;
        let written = Written { file: None, size: 0, hash: Sha256::new() };
        Ok(Self {
            role,
            form,
            field: Field::Other,
            names: Names::default(),
            text: String::new(),
            written,
            digest: part.map(|part| part.digest),
            from: part.map(|part| part.size),
            prints: false,
            stage: Stage::Form,
            is_in_place: false,
            modified: 0,
        })
    }

    /// Returns how many bytes of the body are to be taken together, of so many that have come; 0 to wait for
    /// more. Blocks are written whole, and what does not fill one waits in its socket.
    #[must_use]
    pub fn takes(&self, come: usize, body_left: Option<u64>) -> usize {
        let is_last = body_left.is_none_or(|left| left <= come as u64);
        if self.written.file.is_none() || is_last {
            return come;
        }
        let missing = BLOCK - self.written.size as usize % BLOCK;
        come.checked_sub(missing).map_or(0, |more| missing + more / BLOCK * BLOCK)
    }

    /// Returns whether so many bytes can be taken though the card is not at rest.
    pub fn writes_on(&self, bytes: usize, card: &mut impl Storage) -> bool {
        self.written.file.is_some_and(|file| card.can_write_on(file, bytes))
    }

    /// Takes bytes of the form, when the card is at rest. `place` is the number of the upload.
    ///
    /// # Errors
    /// Why the file is not taken.
    pub fn take(&mut self, place: usize, mut bytes: &[u8], card: &mut impl Storage) -> Result<(), Refusal> {
        let mut gathered = Gathered::default();
        let Self { form, field, names, text, written, digest, from, prints, .. } = self;
        while let Some(item) = form.next(&mut bytes).map_err(of_form)? {
            match item {
                Item::Part { name, file_name } => {
                    text.clear();
                    *field = field_of(name, file_name);
                    if *field == Field::File {
                        begin_file(file_name.unwrap_or_default(), names, written)?;
                        written.file = Some(open_file(place, digest.as_ref(), *from, card)?);
                        written.size = from.unwrap_or(0);
                    }
                }
                Item::Data(data) => match *field {
                    Field::File => written.put(&mut gathered, data, card)?,
                    Field::Folder if names.add_folder(data) => {}
                    Field::Folder => return Err(Refusal::bad("the path is too long")),
                    Field::Root | Field::Print | Field::Checksum => add_text(text, data)?,
                    Field::Other => {}
                },
                Item::EndPart => match *field {
                    Field::Folder if !names.add_folder(b"/") => return Err(Refusal::bad("the path is too long")),
                    Field::Root if text != place::ROOT => {
                        return Err(Refusal::bad("there is no such root: files are in gcodes"));
                    }
                    Field::Print => *prints = text.eq_ignore_ascii_case("true"),
                    Field::Checksum => {
                        let said = read_digest(text)?;
                        if digest.replace(said).is_some_and(|before| before != said) {
                            return Err(Refusal::bad("the file has two checksums"));
                        }
                    }
                    Field::Root | Field::File | Field::Folder | Field::Other => {}
                },
                Item::End => {}
            }
        }
        Ok(written.flush(&mut gathered, card)?)
    }

    /// The form is whole.
    pub fn hear_end(&mut self) {
        self.stage = Stage::Whole;
    }

    /// Returns whether the form is whole: [`Self::go_on`] is to be called.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        matches!(self.stage, Stage::Whole | Stage::Reading | Stage::Keeping(_))
    }

    /// Returns whether the file is read, whose blocks the card keeps for one visitor at a time.
    #[must_use]
    pub fn reads(&self) -> bool {
        self.stage == Stage::Reading
    }

    /// Ends the form: the file is closed, and read anew where not all of it has come by this form.
    fn end(&mut self, place: usize, card: &mut impl Storage) -> Result<(), Refusal> {
        self.form.finish().map_err(of_form)?;
        let file = self.written.file.take().ok_or(Refusal::bad("the form has no file"))?;
        card.close(file)?;
        if self.from.unwrap_or(0) == 0 {
            return self.compare(place, card);
        }
        self.written.hash = Sha256::new();
        self.written.file = Some(keeping::read(place, card)?);
        self.stage = Stage::Reading;
        Ok(())
    }

    /// Reads some blocks of the file for its digest.
    fn read(&mut self, place: usize, card: &mut impl Storage) -> Result<(), Refusal> {
        let file = self.written.file.ok_or(StorageError::NotFound)?;
        let mut block = [0; BLOCK];
        for _ in 0..READS {
            if !card.is_at_hand(file) {
                break;
            }
            let count = card.read(file, &mut block)?;
            self.written.hash.update(block.get(..count).unwrap_or_default());
            if count == 0 {
                self.written.file = None;
                card.close(file)?;
                return self.compare(place, card);
            }
        }
        Ok(())
    }

    /// Compares the file with the digest that it is to have. From now on it is wanted whole, or not at all.
    fn compare(&mut self, place: usize, card: &mut impl Storage) -> Result<(), Refusal> {
        let digest = self.written.hash.clone().finalize().into();
        let wanted = self.digest.replace(digest);
        if wanted.is_some_and(|wanted| wanted != digest) {
            let message = "the file has another checksum than was said: it has come damaged, send it again";
            return Err(Refusal::new(Status::UnprocessableContent, message));
        }
        place::admit(&self.path()?, self.role)?;
        self.stage = Stage::Keeping(Step::Written);
        if self.from.is_some() {
            keeping::unmark(place, card)?;
        }
        Ok(())
    }

    /// Takes the next step of a file whose form is whole. True when it is in place.
    ///
    /// # Errors
    /// The form or the file is not whole, or cannot have its name.
    pub fn go_on(&mut self, place: usize, card: &mut impl Storage) -> Result<bool, Refusal> {
        match self.stage {
            Stage::Form | Stage::Over => {}
            Stage::Whole => self.end(place, card)?,
            Stage::Reading => self.read(place, card)?,
            Stage::Keeping(step) => {
                let path = self.path()?;
                let step = keeping::go_on(place, step, &path, card)?;
                self.is_in_place |= step == Step::Noted;
                self.stage = Stage::Keeping(step);
                if step == Step::Done {
                    self.modified = card.facts(&path).map_or(0, |facts| unix_s(facts.written));
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Gives the file up, unless it is in place. [`Self::clear`] removes what is there of it, or keeps it
    /// where the form has broken off and its sender can go on with it.
    pub fn give_up(&mut self) {
        if self.stage != Stage::Form {
            self.from = None;
        }
        self.stage = Stage::Over;
    }

    /// Refuses the file: nothing of it is kept.
    pub fn refuse(&mut self) {
        self.from = None;
    }

    /// Returns whether this is a file of this digest that its sender can go on with, and still comes.
    #[must_use]
    pub fn comes_as(&self, digest: &Digest) -> bool {
        self.stage == Stage::Form && self.from.is_some() && self.digest.as_ref() == Some(digest)
    }

    /// Returns whether the file was given up.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.stage == Stage::Over
    }

    /// Removes what is there of a file that was given up, when the card is at rest. Returns what is kept of
    /// it.
    pub fn clear(&mut self, place: usize, card: &mut impl Storage) -> Option<Part> {
        if let Some(file) = self.written.file.take() {
            // What has not come to the card is sent again.
            let _ = card.close(file);
        }
        // What cannot be removed now is removed before the next upload.
        keeping::recover(place, self.from.is_some(), card).ok().flatten()
    }

    /// Returns the path of the file on the card.
    ///
    /// # Errors
    /// No file can have it.
    pub fn path(&self) -> Result<Path, Refusal> {
        self.names.path()
    }

    /// Returns what is told of the file, once it is in place.
    #[must_use]
    pub fn told(&self) -> Told {
        Told {
            size: self.written.size,
            digest: self.digest.unwrap_or_default(),
            modified: self.modified,
            prints: self.prints,
            is_in_place: self.is_in_place,
        }
    }
}

fn field_of(name: &str, file_name: Option<&str>) -> Field {
    match (name, file_name) {
        (_, Some(_)) => Field::File,
        ("path", None) => Field::Folder,
        ("root", None) => Field::Root,
        ("print", None) => Field::Print,
        ("checksum", None) => Field::Checksum,
        _ => Field::Other,
    }
}

fn begin_file(name: &str, names: &mut Names, written: &Written) -> Result<(), Refusal> {
    if written.file.is_some() {
        return Err(Refusal::bad("the form has two files: send one after the other"));
    }
    if name.is_empty() {
        return Err(Refusal::bad("the file has no name"));
    }
    names.text.extend_from_slice(name.as_bytes()).map_err(|_| Refusal::bad("the path is too long"))?;
    // The folder may yet come, and with it the path that the role is asked for.
    names.path().map(drop)
}

/// Opens the file that is written: a new one, or one that has broken off, from a place in it.
fn open_file(
    place: usize,
    digest: Option<&Digest>,
    from: Option<u32>,
    card: &mut impl Storage,
) -> Result<FileHandle, Refusal> {
    match from {
        Some(size @ 1..) => keeping::write_on(place, size, card)?.ok_or(OTHER_SIZE),
        from => Ok(keeping::begin(place, digest.filter(|_| from.is_some()), card)?),
    }
}

fn add_text(text: &mut String<TEXT_BYTES>, data: &[u8]) -> Result<(), Refusal> {
    let added = core::str::from_utf8(data).map_err(drop).and_then(|data| text.push_str(data).map_err(drop));
    added.map_err(|()| Refusal::bad("a field of the form is too long, or no text"))
}

/// Reads a digest of 64 hexadecimal digits.
///
/// # Errors
/// The text is none.
pub fn read_digest(text: &str) -> Result<Digest, Refusal> {
    let wrong = Refusal::bad("checksum is the SHA-256 of the file, in 64 hexadecimal digits");
    let mut digest = [0; DIGEST_BYTES];
    if text.len() != 2 * DIGEST_BYTES || !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(wrong);
    }
    for (place, pair) in digest.iter_mut().zip(text.as_bytes().chunks(2)) {
        let pair = core::str::from_utf8(pair).map_err(|_| wrong)?;
        *place = u8::from_str_radix(pair, 16).map_err(|_| wrong)?;
    }
    Ok(digest)
}

const fn of_form(error: Error) -> Refusal {
    match error {
        Error::Boundary => Refusal::bad("the form has no boundary"),
        Error::Part => Refusal::bad("a part of the form is malformed"),
        Error::TooLong => Refusal::bad("the form has too much beside the file"),
        Error::Short => Refusal::bad("the form ended before its end"),
    }
}

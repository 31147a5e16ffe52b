//! Requests about files: their beginning, their bodies, their answers.

use base::paths::CARD;
use base::ports::Storage;
use http::json::{Next, Parts, Writer};
use http::{Body, Fields, Made, Request, Response, Role, Status};

use super::keeping::{Part, UPLOADS};
use super::picture::{self, Picture};
use super::place;
use super::reading::{Reading, type_of};
use super::refusal::Refusal;
use super::upload::{OTHER_SIZE, Upload, read_digest};
use super::{CARD_PATIENCE_MS, Files, Visitor};

/// Headers of an upload that its sender can go on with: the SHA-256 of the whole file, and the place in it at
/// which the form goes on.
const CHECKSUM: &str = "Upload-Checksum";
const OFFSET: &str = "Upload-Offset";

/// Work of a connection on files.
#[derive(Debug)]
pub enum FileWork {
    /// Upload of this number: its form comes, or its file is put in place.
    Upload(u8),
    /// Answer that an upload is there.
    Stored(u8, Parts),
    /// File that is sent.
    Read(Reading),
    /// Picture that is looked for.
    Find(Picture),
    /// Picture that is sent.
    Picture(Picture),
}

impl FileWork {
    /// Returns whether the answer has begun.
    #[must_use]
    pub const fn is_answered(&self) -> bool {
        matches!(self, Self::Stored(..) | Self::Read(_) | Self::Picture(_))
    }
}

/// Upload that has ended: how.
#[derive(Debug)]
pub enum Stored {
    /// The file is there; whether it is to be played.
    Whole(bool),
    Refused(Refusal),
}

impl Files {
    /// Begins an upload, or goes on with one that broke off.
    ///
    /// # Errors
    /// There are as many as can be, the form is none, or what is there is not what it goes on with.
    pub fn begin_upload(&mut self, request: &Request<'_>, role: Role) -> Result<FileWork, Refusal> {
        let digest = request.header(CHECKSUM).map(read_digest).transpose()?;
        let size = request.header(OFFSET).map_or(Ok(0), str::parse).map_err(|_| OTHER_SIZE)?;
        let part = digest.map(|digest| Part { digest, size });
        let Self { uploads, kept, .. } = self;
        let place = if size > 0 {
            let goes_on = |kept: &Option<(Part, u64)>| part.is_some() && kept.map(|(kept, _)| kept) == part;
            kept.iter().position(goes_on).ok_or(OTHER_SIZE)?
        } else {
            // Another's part makes room only where there is no other.
            let is_free = |place: &usize| uploads.get(*place).is_some_and(Option::is_none);
            let has_part = |place: &usize| kept.get(*place).is_some_and(Option::is_some);
            let busy = Refusal::new(Status::ServiceUnavailable, "two uploads are under way: wait for one to end");
            (0..UPLOADS).filter(is_free).min_by_key(has_part).ok_or(busy)?
        };
        let upload = Upload::new(request.header("Content-Type").unwrap_or_default(), role, part)?;
        if let (Some(free), Some(kept)) = (uploads.get_mut(place), kept.get_mut(place)) {
            (*free, *kept) = (Some(upload), None);
        }
        Ok(FileWork::Upload(place as u8))
    }

    /// Returns how much is there of the file of which a request has the digest, and the number of the upload
    /// that it came by, if that had not ended: it has now. The card is at rest.
    ///
    /// # Errors
    /// The request has no digest.
    pub fn ask_part(
        &mut self,
        request: &Request<'_>,
        now_ms: u64,
        card: &mut impl Storage,
    ) -> Result<(u32, Option<u8>), Refusal> {
        let digest = read_digest(request.header(CHECKSUM).unwrap_or_default())?;
        let comes = |upload: &Option<Upload>| upload.as_ref().is_some_and(|upload| upload.comes_as(&digest));
        let under_way = self.uploads.iter().position(comes);
        if let Some(place) = under_way
            && let Some(upload) = self.uploads.get_mut(place).and_then(Option::as_mut)
        {
            upload.give_up();
            self.clear_at(place, now_ms, card);
        }
        self.recover(now_ms, card);
        let part = self.kept.iter().flatten().find(|(part, _)| part.digest == digest);
        Ok((part.map_or(0, |(part, _)| part.size), under_way.map(|place| place as u8)))
    }

    /// Begins to send a file, or a picture out of one. `rest` is the path below the root. Without a head the
    /// answer begins later.
    ///
    /// # Errors
    /// Those of the path and the card.
    pub fn begin_reading(
        &mut self,
        rest: &str,
        request: &Request<'_>,
        card: &mut impl Storage,
    ) -> Result<(Option<Response>, Option<FileWork>), Refusal> {
        if let Some((folder, name, picture)) = picture::parts(rest) {
            let path = place::below(&place::below(CARD, folder)?, name)?;
            return Ok((None, Some(FileWork::Find(Picture::begin(&path, picture, card)?))));
        }
        let path = place::below(CARD, rest)?;
        let (response, reading) = Reading::begin(&path, "application/octet-stream", true, request, card)?;
        Ok((Some(response), reading.map(FileWork::Read)))
    }

    /// Begins to send a file of the user's own page, if there is one.
    ///
    /// # Errors
    /// There is none.
    pub fn begin_page(
        &mut self,
        path: &str,
        request: &Request<'_>,
        card: &mut impl Storage,
    ) -> Result<(Response, Option<FileWork>), Refusal> {
        let path = place::below(place::PAGE_FOLDER, if path == "/" { "index.html" } else { path })?;
        let (response, reading) = Reading::begin(&path, type_of(&path), false, request, card)?;
        Ok((response, reading.map(FileWork::Read)))
    }

    /// Removes a file at once. `rest` is its path below the root.
    ///
    /// # Errors
    /// Those of the path, the role and the card.
    pub fn remove(&mut self, rest: &str, role: Role, card: &mut impl Storage) -> Result<(), Refusal> {
        let path = place::below(CARD, rest)?;
        place::admit(&path, role)?;
        if card.facts(&path)?.is_directory {
            return Err(Refusal::new(Status::Conflict, "this is a folder"));
        }
        card.remove(&path)?;
        self.note("delete_file", &path);
        Ok(())
    }

    /// Returns how many of the bytes that have come are to be taken together; none while they have to wait.
    pub fn most(
        &mut self,
        work: &FileWork,
        place: u8,
        come: usize,
        body_left: Option<u64>,
        now_ms: u64,
        card: &mut impl Storage,
    ) -> Option<usize> {
        let FileWork::Upload(number) = work else { return Some(come) };
        let Some(Some(upload)) = self.uploads.get(usize::from(*number)).filter(|_| come > 0) else { return Some(come) };
        let most = upload.takes(come, body_left);
        let writes_on = most > 0 && upload.writes_on(most, card);
        (writes_on || most > 0 && self.has_card(Visitor::Connection(place), now_ms, card)).then_some(most)
    }

    /// Takes a piece of an upload's form.
    ///
    /// # Errors
    /// Why the upload is refused.
    pub fn take(&mut self, number: u8, bytes: &[u8], card: &mut impl Storage) -> Result<(), Refusal> {
        match self.uploads.get_mut(usize::from(number)) {
            Some(Some(upload)) => {
                let taken = upload.take(usize::from(number), bytes, card);
                if taken.is_err() {
                    upload.refuse();
                }
                taken
            }
            Some(None) | None => Err(Refusal::bad("the upload has ended")),
        }
    }

    /// Notes that an upload's form is whole.
    pub fn end_form(&mut self, number: u8) {
        if let Some(Some(upload)) = self.uploads.get_mut(usize::from(number)) {
            upload.hear_end();
        }
    }

    /// Goes on to put an upload in place. None while there is more to do.
    pub fn keep(&mut self, number: u8, place: u8, now_ms: u64, card: &mut impl Storage) -> Option<Stored> {
        if !self.upload(number).is_some_and(Upload::is_whole)
            || !self.has_card(Visitor::Connection(place), now_ms, card)
        {
            return None;
        }
        let upload = self.uploads.get_mut(usize::from(number))?.as_mut()?;
        if upload.reads() && !self.reads.take(place, now_ms, CARD_PATIENCE_MS) {
            return None;
        }
        let done = upload.go_on(usize::from(number), card);
        let path = upload.path().unwrap_or_default();
        let told = upload.told();
        match done {
            Ok(false) => None,
            Ok(true) => {
                self.note(told.action(), &path);
                Some(Stored::Whole(told.prints))
            }
            Err(refusal) => Some(Stored::Refused(refusal)),
        }
    }

    /// Ends the turn of a connection that has got something of its file.
    fn ended(&mut self, place: u8, made: Made) -> Made {
        if made != Made::Part(0) {
            self.reads.end(place);
        }
        made
    }

    fn upload(&self, number: u8) -> Option<&Upload> {
        self.uploads.get(usize::from(number))?.as_ref()
    }

    /// Returns the path on the card of an upload that is in place.
    #[must_use]
    pub fn path_of(&self, number: u8) -> base::paths::Path {
        self.upload(number).and_then(|upload| upload.path().ok()).unwrap_or_default()
    }

    /// Ends a connection's work, done or not.
    pub fn end(&mut self, work: FileWork, place: u8, card: &mut impl Storage) {
        self.card.end(Visitor::Connection(place).number());
        self.reads.end(place);
        match work {
            FileWork::Upload(number) => {
                if let Some(Some(upload)) = self.uploads.get_mut(usize::from(number)) {
                    upload.give_up();
                }
            }
            FileWork::Stored(number, _) => {
                if let Some(upload) = self.uploads.get_mut(usize::from(number)) {
                    *upload = None;
                }
            }
            FileWork::Read(reading) => reading.end(card),
            FileWork::Find(picture) | FileWork::Picture(picture) => {
                // A file that was only read has nothing to lose.
                let _ = card.close(picture.file());
            }
        }
    }

    /// Clears away uploads that were given up. Returns whether some are left.
    pub fn clear(&mut self, now_ms: u64, card: &mut impl Storage) -> bool {
        for place in 0..UPLOADS {
            if !self.upload(place as u8).is_some_and(Upload::is_over) {
                continue;
            }
            if !self.has_card(Visitor::Site, now_ms, card) {
                return true;
            }
            self.clear_at(place, now_ms, card);
        }
        false
    }

    /// Clears away an upload that was given up, and keeps what its sender can go on with.
    fn clear_at(&mut self, place: usize, now_ms: u64, card: &mut impl Storage) {
        let over = self.uploads.get_mut(place).and_then(Option::take);
        if let (Some(mut over), Some(kept)) = (over, self.kept.get_mut(place)) {
            *kept = over.clear(place, card).map(|part| (part, now_ms));
        }
    }

    /// Notes whether an upload that is in place is played.
    pub fn note_started(&mut self, number: u8, is_started: bool) {
        if let Some(Some(upload)) = self.uploads.get_mut(usize::from(number)) {
            upload.prints = is_started;
        }
    }
}

/// Body of an answer about files.
pub struct FileBody<'b, S> {
    /// Work that is answered.
    pub work: &'b mut FileWork,
    /// Place of the connection.
    pub place: u8,
    /// Files, and the card.
    pub files: &'b mut Files,
    pub card: &'b mut S,
    /// Time since the start, milliseconds.
    pub now_ms: u64,
}

impl<S: Storage> Body for FileBody<'_, S> {
    fn fields(&self, fields: &mut Fields<'_, '_>) {
        if let FileWork::Read(Reading { is_attachment: true, .. }) = self.work {
            fields.line("Content-Disposition", "attachment");
        }
    }

    fn make(&mut self, room: &mut [u8]) -> Made {
        match self.work {
            FileWork::Upload(_) | FileWork::Find(_) => Made::Part(0),
            FileWork::Stored(number, parts) => match self.files.upload(*number) {
                Some(upload) => parts.make(room, |_, json| write_stored(upload, json)),
                None => Made::Failed,
            },
            FileWork::Read(_) | FileWork::Picture(_)
                if !self.files.reads.take(self.place, self.now_ms, CARD_PATIENCE_MS) =>
            {
                Made::Part(0)
            }
            FileWork::Read(reading) => self.files.ended(self.place, reading.make(room, self.card)),
            FileWork::Picture(picture) => self.files.ended(self.place, picture.make(room, self.card)),
        }
    }
}

/// Writes the answer to an upload.
fn write_stored(upload: &Upload, json: &mut Writer<'_, '_>) -> Next {
    let told = upload.told();
    let path = upload.path().unwrap_or_default();
    json.begin_object();
    json.key("item");
    json.begin_object();
    json.key("root");
    json.text(place::ROOT);
    json.key("path");
    json.text(place::shown(&path));
    json.key("size");
    json.number(u64::from(told.size));
    json.key("modified");
    json.number(told.modified);
    json.key("permissions");
    json.text("rw");
    json.end_object();
    json.key("print_started");
    json.bool(told.prints);
    json.key("print_queued");
    json.bool(false);
    json.key("action");
    json.text(told.action());
    json.key("checksum");
    json.begin_text();
    for byte in told.digest {
        let digits = [byte >> 4, byte & 15].map(|digit| char::from_digit(u32::from(digit), 16).unwrap_or('0'));
        digits.iter().for_each(|digit| json.more_text(digit.encode_utf8(&mut [0; 4])));
    }
    json.end_text();
    json.end_object();
    Next::End
}

/// Returns whether a request that begins like this may want the card: it waits in its socket until the card
/// is at rest.
#[must_use]
pub fn may_want_card(bytes: &[u8]) -> bool {
    const METHODS: [&[u8]; 3] = [b"GET ", b"HEAD ", b"DELETE "];
    // What tells of the machine, and stops it, never waits.
    const OTHERS: [&[u8]; 4] = [b"/printer/", b"/websocket", b"/server/info", b"/access/"];
    let rest = METHODS.iter().find_map(|method| bytes.strip_prefix(*method));
    rest.is_some_and(|rest| !OTHERS.iter().any(|other| rest.starts_with(other)))
}

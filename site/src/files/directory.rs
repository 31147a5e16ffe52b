//! A folder's entries in JSON, made as they are read (Moonraker's `server.files.get_directory` and `.list`).

use base::ports::{DirectoryEntry, FileTime, Storage};
use http::json::{Next, Writer};

use super::place;

/// Entries that are read in one go, so that a folder of a thousand takes nobody's time.
const ENTRIES: usize = 16;

/// Shape of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Folders, files, and how full the card is.
    Directory,
    /// Files alone, as a plain list.
    List,
}

/// Part of the list that is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Begin,
    Folders,
    Files,
    Rest,
}

/// A list, as far as it is out.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    shape: Shape,
    /// Number of the part that is made, its stage and its entry.
    part: u32,
    stage: Stage,
    at: u16,
    /// Stage and entry of the part behind it.
    next: (Stage, u16),
}

impl Walk {
    /// Begins the list of a folder.
    #[must_use]
    pub const fn new(shape: Shape) -> Self {
        Self { shape, part: 0, stage: Stage::Begin, at: 0, next: (Stage::Begin, 0) }
    }

    /// Writes a part of the list of a folder. `free` is the free and the whole space of the card, once they
    /// are known.
    pub fn write(
        &mut self,
        part: u32,
        folder: &str,
        free: Option<(u64, u64)>,
        card: &mut impl Storage,
        json: &mut Writer<'_, '_>,
    ) -> Next {
        if part != self.part {
            (self.part, (self.stage, self.at)) = (part, self.next);
        }
        match (self.stage, self.shape) {
            (Stage::Begin, Shape::Directory) => {
                json.begin_object();
                json.key("dirs");
                json.begin_array();
                self.next = (Stage::Folders, 0);
            }
            (Stage::Begin, Shape::List) => {
                json.begin_array();
                self.next = (Stage::Files, 0);
            }
            (Stage::Folders | Stage::Files, _) => return self.write_entry(folder, card, json),
            (Stage::Rest, Shape::Directory) => {
                write_rest(free, json);
                return Next::End;
            }
            (Stage::Rest, Shape::List) => return Next::End,
        }
        Next::Part
    }

    /// Writes the next entry that belongs into the list, or the list's end.
    fn write_entry(&mut self, folder: &str, card: &mut impl Storage, json: &mut Writer<'_, '_>) -> Next {
        let is_for_folders = self.stage == Stage::Folders;
        for _ in 0..ENTRIES {
            // A card that fails in the middle of the list ends it: the head of the answer is out.
            let Ok(Some(entry)) = card.entry(folder, usize::from(self.at)) else {
                json.end_array();
                if is_for_folders {
                    json.key("files");
                    json.begin_array();
                }
                self.next = (if is_for_folders { Stage::Files } else { Stage::Rest }, 0);
                return Next::Part;
            };
            if entry.is_directory == is_for_folders && !place::is_hidden(&entry.name) {
                self.write_named(&entry, json);
                self.next = (self.stage, self.at + 1);
                return Next::Part;
            }
            self.at += 1;
        }
        Next::Later
    }

    fn write_named(&self, entry: &DirectoryEntry, json: &mut Writer<'_, '_>) {
        json.begin_object();
        json.key(match (self.shape, self.stage) {
            (Shape::List, _) => "path",
            (Shape::Directory, Stage::Folders) => "dirname",
            (Shape::Directory, _) => "filename",
        });
        json.text(&entry.name);
        write_facts(entry.size_bytes, entry.written, json);
        json.end_object();
    }
}

/// Writes the members that tell of a file.
pub fn write_facts(size: u32, written: FileTime, json: &mut Writer<'_, '_>) {
    json.key("size");
    json.number(u64::from(size));
    json.key("modified");
    json.number(unix_s(written));
    json.key("permissions");
    json.text("rw");
}

fn write_rest(free: Option<(u64, u64)>, json: &mut Writer<'_, '_>) {
    json.key("disk_usage");
    match free {
        Some((free, total)) => {
            json.begin_object();
            json.key("total");
            json.number(total);
            json.key("used");
            json.number(total.saturating_sub(free));
            json.key("free");
            json.number(free);
            json.end_object();
        }
        None => json.null(),
    }
    json.key("root_info");
    json.begin_object();
    json.key("name");
    json.text(place::ROOT);
    json.key("permissions");
    json.text("rw");
    json.end_object();
    json.end_object();
}

/// Returns a file's time in seconds since 1970, as if the board's clock were set to UTC: it is.
#[must_use]
pub fn unix_s(at: FileTime) -> u64 {
    // Days from a year that begins in March, so that a leap day is the last one (Hinnant, "chrono-compatible
    // low-level date algorithms").
    let (month, day) = (u64::from(at.month.max(1)), u64::from(at.day.max(1)));
    let year = u64::from(at.year) - u64::from(month <= 2);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let days = 365 * year + year / 4 - year / 100 + year / 400 + of_year;
    (days.saturating_sub(719_468) * 24 + u64::from(at.hour)) * 3_600 + u64::from(at.minute) * 60
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_seconds_since_1970() {
        let at = |year, month, day, hour, minute| unix_s(FileTime { year, month, day, hour, minute });
        assert_eq!(at(1980, 1, 1, 0, 0), 315_532_800);
        assert_eq!(at(2000, 2, 29, 12, 34), 951_827_640);
        assert_eq!(at(2024, 3, 1, 0, 0), 1_709_251_200);
        assert_eq!(at(2026, 11, 29, 23, 59), 1_795_996_740);
        assert_eq!(at(1980, 0, 0, 0, 0), 315_532_800, "no date");
    }
}

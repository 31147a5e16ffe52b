//! Long answers: `ls`, M20, `cat`, `config-get`. Each is given in pieces, as fast as its session takes them,
//! beside everything else.
//!
//! A piece is at most [`MOST_BYTES`] long, or one entry of a directory: with the bytes waiting already, less
//! than a session's output holds.

use base::failure::{Failure, Texts};
use base::paths::{CARD, CONFIG_PATH, Path, quoted, words};
use base::ports::{DirectoryEntry, FileTime, LIST_CHUNK, OpenMode, Storage, StorageError};
use base::secrets::open_to_show;
use base::sessions::{Listing, Reply};
use heapless::{String, Vec};
use units::Micros;

use super::Files;

/// Longest piece in bytes.
const MOST_BYTES: usize = 1_024;
/// Bytes in an entry's line beside its name: marks, a date, its size, blanks, the line's end.
const ENTRY_BYTES: usize = 36;
/// Bytes of a file shown at a time.
const FILE_CHUNK: usize = 128;
/// Delay of `cat -d`.
const DELAY: Micros = Micros::from_seconds(5);
/// Bytes of config.ini searched at a time.
const CONFIG_CHUNK: usize = 512;

// --- how they begin ---

/// `ls [-1] [path]`: begins the listing of a directory.
///
/// # Errors
/// None.
pub fn directory(files: &Files, arguments: &str) -> Result<Option<Listing>, Failure> {
    let names_only = words(arguments).any(|word| word == "-1");
    let place = words(arguments).find(|word| !word.starts_with('-')).unwrap_or("");
    let path = files.absolute(place);
    Ok(Some(Listing::Directory { path, seen: 0, sums: (0, 0, 0), names_only, for_m20: false }))
}

/// M20: begins the listing of the names on the card. The first line is the caller's.
#[must_use]
pub fn card() -> Listing {
    // The card's name fits into a path.
    let path = Path::try_from(CARD).unwrap_or_default();
    Listing::Directory { path, seen: 0, sums: (0, 0, 0), names_only: true, for_m20: true }
}

/// `cat file [-d] [lines]`: begins to show a file; none when it cannot be read, which has been printed. `-d`
/// waits, so that the user can begin to record, and ends with Ctrl-Z.
///
/// # Errors
/// When the name is missing.
pub fn file(
    files: &Files,
    arguments: &str,
    now: Micros,
    storage: &mut impl Storage,
    reply: &mut Reply<'_>,
) -> Result<Option<Listing>, Failure> {
    let mut names = words(arguments).filter(|word| *word != "-d");
    let Some(name) = names.next() else {
        reply.say(format_args!("file name required\nok\n"));
        return Ok(None);
    };
    let path = files.absolute(name);
    let lines = names.next().and_then(|word| word.parse::<u32>().ok()).unwrap_or(u32::MAX);
    let begins = words(arguments).any(|word| word == "-d").then(|| now.plus(DELAY));
    match open_to_show(storage, &path, OpenMode::Read) {
        Ok(file) => Ok(Some(Listing::File { path, file, lines, carried: Vec::new(), begins })),
        Err(StorageError::NotFound) => {
            reply.say(format_args!("File not found: {name}\n"));
            Ok(None)
        }
        Err(error) => {
            reply.say(format_args!("Could not read {path}: {}\n", error.text()));
            Ok(None)
        }
    }
}

/// `config-get "section"`: begins to show the settings of a section.
///
/// # Errors
/// When config.ini cannot be read.
pub fn section(
    texts: &Texts,
    arguments: &str,
    storage: &mut impl Storage,
    reply: &mut Reply<'_>,
) -> Result<Option<Listing>, Failure> {
    let (section, _) = quoted(arguments);
    if section.is_empty() {
        reply.say(format_args!("Usage: config-get section\nok\n"));
        return Ok(None);
    }
    let section = String::try_from(section).map_err(|_| Failure::refused(&"no section has a name as long as this"))?;
    let file = storage.open(CONFIG_PATH, OpenMode::Read).map_err(|error| config_failed(texts, error))?;
    Ok(Some(Listing::Section { file, section, inside: false, found: false, line: Vec::new(), begins: true }))
}

fn config_failed(texts: &Texts, error: StorageError) -> Failure {
    texts.about_file(CONFIG_PATH, error.text())
}

// --- how they end ---

/// Closes the file of a listing, at its end or before.
pub fn close(listing: &Listing, storage: &mut impl Storage) {
    if let Listing::File { file, .. } | Listing::Section { file, .. } = listing {
        // A failing close loses nothing: the file was only read.
        let _ = storage.close(*file);
    }
}

/// Returns the text behind a listing, also behind one that was stopped: its sender waits for it.
#[must_use]
pub const fn ending(listing: &Listing) -> &'static str {
    match listing {
        Listing::Directory { for_m20: true, .. } => "End file list\nok\n",
        Listing::File { begins: Some(_), .. } => "\x1a\n",
        Listing::File { .. } | Listing::Section { .. } => "",
        _ => "ok\n",
    }
}

// --- their pieces ---

/// Prints some more of a listing of files. False at its end; then [`close`] and [`ending`] remain.
///
/// # Errors
/// When config.ini cannot be read.
pub fn piece(
    texts: &Texts,
    listing: &mut Listing,
    now: Micros,
    storage: &mut impl Storage,
    reply: &mut Reply<'_>,
) -> Result<bool, Failure> {
    match listing {
        Listing::File { begins: Some(begins), .. } if now < *begins => Ok(true),
        Listing::Directory { .. } => Ok(directory_piece(listing, storage, reply)),
        Listing::File { .. } => Ok(file_piece(listing, storage, reply)),
        _ => section_piece(texts, listing, storage, reply),
    }
}

/// Prints some more entries of a directory.
fn directory_piece(listing: &mut Listing, storage: &mut impl Storage, reply: &mut Reply<'_>) -> bool {
    let Listing::Directory { path, seen, sums, names_only, for_m20 } = listing else { return false };
    let mut entries: Vec<DirectoryEntry, LIST_CHUNK> = Vec::new();
    if let Err(error) = storage.list(path, *seen, &mut entries) {
        // After an error of M20 its end is not printed.
        match core::mem::take(for_m20) {
            true => reply.say(format_args!("error:{}\n", error.text())),
            false => reply.say(format_args!("Could not open directory {path} ({})\n", error.text())),
        }
        return false;
    }
    if entries.is_empty() && !*names_only {
        let (files, directories, bytes) = *sums;
        reply.say(format_args!("{files:4} File(s),{bytes:10} bytes total\n{directories:4} Dir(s)\n"));
    }
    let mut said = 0;
    for entry in &entries {
        let length = entry.name.len() + ENTRY_BYTES;
        if said > 0 && said + length > MOST_BYTES {
            // The entry comes with the next piece.
            break;
        }
        said += length;
        *seen += 1;
        say_entry(entry, *names_only, reply);
        let (files, directories, bytes) = sums;
        *if entry.is_directory { directories } else { files } += 1;
        *bytes += u64::from(entry.size_bytes);
    }
    said > 0
}

fn say_entry(entry: &DirectoryEntry, names_only: bool, reply: &mut Reply<'_>) {
    if names_only {
        let slash = if entry.is_directory { "/" } else { "" };
        return reply.say(format_args!("{}{slash}\n", entry.name));
    }
    let marks = entry.attributes;
    let marks = [entry.is_directory, marks.read_only, marks.hidden, marks.system, marks.archive];
    for (letter, is_marked) in ['D', 'R', 'H', 'S', 'A'].into_iter().zip(marks) {
        reply.say(format_args!("{}", if is_marked { letter } else { '-' }));
    }
    let FileTime { year, month, day, hour, minute } = entry.written;
    let (size, name) = (entry.size_bytes, &entry.name);
    reply.say(format_args!(" {year}/{month:02}/{day:02} {hour:02}:{minute:02} {size:9}  {name}\n"));
}

/// Prints some more bytes of a file.
fn file_piece(listing: &mut Listing, storage: &mut impl Storage, reply: &mut Reply<'_>) -> bool {
    let Listing::File { path, file, lines, carried, .. } = listing else { return false };
    let mut bytes = [0; FILE_CHUNK];
    let count = match storage.read(*file, &mut bytes) {
        Ok(count) => count,
        Err(error) => {
            reply.say(format_args!("Could not read {path}: {}\n", error.text()));
            return false;
        }
    };
    let mut chunk: Vec<u8, { FILE_CHUNK + 4 }> = Vec::new();
    // The chunk has room for both parts.
    let _ = chunk.extend_from_slice(carried);
    let _ = chunk.extend_from_slice(bytes.get(..count).unwrap_or(&[]));
    carried.clear();
    show_text(&chunk, count == 0, lines, carried, reply);
    count > 0 && *lines > 0
}

/// Prints bytes as text. A character cut by their end goes with the next ones; bytes that are no text show as
/// dots.
fn show_text(bytes: &[u8], at_end: bool, lines: &mut u32, carried: &mut Vec<u8, 4>, reply: &mut Reply<'_>) {
    let mut rest = bytes;
    while !rest.is_empty() && *lines > 0 {
        let (text, is_cut) = match core::str::from_utf8(rest) {
            Ok(text) => (text, false),
            Err(error) => (beginning(rest), error.error_len().is_none()),
        };
        for line in text.split_inclusive('\n').take(*lines as usize) {
            reply.say(format_args!("{line}"));
            *lines = lines.saturating_sub(u32::from(line.ends_with('\n')));
        }
        rest = match rest.get(text.len()..).unwrap_or(&[]) {
            behind if is_cut && !at_end => {
                // A character is cut after its third byte at most.
                let _ = carried.extend_from_slice(behind);
                &[]
            }
            [_, behind @ ..] => {
                if *lines > 0 {
                    reply.say(format_args!("."));
                }
                behind
            }
            [] => &[],
        };
    }
}

/// Returns the longest beginning of these bytes that is text.
fn beginning(bytes: &[u8]) -> &str {
    match core::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => core::str::from_utf8(bytes.get(..error.valid_up_to()).unwrap_or(&[])).unwrap_or(""),
    }
}

/// Searches some more of config.ini for settings of the section.
fn section_piece(
    texts: &Texts,
    listing: &mut Listing,
    storage: &mut impl Storage,
    reply: &mut Reply<'_>,
) -> Result<bool, Failure> {
    let Listing::Section { file, section, inside, found, line, begins } = listing else { return Ok(false) };
    let mut bytes = [0; CONFIG_CHUNK];
    let count = storage.read(*file, &mut bytes).map_err(|error| config_failed(texts, error))?;
    if count == 0 {
        show_setting(line, *begins, section, inside, reply);
        *found |= *inside;
        if !*found {
            reply.say(format_args!("No section named {section}\n"));
        }
        return Ok(false);
    }
    for byte in bytes.get(..count).unwrap_or(&[]) {
        let ends = *byte == b'\n';
        if ends || line.is_full() {
            show_setting(line, *begins, section, inside, reply);
            *found |= *inside;
            line.clear();
            // The rest of a line that does not fit is comment.
            *begins = ends;
        }
        if !ends {
            // There is room for the byte now.
            let _ = line.push(*byte);
        }
    }
    Ok(true)
}

/// Prints the setting of a line, if it is in the section.
fn show_setting(line: &[u8], begins: bool, section: &str, inside: &mut bool, reply: &mut Reply<'_>) {
    let text = beginning(line);
    let content = text.split_once('#').map_or(text, |(content, _)| content).trim();
    if !begins {
        return;
    }
    if let Some(header) = content.strip_prefix('[') {
        *inside = header.split_once(']').is_some_and(|(name, _)| name == section);
    } else if let Some((key, value)) = content.split_once('=').filter(|_| *inside) {
        reply.say(format_args!("{} = {}\n", key.trim(), value.trim()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{Card, Desk};

    type Text = std::string::String;

    /// Returns the whole of a listing with its end, and its longest piece.
    fn whole(mut listing: Listing, card: &mut Card) -> (Text, usize) {
        let (mut text, mut longest, mut more) = (Text::new(), 0, true);
        let mut desk = Desk::new();
        while more {
            let said = desk.hears(|reply| more = piece(&Texts::new(), &mut listing, Micros(0), card, reply).unwrap());
            longest = longest.max(said.len());
            text += &said;
        }
        close(&listing, card);
        assert_eq!(card.open_files(), 0);
        (text + ending(&listing), longest)
    }

    fn of_directory(arguments: &str, card: &mut Card) -> (Text, usize) {
        whole(directory(&Files::default(), arguments).unwrap().unwrap(), card)
    }

    #[test]
    fn names_alone_come_without_sums() {
        let mut card = Card::with(&[("/sd/a.g", "G28\n"), ("/sd/b.g", "")]);
        let mut begun = directory(&Files::default(), "").unwrap().unwrap();
        if let Listing::Directory { names_only, .. } = &mut begun {
            *names_only = true;
        }
        let (names, _) = whole(begun, &mut card);
        assert!(names.starts_with("a.g\nb.g\n") && !names.contains("File(s)"), "{names}");
        begun = directory(&Files::default(), "").unwrap().unwrap();
        if let Listing::Directory { names_only, .. } = &mut begun {
            *names_only = false;
        }
        let (all, _) = whole(begun, &mut card);
        assert_eq!(all.matches("   2 File(s),         4 bytes total\n   0 Dir(s)\n").count(), 1, "{all}");
    }

    fn listed(arguments: &str, card: &mut Card) -> Text {
        of_directory(arguments, card).0
    }

    fn shown(arguments: &str, card: &mut Card) -> Text {
        let mut begun = None;
        let said =
            Desk::new().hears(|reply| begun = file(&Files::default(), arguments, Micros(0), card, reply).unwrap());
        begun.map_or(said, |listing| whole(listing, card).0)
    }

    fn of_section(name: &str, config: &[u8]) -> Text {
        let mut card = Card::default();
        card.put(CONFIG_PATH, config);
        let mut begun = None;
        Desk::new().hears(|reply| begun = section(&Texts::new(), name, &mut card, reply).unwrap());
        whole(begun.unwrap(), &mut card).0
    }

    #[test]
    fn a_directory_is_listed_with_its_totals() {
        let mut card = Card::with(&[("/sd/a.g", "G28\n"), ("/sd/b.g", ""), ("/sd/c.g", "1"), ("/sd/d.g", "22")]);
        card.make_directory("/sd/parts").unwrap();
        let dated = |marks, rest| format!("{marks} 2021/05/18 18:20         {rest}\n");
        let mut expected = dated("D----", "0  parts");
        ["4  a.g", "0  b.g", "1  c.g", "2  d.g"].iter().for_each(|rest| expected += &dated("-----", *rest));
        expected += "   4 File(s),         7 bytes total\n   1 Dir(s)\nok\n";
        assert_eq!(listed("", &mut card), expected);
        assert_eq!(listed("-1", &mut card), "parts/\na.g\nb.g\nc.g\nd.g\nok\n");
        assert_eq!(listed("-1 parts", &mut card), "ok\n");
        assert_eq!(listed("no", &mut card), "Could not open directory /sd/no (no such file)\nok\n");
    }

    #[test]
    fn m20_has_an_end_unless_it_failed() {
        let mut there = Card::with(&[("/sd/a.g", "")]);
        assert_eq!(ending(&card()), "End file list\nok\n", "also when it is stopped");
        assert_eq!(whole(card(), &mut there).0, "a.g\nEnd file list\nok\n");
        there.fails = true;
        assert_eq!(whole(card(), &mut there).0, "error:the SD card reports a read or write error\nok\n");
    }

    #[test]
    fn no_name_is_lost_however_long_they_are() {
        let names: std::vec::Vec<Text> = (0..9).map(|i| format!("{i}{}", "n".repeat((100 * i + 1).min(760)))).collect();
        let mut card = Card::default();
        names.iter().for_each(|name| card.put(&format!("/sd/{name}"), b""));
        let (text, longest) = of_directory("-1", &mut card);
        assert_eq!(text, names.join("\n") + "\nok\n");
        assert!(longest <= MOST_BYTES, "{longest}");
    }

    #[test]
    fn a_file_is_shown_whole_or_its_first_lines() {
        let text = "first\n\u{e4}\u{20ac}\u{1f600}\n".repeat(40) + "no end";
        let mut card = Card::with(&[("/sd/with space.g", &text)]);
        assert_eq!(shown("\"with space.g\"", &mut card), text);
        assert_eq!(shown("\"with space.g\" 3", &mut card), "first\n\u{e4}\u{20ac}\u{1f600}\nfirst\n");
        assert_eq!(shown("\"with space.g\" 0", &mut card), "");
        assert_eq!(shown("no.g", &mut card), "File not found: no.g\n");
    }

    #[test]
    fn what_is_no_text_shows_as_dots_to_its_last_byte() {
        let mut card = Card::default();
        card.put("/sd/b", b"a\xffb\xc3\xc3\xa4\xe2\x82");
        assert_eq!(shown("b", &mut card), "a.b.\u{e4}..");
        card.put("/sd/b", &[0x80; 300]);
        assert_eq!(shown("b", &mut card), ".".repeat(300));
    }

    #[test]
    fn a_card_that_fails_is_told() {
        let mut card = Card::with(&[("/sd/a.g", "G28\n"), (CONFIG_PATH, "[a]\n")]);
        let (mut desk, mut shows) = (Desk::new(), None);
        desk.hears(|reply| shows = file(&Files::default(), "a.g", Micros(0), &mut card, reply).unwrap());
        card.fails = true;
        let why = "the SD card reports a read or write error";
        assert_eq!(whole(shows.unwrap(), &mut card).0, format!("Could not read /sd/a.g: {why}\n"));
        let mut gets = None;
        desk.hears(|reply| gets = section(&Texts::new(), "a", &mut card, reply).unwrap());
        let mut gets = gets.unwrap();
        desk.hears(|reply| {
            let texts = Texts::new();
            let failed = piece(&texts, &mut gets, Micros(0), &mut card, reply).unwrap_err();
            assert_eq!(texts.of(failed).to_string(), format!("{CONFIG_PATH}: {why}"));
        });
        close(&gets, &mut card);
        assert_eq!(card.open_files(), 0);
    }

    #[test]
    fn a_section_is_shown_without_comments() {
        let config = b"[one]\na = 1\n[motion control]\nspeed = 3 # fast\n# c = 4\n d=5\r\n[two]\ne = 6";
        assert_eq!(of_section("\"motion control\"", config), "speed = 3\nd = 5\n");
        assert_eq!(of_section("two", config), "e = 6\n");
        assert_eq!(of_section("three", config), "No section named three\n");
        Desk::new()
            .hears(|reply| assert!(section(&Texts::new(), &"x".repeat(49), &mut Card::default(), reply).is_err()));
    }

    #[test]
    fn a_setting_is_shown_wherever_the_end_of_the_piece_or_of_the_buffer_cuts_its_line() {
        for blanks in 0..CONFIG_CHUNK {
            let config = format!("#{}\n[one]\nkey = value\n", " ".repeat(blanks));
            assert_eq!(of_section("one", config.as_bytes()), "key = value\n", "{blanks}");
        }
        for length in 300..330 {
            let config = format!("[one]\nkey = value #{}\u{20ac}x = 3\n[two]\n", "x".repeat(length));
            assert_eq!(of_section("one", config.as_bytes()), "key = value\n", "{length}");
        }
    }
}

//! File commands that read a whole file: `cp`, `truncate`, `md5sum`. Other work gets its turns meanwhile.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::paths::Path;
use base::paths::{absolute, words};
use base::ports::{FileHandle, OpenMode, Storage, StorageError, Wake};
use base::safe_file::{self, Draft};
use base::secrets::open_to_show;
use md5::{Digest, Md5};

/// Bytes read at a time: a block of the card.
const BLOCK: usize = 512;

/// Blocks that are only read before other work has a turn: a hundred microseconds.
const BLOCKS_IN_A_ROW: u32 = 8;

/// Hands a file to `take`, block by block, at most `most` bytes. Ctrl-Y ends it, with false.
pub fn read_through<'c, H: Hands<'c>>(
    hands: &mut H,
    file: FileHandle,
    most: u32,
    writes: bool,
    mut take: impl FnMut(&mut H::Ports, &[u8]) -> Result<(), StorageError>,
) -> Result<bool, StorageError> {
    let (mut left, mut turn) = (most, 0_u32);
    hands.read_ahead(file);
    while left > 0 {
        while !hands.storage().is_at_hand(file) {
            hands.wait(Wake::Any).whatever_happens();
        }
        let mut block = [0; BLOCK];
        let count = hands.storage().read(file, &mut block)?.min(left as usize);
        if count == 0 {
            break;
        }
        left -= count as u32;
        if writes {
            hands.card_at_rest();
        }
        take(hands.storage(), block.get(..count).unwrap_or(&[]))?;
        if hands.stop_requested() {
            return Ok(false);
        }
        turn = turn.wrapping_add(1);
        if writes || turn.is_multiple_of(BLOCKS_IN_A_ROW) {
            hands.wait(Wake::Any).whatever_happens();
        }
    }
    Ok(true)
}

/// `cp from to`: copies a file.
pub fn copy<'c>(hands: &mut impl Hands<'c>, directory: &str, arguments: &str) -> Outcome {
    let mut names = words(arguments);
    let (Some(from), Some(to)) = (names.next(), names.next()) else {
        hands.say(format_args!("from and to files required\n"));
        return Ok(Answer::Ok);
    };
    let (source, target) = (absolute(directory, from), absolute(directory, to));
    match copy_file(hands, &source, &target) {
        Ok(true) => {}
        Ok(false) => hands.say(format_args!("stopped: {to} is not whole\n")),
        Err(StorageError::NotFound) => hands.say(format_args!("File {from} does not exist\n")),
        Err(error) => hands.say(format_args!("Could not copy {from} to {to}: {}\n", error.text())),
    }
    Ok(Answer::Ok)
}

fn copy_file<'c>(hands: &mut impl Hands<'c>, from: &str, to: &str) -> Result<bool, StorageError> {
    let source = open_to_show(hands.storage(), from, OpenMode::Read)?;
    hands.wait(Wake::Any).whatever_happens();
    hands.card_at_rest();
    // The source file stays open, so it can never be emptied as its own copy.
    let target = match hands.storage().open(to, OpenMode::Write) {
        Ok(target) => target,
        Err(error) => {
            // Errors are ignored: the file was only opened to be read.
            let _ = hands.storage().close(source);
            return Err(if error == StorageError::NotFound { StorageError::BadPath } else { error });
        }
    };
    let copied = read_through(hands, source, u32::MAX, true, |storage, bytes| Storage::write(storage, target, bytes));
    let _ = hands.storage().close(source);
    hands.card_at_rest();
    let closed = hands.storage().close(target);
    let whole = copied?;
    closed?;
    hands.card_has_kept().map(|()| whole)
}

/// `truncate file size`: keeps only the beginning of a file.
pub fn truncate<'c>(hands: &mut impl Hands<'c>, directory: &str, arguments: &str) -> Outcome {
    let mut names = words(arguments);
    let (Some(name), Some(size)) = (names.next(), names.next()) else {
        hands.say(format_args!("Usage: truncate filename size\n"));
        return Ok(Answer::Ok);
    };
    let Some(size) = size.parse::<u32>().ok().filter(|size| *size > 0) else {
        hands.say(format_args!("size must be > 0\n"));
        return Ok(Answer::Ok);
    };
    let path = absolute(directory, name);
    match keep_beginning(hands, &path, size) {
        Ok(()) => hands.say(format_args!("File {name} truncated to {size} bytes\n")),
        Err(StorageError::NotFound) => hands.say(format_args!("file {name} does not exist\n")),
        Err(error) => hands.say(format_args!("Could not truncate {name}: {}\n", error.text())),
    }
    Ok(Answer::Ok)
}

/// Replaces the file by its first bytes, whole or not at all.
fn keep_beginning<'c>(hands: &mut impl Hands<'c>, path: &Path, size: u32) -> Result<(), StorageError> {
    let file = open_to_show(hands.storage(), path, OpenMode::Read)?;
    let kept = write_beginning(hands, path, file, size);
    let draft = kept?;
    hands.put_in_place(draft)?;
    hands.card_at_rest();
    safe_file::forget_previous(hands.storage(), path)?;
    hands.card_has_kept()
}

fn write_beginning<'c, H: Hands<'c>>(
    hands: &mut H,
    path: &Path,
    file: FileHandle,
    size: u32,
) -> Result<Draft<H::Ports>, StorageError> {
    let mut draft = match Draft::begin(hands.storage(), path) {
        Ok(draft) => draft,
        Err(error) => {
            let _ = hands.storage().close(file);
            return Err(error);
        }
    };
    let copied = read_through(hands, file, size, true, |storage, bytes| draft.write(storage, bytes).map(drop));
    // Errors are ignored: the file was only read.
    let _ = hands.storage().close(file);
    match copied {
        Ok(true) => Ok(draft),
        Ok(false) => {
            draft.give_up(hands.storage());
            Err(StorageError::Unsupported)
        }
        Err(error) => {
            draft.give_up(hands.storage());
            Err(error)
        }
    }
}

/// `md5sum file ...`: prints the MD5 digests of files.
pub fn md5sum<'c>(hands: &mut impl Hands<'c>, directory: &str, arguments: &str) -> Outcome {
    if words(arguments).next().is_none() {
        return Err(Failure::refused(&"md5sum needs the names of files"));
    }
    for name in words(arguments) {
        let path = absolute(directory, name);
        match digest(hands, &path) {
            Ok(Some(digest)) => {
                digest.iter().for_each(|byte| hands.say(format_args!("{byte:02x}")));
                hands.say(format_args!(" {name}\n"));
            }
            Ok(None) => break,
            Err(StorageError::NotFound) => hands.say(format_args!("File not found: {name}\n")),
            Err(error) => hands.say(format_args!("Could not read {name}: {}\n", error.text())),
        }
    }
    Ok(Answer::Said)
}

fn digest<'c>(hands: &mut impl Hands<'c>, path: &Path) -> Result<Option<[u8; 16]>, StorageError> {
    let file = open_to_show(hands.storage(), path, OpenMode::Read)?;
    let mut digest = Md5::new();
    let read = read_through(hands, file, u32::MAX, false, |_, bytes| {
        digest.update(bytes);
        Ok(())
    });
    // Errors are ignored: the file was only read.
    let _ = hands.storage().close(file);
    Ok(read?.then(|| digest.finalize().into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{BenchHands, Card, THREE_MOTORS};

    /// A machine with these files on its card.
    fn with(files: &[(&str, &str)]) -> BenchHands<()> {
        let mut bench = BenchHands::new(THREE_MOTORS);
        bench.world.card = Card::with(files);
        bench
    }

    #[test]
    fn a_copy_is_the_file_and_leaves_nothing_open() {
        // Longer than two blocks, and not a whole number of them.
        let long = "G1 X10 Y20\n".repeat(120);
        for text in ["", "G28\n", &long] {
            let mut bench = with(&[("/sd/a.gcode", text), ("/sd/b.gcode", "an older one")]);
            assert_eq!(copy(&mut bench, "/sd", "a.gcode /sd/b.gcode"), Ok(Answer::Ok));
            assert_eq!((bench.world.card.text("/sd/b.gcode"), bench.world.card.text("/sd/a.gcode")), (text, text));
            assert_eq!((bench.heard(), bench.world.card.open_files()), (String::new(), 0));
        }
    }

    #[test]
    fn what_cannot_be_copied_is_said() {
        let mut bench = with(&[("/sd/a.gcode", "G28\n")]);
        let said = |bench: &mut BenchHands<()>, names: &str| {
            assert_eq!(copy(bench, "/sd", names), Ok(Answer::Ok));
            assert_eq!(bench.world.card.open_files(), 0);
            bench.heard()
        };
        assert_eq!(said(&mut bench, "a.gcode"), "from and to files required\n");
        assert_eq!(said(&mut bench, "none.gcode b.gcode"), "File none.gcode does not exist\n");
        assert!(
            said(&mut bench, "a.gcode a.gcode").starts_with("Could not copy a.gcode to a.gcode: the file is in use")
        );
        assert_eq!(bench.world.card.text("/sd/a.gcode"), "G28\n", "it was not emptied as its own copy");
        bench.world.card.is_full = true;
        assert!(said(&mut bench, "a.gcode b.gcode").contains("the SD card is full"));
        bench.world.card.is_full = false;
        bench.stops = true;
        assert_eq!(said(&mut bench, "a.gcode b.gcode"), "stopped: b.gcode is not whole\n");
    }

    #[test]
    fn a_file_keeps_its_beginning_or_all_of_it() {
        let text = "0123456789".repeat(130);
        for size in [1, 512, 700, 1_299, 5_000] {
            let mut bench = with(&[("/sd/a.txt", &text)]);
            assert_eq!(truncate(&mut bench, "/sd", &format!("a.txt {size}")), Ok(Answer::Ok));
            assert_eq!(bench.world.card.text("/sd/a.txt"), &text[..size.min(1_300)]);
            assert_eq!(bench.world.card.files.len(), 1, "nothing else stays");
            assert!(bench.heard().contains(&format!("truncated to {size} bytes")));
        }
        let mut bench = with(&[("/sd/a.txt", &text)]);
        for (words, said) in [("a.txt", "Usage"), ("a.txt 0", "size must be > 0"), ("b.txt 5", "does not exist")] {
            truncate(&mut bench, "/sd", words).unwrap();
            assert!(bench.heard().contains(said), "{words}");
        }
        bench.stops = true;
        truncate(&mut bench, "/sd", "a.txt 700").unwrap();
        assert_eq!((bench.world.card.text("/sd/a.txt"), bench.world.card.open_files()), (text.as_str(), 0));
    }

    #[test]
    fn digests_are_those_of_the_standard() {
        let mut bench = with(&[("/sd/abc", "abc"), ("/sd/empty", "")]);
        assert_eq!(md5sum(&mut bench, "/sd", "abc none empty"), Ok(Answer::Said));
        let said =
            "900150983cd24fb0d6963f7d28e17f72 abc\nFile not found: none\nd41d8cd98f00b204e9800998ecf8427e empty\n";
        assert_eq!(bench.heard(), said);
        assert!(md5sum(&mut bench, "/sd", " ").is_err());
    }
}

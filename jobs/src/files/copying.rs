//! File commands that read a whole file: `cp`, `truncate`, `md5sum`. Other work gets its turns meanwhile.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::paths::Path;
use base::paths::{absolute, words};
use base::ports::{FileHandle, OpenMode, Storage, StorageError, Wake};
use base::safe_file::{self, Draft};
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
    let source = hands.storage().open(from, OpenMode::Read)?;
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
    let file = hands.storage().open(path, OpenMode::Read)?;
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
    let file = hands.storage().open(path, OpenMode::Read)?;
    let mut digest = Md5::new();
    let read = read_through(hands, file, u32::MAX, false, |_, bytes| {
        digest.update(bytes);
        Ok(())
    });
    // Errors are ignored: the file was only read.
    let _ = hands.storage().close(file);
    Ok(read?.then(|| digest.finalize().into()))
}

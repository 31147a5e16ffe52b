//! An SD card's content: a FAT32 or FAT16 volume with files of the host.

use std::fs;
use std::io::{self, Cursor, Write};
use std::path::Path;

use fatfs::{Dir, FatType, FileSystem, FormatVolumeOptions, FsOptions};

/// Size of the smallest card that FAT32 can format, and of ours unless the files need more: 64 MiB.
const CARD_BYTES: usize = 64 << 20;

/// Size of a card with FAT16: 16 MiB.
const SMALL_CARD_BYTES: usize = 16 << 20;

type Disk<'a> = &'a mut Cursor<Vec<u8>>;

/// A file to be put onto the card.
pub type File = (String, Vec<u8>);

/// Builds a FAT32 volume with everything below `directory`, and these files over it.
///
/// # Errors
/// When a file cannot be read, or the volume cannot hold them all.
pub fn build(directory: Option<&Path>, files: &[File]) -> Result<Vec<u8>, String> {
    let extra: usize = files.iter().map(|(_, content)| content.len()).sum();
    let present = directory.map_or(Ok(0), size_of).map_err(|error| error.to_string())?;
    let size = CARD_BYTES.max((extra + present) * 5 / 4 + CARD_BYTES / 2).next_multiple_of(1 << 20);
    format(size, FatType::Fat32, directory, files)
}

/// Builds a small card: a FAT16 volume with these files.
///
/// # Errors
/// When it cannot hold them all.
pub fn build_fat16(files: &[File]) -> Result<Vec<u8>, String> {
    format(SMALL_CARD_BYTES, FatType::Fat16, None, files)
}

fn format(size: usize, kind: FatType, directory: Option<&Path>, files: &[File]) -> Result<Vec<u8>, String> {
    let fail = |error: io::Error| format!("the SD card's volume: {error}");
    let mut image = Cursor::new(vec![0; size]);
    let options = FormatVolumeOptions::new().fat_type(kind).volume_label(*b"PRIME      ");
    fatfs::format_volume(&mut image, options).map_err(fail)?;
    let volume = FileSystem::new(&mut image, FsOptions::new()).map_err(fail)?;
    if let Some(directory) = directory {
        copy(directory, &volume.root_dir()).map_err(|error| format!("{}: {error}", directory.display()))?;
    }
    for (name, content) in files {
        let root = volume.root_dir();
        // A file given by name replaces the file of the directory.
        let _ = root.remove(name);
        root.create_file(name).and_then(|mut file| file.write_all(content)).map_err(fail)?;
    }
    volume.unmount().map_err(fail)?;
    Ok(image.into_inner())
}

/// Lists the names in a card's root directory, sorted: long names where there are such.
///
/// # Errors
/// When the volume is damaged.
pub fn names(image: &[u8]) -> Result<Vec<String>, String> {
    let fail = |error: io::Error| format!("the root directory: {error}");
    let mut disk = Cursor::new(image.to_vec());
    let volume = FileSystem::new(&mut disk, FsOptions::new()).map_err(fail)?;
    let names: io::Result<Vec<String>> = volume.root_dir().iter().map(|entry| Ok(entry?.file_name())).collect();
    let mut names = names.map_err(fail)?;
    names.sort();
    Ok(names)
}

/// Reads the file of this name in a card's root directory, as the run left it.
///
/// # Errors
/// When the volume is damaged or has no such file.
pub fn read(image: &[u8], name: &str) -> Result<Vec<u8>, String> {
    let fail = |error: io::Error| format!("{name}: {error}");
    let mut disk = Cursor::new(image.to_vec());
    let volume = FileSystem::new(&mut disk, FsOptions::new()).map_err(fail)?;
    let mut content = Vec::new();
    let mut file = volume.root_dir().open_file(name).map_err(fail)?;
    io::copy(&mut file, &mut content).map_err(fail)?;
    Ok(content)
}

fn size_of(directory: &Path) -> io::Result<usize> {
    fs::read_dir(directory)?.try_fold(0, |sum, entry| {
        let entry = entry?;
        let kind = entry.file_type()?;
        Ok(sum + if kind.is_dir() { size_of(&entry.path())? } else { entry.metadata()?.len() as usize })
    })
}

fn copy(from: &Path, to: &Dir<'_, Disk<'_>>) -> io::Result<()> {
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to.create_dir(&name)?)?;
        } else {
            to.create_file(&name)?.write_all(&fs::read(entry.path())?)?;
        }
    }
    Ok(())
}

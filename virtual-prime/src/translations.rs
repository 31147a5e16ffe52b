//! Translations of an image's code, kept from one process to the next.
//!
//! Translating our image takes longer than running it to its prompt. A file holds the translations of one
//! image by one build of this program, which alone can use it; the emulator compares the code that they were
//! made from, so a stale translation costs time and changes nothing. An image whose file cannot be read or
//! written is translated in full, as without the file.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::SystemTime;

use rigless::cpu::armv7m::translations;

/// Folder of the files.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/translations");
/// Greatest number of files; the oldest beyond it are deleted.
const MOST_FILES: usize = 6;
/// Number of new translations that make the file worth writing again; an eighth of the file, if that is more.
const WORTH_WRITING: u32 = 200;

/// Translations file of this process.
static FILE: OnceLock<Option<PathBuf>> = OnceLock::new();
static LOADED: Once = Once::new();
/// Number of translations in the file.
static WRITTEN: AtomicU32 = AtomicU32::new(0);
static WRITING: Mutex<()> = Mutex::new(());

/// Loads the translations of earlier processes. `image` is the first image that is run; tests run variants of
/// the image that `VELVET_ELF` names.
pub fn load(image: &Path) {
    LOADED.call_once(|| {
        let image = env::var_os("VELVET_ELF").map_or_else(|| image.to_owned(), PathBuf::from);
        if let Some(file) = FILE.get_or_init(|| name_of(&image)) {
            // An unreadable file only costs a new translation.
            WRITTEN.store(translations::load(file).unwrap_or(0), Ordering::Relaxed);
        }
    });
}

/// Saves the translations for the next process, when they are worth it.
pub fn save() {
    let (count, written) = (translations::count(), WRITTEN.load(Ordering::Relaxed));
    if count < written + WORTH_WRITING.max(written / 8) {
        return;
    }
    let (Some(Some(file)), Ok(_alone)) = (FILE.get(), WRITING.try_lock()) else { return };
    // Without the file the next process is slower, no more.
    if fs::create_dir_all(FOLDER).and_then(|()| translations::save(file)).is_ok() {
        WRITTEN.store(count, Ordering::Relaxed);
        delete_old(Path::new(FOLDER));
    }
}

/// Names the file by program and image: FNV-1a over the image; the program's file name identifies the build.
fn name_of(image: &Path) -> Option<PathBuf> {
    let program = env::current_exe().ok()?;
    let hash = fs::read(image)
        .ok()?
        .iter()
        .fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3));
    let program = program.file_name()?.to_string_lossy();
    Some(Path::new(FOLDER).join(format!("{program}-{hash:016x}.bin")))
}

fn delete_old(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let age = |path: &PathBuf| path.metadata().and_then(|data| data.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.sort_by_key(age);
    for file in files.iter().rev().skip(MOST_FILES) {
        // Another process may have deleted the file already.
        let _ = fs::remove_file(file);
    }
}

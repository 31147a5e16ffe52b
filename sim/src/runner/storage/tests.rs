//! The folder answers as the board's card does.

use std::io::Cursor;
use std::sync::atomic::{AtomicU32, Ordering};

use base::ports::Storage;
use proptest::prelude::*;
use storage::CardStorage;
use storage::ram::{RamCard, Standing};

use super::*;

type Board = CardStorage<'static, RamCard, Standing>;

#[derive(Clone, Debug)]
enum Call {
    Open(String, u8),
    Write(usize, usize),
    Read(usize, usize),
    Seek(usize, u32),
    Close(usize),
    Remove(String),
    Rename(String, String),
    MakeDirectory(String),
    List(String),
    Mount,
}

fn path() -> impl Strategy<Value = String> {
    let names = [
        "config.ini",
        "CONFIG.INI",
        "Config.Initial",
        "config.initial",
        "config-override",
        "größe.g",
        "GRÖßE.G",
        " a b. ",
        "a b",
        "sub",
        "Sub",
        "deep directory",
        "in:valid",
        "a?",
        "..",
        ".",
        "",
        ".hidden",
    ];
    let name =
        prop_oneof![12 => proptest::sample::select(names.to_vec()).prop_map(str::to_owned), 1 => Just("n".repeat(256))];
    let directories =
        ["/sd", "/sd", "/sd", "/SD/", "/sd/sub", "/sd/SUB/deep directory", "/sd/config.ini", "", "/elsewhere"];
    (proptest::sample::select(directories.to_vec()), name).prop_map(|(directory, name)| format!("{directory}/{name}"))
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        8 => (path(), 0..4_u8).prop_map(|(path, mode)| Call::Open(path, mode)),
        6 => (0..5_usize, 0..900_usize).prop_map(|(file, size)| Call::Write(file, size)),
        3 => (0..5_usize, 0..900_usize).prop_map(|(file, size)| Call::Read(file, size)),
        2 => (0..5_usize, 0..900_u32).prop_map(|(file, at)| Call::Seek(file, at)),
        4 => (0..5_usize).prop_map(Call::Close),
        4 => path().prop_map(Call::Remove),
        5 => (path(), path()).prop_map(|(from, to)| Call::Rename(from, to)),
        4 => path().prop_map(Call::MakeDirectory),
        2 => path().prop_map(Call::List),
        1 => Just(Call::Mount),
    ]
}

/// A folder of its own, which goes with it.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let place = std::env::temp_dir().join(format!("velvet-card-{}-{number}", std::process::id()));
        fs::create_dir(&place).unwrap();
        Self(place)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

fn board() -> Board {
    let mut image = Cursor::new(vec![0; 4_400 * 512]);
    let options = fatfs::FormatVolumeOptions::new().fat_type(fatfs::FatType::Fat16).bytes_per_cluster(512);
    fatfs::format_volume(&mut image, options).unwrap();
    let mut board = CardStorage::new(RamCard::new(image.into_inner()), Standing, Box::leak(Box::default()));
    Storage::mount(&mut board).unwrap();
    board
}

/// Both handles of a file that both have opened.
type Files = Vec<(FileHandle, FileHandle)>;

fn step(folder: &mut Card, board: &mut Board, files: &mut Files, call: &Call) {
    let file = |place: &usize| files.get(*place).copied();
    match call {
        Call::Open(path, mode) => {
            let mode = [OpenMode::Read, OpenMode::Write, OpenMode::Append, OpenMode::Beside][usize::from(*mode)];
            match (folder.open(path, mode), board.open(path, mode)) {
                (Ok(one), Ok(other)) => files.push((one, other)),
                (one, other) => assert_eq!(one.map(drop), other.map(drop), "{call:?}"),
            }
        }
        Call::Write(place, size) => {
            let Some((one, other)) = file(place) else { return };
            let bytes: Vec<u8> = (0..*size).map(|at| (at * 7) as u8).collect();
            assert_eq!(folder.write(one, &bytes), board.write(other, &bytes), "{call:?}");
        }
        Call::Read(place, size) => {
            let Some((one, other)) = file(place) else { return };
            let ours = read(*size, |rest| folder.read(one, rest));
            let theirs = read(*size, |rest| board.read(other, rest));
            assert_eq!(ours, theirs, "{call:?}");
        }
        Call::Seek(place, to) => {
            let Some((one, other)) = file(place) else { return };
            assert_eq!(folder.size(one), board.size(other), "{call:?}");
            assert_eq!(folder.seek(one, *to), board.seek(other, *to), "{call:?}");
        }
        Call::Close(place) if *place < files.len() => {
            let (one, other) = files.remove(*place);
            assert_eq!(folder.close(one), board.close(other), "{call:?}");
        }
        Call::Close(_) => {}
        Call::Remove(path) => assert_eq!(folder.remove(path), board.remove(path), "{call:?}"),
        Call::Rename(from, to) => assert_eq!(folder.rename(from, to), board.rename(from, to), "{call:?}"),
        Call::MakeDirectory(path) => assert_eq!(folder.make_directory(path), board.make_directory(path), "{call:?}"),
        Call::List(path) => {
            let ours = listed(|skip, entries| folder.list(path, skip, entries));
            let theirs = listed(|skip, entries| board.list(path, skip, entries));
            // The size of a file that is being written is in the directory when it is closed.
            let names = |entries: Vec<DirectoryEntry>| -> Vec<_> {
                let size = |entry: &DirectoryEntry| if files.is_empty() { entry.size_bytes } else { 0 };
                entries.iter().map(|entry| (entry.name.clone(), size(entry), entry.attributes, entry.written)).collect()
            };
            assert_eq!(ours.map(names), theirs.map(names), "{call:?}");
        }
        Call::Mount => {
            assert_eq!(folder.mount(), board.mount());
            files.clear();
        }
    }
}

/// As much as there is up to `size`; a single call may give less.
fn read(size: usize, mut read: impl FnMut(&mut [u8]) -> Result<usize, StorageError>) -> Result<Vec<u8>, StorageError> {
    let (mut bytes, mut done) = (vec![0; size], 0);
    loop {
        let more = read(&mut bytes[done..])?;
        done += more;
        if more == 0 {
            bytes.truncate(done);
            return Ok(bytes);
        }
    }
}

fn listed(
    mut list: impl FnMut(usize, &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>) -> Result<(), StorageError>,
) -> Result<Vec<DirectoryEntry>, StorageError> {
    let (mut all, mut entries) = (Vec::new(), heapless::Vec::new());
    loop {
        list(all.len(), &mut entries)?;
        if entries.is_empty() {
            all.sort_by(|one: &DirectoryEntry, other| one.name.cmp(&other.name));
            return Ok(all);
        }
        all.extend(entries.iter().cloned());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]
    #[test]
    fn the_folder_answers_as_the_board_s_card_does(calls in proptest::collection::vec(call(), 1..60)) {
        let place = Folder::new();
        let (mut folder, mut board, mut files) = (Card::new(&place.0, CardState::Good, None), board(), Files::new());
        for call in &calls {
            step(&mut folder, &mut board, &mut files, call);
        }
    }
}

//! Meshes on the card: M374 saves, M374.1 deletes, M374.2 lists, M375 loads. A mesh with a name is a file of
//! text; a mesh without has Smoothieware's format.

use base::CodeContext;
use base::bed::{Bed, MeshName};
use base::failure::{Answer, Failure, FailureKind, Outcome, Texts};
use base::ports::{DirectoryEntry, FileHandle, LIST_CHUNK, OpenMode, Storage, StorageError, Wake};
use base::safe_file::{self, Draft};
use heapless::Vec;
use motion::GridShape;
use program::Words;

use super::compensation::{adopt_grid, level_again, level_aside, shape_in_force};
use super::profile_file::{self, ProfileReader};
use super::{fade_height, grid_file, show_map};
use base::hands::Hands;

/// Ending of a mesh's file name.
const ENDING: &str = ".mesh";
/// Number of bytes read from the card at a time.
const CHUNK: usize = 128;

type Path = heapless::String<40>;

/// Returns the name in the words, or `None`.
fn name_in(texts: &Texts, words: &Words<'_>) -> Result<Option<MeshName>, Failure> {
    words.text().map(MeshName::read).transpose().map_err(|error| texts.refused(format_args!("{error}")))
}

fn path_of(name: &MeshName) -> Path {
    let mut path = Path::new();
    // The path has room for a name of 24 letters.
    let _ = core::fmt::write(&mut path, format_args!("/sd/{}{ENDING}", name.as_str()));
    path
}

/// M374: saves the mesh.
pub fn save<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let Some(name) = name_in(hands.texts(), words)? else { return grid_file::save_grid(hands) };
    let shape = shape_in_force(hands).ok_or_else(|| Failure::refused(&"no mesh to save: measure the bed with G32"))?;
    let path = path_of(&name);
    let written = write(hands, &path, &shape);
    written.map_err(|error| hands.texts().about_file(&path, error.text()))?;
    hands.bed().mesh_name = name;
    hands.say(format_args!("mesh saved to {path}\n"));
    Ok(Answer::Ok)
}

/// Writes the mesh to a draft first, so that a power cut leaves the old file or the new.
fn write<'c>(hands: &mut impl Hands<'c>, path: &str, shape: &GridShape) -> Result<(), StorageError> {
    let mut draft = Draft::begin(hands.storage(), path)?;
    let mut written = draft.write(hands.storage(), profile_file::heading(shape).as_bytes());
    for index in 0..shape.points() {
        let height = hands.motion(|motion| {
            motion.compensation().grid().and_then(|grid| grid.heights().get(index).copied()).unwrap_or(f32::NAN)
        });
        let text = profile_file::height(shape, index, height);
        written = match written {
            Ok(_) => draft.write(hands.storage(), text.as_bytes()),
            Err(error) => {
                draft.give_up(hands.storage());
                return Err(error);
            }
        };
        if written.as_ref().is_ok_and(|a_block| *a_block) {
            hands.wait(Wake::Any).whatever_happens();
            hands.card_at_rest();
        }
    }
    match written {
        Ok(_) => hands.put_in_place(draft),
        Err(error) => {
            draft.give_up(hands.storage());
            Err(error)
        }
    }
}

/// M374.1: deletes a mesh.
///
/// # Errors
/// When there is no such mesh, or the card refuses.
pub fn delete(code: CodeContext<'_, impl Storage>, bed: &mut Bed) -> Outcome {
    let CodeContext { texts, ports, config, words, reply } = code;
    let Some(name) = name_in(texts, words)? else { return grid_file::delete_grid(texts, config, ports, reply) };
    let path = path_of(&name);
    safe_file::remove(ports, &path).map_err(|error| texts.about_file(&path, error.text()))?;
    if bed.mesh_name == name {
        // The mesh stays in force, but M500 has no file any more to load it from.
        bed.mesh_name = MeshName::default();
        reply.say(format_args!("// NOTE it is in force: M374 with a name keeps it\n"));
    }
    reply.say(format_args!("{path} deleted\n"));
    Ok(Answer::Ok)
}

/// M375: loads a mesh.
pub fn load<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    match name_in(hands.texts(), words)? {
        Some(name) => load_named(hands, name),
        None => grid_file::load_grid(hands),
    }
}

fn load_named<'c>(hands: &mut impl Hands<'c>, name: MeshName) -> Outcome {
    let texts = hands.texts();
    let path = path_of(&name);
    // Motion's draft is about to be filled: no move may be on its way.
    hands.standstill()?;
    let failed = |error: StorageError| texts.about_file(&path, error.text());
    safe_file::settle(hands.storage(), &path).map_err(failed)?;
    let file = hands.storage().open(&path, OpenMode::Read).map_err(failed)?;
    let read = read(hands, file);
    // The file was only read: a failing close loses nothing.
    let _ = hands.storage().close(file);
    let about = |failure: Failure| match failure.kind {
        FailureKind::Refused => texts.refused(format_args!("{path}: {}", texts.of(failure))),
        _ => failure,
    };
    let shape = read.map_err(about)?;
    adopt_grid(hands, &shape).map_err(about)?;
    hands.bed().mesh_name = name;
    let ([nx, ny], [x, y], last) = (shape.count, shape.origin, shape.place(shape.points().saturating_sub(1)));
    let name = name.as_str();
    hands.say(format_args!(
        "mesh {name} loaded, {nx} x {ny} points from X{x:.1} Y{y:.1} to X{:.1} Y{:.1}\n",
        last[0], last[1]
    ));
    Ok(Answer::Ok)
}

/// Reads a mesh, whose heights are then in the draft.
fn read<'c>(hands: &mut impl Hands<'c>, file: FileHandle) -> Result<GridShape, Failure> {
    let texts = hands.texts();
    let mut reader = ProfileReader::default();
    loop {
        let mut chunk = [0; CHUNK];
        let count = hands.storage().read(file, &mut chunk).map_err(|error| texts.because(error.text()))?;
        let bytes = chunk.get(..count).unwrap_or_default();
        let flaw = |flaw| texts.refused(format_args!("{flaw}"));
        if bytes.is_empty() {
            return hands
                .motion(|motion| reader.finish(&mut |index, height| put(motion.draft(), index, height)))
                .map_err(flaw);
        }
        let read = hands.motion(|motion| {
            let mut take = |index, height| put(motion.draft(), index, height);
            bytes.iter().try_for_each(|byte| reader.push(*byte, &mut take))
        });
        read.map_err(flaw)?;
        hands.wait(Wake::Any).whatever_happens();
    }
}

fn put(draft: &mut [f32], index: usize, height: f32) {
    if let Some(slot) = draft.get_mut(index) {
        *slot = height;
    }
}

/// M374.2: lists the names of the meshes on the card.
pub fn list<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let (mut seen, mut found) = (0, 0);
    let loaded = hands.bed().mesh_name;
    loop {
        let listed = names_behind(hands.storage(), seen);
        let (entries, names) = listed.map_err(|error| hands.texts().about_file("/sd", error.text()))?;
        for name in &names {
            found += 1;
            let mark = if *name == loaded { " (in force)" } else { "" };
            hands.say(format_args!("{}{mark}\n", name.as_str()));
        }
        hands.drain();
        if entries == 0 {
            break;
        }
        seen += entries;
    }
    hands.say(format_args!("{found} meshes on the card\n"));
    Ok(Answer::Ok)
}

/// Looks at the card's next entries; returns their number and the names of the meshes among them.
fn names_behind(storage: &mut impl Storage, seen: usize) -> Result<(usize, Vec<MeshName, LIST_CHUNK>), StorageError> {
    let mut entries = Vec::<DirectoryEntry, LIST_CHUNK>::new();
    storage.list("/sd", seen, &mut entries)?;
    let names = entries.iter().filter_map(|entry| MeshName::read(entry.name.strip_suffix(ENDING)?).ok());
    Ok((entries.len(), names.collect()))
}

/// Returns the name of the mesh at a place among those on the card, if there are so many and the card can be
/// read.
pub fn name_at(storage: &mut impl Storage, place: usize) -> Option<MeshName> {
    let (mut seen, mut found) = (0, 0);
    loop {
        let (entries, names) = names_behind(storage, seen).ok().filter(|(entries, _)| *entries > 0)?;
        if let Some(name) = names.get(place - found) {
            return Some(*name);
        }
        (seen, found) = (seen + entries, found + names.len());
    }
}

/// M420: S0 sets the mesh aside, S1 puts it in force again, or loads the saved mesh; L loads the mesh with
/// this number; Z is the height at which it has faded, V shows it. Without words as S1.
pub fn use_mesh<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let (wanted, is_level) =
        (words.get('S'), hands.motion(|motion| motion.compensation().bed() != motion::compensation::Bed::Flat));
    if let Some(number) = words.get('L') {
        load_named(hands, numbered(hands.texts(), number)?)?;
    } else if wanted == Some(0.0) {
        level_aside(hands)?;
    } else if (words.has('S') || words.is_bare()) && !is_level && !level_again(hands)? {
        // A measured mesh must not give way to a mesh that was saved once.
        grid_file::load_grid(hands)?;
    }
    if words.has('Z') {
        fade_height(hands, words.get('Z'), None)?;
    }
    if words.has('V') {
        show_map(hands)?;
    }
    Ok(Answer::Ok)
}

/// Returns the name of Marlin's slot: a number.
fn numbered(texts: &Texts, number: f64) -> Result<MeshName, Failure> {
    let mut name = heapless::String::<8>::new();
    let is_slot = (0.0..=99.0).contains(&number) && libm::floor(number) == number;
    let written = core::fmt::write(&mut name, format_args!("{}", number as u8));
    if !is_slot || written.is_err() {
        return Err(Failure::refused(&"a mesh's number is 0 to 99: it is its name on the card"));
    }
    MeshName::read(&name).map_err(|error| texts.refused(format_args!("{error}")))
}

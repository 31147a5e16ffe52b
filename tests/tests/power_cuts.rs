//! Settings, parameters and tools are replaced on the board's own file system, and the power goes at every
//! single block write.

use std::io::Cursor;

use base::ports::{OpenMode, Storage, StorageError};
use base::safe_file::{Draft, settle};
use jobs::files::program_files::{Progress, SavingParameters, SavingTools, TOOLS, load_parameters, load_tools};
use program::{Dialect, Facts, Interpreter, Setup, ToolEntry};
use storage::CardStorage;
use storage::ram::{RamCard, Standing};

/// The smallest FAT32 volume.
const VOLUME_BYTES: usize = 64 << 20;
const PATH: &str = "/sd/config-override";
const PREVIOUS: &str = "/sd/previous-config-override";

type Card = CardStorage<'static, RamCard, Standing>;

fn formatted() -> RamCard {
    let mut image = Cursor::new(vec![0; VOLUME_BYTES]);
    fatfs::format_volume(&mut image, fatfs::FormatVolumeOptions::new().fat_type(fatfs::FatType::Fat32)).unwrap();
    RamCard::new(image.into_inner())
}

fn insert(disk: RamCard) -> Card {
    let mut card = CardStorage::new(disk, Standing, Box::leak(Box::default()));
    card.mount().unwrap();
    card
}

fn content(card: &mut Card, path: &str) -> Option<Vec<u8>> {
    let file = match card.open(path, OpenMode::Read) {
        Err(StorageError::NotFound) => return None,
        opened => opened.unwrap(),
    };
    let mut content = vec![0; card.size(file).unwrap() as usize];
    assert_eq!(card.read(file, &mut content), Ok(content.len()));
    card.close(file).unwrap();
    Some(content)
}

/// Writes a file like M500.
fn save(card: &mut Card, content: &[u8]) -> Result<(), StorageError> {
    let mut draft = Draft::begin(card, PATH)?;
    for part in content.chunks(300) {
        draft.write(card, part)?;
    }
    draft.finish(card)
}

fn names(card: &mut Card) -> Vec<String> {
    let (mut names, mut entries) = (Vec::new(), heapless::Vec::new());
    while card.list("/sd", names.len(), &mut entries).is_ok() && !entries.is_empty() {
        names.extend(entries.iter().map(|entry| entry.name.to_string()));
    }
    names.sort();
    names
}

fn settings(steps_per_mm: u32, lines: usize) -> Vec<u8> {
    (0..lines).flat_map(|line| format!("M92 X{steps_per_mm} ; {line}\n").into_bytes()).collect()
}

#[test]
fn a_power_cut_at_any_block_write_leaves_the_old_settings_or_the_new() {
    let disk = formatted();
    let (old, new) = (settings(80, 60), settings(90, 110));
    save(&mut insert(disk.clone()), &old).unwrap();
    let whole = disk.powered_for(None);
    save(&mut insert(whole.clone()), &new).unwrap();
    let (mut olds, mut news) = (0, 0);
    for writes in 0..=whole.counts().writes {
        let cut = disk.powered_for(Some(writes));
        let saved = save(&mut insert(cut.clone()), &new);
        assert_eq!(saved.is_ok(), writes == whole.counts().writes, "after {writes} block writes");
        let mut card = insert(cut.powered_for(None));
        settle(&mut card, PATH).unwrap();
        let found = content(&mut card, PATH);
        match found {
            Some(found) if found == old => olds += 1,
            Some(found) if found == new => {
                assert_eq!(content(&mut card, PREVIOUS).as_deref(), Some(&old[..]), "after {writes} block writes");
                news += 1;
            }
            other => panic!("after {writes} block writes: {:?} bytes", other.map(|found| found.len())),
        }
        // And the card goes on as if nothing had been.
        save(&mut card, &old).unwrap();
        assert_eq!(content(&mut card, PATH).as_deref(), Some(&old[..]));
        assert_eq!(names(&mut card), ["config-override", "previous-config-override"]);
    }
    assert!(olds > 5 && news > 5, "{olds} old, {news} new");
}

/// A program on a machine that keeps its offsets.
fn program() -> Interpreter {
    Interpreter::new(Setup { keeps_offsets: true, ..Setup::default() })
}

/// Saves the parameters like the end of a program.
fn save_parameters(card: &mut Card, program: &mut Interpreter) -> Result<(), StorageError> {
    let mut saving = SavingParameters::begin(card)?;
    while saving.step(card, program)? == Progress::More {}
    Ok(())
}

/// Saves the tool table like G10 L1.
fn save_tools(card: &mut Card, program: &mut Interpreter) -> Result<(), StorageError> {
    let mut saving = SavingTools::begin(card, program)?;
    while saving.step(card, program)? == Progress::More {}
    program.tool_table().saved();
    Ok(())
}

/// Returns the parameters and tools that the next boot finds.
fn boot(disk: &RamCard) -> (Vec<(u16, f64)>, Vec<ToolEntry>) {
    let (mut card, mut program) = (insert(disk.powered_for(None)), program());
    assert!(matches!(load_parameters(&mut card, &mut program), Ok(0) | Err(StorageError::NotFound)));
    let read = load_tools(&mut card, &mut program, |line, flaw| panic!("line {line}: {flaw:?}"));
    assert!(matches!(read, Ok(()) | Err(StorageError::NotFound)));
    ((0..).map_while(|place| program.kept_parameter(place)).collect(), program.tools().table().all().to_vec())
}

/// The power goes at every write of what changes a card: the next boot finds all of the old, or all of the
/// new.
fn old_or_new(begun: &RamCard, save: impl Fn(&mut Card) -> Result<(), StorageError>) {
    let whole = begun.powered_for(None);
    save(&mut insert(whole.clone())).unwrap();
    let (old, new) = (boot(begun), boot(&whole));
    assert_ne!(old, new);
    let (mut olds, mut news) = (0, 0);
    for writes in 0..=whole.counts().writes {
        let cut = begun.powered_for(Some(writes));
        let saved = save(&mut insert(cut.clone()));
        assert_eq!(saved.is_ok(), writes == whole.counts().writes, "after {writes} block writes");
        let found = boot(&cut);
        olds += u32::from(found == old);
        news += u32::from(found == new);
        assert!(found == old || found == new, "after {writes} block writes: {found:?}");
    }
    assert!(olds > 5 && news > 1, "{olds} old, {news} new");
}

#[test]
fn a_power_cut_at_any_block_write_leaves_the_old_parameters_and_offsets_or_the_new() {
    let disk = formatted();
    let set = |program: &mut Interpreter, sign: f64| {
        // Some hundred parameters, offsets and rotations of coordinate systems, the park positions.
        for number in (31..140).chain([5_161, 5_162, 5_163, 5_181, 5_182, 5_183, 5_230, 5_390, 5_221, 5_243, 5_382]) {
            assert!(program.restore_parameter(number, sign * (f64::from(number) + 0.123_456)));
        }
    };
    let (mut old, mut new) = (program(), program());
    set(&mut old, 1.0);
    set(&mut new, -1.0);
    save_parameters(&mut insert(disk.clone()), &mut old).unwrap();
    assert_eq!(boot(&disk).0.len(), 120);
    old_or_new(&disk, |card| save_parameters(card, &mut new.clone()));
    // The same holds where there was no file.
    old_or_new(&formatted(), |card| save_parameters(card, &mut new.clone()));
}

/// Carries out a line of codes.
fn run(program: &mut Interpreter, line: &str) {
    let mut blocks = gcode::Blocks::new(line.as_bytes());
    let mut block = gcode::Block::new(None, 0);
    while blocks.read(&mut block, program).unwrap() {
        let row = program.row(&block, Dialect::Grbl).unwrap();
        program.run(&block, row, Facts::default(), Dialect::Grbl).unwrap();
    }
}

#[test]
fn a_power_cut_at_any_block_write_leaves_the_old_tool_table_or_the_new() {
    let disk = formatted();
    let mut text = String::from("; a table\n\nT1 P1 Z12.5 D6.0 ;end mill\n");
    for number in 2..40 {
        text += &format!("T{number}  P{number}  Z+{number}.250000 D+3.000000 ;drill {number}\n");
    }
    text += "T40 Z1 ;the last line has no end";
    let mut card = insert(disk.clone());
    let mut draft = Draft::begin(&mut card, TOOLS).unwrap();
    draft.write(&mut card, text.as_bytes()).unwrap();
    draft.finish(&mut card).unwrap();
    let mut changed = program();
    load_tools(&mut card, &mut changed, |line, flaw| panic!("line {line}: {flaw:?}")).unwrap();
    run(&mut changed, "G10 L1 P2 Z-3.5 R2");
    run(&mut changed, "G10 L1 P40 X0.1");
    run(&mut changed, "G10 L1 P77 Z8");
    old_or_new(&disk, |card| save_tools(card, &mut changed.clone()));
    // The rest of the file stays as it was.
    save_tools(&mut card, &mut changed).unwrap();
    let written = String::from_utf8(content(&mut card, TOOLS).unwrap()).unwrap();
    let expected = text
        .replace("T2  P2  Z+2.250000 D+3.000000 ;drill 2\n", "T2 P2 Z-3.5 D4 ;drill 2\n")
        .replace("T40 Z1 ;the last line has no end", "T40 X0.1 Z1 ;the last line has no end\nT77 Z8\n");
    assert_eq!(written, expected);
    // The same holds where there was no file.
    old_or_new(&formatted(), |card| {
        let mut fresh = program();
        run(&mut fresh, "G10 L1 P1 Z1");
        save_tools(card, &mut fresh)
    });
}

/// The journal of a job is written by whole blocks in place, in an existing file.
#[test]
fn a_block_in_place_is_one_write_of_the_card_and_no_other_changes() {
    let disk = formatted();
    let mut card = insert(disk.clone());
    let file = card.open("/sd/a.journal", OpenMode::Write).unwrap();
    (0..12).for_each(|_| card.write(file, &[0; 512]).unwrap());
    card.close(file).unwrap();
    let file = card.open("/sd/a.journal", OpenMode::Append).unwrap();
    for number in 0..24_u32 {
        let (before, place) = (disk.counts().writes, number * 5 % 12);
        let old: Vec<_> = (0..disk.volume_blocks()).map(|block| disk.volume_block(block)).collect();
        card.seek(file, place * 512).unwrap();
        card.write(file, &[number as u8 + 1; 512]).unwrap();
        assert_eq!(disk.counts().writes, before + 1);
        let changed = old.iter().zip(0..).filter(|(old, block)| disk.volume_block(*block) != **old).count();
        assert_eq!(changed, 1);
        // The block is on the card, although the file is never closed.
        let found = content(&mut insert(disk.powered_for(None)), "/sd/a.journal").unwrap();
        assert_eq!(found[place as usize * 512..][..512], [number as u8 + 1; 512]);
        assert_eq!(found.len(), 12 * 512);
    }
}

/// Checks the number of block writes that the native runner assumes, and to which the watchdog's limit of
/// nearly four seconds for the executor is compared: a card may need a quarter of a second for a block.
#[test]
fn no_step_of_replacing_a_file_is_more_than_six_block_writes() {
    const MOST: u32 = 6;
    let disk = formatted();
    let mut card = insert(disk.clone());
    // A folder that has to grow, and names of two entries each.
    for number in 0..40 {
        let file = card.open(&format!("/sd/a file of this number {number}.txt"), OpenMode::Write).unwrap();
        card.close(file).unwrap();
    }
    let mut before = disk.counts().writes;
    let mut step = |what: &str| {
        let made = disk.counts().writes - before;
        assert!(made <= MOST, "{what}: {made} block writes");
        before = disk.counts().writes;
    };
    let file = card.open("/sd/draft-statistics.txt", OpenMode::Write).unwrap();
    step("open");
    card.write(file, &[b'a'; 512]).unwrap();
    step("write");
    card.close(file).unwrap();
    step("close");
    card.rename("/sd/draft-statistics.txt", "/sd/new-statistics.txt").unwrap();
    step("rename");
    let file = card.open("/sd/new-statistics.txt", OpenMode::Append).unwrap();
    card.close(file).unwrap();
    step("append");
    card.remove("/sd/new-statistics.txt").unwrap();
    step("remove");
}

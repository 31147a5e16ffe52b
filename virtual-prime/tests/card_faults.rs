//! Faults of cards, and the user's messages about them. The table of `docs/card.md` is made of the table
//! here: `WRITE_CARD=1` writes it.

use crate::common::velvet::{CONFIG, Plan, SECOND, Velvet};
use sim::models::sd_card::{BLOCK, Fake, Make, SdCard, Traits, Trouble};

#[path = "../../card/src/exfat/tests/maker.rs"]
mod exfat;

/// A fault of a card, with its test.
struct Row {
    /// Name of the row's test.
    name: &'static str,
    /// Fault in words, for the document.
    what: &'static str,
    /// Message to the user, in pieces where other text may stand between; empty, when there is no message.
    reads: &'static [&'static str],
    /// Consequence in words, for the document.
    does: &'static str,
    run: fn() -> Velvet,
}

const ROWS: &[Row] = &[
    Row {
        name: "an_empty_slot",
        what: "no card",
        reads: &["cannot read /sd/config.ini: no SD card found: insert a card and reset"],
        does: "consoles work; a card that is put in is mounted within two seconds",
        run: || started(Plan::new().without_card()),
    },
    Row {
        name: "a_multimedia_card",
        what: "a MultiMediaCard",
        reads: &["this is no SD card that the board can use: use an SDHC card"],
        does: "as without a card",
        run: || started(Plan::new().with_traits(Traits { make: Make::Mmc, ..Traits::default() })),
    },
    Row {
        name: "a_locked_card",
        what: "locked with a password",
        reads: &["the SD card is locked with a password: unlock it where it was locked, or use another"],
        does: "as without a card",
        run: || started(Plan::new().with_traits(Traits { is_locked: true, ..Traits::default() })),
    },
    Row {
        name: "a_card_of_standard_capacity",
        what: "SDSC, up to 2 GB, byte addresses",
        reads: &["SDSC VELVT", "MB free of"],
        does: "works",
        run: || asked(Plan::new().with_traits(Traits { make: Make::Standard, ..Traits::default() }), "card"),
    },
    Row {
        name: "a_card_without_a_file_system",
        what: "no file system, or one of another kind",
        reads: &["the SD card has no FAT file system: format it as FAT32"],
        does: "as without a card",
        run: || started(Plan::new().with_card(|card| vec![0; card.len()])),
    },
    Row {
        name: "a_card_with_fat12",
        what: "FAT12",
        reads: &["the SD card has a FAT12 file system, which is for cards of a few MB: format it as FAT16 or FAT32"],
        does: "as without a card",
        run: || started(Plan::new().with_card(|_| fat12())),
    },
    Row {
        name: "a_card_that_is_too_small",
        what: "a copy of a larger card: its file system goes beyond its end",
        reads: &["the SD card is smaller than its file system: a copy of a larger card, or a forgery; format it anew"],
        does: "as without a card",
        run: || {
            started(Plan::new().with_card(|mut card| {
                card.truncate(card.len() / 2);
                card
            }))
        },
    },
    Row {
        name: "a_card_with_ntfs",
        what: "NTFS",
        reads: &["the SD card has an NTFS file system: format it as FAT32"],
        does: "as without a card",
        run: || {
            started(Plan::new().with_card(|mut card| {
                card[3..11].copy_from_slice(b"NTFS    ");
                card
            }))
        },
    },
    Row {
        name: "a_card_with_exfat",
        what: "exFAT",
        reads: &[
            "G28.3 X1",
            "open failed, File: new.g.",
            "the SD card has exFAT, which is only read here: to write to it, format it as FAT32 on a computer",
        ],
        does: "read, played, listed; not written",
        run: || {
            let volume = exfat::volume(&[("config.ini", CONFIG.as_bytes()), ("part.g", b"G28.3 X1\n")]);
            let mut velvet = started(Plan::new().with_card(move |_| in_partitions(&volume, 0x07)));
            velvet.type_in("cat part.g");
            velvet.hear(200);
            velvet.ask("M28 new.g", SECOND);
            velvet.ask("M29", SECOND);
            velvet
        },
    },
    Row {
        name: "a_volume_in_the_second_partition",
        what: "a partition table whose first partition is another system's",
        reads: &["MB free of"],
        does: "the first partition that can be used is",
        run: || asked(Plan::new().with_card(|volume| in_partitions(&volume, 0x0C)), "card"),
    },
    Row {
        name: "a_guid_partition_table",
        what: "a GUID partition table (GPT)",
        reads: &["MB free of"],
        does: "the first partition of basic data that can be used is",
        run: || asked(Plan::new().with_card(|volume| in_guid_table(&volume)), "card"),
    },
    Row {
        name: "a_protected_card",
        what: "write-protected, by its switch or for good",
        reads: &["open failed", "the SD card is write-protected: move its switch, or use another card"],
        does: "read and played; nothing is written, a job has no journal",
        run: || {
            let mut velvet = started(Plan::new().with_traits(Traits { is_protected: true, ..Traits::default() }));
            velvet.ask("M28 new.g", SECOND);
            velvet.ask("M29", SECOND);
            velvet
        },
    },
    Row {
        name: "a_forgery_that_loses_writes",
        what: "a forgery: what is written beyond its memory is lost",
        reads: &[
            "Error:error writing to file: the SD card does not keep what is written to it: it is worn out or a forgery; \
             use another card",
        ],
        does: "the last block of each change is read back; what was written behind it is not",
        run: || {
            let traits = Traits { claims: Some((4, Fake::Loses)), ..Traits::default() };
            let mut velvet = started(Plan::new().with_card(search_far).with_traits(traits));
            upload(&mut velvet, 60);
            velvet
        },
    },
    Row {
        name: "a_forgery_that_wraps",
        what: "a forgery: beyond its memory it begins anew",
        reads: &["the SD card does not keep what is written to it: it is worn out or a forgery; use another card"],
        does: "found when it is mounted, by blocks that are there twice; not used",
        run: || started(Plan::new().with_traits(Traits { claims: Some((4, Fake::Wraps)), ..Traits::default() })),
    },
    Row {
        name: "a_block_damaged_on_its_way",
        what: "a block, an answer or a write damaged on the bus",
        reads: &["Done saving file.", "repeated "],
        does: "repeated up to four times; counted by `card`",
        run: || {
            let mut velvet = started(Plan::new());
            let damaged = Trouble { damaged_reads: 1, damaged_writes: 1, damaged_answers: 1, ..Trouble::default() };
            set_trouble(&mut velvet, damaged);
            upload(&mut velvet, 60);
            assert_eq!(velvet.ask("card", SECOND).matches("repeated 0").count(), 0, "{}", velvet.said());
            velvet
        },
    },
    Row {
        name: "writes_that_always_fail",
        what: "every write fails",
        reads: &[
            "the SD card could not be written, the last changes are lost: the SD card reports a read or write error",
            "Error:error writing to file:",
        ],
        does: "nothing behind it is written, as if the power had gone there; the next change begins anew",
        run: || {
            let mut velvet = started(Plan::new());
            set_trouble(&mut velvet, Trouble { damaged_writes: u32::MAX, ..Trouble::default() });
            upload(&mut velvet, 60);
            velvet.hear(SECOND);
            set_trouble(&mut velvet, Trouble::default());
            velvet.ask("M28 again.g", SECOND);
            velvet.ask("G1 X1", SECOND);
            assert!(velvet.ask("M29", 5 * SECOND).contains("Done saving file."), "{}", velvet.said());
            velvet
        },
    },
    Row {
        name: "a_block_that_cannot_be_read",
        what: "a block that the card cannot read any more",
        reads: &["the SD card cannot read a part of itself any more: save its files and replace it"],
        does: "all other files are read; a job pauses there",
        run: || {
            let text = "G1 X1 ; a line of the file\n".repeat(300);
            let mut velvet = started(Plan::new().file("part.g", &text));
            let block = velvet.card(|card| {
                let blocks = card.content().chunks(BLOCK);
                blocks
                    .enumerate()
                    .filter(|(_, block)| block.windows(9).any(|piece| piece == b"of the fi"))
                    .nth(4)
                    .map(|(number, _)| number as u32)
                    .expect("the file's fifth block")
            });
            set_trouble(&mut velvet, Trouble { unreadable: vec![block], ..Trouble::default() });
            velvet.type_in("cat part.g");
            velvet.hear(5 * SECOND);
            velvet.assert_card_listed("part.g");
            velvet
        },
    },
    Row {
        name: "a_card_that_stays_busy",
        what: "never ready again after a write",
        reads: &["the SD card was taken out, or has failed, before all was written: the last changes are lost"],
        does: "given up after some seconds, as a card that was taken out; consoles work meanwhile",
        run: || {
            let mut velvet = started(Plan::new());
            set_trouble(&mut velvet, Trouble { stays_busy: true, ..Trouble::default() });
            velvet.type_in("mkdir folder");
            velvet.hear(SECOND);
            velvet.type_in("M114");
            assert!(velvet.hear(SECOND / 10).contains("ok C: X:"), "{}", velvet.said());
            velvet.hear(20 * SECOND);
            velvet
        },
    },
    Row {
        name: "a_bus_that_is_too_fast",
        what: "contacts or a card that damage data at the usual clock",
        reads: &["much from the SD card arrives damaged, its bus is set to 12.5 MHz: clean its contacts"],
        does: "slower by halves, down to 12.5 MHz; one that fails at 50 MHz when it is found out stays at 25 MHz",
        run: || asked(Plan::new().with_traits(Traits { clean_hz: 20_000_000, ..Traits::default() }), "card"),
    },
    Row {
        name: "a_card_without_high_speed",
        what: "a card of version 1.0, or one that fails at 50 MHz",
        reads: &["25.0 MHz, 4 bits"],
        does: "25 MHz, and nothing is said",
        run: || {
            asked(Plan::new().with_traits(Traits { clean_hz: 30_000_000, ..Traits::default() }), "card");
            asked(Plan::new().with_traits(Traits { is_fast: false, ..Traits::default() }), "card")
        },
    },
    Row {
        name: "a_card_taken_out_at_rest",
        what: "taken out while nobody uses it, and put in again",
        reads: &["// NOTICE the SD card was taken out", "// NOTICE an SD card was put in"],
        does: "noticed within a second and two; mounted without a word from anybody",
        run: || {
            let mut velvet = started(Plan::new().file("part.g", "G4 P1\n"));
            let card = pull(&mut velvet);
            velvet.hear(2 * SECOND);
            put(&mut velvet, card);
            velvet.hear(4 * SECOND);
            velvet.assert_card_listed("part.g");
            velvet
        },
    },
    Row {
        name: "a_card_taken_out_while_it_is_written",
        what: "taken out in the middle of an upload",
        reads: &["the SD card was taken out", "Error:error writing to file:"],
        does: "the file is not there or as it was; what comes up to M29 is discarded",
        run: || {
            let mut velvet = started(Plan::new());
            velvet.ask("M28 new.g", SECOND);
            for line in 0..20 {
                velvet.ask(&format!("G1 X{line} ; a line of the file that is sent"), SECOND);
            }
            let card = pull(&mut velvet);
            for line in 0..20 {
                velvet.type_in(&format!("G1 X{line} ; a line of the file that is sent"));
                velvet.hear(50);
            }
            velvet.hear(3 * SECOND);
            velvet.type_in("M29");
            velvet.hear(SECOND);
            put(&mut velvet, card);
            velvet.hear(4 * SECOND);
            velvet.assert_card_listed("config.ini");
            velvet
        },
    },
    Row {
        name: "a_card_that_takes_its_time",
        what: "250 ms for every block that is written, 100 ms for every read",
        reads: &["Done saving file."],
        does: "as slow as that; consoles, motion and heaters do not notice",
        run: || {
            let traits = Traits { programming_ns: 250_000_000, access_ns: 100_000_000, ..Traits::default() };
            let mut velvet = Plan::new().with_traits(traits).held();
            velvet.hear_until(crate::common::velvet::PROMPT, 60 * SECOND);
            velvet.ask("M28 new.g", 20 * SECOND);
            for line in 0..30 {
                velvet.ask(&format!("G1 X{line} ; a line of the file that is sent"), 20 * SECOND);
            }
            velvet.ask("M29", 60 * SECOND);
            velvet
        },
    },
];

/// Starts the machine and runs it for a while.
fn started(plan: Plan) -> Velvet {
    let mut velvet = plan.held();
    velvet.hear(SECOND);
    velvet
}

fn asked(plan: Plan, line: &str) -> Velvet {
    let mut velvet = started(plan);
    velvet.ask(line, 5 * SECOND);
    velvet.hear(100);
    velvet
}

fn set_trouble(velvet: &mut Velvet, trouble: Trouble) {
    let set = velvet
        .bench
        .vm
        .with(move |stopped| stopped.session.board_mut().mcu.sdmmc.card_mut().map(|card| *card.trouble() = trouble));
    set.flatten().expect("a card in the slot");
}

fn pull(velvet: &mut Velvet) -> SdCard {
    let card = velvet.card(Clone::clone);
    velvet.bench.vm.with(|stopped| stopped.session.board_mut().insert(None)).expect("the run goes on");
    card
}

/// Puts a card in as a new one comes: without power it has forgotten its state.
fn put(velvet: &mut Velvet, mut card: SdCard) {
    card.command(0, 0, 0);
    velvet.bench.vm.with(move |stopped| stopped.session.board_mut().insert(Some(card))).expect("the run goes on");
}

fn upload(velvet: &mut Velvet, lines: u32) {
    velvet.type_in("M28 new.g");
    velvet.hear(500);
    for line in 0..lines {
        velvet.type_in(&format!("G1 X{line} ; a line of the file that is sent"));
        velvet.hear(20);
    }
    velvet.type_in("M29");
    velvet.hear(4 * SECOND);
}

/// Makes the search for free clusters begin in the last quarter of the volume: FSI_Nxt_Free.
fn search_far(mut card: Vec<u8>) -> Vec<u8> {
    let clusters = (card.len() / BLOCK) as u32;
    card[BLOCK + 492..BLOCK + 496].copy_from_slice(&(clusters / 2).to_le_bytes());
    // The card has only a quarter of the capacity that it claims.
    card.truncate(card.len() / 4);
    card
}

fn fat12() -> Vec<u8> {
    let mut image = std::io::Cursor::new(vec![0; 2 << 20]);
    let options = fatfs::FormatVolumeOptions::new().fat_type(fatfs::FatType::Fat12);
    fatfs::format_volume(&mut image, options).expect("a volume");
    image.into_inner()
}

/// Puts the volume into the second of two partitions, of this type.
fn in_partitions(volume: &[u8], kind: u8) -> Vec<u8> {
    const FIRST: u32 = 2_048;
    let mut card = vec![0; FIRST as usize * BLOCK];
    let entry = |kind: u8, first: u32, blocks: u32| {
        let mut entry = [0; 16];
        entry[4] = kind;
        entry[8..12].copy_from_slice(&first.to_le_bytes());
        entry[12..].copy_from_slice(&blocks.to_le_bytes());
        entry
    };
    // The first entry is a Linux partition.
    card[446..462].copy_from_slice(&entry(0x83, 64, 1_000));
    card[462..478].copy_from_slice(&entry(kind, FIRST, (volume.len() / BLOCK) as u32));
    card[510..512].copy_from_slice(&[0x55, 0xAA]);
    card.extend_from_slice(volume);
    card
}

fn in_guid_table(volume: &[u8]) -> Vec<u8> {
    const FIRST: u64 = 2_048;
    let mut card = in_partitions(volume, 0x0C);
    card[446..478].fill(0);
    card[450] = 0xEE;
    card[454] = 1;
    card[458..462].copy_from_slice(&u32::MAX.to_le_bytes());
    card[BLOCK..BLOCK + 8].copy_from_slice(b"EFI PART");
    card[BLOCK + 72] = 2;
    card[BLOCK + 80] = 128;
    card[BLOCK + 84] = 128;
    let data = [0xA2, 0xA0, 0xD0, 0xEB, 0xE5, 0xB9, 0x33, 0x44, 0x87, 0xC0, 0x68, 0xB6, 0xB7, 0x26, 0x99, 0xC7];
    // The first entry is a system partition.
    card[2 * BLOCK..2 * BLOCK + 16].copy_from_slice(&[0x28; 16]);
    let entry = &mut card[2 * BLOCK + 128..2 * BLOCK + 256];
    entry[..16].copy_from_slice(&data);
    entry[32..40].copy_from_slice(&FIRST.to_le_bytes());
    entry[40..48].copy_from_slice(&(FIRST + (volume.len() / BLOCK) as u64 - 1).to_le_bytes());
    card
}

#[track_caller]
fn check(name: &str) {
    let row = ROWS.iter().find(|row| row.name == name).expect("a row");
    let mut velvet = (row.run)();
    for words in row.reads {
        assert!(velvet.said().contains(words), "{}: not {words:?}, but: {}", row.what, velvet.said());
    }
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
}

macro_rules! rows {
    ($($name:ident)+) => {
        $(#[test]
        fn $name() {
            check(stringify!($name));
        })+

        #[test]
        fn every_row_has_its_test() {
            assert!(ROWS.iter().map(|row| row.name).eq([$(stringify!($name)),+]));
        }
    };
}

rows! {
    an_empty_slot
    a_multimedia_card
    a_locked_card
    a_card_of_standard_capacity
    a_card_without_a_file_system
    a_card_with_fat12
    a_card_that_is_too_small
    a_card_with_ntfs
    a_card_with_exfat
    a_volume_in_the_second_partition
    a_guid_partition_table
    a_protected_card
    a_forgery_that_loses_writes
    a_forgery_that_wraps
    a_block_damaged_on_its_way
    writes_that_always_fail
    a_block_that_cannot_be_read
    a_card_that_stays_busy
    a_bus_that_is_too_fast
    a_card_without_high_speed
    a_card_taken_out_at_rest
    a_card_taken_out_while_it_is_written
    a_card_that_takes_its_time
}

const BEGIN: &str = "<!-- the table of virtual-prime/tests/card_faults.rs: WRITE_CARD=1 writes it -->\n";
const END: &str = "<!-- its end -->\n";

#[test]
fn the_page_has_this_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/card.md");
    let page = std::fs::read_to_string(path).expect("docs/card.md");
    let mut table = String::from("| fault | what is read | what becomes of it |\n|---|---|---|\n");
    for Row { what, reads, does, .. } in ROWS {
        let reads: Vec<_> = reads.iter().map(|words| format!("`{words}`")).collect();
        table += &format!("| {what} | {} | {does} |\n", reads.join(" ... "));
    }
    let (before, rest) = page.split_once(BEGIN).expect("where the table begins");
    let (_, after) = rest.split_once(END).expect("where it ends");
    let made = format!("{before}{BEGIN}{table}{END}{after}");
    if std::env::var_os("WRITE_CARD").is_some() {
        std::fs::write(path, made).expect("docs/card.md");
    } else {
        assert!(page == made, "docs/card.md has another table: WRITE_CARD=1 writes it");
    }
}

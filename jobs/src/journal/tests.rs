use super::*;
use base::bench::Card;

fn played(size: u32) -> PlayedFile {
    PlayedFile { path: Path::try_from("/sd/a.g").unwrap(), size, ..PlayedFile::default() }
}

fn made(card: &mut Card) -> Option<(u32, u32)> {
    match find(card).unwrap() {
        Found::Offer(offer) => Some((offer.file.size, offer.entry.made)),
        Found::Nothing => None,
        Found::Broken => panic!("broken"),
    }
}

#[test]
fn the_newest_entry_of_the_newest_job_is_offered_until_it_ends() {
    let (mut card, mut journal) = (Card::default(), Journal::default());
    assert_eq!(made(&mut card), None);
    for job in 1..3 {
        prepare(&mut card, |_| {}).unwrap();
        journal.count(&mut card).unwrap();
        journal.begin(&played(job), &[job as u8; program::BEGINNING_BYTES], &mut card).unwrap();
        for line in 1..10 {
            journal.note(Entry { made: line, ..Entry::default() }, &mut card).unwrap();
            journal.close(&mut card);
            assert_eq!(made(&mut card), Some((job, line)));
            let Found::Offer(offer) = find(&mut card).unwrap() else { panic!() };
            assert_eq!(offer.beginning, [job as u8; program::BEGINNING_BYTES]);
            journal.go_on(&offer, &mut card).unwrap();
        }
        journal.end(&mut card);
        assert_eq!((made(&mut card), card.open_files()), (None, 0));
    }
}

#[test]
fn what_is_forgotten_is_offered_no_more() {
    let (mut card, mut journal) = (Card::default(), Journal::default());
    prepare(&mut card, |_| {}).unwrap();
    journal.count(&mut card).unwrap();
    journal.begin(&played(9), &[0; program::BEGINNING_BYTES], &mut card).unwrap();
    journal.note(Entry { made: 3, ..Entry::default() }, &mut card).unwrap();
    journal.close(&mut card);
    let Found::Offer(offer) = find(&mut card).unwrap() else { panic!() };
    forget(&offer, &mut card).unwrap();
    assert_eq!(made(&mut card), None);
}

/// Returns a card with a job that has made so many lines, and its journal.
fn noted(lines: u32) -> (Card, Journal) {
    let (mut card, mut journal) = (Card::default(), Journal::default());
    prepare(&mut card, |_| {}).unwrap();
    journal.count(&mut card).unwrap();
    journal.begin(&played(9), &[7; program::BEGINNING_BYTES], &mut card).unwrap();
    for made in 1..=lines {
        journal.note(Entry { made, ..Entry::default() }, &mut card).unwrap();
    }
    (card, journal)
}

#[test]
fn a_cut_at_any_write_leaves_the_entry_before_or_the_new_one() {
    let (before, _) = noted(3);
    let writes = before.writes;
    for left in 0..2 {
        let (mut card, mut journal) = noted(3);
        card.writes_left = Some(left);
        assert!(journal.note(Entry { made: 4, ..Entry::default() }, &mut card).is_err());
        assert!(!journal.is_noting(), "nothing more is noted");
        assert_eq!(made(&mut card.rebooted()), Some((9, 3)), "cut after {left} writes");
    }
    let (mut card, mut journal) = noted(3);
    assert_eq!(card.writes, writes);
    journal.note(Entry { made: 4, ..Entry::default() }, &mut card).unwrap();
    assert_eq!(made(&mut card.rebooted()), Some((9, 4)));
}

#[test]
fn a_job_that_had_made_no_line_takes_the_offer_of_the_one_before() {
    let (mut card, mut journal) = noted(3);
    journal.close(&mut card);
    journal.count(&mut card).unwrap();
    journal.begin(&played(5), &[0; program::BEGINNING_BYTES], &mut card).unwrap();
    journal.close(&mut card);
    assert_eq!(made(&mut card), None);
}

#[test]
fn an_entry_without_the_facts_of_its_job_is_broken() {
    let (mut card, mut journal) = noted(3);
    journal.close(&mut card);
    let mut blocks = card.files[PATH].clone();
    assert_eq!(blocks.len(), 12 * BLOCK);
    for (place, block) in blocks.chunks_mut(BLOCK).take(4).enumerate() {
        block[place] ^= 1;
    }
    card.put(PATH, &blocks);
    assert!(matches!(find(&mut card), Ok(Found::Broken)));
}

#[test]
fn a_single_broken_block_without_entries_was_no_job_and_two_were() {
    for (count, is_broken) in [(1, false), (2, true)] {
        let mut card = Card::default();
        prepare(&mut card, |_| {}).unwrap();
        let mut blocks = card.files[PATH].clone();
        blocks.chunks_mut(BLOCK).take(count).for_each(|block| block[100] = 1);
        card.put(PATH, &blocks);
        assert_eq!(matches!(find(&mut card), Ok(Found::Broken)), is_broken, "{count} blocks");
    }
}

#[test]
fn a_journal_is_made_once_block_by_block_and_anew_if_it_has_another_size() {
    let (mut card, turns) = (Card::default(), core::cell::Cell::new(0));
    let count = |_: &mut Card| turns.set(turns.get() + 1);
    prepare(&mut card, count).unwrap();
    assert_eq!((turns.get(), card.files[PATH].len(), card.open_files()), (13, 12 * BLOCK, 0));
    let writes = card.writes;
    prepare(&mut card, count).unwrap();
    // The one change is that the file was closed again.
    assert_eq!((turns.get(), card.writes - writes), (13, 1));
    card.put(PATH, b"short");
    prepare(&mut card, count).unwrap();
    assert_eq!((turns.get(), card.files[PATH].len()), (26, 12 * BLOCK));
}

#[test]
fn a_journal_goes_on_with_its_own_card_and_no_other_one() {
    for is_same in [true, false] {
        let (card, mut journal) = noted(3);
        journal.lose();
        assert!(!journal.is_noting());
        let mut back = card.rebooted();
        if !is_same {
            let (other, _) = noted(4);
            back = other.rebooted();
        }
        journal.reopen(&mut back);
        assert_eq!(journal.is_noting(), is_same);
        journal.reopen(&mut back);
        assert_eq!(journal.is_noting(), is_same, "once");
    }
    let (mut card, mut journal) = noted(3);
    journal.close(&mut card);
    journal.reopen(&mut card);
    assert!(!journal.is_noting(), "what was closed was not lost");
}

#[test]
fn an_offer_stands_after_lines_until_the_job_ends() {
    let (mut card, mut journal) = noted(2);
    journal.close(&mut card);
    assert!(!journal.has_offer, "no filament has been laid");
    let (mut card, mut journal) = noted(2);
    journal.has_laid = true;
    journal.close(&mut card);
    assert!(journal.has_offer);
    let Found::Offer(offer) = find(&mut card).unwrap() else { panic!() };
    journal.go_on(&offer, &mut card).unwrap();
    assert!(journal.has_laid && journal.last.made == 2);
    journal.end(&mut card);
    assert!(!journal.has_offer && !journal.is_noting());
    assert_eq!(made(&mut card), None);
}

#[test]
fn axes_that_strayed_are_noted_with_the_offer() {
    let (mut card, mut journal) = noted(3);
    journal.note(Entry { made: 4, stands: true, ..Entry::default() }, &mut card).unwrap();
    journal.close(&mut card);
    let Found::Offer(offer) = find(&mut card).unwrap() else { panic!() };
    assert!(offer.entry.stands && offer.entry.strayed == 0);
    stray(&offer, 0b101, &mut card).unwrap();
    let Found::Offer(offer) = find(&mut card).unwrap() else { panic!() };
    assert_eq!((offer.entry.made, offer.entry.strayed, offer.entry.stands), (4, 0b101, true));
    assert_eq!(card.open_files(), 0);
}

#[test]
fn the_check_value_sees_size_beginning_and_end() {
    let value = |content: &[u8]| {
        let mut card = Card::default();
        card.put("/sd/a.g", content);
        let file = card.open("/sd/a.g", OpenMode::Read).unwrap();
        check_value(file, content.len() as u32, &mut card).unwrap()
    };
    let part = vec![b'x'; 40 * BLOCK];
    let changed = |place: usize| {
        let mut content = part.clone();
        content[place] = b'y';
        value(&content)
    };
    let own = value(&part);
    assert_eq!(own, value(&part));
    for place in [0, BLOCK - 1, part.len() - 1, part.len() - BLOCK] {
        assert_ne!(changed(place), own, "{place}");
    }
    assert_ne!(value(&part[1..]), own, "another size");
    // Of 40 blocks sixteen are looked at: the third is none of them.
    assert_eq!(changed(3 * BLOCK), own);
    assert_eq!(value(b""), crc32(0, &[0; 4]));
}

#[test]
fn the_machines_value_sees_settings_and_neither_comments_nor_blanks() {
    let value = |config: &str, saved: Option<&str>| {
        let mut card = Card::with(&[(CONFIG_PATH, config)]);
        if let Some(saved) = saved {
            card.put(OVERRIDE_PATH, saved.as_bytes());
        }
        let value = machine_value(&mut card).unwrap();
        assert_eq!(card.open_files(), 0);
        value
    };
    let own = value("[a]\nb = 1\n", None);
    for same in ["[a]\n\n  b=1", "# x\n[a] # y\nb = 1 ; z\n;w"] {
        assert_eq!(value(same, None), own, "{same}");
    }
    for other in ["[a]\nb = 2\n", "[a]\n#b = 1\n", "[a]\nb = 1\nc = 1\n"] {
        assert_ne!(value(other, None), own, "{other}");
    }
    assert_ne!(value("[a]\nb = 1\n", Some("M204 S5\n")), own);
    assert_eq!(value("[a]\nb = 1\n", Some("; nothing\n")), own);
    assert_eq!(machine_value(&mut Card::default()), Ok(0), "neither file need be there");
}

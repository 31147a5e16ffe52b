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

//! Files from a console, on a card in memory.

use super::*;
use base::bench::{Desk, World};
use base::sessions::Intake;
use config::MachineConfig;

const ME: SessionId = SessionId(0);

/// A console, the card, and what is said to the console.
struct Bench {
    world: World,
    desk: Desk,
    transfers: Transfers,
    now: Micros,
}

impl Bench {
    fn new() -> Self {
        let world = World::new(&MachineConfig::default());
        world.inbox(ME).set_raw(true);
        Self { world, desk: Desk::new(), transfers: Transfers::default(), now: Micros(0) }
    }

    fn upload(&mut self, name: &str) -> Result<String, Failure> {
        let Self { world, desk, transfers, .. } = self;
        let (mut begun, path) = (Ok(()), base::paths::absolute("/sd", name));
        let said = desk.hears(|reply| {
            begun = transfers.receive_plain(&Texts::new(), name, path, world, reply);
        });
        begun.map(|()| said)
    }

    fn count(&mut self, name: &str, size: u32) -> Result<String, &'static str> {
        let Self { world, desk, transfers, now } = self;
        let (mut begun, path) = (Ok(()), base::paths::absolute("/sd", name));
        let said = desk.hears(|reply| begun = transfers.receive_counted(path, size, *now, world, reply));
        begun.map(|()| said)
    }

    /// Sends bytes; returns the progress, and what is said.
    fn send(&mut self, bytes: &[u8]) -> (Progress, String) {
        let (Self { world, desk, transfers, now }, mut intake) = (self, Intake::new());
        let (mut progress, mut said) = (Progress::Receiving, String::new());
        for piece in bytes.chunks(900).chain(bytes.is_empty().then_some(bytes)) {
            world.inbox(ME).receive_all(&mut intake, piece);
            let end = world.inbox(ME).received();
            said += &desk.hears(|reply| progress = transfers.go_on("/sd", (ME, end), *now, world, reply));
        }
        (progress, said)
    }
}

#[test]
fn an_upload_is_all_bytes_up_to_its_end() {
    for end in [CTRL_D, CTRL_Z] {
        let mut bench = Bench::new();
        let said = bench.upload("a.g").unwrap();
        assert_eq!(said, "uploading to file: a.g, send control-D or control-Z to finish\n");
        let text = "G1 X1 ; ? ! ~\n".repeat(200);
        assert_eq!(bench.send(text.as_bytes()), (Progress::Receiving, String::new()));
        let uploaded = format!("uploaded {} bytes\n", text.len());
        assert_eq!(bench.send(&[end]), (Progress::Ended, uploaded));
        assert_eq!(bench.world.card.text("/sd/a.g"), text);
        assert_eq!(bench.world.card.open_files(), 0);
    }
}

#[test]
fn a_cancelled_upload_leaves_nothing() {
    let mut bench = Bench::new();
    bench.upload("a.g").unwrap();
    bench.send(b"G1 X1\n");
    assert_eq!(bench.send(&[CTRL_X]), (Progress::Ended, "upload cancelled\n".into()));
    assert!(bench.world.card.files.is_empty() && bench.world.card.open_files() == 0);
    assert_eq!(bench.send(b"G1"), (Progress::Ended, String::new()), "the bytes are lines again");
}

#[test]
fn one_console_sends_at_a_time() {
    let mut bench = Bench::new();
    assert!(bench.upload("").is_err(), "no name");
    bench.upload("a.g").unwrap();
    assert!(bench.upload("b.g").is_err());
    assert_eq!(bench.count("b.g", 5), Err("another console sends a file"));
    let Bench { world, desk, transfers, now } = &mut bench;
    let mut refused = Ok(());
    desk.hears(|reply| refused = transfers.receive(false, *now, reply));
    assert!(refused.is_err());
    transfers.break_off(world);
    assert!(world.card.files.is_empty() && world.card.open_files() == 0, "a sender that has gone");
    assert!(bench.count("b.g", 5).is_ok());
}

#[test]
fn a_counted_file_takes_its_bytes_whatever_they_are_and_no_more() {
    let mut bench = Bench::new();
    let bytes: Vec<u8> = (0..2_500_u32).map(|n| (n * 7) as u8).collect();
    assert_eq!(bench.count("a.bin", 2_500).unwrap(), "READY - 2500\n");
    assert_eq!(bench.send(&bytes[..2_499]), (Progress::Receiving, String::new()));
    assert_eq!(bench.send(&bytes[2_499..]), (Progress::Ended, "SUCCESS\n".into()));
    assert_eq!(bench.world.card.files["/sd/a.bin"], bytes);
}

#[test]
fn a_counted_file_is_given_up_after_a_while_without_bytes() {
    let mut bench = Bench::new();
    bench.count("a.bin", 3_000).unwrap();
    bench.now = Micros::from_seconds(19);
    assert_eq!(bench.send(&[0; CHUNK]), (Progress::Receiving, String::new()));
    bench.now = Micros(Micros::from_seconds(19 + 20).0 - 1);
    assert_eq!(bench.send(b"").0, Progress::Receiving, "twenty seconds from the last bytes that were written");
    bench.now = Micros::from_seconds(60);
    assert_eq!(bench.send(b""), (Progress::Ended, "FAIL - nothing came for 20 s\n".into()));
    assert!(bench.world.card.files.is_empty(), "half a file does not stay");
}

#[test]
fn a_full_card_swallows_the_rest_of_a_counted_file() {
    let mut bench = Bench::new();
    bench.count("a.bin", 3_000).unwrap();
    bench.world.card.is_full = true;
    assert_eq!(bench.send(&[0; 2_999]), (Progress::Receiving, String::new()), "they are no lines");
    let (progress, said) = bench.send(&[0]);
    assert_eq!(progress, Progress::Ended);
    assert!(said.starts_with("FAIL - ") && bench.world.card.files.is_empty(), "{said}");
}

#[test]
fn an_upload_that_is_faster_than_the_card_is_given_up() {
    let mut bench = Bench::new();
    bench.upload("a.g").unwrap();
    let mut intake = Intake::new();
    while bench.world.inbox(ME).receive(&mut intake, b'x') {}
    let mut ended = bench.send(b"");
    while ended.0 == Progress::Receiving {
        ended = bench.send(b"");
    }
    assert_eq!(ended.1, "upload failed: bytes were lost, send more slowly\n");
    assert!(bench.world.card.files.is_empty());
}

#[test]
fn ymodem_says_when_it_begins_and_that_nobody_came() {
    for (silent, words) in [(false, "start ymodem transfer\n"), (true, "")] {
        let mut bench = Bench::new();
        let Bench { desk, transfers, now, .. } = &mut bench;
        let said = desk.hears(|reply| transfers.receive(silent, *now, reply).unwrap());
        assert_eq!(said, words);
        let (mut ended, mut heard) = (Progress::Receiving, String::new());
        while ended == Progress::Receiving && bench.now < Micros::from_seconds(300) {
            bench.now = bench.now.plus(Micros::from_seconds(1));
            let (progress, said) = bench.send(b"");
            (ended, heard) = (progress, heard + &said);
        }
        assert!(heard.starts_with('C') && heard.contains("download failed with error -"), "{heard:?}");
    }
}

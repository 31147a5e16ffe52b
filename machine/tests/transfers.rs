//! Files that come over a console as bytes: YModem and `upload`, and a console that stays usable.

use base::sessions::SessionId;
use scenarios::{Bench, CARTESIAN, Plan};

const CONSOLE: SessionId = SessionId(0);
const ACK: u8 = 0x06;
const NAK: u8 = 0x15;
const CAN: u8 = 0x18;
const EOT: u8 = 0x04;

fn crc(bytes: &[u8]) -> u16 {
    let mut crc = 0_u16;
    for byte in bytes {
        crc ^= u16::from(*byte) << 8;
        for _ in 0..8 {
            crc = if crc & 0x8000 == 0 { crc << 1 } else { (crc << 1) ^ 0x1021 };
        }
    }
    crc
}

fn block(number: u8, data: &[u8]) -> Vec<u8> {
    let (mark, length) = if data.len() > 128 { (2, 1_024) } else { (1, 128) };
    let mut padded = data.to_vec();
    padded.resize(length, if number == 0 { 0 } else { 0x1A });
    let mut frame = vec![mark, number, !number];
    frame.extend(&padded);
    frame.extend(crc(&padded).to_be_bytes());
    frame
}

/// Sends bytes slowly enough for the console, and returns what is said meanwhile.
fn send(bench: &mut Bench, bytes: &[u8]) -> Vec<u8> {
    let mut said = Vec::new();
    for part in bytes.chunks(200) {
        bench.send(part);
        said.extend(bench.hear(0.02).bytes());
    }
    said
}

/// Sends files as a sender of YModem does.
fn send_files(bench: &mut Bench, files: &[(&str, &[u8])]) {
    for (name, content) in files {
        let head = format!("{name}\0{} 14000000000 100644", content.len());
        assert_eq!(send(bench, &block(0, head.as_bytes())), [ACK, b'C'], "{name}");
        for (number, part) in (1_u8..).zip(content.chunks(1_024)) {
            assert_eq!(send(bench, &block(number, part)), [ACK], "block {number} of {name}");
        }
        assert_eq!(send(bench, &[EOT]), [NAK]);
        assert_eq!(send(bench, &[EOT]), [ACK, b'C']);
    }
}

fn start() -> Bench {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("ry\n");
    let said = bench.hear(2.5);
    assert_eq!(said, "start ymodem transfer\nC");
    bench
}

#[test]
fn files_come_by_ymodem_whole_and_the_console_goes_on() {
    let mut bench = start();
    // Every byte there is, those that act on consoles too.
    let all: Vec<u8> = (0..3_000_u32).map(|n| (n * 7 + n / 256) as u8).collect();
    send_files(&mut bench, &[("all.bin", &all), ("short.g", b"G28\n")]);
    let mut end = send(&mut bench, &block(0, b""));
    end.extend(bench.hear(0.1).bytes());
    assert_eq!(String::from_utf8_lossy(&end), "\x06downloaded 2 file(s) ok\nok\n");
    assert_eq!(bench.read_card_bytes("all.bin"), Some(all));
    assert_eq!(bench.read_card("short.g").as_deref(), Some("G28\n"));
    assert!(bench.say("M105").starts_with("ok "), "the console is one again");
}

#[test]
fn a_wrong_block_is_asked_for_again() {
    let mut bench = start();
    assert_eq!(send(&mut bench, &block(0, b"a.g\x004")), [ACK, b'C']);
    let mut wrong = block(1, b"G28\n");
    wrong[20] ^= 0x40;
    assert_eq!(send(&mut bench, &wrong), [NAK]);
    assert_eq!(send(&mut bench, &block(1, b"G28\n")), [ACK]);
    send(&mut bench, &[EOT]);
    send(&mut bench, &[EOT]);
    send(&mut bench, &block(0, b""));
    assert_eq!(bench.read_card("a.g").as_deref(), Some("G28\n"));
}

#[test]
fn a_cancelled_transfer_leaves_no_part_of_a_file() {
    let mut bench = start();
    send(&mut bench, &block(0, b"a.g\x00200"));
    send(&mut bench, &block(1, &[b'x'; 128]));
    let said = send(&mut bench, &[CAN, CAN]);
    assert_eq!(String::from_utf8_lossy(&said), "\x06download failed with error -1\nok\n");
    assert_eq!(bench.read_card("a.g"), None);
    assert!(bench.say("M105").starts_with("ok "));
}

#[test]
fn nobody_who_sends_is_waited_for_a_while() {
    let mut bench = start();
    let said = bench.hear_until("ok\n", 30.0);
    assert!(said.ends_with("\x18\x18download failed with error -2\nok\n"), "{said:?}");
    // A sender that falls silent in a block is given up too.
    let mut bench = start();
    send(&mut bench, &block(0, b"a.g\x00200"));
    send(&mut bench, &block(1, &[b'x'; 128])[..50]);
    let said = bench.hear_until("ok\n", 30.0);
    assert!(said.ends_with("download failed with error -3\nok\n"), "{said:?}");
    assert_eq!(bench.read_card("a.g"), None);
    assert!(bench.say("M105").starts_with("ok "));
}

#[test]
fn other_consoles_are_heard_and_may_stop_the_machine_meanwhile() {
    let profile = base::sessions::SessionProfile::SERIAL;
    let mut bench = Plan::new(CARTESIAN).visitor(profile).start();
    let other = SessionId(2);
    bench.set_open(other, true);
    bench.type_on(CONSOLE, "ry x\n");
    let _greeting = bench.hear_on(other, 0.1);
    assert!(bench.say_on(other, "M105").starts_with("ok "));
    assert_eq!(bench.say_on(other, "ry"), "error:another console sends a file\n");
    bench.type_on(other, "M112\n");
    assert!(bench.hear_on(other, 0.3).contains("Emergency stop"));
}

#[test]
fn upload_takes_what_comes_up_to_its_end() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.ask("upload a.g"), "uploading to file: a.g, send control-D or control-Z to finish\n");
    let text = "G1 X1 ? ! ~\nM112\nM117 caf\u{e9}\n".repeat(60);
    send(&mut bench, text.as_bytes());
    let said = send(&mut bench, &[0x1A]);
    assert_eq!(String::from_utf8_lossy(&said), format!("uploaded {} bytes\nok\n", text.len()));
    assert_eq!(bench.read_card("a.g"), Some(text));
    bench.ask("upload b.g");
    let said = send(&mut bench, b"half a fi\x18");
    assert_eq!(String::from_utf8_lossy(&said), "upload cancelled\nok\n");
    assert_eq!(bench.read_card("b.g"), None);
}

/// A console at a USB port, somebody at its other end.
fn over_usb() -> (Bench, SessionId) {
    let serial = base::sessions::SessionProfile::SERIAL;
    let profile = base::sessions::SessionProfile { kind: base::sessions::ConsoleKind::Usb, ..serial };
    let (mut bench, usb) = (Plan::new(CARTESIAN).visitor(profile).start(), SessionId(2));
    bench.set_open(usb, true);
    assert_eq!(bench.hear_on(usb, 0.1), "Welcome to Smoothie\nok\n");
    (bench, usb)
}

#[test]
fn dl_takes_so_many_bytes_whatever_they_are() {
    let (mut bench, usb) = over_usb();
    let text = "G1 X1 ? ! ~\nM112\n\u{4}\u{18}\u{19}\u{1a}".repeat(100);
    bench.type_on(usb, &format!("dl a b.g {}\n", text.len()));
    assert_eq!(bench.hear_on(usb, 0.1), format!("READY - {}\n", text.len()));
    bench.type_on(usb, &text);
    assert_eq!(bench.hear_on(usb, 0.5), "SUCCESS\nok\n");
    assert_eq!(bench.read_card("a b.g"), Some(text));
    assert!(bench.say_on(usb, "M105").starts_with("ok "), "lines are lines again");
}

#[test]
fn dl_says_why_it_does_not() {
    let (mut bench, usb) = over_usb();
    for (command, why) in [
        ("dl", "Usage dl filename size"),
        ("dl a.g", "Usage dl filename size"),
        ("dl a.g 0", "file size is bad"),
        ("dl a.g much", "file size is bad"),
        ("dl nowhere/a.g 5", "no such file"),
    ] {
        bench.type_on(usb, &format!("{command}\n"));
        assert_eq!(bench.hear_on(usb, 0.1), format!("FAIL - {why}\n"), "{command}");
    }
    assert_eq!(bench.ask("dl a.g 5"), "FAIL - download only allowed over USB\n");
    bench.type_on(usb, "dl a.g 5\n");
    assert_eq!(bench.hear_on(usb, 0.1), "READY - 5\n");
    bench.type_on(usb, "abc");
    assert_eq!(bench.hear_on(usb, 30.0), "FAIL - nothing came for 20 s\nok\n");
    assert_eq!(bench.read_card("a.g"), None, "half a file does not stay");
}

#[test]
fn the_rest_of_a_file_whose_sender_has_gone_is_no_lines() {
    let (mut bench, usb) = over_usb();
    bench.type_on(usb, "dl a.g 1000\n");
    assert_eq!(bench.hear_on(usb, 0.1), "READY - 1000\n");
    bench.type_on(usb, &"M112\n".repeat(50));
    bench.set_open(usb, false);
    bench.set_open(usb, true);
    assert_eq!(bench.hear_on(usb, 0.2), "Welcome to Smoothie\nok\n");
    assert!(bench.say_on(usb, "M105").starts_with("ok "), "and nothing was halted");
    assert_eq!(bench.read_card("a.g"), None);
}

// Smoothieware v2 refuses while something moves or heats, and takes blocks with a checksum, too.
#[test]
fn a_file_may_come_while_the_machine_moves_and_heats_and_every_block_has_its_crc() {
    let mut bench = Plan::new(CARTESIAN).file("part.g", "M104 S60\nG1 X50 F300\nG1 X0\n").start();
    bench.say("play part.g");
    bench.type_in("ry\n");
    assert!(bench.hear(2.5).ends_with("start ymodem transfer\nC"));
    assert!(bench.moves() && bench.heats());
    send_files(&mut bench, &[("short.g", b"G28\n")]);
    send(&mut bench, &block(0, b""));
    bench.hear(0.1);
    assert_eq!(bench.read_card("short.g").as_deref(), Some("G28\n"));
    // A sender that knows checksums alone is asked for a CRC until nobody waits any more.
    let mut bench = start();
    let mut asked = bench.hear(20.0);
    asked.retain(|letter| letter != '\x18');
    assert!(asked.starts_with("CCCCCCCC") && !asked.contains('\x15'), "{asked:?}");
}

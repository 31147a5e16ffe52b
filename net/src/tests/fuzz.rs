//! Frames that make no sense: nothing fails, and nothing is left behind.

use std::net::Ipv4Addr;

use crate::Settings;
use crate::random::Random;
use crate::testing::{
    BOARD, BOARD_MAC, Bench, DESK, DESK_MAC, Faults, MS, SECOND, arp, datagram, echo, syn, time_server,
};

/// Settings with everything.
fn settings() -> Settings {
    Settings { time_server: time_server("10.0.0.1"), ..Bench::settings() }
}

/// Frames of all that the board speaks, as they were heard on the wire.
fn samples() -> Vec<Vec<u8>> {
    let mut bench = Bench::new(settings());
    bench.wire.listens = true;
    let (mdns, ntp) = (bench.desk.bind(5353), bench.desk.bind(123));
    bench.get_address();
    let client = bench.connect(23);
    bench.desk.send(client, b"\xFF\xFD\x01M115\n");
    for _ in 0..100 {
        bench.run(100 * MS);
        // Probes come back as questions, announcements as contradictions.
        while let Some((bytes, _)) = bench.desk.datagram(mdns) {
            bench.desk.tell(mdns, (Ipv4Addr::new(224, 0, 0, 251), 5353), &bytes);
        }
        while let Some((mut bytes, _)) = bench.desk.datagram(ntp) {
            bytes.copy_within(40..48, 24);
            (bytes[0], bytes[1]) = (0x24, 2);
            bench.desk.tell(ntp, (BOARD, 50_000), &bytes);
        }
    }
    bench.desk.tcp(client).close();
    bench.run(2 * SECOND);
    let mut samples = std::mem::take(&mut bench.wire.heard);
    samples.append(&mut bench.wire.told);
    samples.extend([syn((DESK, 9), (BOARD, 23)), echo(DESK, BOARD, 64), arp(true, DESK_MAC, DESK, BOARD)]);
    samples.sort();
    samples.dedup();
    samples
}

/// Turns a frame of the board into one for it: addresses and ports are swapped.
fn returned(frame: &[u8]) -> Vec<u8> {
    let mut frame = frame.to_vec();
    if frame.len() > 34 && frame[6..12] == BOARD_MAC {
        for at in 0..6 {
            frame.swap(at, at + 6);
        }
        if frame[12..14] == [8, 0] {
            (0..4).for_each(|at| frame.swap(26 + at, 30 + at));
            if frame.len() > 37 {
                (0..2).for_each(|at| frame.swap(34 + at, 36 + at));
            }
        }
    }
    frame
}

fn mutated(samples: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut frame = returned(&samples[random.below(samples.len() as u32) as usize]);
    for _ in 0..random.below(6) {
        let at = random.below(frame.len().max(1) as u32) as usize;
        match random.below(5) {
            0 if !frame.is_empty() => frame[at] = random.next() as u8,
            1 if !frame.is_empty() => frame[at] ^= 1 << random.below(8),
            2 => frame.truncate(at),
            3 => frame.extend((0..random.below(60)).map(|_| random.next() as u8)),
            _ if frame.len() > at => frame[at] = [0, 1, 0x7F, 0x80, 0xFF][random.below(5) as usize],
            _ => {}
        }
    }
    frame.truncate(1_514);
    frame
}

/// Feeds frames to a board, and then sees whether it is as good as new.
fn feed(count: u32, seed: u64) {
    let (samples, mut random) = (samples(), Random::new(seed));
    let mut bench = if seed.is_multiple_of(2) { Bench::new(settings()) } else { Bench::trusting(settings()) };
    bench.get_address();
    for turn in 0..count {
        let frame = if random.below(8) == 0 {
            let mut frame: Vec<u8> = BOARD_MAC.to_vec();
            frame.extend((0..random.below(1_500)).map(|_| random.next() as u8));
            frame
        } else {
            mutated(&samples, &mut random)
        };
        bench.port.inject(&frame);
        bench.step();
        if turn % 64 == 0 {
            bench.run(u64::from(random.below(20)) * MS);
        }
    }
    bench.run(60 * SECOND);
    bench.get_address();
    let clients = [bench.connect(23), bench.connect(23), bench.connect(2323), bench.connect(2323)];
    bench.run(50 * MS);
    for line in &bench.lines {
        assert!(line.visitor.is_some(), "a console is lost");
    }
    bench.desk.send(clients[0], b"M115\n");
    assert!(bench.until(SECOND, |bench| bench.lines.iter().any(|line| line.text().ends_with("M115\n"))));
}

#[test]
fn frames_that_make_no_sense_do_no_harm() {
    (1..5).for_each(|seed| feed(3_000, seed));
}

#[test]
fn senders_and_addressees_that_cannot_be_do_no_harm() {
    let mut bench = Bench::new(settings());
    bench.get_address();
    let strange = ["0.0.0.0", "255.255.255.255", "10.0.0.255", "10.0.0.0", "224.0.0.251", "127.0.0.1", "240.0.0.1"];
    let strange: Vec<Ipv4Addr> = strange.into_iter().map(|text| text.parse().unwrap()).chain([BOARD, DESK]).collect();
    for from in &strange {
        for to in strange.iter().chain([&Ipv4Addr::new(8, 8, 8, 8)]) {
            for port in [0, 23, 67, 68, 80, 2323, 5353, 50_000] {
                for source in [0, 53, 67, 68, 123, 5353, 40_000] {
                    bench.port.inject(&syn((*from, source), (*to, port)));
                    bench.port.inject(&datagram((*from, source), (*to, port)));
                }
                bench.step();
            }
            bench.port.inject(&echo(*from, *to, 9));
            bench.port.inject(&arp(true, DESK_MAC, *from, *to));
            bench.port.inject(&arp(false, [0xFF; 6], *from, *to));
            bench.run(20 * MS);
        }
    }
    bench.run(60 * SECOND);
    bench.get_address();
    let client = bench.connect(23);
    assert!(bench.desk.tcp(client).is_active());
}

#[test]
fn a_server_that_gives_nonsense_does_no_harm() {
    for router in ["0.0.0.0", "255.255.255.255", "224.0.0.1", "10.0.0.255", "10.0.0.42", "127.0.0.1"] {
        let mut bench = Bench::new(Settings { time_server: time_server("8.8.8.8"), ..Bench::settings() });
        bench.desk.dhcp.router = router.parse().unwrap();
        bench.get_address();
        bench.run(10 * SECOND);
        let client = bench.connect(23);
        assert!(bench.desk.tcp(client).is_active());
    }
}

/// Sends bytes to a console that is short of room, in pieces, and sees what it makes of them.
fn reaches(bytes: &[u8], plain: &[u8], random: &mut Random) {
    let mut bench = Bench::with_address();
    let client = bench.connect(2323);
    let mut sent = 0;
    while sent < bytes.len() || bench.desk.tcp(client).send_queue() > 0 {
        let end = (sent + random.below(200) as usize).min(bytes.len());
        sent += bench.desk.send(client, &bytes[sent..end]);
        bench.lines[2].size = 8 + random.below(100) as usize;
        bench.reads = random.below(30) as usize;
        bench.step();
    }
    bench.reads = usize::MAX;
    bench.run(SECOND);
    let acts = |byte: &u8| matches!(byte, b'?' | b'!');
    let (acting, kept): (Vec<u8>, Vec<u8>) = plain.iter().partition(|byte| acts(byte));
    let received = &bench.lines[2].received;
    let same = received.iter().zip(&kept).take_while(|(a, b)| a == b).count();
    assert_eq!((same, received.len()), (kept.len(), kept.len()));
    assert!(bench.lines[2].acted == acting);
}

#[test]
fn bytes_of_any_kind_reach_the_console_in_order_and_what_acts_does_so_once() {
    let mut random = Random::new(5);
    for _ in 0..30 {
        let bytes: Vec<u8> = (0..4_000).map(|_| b"G1 X?!\n\xFF\x85\r\0"[random.below(11) as usize]).collect();
        // The first byte is no command of telnet.
        let bytes = [b"$", &bytes[..]].concat();
        reaches(&bytes, &bytes, &mut random);
    }
}

#[test]
fn the_same_holds_in_telnet_whose_commands_stand_between() {
    // Bytes as they are sent, and what they mean.
    let words: [(&[u8], &[u8]); 9] = [
        (b"G1 X", b"G1 X"),
        (b"?", b"?"),
        (b"!", b"!"),
        (b"\r\n", b"\r\n"),
        (b"\r\0", b"\r"),
        (b"\xFF\xFF", b"\xFF"),
        (b"\xFF\xF1", b""),
        (b"\xFF\xFD\x05", b""),
        (b"\xFF\xFA\x18\x00?\xFF\xFF!\xFF\xF0", b""),
    ];
    let mut random = Random::new(6);
    for _ in 0..30 {
        let (mut bytes, mut plain) = (b"\xFF\xFB\x18".to_vec(), Vec::new());
        for _ in 0..1_500 {
            let (sent, means) = words[random.below(words.len() as u32) as usize];
            bytes.extend(sent);
            plain.extend(means);
        }
        reaches(&bytes, &plain, &mut random);
    }
}

#[test]
fn a_client_that_speaks_nonsense_in_telnet_harms_itself_alone() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut bench = Bench::new(Settings { password_required: seed % 2 == 0, ..Bench::settings() });
        bench.network.set_password(b"x", [1; 16]);
        bench.get_address();
        let client = bench.connect(23);
        bench.desk.send(client, &[0xFF, 0xFD, 1]);
        for _ in 0..200 {
            let bytes: Vec<u8> = (0..random.below(300))
                .map(|_| if random.below(3) == 0 { 0xF0 + random.below(16) as u8 } else { random.next() as u8 })
                .collect();
            bench.desk.send(client, &bytes);
            bench.network.write(0, &bytes);
            bench.step();
            bench.desk.read(client);
        }
        bench.desk.tcp(client).abort();
        bench.run(10 * SECOND);
        assert!(bench.lines[0].visitor.is_none());
    }
}

/// Seeds of the long tests: a round of half a second each. A process keeps the memory of every round's
/// board, 5 MB; `make net` takes them in pieces.
fn rounds() -> std::ops::Range<u64> {
    let number = |name, otherwise| std::env::var(name).map_or(otherwise, |text| text.parse().unwrap());
    let first = number("NET_SEED", 100);
    first..first + number("NET_ROUNDS", 200)
}

/// Garbles what a board that leaves checksums unchecked hears from its very start.
fn garble(seed: u64) {
    let server = time_server(if seed.is_multiple_of(2) { "10.0.0.1" } else { "pool.ntp.org" });
    let mut bench = Bench::trusting(Settings { time_server: server, ..Bench::settings() });
    bench.wire.reseed(seed);
    bench.wire.faults = Faults { corruption: 60, doubling: 20, ..Faults::default() };
    let services = [bench.desk.bind(53), bench.desk.bind(123), bench.desk.bind(5353)];
    let end = bench.now + 60 * SECOND;
    while bench.now < end {
        bench.step();
        for service in services {
            while let Some((mut bytes, from)) = bench.desk.datagram(service) {
                let std::net::IpAddr::V4(to) = std::net::IpAddr::from(from.addr) else { continue };
                match bytes.len() {
                    48 => {
                        bytes.copy_within(40..48, 24);
                        (bytes[0], bytes[1]) = (0x24, 2);
                    }
                    _ => bytes[2] |= 0x80,
                }
                bench.desk.tell(service, (to, from.port), &bytes);
            }
        }
    }
    bench.wire.faults = Faults::default();
    // What a garbled lease says is believed as long as it lasts.
    bench.is_up = false;
    bench.run(SECOND);
    bench.is_up = true;
    bench.get_address();
    let client = bench.connect(23);
    assert!(bench.desk.tcp(client).is_active());
}

#[test]
fn answers_that_are_garbled_do_no_harm() {
    (0..20).for_each(garble);
}

#[test]
#[ignore = "minutes of frames: make net runs it"]
fn many_answers_that_are_garbled_do_no_harm() {
    rounds().flat_map(|round| 10 * round..10 * (round + 1)).for_each(garble);
}

#[test]
#[ignore = "minutes of frames: make net runs it"]
fn many_frames_that_make_no_sense_do_no_harm() {
    rounds().for_each(|seed| feed(20_000, seed));
}

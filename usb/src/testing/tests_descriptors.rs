//! Every descriptor, walked and counted.

use super::{Board, Descriptor, Failure, Options, Request, walk};

const DEVICE: u8 = 1;
const CONFIGURATION: u8 = 2;
const STRING: u8 = 3;
const INTERFACE: u8 = 4;
const ENDPOINT: u8 = 5;
const ASSOCIATION: u8 = 11;
const BOS: u8 = 15;

fn every_choice() -> impl Iterator<Item = Options> {
    (0..8).map(|bits| Options { second: bits & 1 != 0, disk: bits & 2 != 0, download: bits & 4 != 0 })
}

fn configuration(options: Options) -> Vec<Descriptor> {
    let mut board = Board::new(options);
    board.host.reset();
    let head = board.host.descriptor(CONFIGURATION, 0, 9).unwrap();
    let total = u16::from_le_bytes([head[2], head[3]]);
    let whole = board.host.descriptor(CONFIGURATION, 0, total).unwrap();
    assert_eq!(whole.len(), usize::from(total), "wTotalLength");
    assert_eq!(whole, board.host.descriptor(CONFIGURATION, 0, 1024).unwrap(), "a longer request gives the same");
    let descriptors = walk(&whole);
    assert_eq!(descriptors[0].kind, CONFIGURATION);
    descriptors
}

#[test]
fn the_device_says_who_it_is() {
    let mut board = Board::new(Options::ALL);
    board.host.reset();
    let device = board.host.descriptor(DEVICE, 0, 18).unwrap();
    let expected: &[u8] = &[
        18, 1, 0x10, 0x02, // USB 2.1
        0xEF, 0x02, 0x01, // functions with interface associations
        64, 0x50, 0x1D, 0x15, 0x60, 0x00, 0x02, 1, 2, 3, 1,
    ];
    assert_eq!(device, expected);
    assert_eq!(board.host.descriptor(DEVICE, 0, 8).unwrap(), &expected[..8], "a host that asks for less gets less");
    let text = |bytes: Vec<u8>| {
        assert_eq!((bytes[0], bytes[1]), (bytes.len() as u8, STRING));
        let units: Vec<u16> = bytes[2..].chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
        String::from_utf16(&units).unwrap()
    };
    assert_eq!(board.host.descriptor(STRING, 0, 255).unwrap(), [4, 3, 0x09, 0x04], "English");
    let texts: Vec<String> = (1..=7).map(|index| text(board.host.descriptor(STRING, index, 255).unwrap())).collect();
    let expected = [
        "Velvet",
        "Smoothieboard v2 Prime",
        "000012340000ABCD56789ABC",
        "Velvet console",
        "Velvet second console",
        "Velvet SD card",
        "Velvet firmware download",
    ];
    assert_eq!(texts, expected);
    assert_eq!(board.host.descriptor(STRING, 8, 255), Err(Failure::Stall));
}

#[test]
fn the_configuration_of_every_choice_is_whole() {
    for options in every_choice() {
        let descriptors = configuration(options);
        let head = &descriptors[0].body;
        let of = |kind: u8| descriptors.iter().filter(move |descriptor| descriptor.kind == kind);
        let mut numbers: Vec<u8> = of(INTERFACE).map(|interface| interface.body[0]).collect();
        numbers.dedup();
        assert_eq!(numbers, (0..head[2]).collect::<Vec<u8>>(), "bNumInterfaces, numbered from 0");
        assert_eq!((head[3], head[5], head[6]), (1, 0xC0, 50), "value, self-powered without wake-up, 100 mA");
        let functions = 1 + usize::from(options.second) + usize::from(options.disk) + usize::from(options.download);
        let interfaces = functions + 1 + usize::from(options.second);
        assert_eq!(numbers.len(), interfaces);
        for (place, interface) in descriptors.iter().enumerate().filter(|(_, one)| one.kind == INTERFACE) {
            let rest = descriptors[place + 1..].iter().take_while(|one| !matches!(one.kind, INTERFACE | ASSOCIATION));
            let endpoints = rest.filter(|one| one.kind == ENDPOINT).count();
            assert_eq!(endpoints, usize::from(interface.body[2]), "bNumEndpoints");
        }
    }
}

#[test]
fn every_serial_port_is_one_function() {
    let descriptors = configuration(Options::ALL);
    let ports: Vec<usize> =
        descriptors.iter().enumerate().filter(|(_, one)| one.kind == ASSOCIATION).map(|(place, _)| place).collect();
    assert_eq!(ports.len(), 2, "only functions of several interfaces need an association");
    for place in ports {
        let association = &descriptors[place].body;
        let (first, name) = (association[0], association[5]);
        assert!(name > 3, "a name of its own");
        assert_eq!(association[1..5], [2, 0x02, 0x02, 0x00]);
        let control = &descriptors[place + 1];
        assert_eq!(control.kind, INTERFACE);
        assert_eq!(control.body, [first, 0, 1, 0x02, 0x02, 0x00, name]);
        let specific: Vec<&[u8]> =
            descriptors[place + 2..].iter().take_while(|one| one.kind == 0x24).map(|one| &one.body[..]).collect();
        let expected: [&[u8]; 4] =
            [&[0x00, 0x10, 0x01], &[0x02, 0x02], &[0x06, first, first + 1], &[0x01, 0, first + 1]];
        assert_eq!(specific, expected);
        assert_eq!(descriptors[place + 7].body[0], first + 1, "the data interface follows");
    }
}

/// Corrections of the configuration descriptor are the same if a host ends the answer early or asks for
/// something else.
#[test]
fn every_part_of_the_configuration_is_of_the_same_one() {
    let mut board = Board::new(Options::ALL);
    board.host.reset();
    let whole = board.host.descriptor(CONFIGURATION, 0, 1024).unwrap();
    let device = board.host.descriptor(DEVICE, 0, 18).unwrap();
    for length in 1..=whole.len() {
        let part = board.host.descriptor(CONFIGURATION, 0, length as u16).unwrap();
        assert_eq!(part, whole[..length], "{length} bytes");
    }
    for packets in 0..4 {
        board.host.bus.wire().setup(Request::new(0x80, 6, 0x0200, 0, 1024).bytes());
        board.host.device_runs();
        (0..packets).for_each(|_| drop(board.host.in_packet(0)));
        assert_eq!(board.host.descriptor(DEVICE, 0, 18).unwrap(), device, "behind {packets} packets of another");
        assert_eq!(board.host.descriptor(CONFIGURATION, 0, 1024).unwrap(), whole);
    }
}

#[test]
fn endpoints_are_those_of_smoothieware_and_the_disks() {
    let descriptors = configuration(Options::ALL);
    let endpoints: Vec<(u8, u8, u16, u8)> = descriptors
        .iter()
        .filter(|one| one.kind == ENDPOINT)
        .map(|one| (one.body[0], one.body[1], u16::from_le_bytes([one.body[2], one.body[3]]), one.body[4]))
        .collect();
    let expected = [
        (0x82, 3, 16, 32),
        (0x81, 2, 64, 0),
        (0x01, 2, 64, 0),
        (0x84, 3, 16, 32),
        (0x83, 2, 64, 0),
        (0x02, 2, 64, 0),
        (0x85, 2, 64, 0),
        (0x03, 2, 64, 0),
    ];
    assert_eq!(endpoints, expected);
}

#[test]
fn the_download_says_what_it_can() {
    let descriptors = configuration(Options::ALL);
    let functional = descriptors.iter().find(|one| one.kind == 0x21).unwrap();
    assert_eq!(functional.body, [0b1011, 0xE8, 0x03, 0x00, 0x01, 0x10, 0x01]);
    let interface = descriptors.iter().rfind(|one| one.kind == INTERFACE).unwrap();
    assert_eq!(interface.body[2..6], [0, 0xFE, 0x01, 0x01]);
}

#[test]
fn windows_finds_its_descriptors() {
    let mut board = Board::new(Options::ALL);
    board.host.reset();
    let bos = board.host.descriptor(BOS, 0, 255).unwrap();
    assert_eq!(usize::from(u16::from_le_bytes([bos[2], bos[3]])), bos.len());
    let capabilities = walk(&bos);
    assert_eq!(usize::from(bos[4]), capabilities.len() - 1, "bNumDeviceCaps");
    // No other capability: a "USB 2.0 extension" without link power management is an error for `lsusb -v`.
    let platform = &capabilities[1].body;
    assert_eq!((bos[4], platform[0]), (1, 5), "the capability PLATFORM");
    let length = u16::from_le_bytes([platform[22], platform[23]]);
    let set = board.host.ask(Request::new(0xC0, platform[24], 0, 7, length)).unwrap();
    assert_eq!(set.len(), usize::from(length));
    assert_eq!(set[22], 5, "the download's interface");
    assert_eq!(board.host.ask(Request::new(0xC0, platform[24], 0, 6, length)), Err(Failure::Stall));

    let mut without = Board::new(Options { download: false, ..Options::ALL });
    without.host.reset();
    assert_eq!(without.host.descriptor(BOS, 0, 255), Err(Failure::Stall), "nothing for Windows to look at");
    for (board, version) in [(&mut without, [0x00, 0x02]), (&mut board, [0x10, 0x02])] {
        assert_eq!(board.host.descriptor(DEVICE, 0, 18).unwrap()[2..4], version, "bcdUSB");
    }
}

#[test]
fn descriptors_that_there_are_not_are_refused() {
    let mut board = Board::new(Options::ALL);
    board.host.reset();
    // Qualifier and other speed, of high-speed devices; a second device, a second configuration.
    for (kind, index) in [(6, 0), (7, 0), (DEVICE, 1), (CONFIGURATION, 1), (0, 0), (0x29, 0), (BOS, 1)] {
        assert_eq!(board.host.descriptor(kind, index, 64), Err(Failure::Stall), "descriptor {kind} {index}");
    }
    assert!(board.host.descriptor(DEVICE, 0, 18).is_ok(), "and the next request is answered");
}

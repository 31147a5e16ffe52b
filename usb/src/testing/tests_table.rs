//! Table of requests and transfers: one row for each thing that a host may do to the device, with the result.
//! Behind each row the device must still work: its descriptor is read, and a port carries bytes.

use std::collections::BTreeMap;

use super::bus::Event;
use super::disk::ten;
use super::tests_disk_cases::{cases, run_case};
use super::{Board, Failure, Request};

/// Expected result of a request.
#[derive(Clone, Debug)]
enum Expects {
    /// Data of this length, or success without data for the host.
    Bytes(usize),
    /// Data equal to these bytes.
    Exactly(Vec<u8>),
    Stall,
}
use Expects::{Bytes, Exactly, Stall};

/// Event of the bus in the middle of a transfer.
#[derive(Clone, Copy, Debug)]
enum Happening {
    Reset,
    Sleep,
    SleepAndReset,
    Unplug,
    NewRequest,
}

enum Row {
    /// Request, with data if the request sends some.
    Request(Request, Vec<u8>, Expects),
    /// Bytes to a port: their number, and whether an empty packet ends them.
    ToPort(usize, bool),
    /// Bytes from a port: their number, and the number that the host asks for at a time.
    FromPort(usize, usize),
    /// Case of the bulk-only transport, by its index in the table of cases.
    Disk(usize),
    /// Event behind this number of packets of a transfer to a port, of a control answer, and of a read of the
    /// disk.
    InPort(usize, Happening),
    InControl(usize, Happening),
    InDisk(usize, Happening),
}

type Table = Vec<(&'static str, Row)>;

fn ask(
    table: &mut Table,
    group: &'static str,
    [kind, request]: [u8; 2],
    [value, index, length]: [u16; 3],
    expects: Expects,
) {
    table.push((group, Row::Request(Request::new(kind, request, value, index, length), Vec::new(), expects)));
}

fn tell(
    table: &mut Table,
    group: &'static str,
    [kind, request]: [u8; 2],
    [value, index]: [u16; 2],
    data: &[u8],
    expects: Expects,
) {
    let request = Request::new(kind, request, value, index, data.len() as u16);
    table.push((group, Row::Request(request, data.to_vec(), expects)));
}

fn descriptors(table: &mut Table) {
    const GET: [u8; 2] = [0x80, 6];
    let mut board = Board::enumerated();
    for (value, group) in [(0x0100, "device"), (0x0200, "configuration"), (0x0F00, "BOS")] {
        let whole = board.host.ask(Request::new(0x80, 6, value, 0, 0xFFFF)).unwrap();
        for length in [1, 2, 4, 8, 9, 17, 18, 63, 64, 65, 255, 0xFFFF_usize] {
            let part = whole[..length.min(whole.len())].to_vec();
            ask(table, group, GET, [value, 0, length as u16], Exactly(part));
        }
    }
    // Strings: languages; maker, product, serial number; both ports, disk, download.
    for index in 0..=7 {
        let whole = board.host.descriptor(3, index, 255).unwrap();
        let language = if index == 0 { 0 } else { 0x0409 };
        ask(table, "string", GET, [0x0300 | u16::from(index), language, 255], Exactly(whole.clone()));
        ask(table, "string", GET, [0x0300 | u16::from(index), language, 2], Exactly(whole[..2].to_vec()));
    }
    for value in
        [0x0308, 0x03EE, 0x03FF, 0x0101, 0x0201, 0x0F01, 0x0400, 0x0500, 0x0600, 0x0700, 0x0800, 0x2100, 0x2900, 0]
    {
        ask(table, "no such descriptor", GET, [value, 0x0409, 64], Stall);
    }
    tell(table, "no such descriptor", [0x00, 7], [0x0100, 0], &[0; 18], Stall);
}

fn chapter_9(table: &mut Table) {
    const ENDPOINTS: [u16; 10] = [0x00, 0x80, 0x81, 0x01, 0x82, 0x83, 0x02, 0x84, 0x85, 0x03];
    ask(table, "status", [0x80, 0], [0, 0, 2], Exactly(vec![1, 0]));
    (0..6).for_each(|interface| ask(table, "status", [0x81, 0], [0, interface, 2], Exactly(vec![0, 0])));
    ENDPOINTS.iter().for_each(|endpoint| ask(table, "status", [0x82, 0], [0, *endpoint, 2], Exactly(vec![0, 0])));
    [6, 0xFF, 0x100].iter().for_each(|interface| ask(table, "status", [0x81, 0], [0, *interface, 2], Stall));
    [4, 0x86, 0x0F, 0x8F, 0x10].iter().for_each(|endpoint| ask(table, "status", [0x82, 0], [0, *endpoint, 2], Stall));
    for endpoint in ENDPOINTS {
        let expects = if endpoint & 0x0F == 0 { Stall } else { Bytes(0) };
        tell(table, "halt", [0x02, 3], [0, endpoint], &[], expects);
        tell(table, "halt ends", [0x02, 1], [0, endpoint], &[], Bytes(0));
        tell(table, "no such feature", [0x02, 3], [1, endpoint], &[], Stall);
    }
    // Remote wake-up and test modes are not supported, and requests for them stall.
    for (request, value, index) in [(3, 1, 0), (1, 1, 0), (3, 2, 0x0100), (3, 2, 0x0400), (3, 0, 0), (3, 3, 0)] {
        tell(table, "remote wake-up", [0x00, request], [value, index], &[], Stall);
    }
    ask(table, "configuration is told", [0x80, 8], [0, 0, 1], Exactly(vec![1]));
    for (value, expects) in [(1, Bytes(0)), (2, Stall), (0xFF, Stall), (0x0100, Stall)] {
        tell(table, "configuration", [0x00, 9], [value, 0], &[], expects);
    }
    for interface in 0..6 {
        ask(table, "alternative is told", [0x81, 10], [0, interface, 1], Exactly(vec![0]));
        tell(table, "alternative", [0x01, 11], [0, interface], &[], Bytes(0));
        tell(table, "no such alternative", [0x01, 11], [1, interface], &[], Stall);
    }
    ask(table, "no such interface", [0x81, 10], [0, 6, 1], Stall);
    tell(table, "no such interface", [0x01, 11], [0, 6], &[], Stall);
    ask(table, "no such request", [0x82, 12], [0, 0x81, 2], Stall);
    for kind in [0x80, 0x81, 0x82, 0x83, 0xA0, 0xA2, 0xC1, 0xE0, 0xFF] {
        ask(table, "no such request", [kind, 0x77], [0, 0, 8], Stall);
    }
    for kind in [0x00, 0x01, 0x02, 0x20, 0x22, 0x40, 0x60] {
        tell(table, "no such request", [kind, 0x77], [0, 0], &[], Stall);
        tell(table, "no such request", [kind, 0x77], [0, 0], &[9; 9], Stall);
    }
}

fn classes(table: &mut Table) {
    const LINE: [u8; 7] = [0x00, 0xC2, 0x01, 0, 0, 0, 8];
    for interface in [0, 2] {
        tell(table, "line coding", [0x21, 0x20], [0, interface], &LINE, Bytes(0));
        ask(table, "line coding", [0xA1, 0x21], [0, interface, 7], Bytes(7));
        ask(table, "line coding", [0xA1, 0x21], [0, interface, 4], Bytes(4));
        ask(table, "line coding", [0xA1, 0x21], [0, interface, 64], Bytes(7));
        tell(table, "no modem", [0x21, 0x00], [0, interface], b"ATZ", Stall);
        ask(table, "no modem", [0xA1, 0x01], [0, interface, 64], Stall);
        (0..4).for_each(|lines| tell(table, "DTR and RTS", [0x21, 0x22], [lines, interface], &[], Bytes(0)));
        for wrong in [&LINE[..0], &LINE[..6], &[1; 8][..], &[1; 64][..]] {
            tell(table, "no line coding", [0x21, 0x20], [0, interface], wrong, Stall);
        }
    }
    for interface in [1, 3, 4, 5, 6] {
        tell(table, "no line coding", [0x21, 0x20], [0, interface], &LINE, Stall);
        ask(table, "no line coding", [0xA1, 0x21], [0, interface, 7], Stall);
    }
    ask(table, "units", [0xA1, 0xFE], [0, 4, 1], Exactly(vec![0]));
    tell(table, "transport reset", [0x21, 0xFF], [0, 4], &[], Bytes(0));
    for (value, index, length) in [(1, 4, 1), (0, 4, 2), (0, 3, 1), (0, 6, 1)] {
        ask(table, "no units", [0xA1, 0xFE], [value, index, length], Stall);
    }
    tell(table, "no transport reset", [0x21, 0xFF], [1, 4], &[], Stall);
    tell(table, "no transport reset", [0x21, 0xFF], [0, 3], &[], Stall);
    ask(table, "download", [0xA1, 5], [0, 5, 1], Exactly(vec![0]));
    ask(table, "download", [0xA1, 3], [0, 5, 6], Exactly(vec![0; 6]));
    tell(table, "download", [0x21, 0], [1_000, 5], &[], Bytes(0));
    for request in [1, 4, 6, 7] {
        tell(table, "no download here", [0x21, request], [0, 5], &[], Stall);
    }
    ask(table, "no download here", [0xA1, 2], [0, 5, 64], Stall);
    ask(table, "Microsoft", [0xC0, 0x20], [0, 7, 10], Bytes(10));
    ask(table, "no Microsoft", [0xC0, 0x20], [0, 6, 10], Stall);
    ask(table, "no Microsoft", [0xC1, 0x20], [0, 7, 10], Stall);
}

fn transfers(table: &mut Table) {
    for length in (0..=129).chain([191, 192, 193, 255, 256, 257, 511, 512, 513, 1_023, 1_024, 4_095, 4_096]) {
        table.push(("to a port", Row::ToPort(length, false)));
        table.push(("from a port", Row::FromPort(length, 65_536)));
        if length % 64 == 0 {
            table.push(("to a port, with an empty packet", Row::ToPort(length, true)));
        }
    }
    // The host asks for exactly the available bytes, or fewer; the device must never send more than
    // requested.
    for asked in [64, 128, 192, 256, 512] {
        table.push(("from a port, no babble", Row::FromPort(512, asked)));
    }
    (0..cases().len()).for_each(|place| table.push(("bulk-only cases", Row::Disk(place))));
    let happenings =
        [Happening::Reset, Happening::Sleep, Happening::SleepAndReset, Happening::Unplug, Happening::NewRequest];
    for happening in happenings {
        (0..4).for_each(|packets| table.push(("in a port's transfer", Row::InPort(packets, happening))));
        (0..3).for_each(|packets| table.push(("in a control transfer", Row::InControl(packets, happening))));
        [0, 1, 7, 8, 9]
            .iter()
            .for_each(|packets| table.push(("in a disk's transfer", Row::InDisk(*packets, happening))));
    }
}

fn text(length: usize) -> Vec<u8> {
    (0..length).map(|at| b'a' + (at % 26) as u8).collect()
}

fn request(board: &mut Board, request: Request, data: &[u8], expects: &Expects) -> Result<(), String> {
    let came =
        if request.is_in() { board.host.ask(request) } else { board.host.out(request, data).map(|()| Vec::new()) };
    let is_right = match (&came, expects) {
        (Ok(came), Bytes(length)) => came.len() == *length,
        (Ok(came), Exactly(bytes)) => came == bytes,
        (Err(Failure::Stall), Stall) => true,
        _ => false,
    };
    if is_right { Ok(()) } else { Err(format!("{request:?}: {came:?} for {expects:?}")) }
}

fn to_port(board: &mut Board, length: usize, ends_empty: bool) -> Result<(), String> {
    board.host.bulk_out(1, &text(length)).map_err(|why| format!("{why:?}"))?;
    if ends_empty {
        board.host.out_packet(1, &[]).map_err(|why| format!("{why:?}"))?;
    }
    let received = board.lines[0].state().received.clone();
    if received == text(length) { Ok(()) } else { Err(format!("{} of {length} bytes arrived", received.len())) }
}

fn from_port(board: &mut Board, length: usize, asked: usize) -> Result<(), String> {
    // Setting DTR begins a visit, as a host program does.
    board.host.out(Request::new(0x21, 0x22, 1, 0, 0), &[]).map_err(|why| format!("{why:?}"))?;
    board.lines[0].say(&text(length));
    board.host.device_runs();
    let mut came = Vec::new();
    while length > 0 && came.len() < length {
        came.extend(board.host.bulk_in(1, asked).map_err(|why| format!("{why:?}"))?);
    }
    if came == text(length) { Ok(()) } else { Err(format!("{} of {length} bytes came", came.len())) }
}

fn happens(board: &mut Board, happening: Happening) {
    match happening {
        Happening::Reset => board.host.enumerate(),
        Happening::Sleep => [Event::Suspend, Event::Resume].into_iter().for_each(|event| board.host.event(event)),
        Happening::SleepAndReset => {
            board.host.event(Event::Suspend);
            board.host.enumerate();
        }
        // The device sees an unplugged cable as silence, and a new one as a reset.
        Happening::Unplug => {
            board.host.event(Event::Suspend);
            board.host.device_runs();
            board.host.event(Event::Resume);
            board.host.enumerate();
        }
        Happening::NewRequest => assert_eq!(board.host.descriptor(1, 0, 18).unwrap().len(), 18),
    }
}

fn in_disk(board: &mut Board, packets: usize, happening: Happening) {
    let wrapper = super::disk::command(7, super::disk::Expects::In(4 * 512), &ten(0x28, 0, 4));
    board.host.bulk_out(3, &wrapper).unwrap();
    (0..packets).for_each(|_| drop(board.host.in_packet(5)));
    happens(board, happening);
    if matches!(happening, Happening::Sleep | Happening::NewRequest) {
        // The transfer goes on from its position.
        let rest = board.host.bulk_in(5, 4 * 512 - packets * 64).unwrap();
        assert_eq!(rest.len(), 4 * 512 - packets * 64);
        assert_eq!(board.host.bulk_in(5, 13).unwrap()[12], 0);
    }
    // A new host gets a unit attention for the medium first.
    let is_met = board.read_blocks(0, 1).data.len() == 512;
    assert!(is_met || board.read_blocks(0, 1).data.len() == 512, "the disk works");
}

fn carry_out(row: &Row) -> Result<(), String> {
    let mut board =
        if matches!(row, Row::Disk(_) | Row::InDisk(..)) { Board::with_disk() } else { Board::enumerated() };
    match row {
        Row::Request(what, data, expects) => request(&mut board, *what, data, expects)?,
        Row::ToPort(length, ends_empty) => to_port(&mut board, *length, *ends_empty)?,
        Row::FromPort(length, asked) => from_port(&mut board, *length, *asked)?,
        Row::Disk(place) => run_case(&cases()[*place]),
        Row::InPort(packets, happening) => {
            (0..*packets).for_each(|_| board.host.out_packet(1, &[b'x'; 64]).unwrap());
            happens(&mut board, *happening);
        }
        Row::InControl(packets, happening) => {
            board.host.bus.wire().setup(Request::new(0x80, 6, 0x0200, 0, 0xFFFF).bytes());
            board.host.device_runs();
            (0..*packets).for_each(|_| drop(board.host.in_packet(0)));
            happens(&mut board, *happening);
        }
        Row::InDisk(packets, happening) => in_disk(&mut board, *packets, *happening),
    }
    // The device still works, and its ports carry bytes after a new enumeration.
    if board.host.descriptor(1, 0, 18).map_err(|why| format!("{why:?}"))?.len() != 18 {
        return Err("the device descriptor has another length".into());
    }
    board.host.enumerate();
    board.lines[0].state().received.clear();
    board.host.bulk_out(1, b"M105\n").map_err(|why| format!("{why:?} behind it"))?;
    if board.lines[0].state().received == b"M105\n" { Ok(()) } else { Err("the port is silent behind it".into()) }
}

#[test]
fn every_row_of_the_table_ends_as_it_should() {
    let mut table = Table::new();
    descriptors(&mut table);
    chapter_9(&mut table);
    classes(&mut table);
    transfers(&mut table);
    let mut groups = BTreeMap::<&str, usize>::new();
    let mut wrong = Vec::new();
    for (number, (group, row)) in table.iter().enumerate() {
        *groups.entry(group).or_default() += 1;
        if let Err(why) = carry_out(row) {
            wrong.push(format!("row {number}, {group}: {why}"));
        }
    }
    println!("{} rows: {groups:?}", table.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(table.len() >= 200, "only {} rows", table.len());
}

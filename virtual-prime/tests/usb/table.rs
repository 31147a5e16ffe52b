//! A share of the table of requests and transfers (`usb/src/testing/tests_table.rs`, which runs all of them
//! on a bus in memory), on the image and its controller.

use usb_host::request::Setup;
use usb_host::transfer::{Outcome, Request};

use super::velvet::{Plugged, plug, two_ports};
use crate::common::MS;

/// A request, and the number of bytes in its answer; none: it is refused.
type Row = (u8, u8, u16, u16, u16, Option<usize>);

const ROWS: &[Row] = &[
    (0x80, 6, 0x0100, 0, 18, Some(18)),
    (0x80, 6, 0x0100, 0, 8, Some(8)),
    (0x80, 6, 0x0100, 0, 0xFFFF, Some(18)),
    (0x80, 6, 0x0200, 0, 9, Some(9)),
    (0x80, 6, 0x0200, 0, 64, Some(64)),
    (0x80, 6, 0x0200, 0, 128, Some(128)),
    (0x80, 6, 0x0300, 0, 255, Some(4)),
    (0x80, 6, 0x0301, 0x0409, 255, Some(14)),
    (0x80, 6, 0x0302, 0x0409, 255, Some(46)),
    (0x80, 6, 0x0303, 0x0409, 255, Some(50)),
    (0x80, 6, 0x0F00, 0, 5, Some(5)),
    (0x80, 6, 0x0600, 0, 10, None),
    (0x80, 6, 0x0700, 0, 10, None),
    (0x80, 6, 0x03EE, 0, 18, None),
    (0x80, 6, 0x0101, 0, 18, None),
    (0x80, 6, 0x0201, 0, 9, None),
    (0x00, 7, 0x0100, 0, 18, None),
    (0x80, 0, 0, 0, 2, Some(2)),
    (0x81, 0, 0, 5, 2, Some(2)),
    (0x81, 0, 0, 6, 2, None),
    (0x82, 0, 0, 0x85, 2, Some(2)),
    (0x82, 0, 0, 0x03, 2, Some(2)),
    (0x82, 0, 0, 0x86, 2, None),
    (0x82, 0, 0, 0x04, 2, None),
    (0x80, 8, 0, 0, 1, Some(1)),
    (0x81, 10, 0, 4, 1, Some(1)),
    (0x81, 10, 0, 6, 1, None),
    (0x01, 11, 1, 4, 0, None),
    (0x00, 9, 2, 0, 0, None),
    (0x00, 3, 1, 0, 0, None),
    (0x00, 1, 1, 0, 0, None),
    (0x00, 3, 2, 0x0100, 0, None),
    (0x02, 3, 0, 0, 0, None),
    (0x82, 12, 0, 0x81, 2, None),
    (0xA1, 0x21, 0, 0, 7, Some(7)),
    (0xA1, 0x21, 0, 2, 7, Some(7)),
    (0xA1, 0x21, 0, 4, 7, None),
    (0x21, 0x22, 3, 0, 0, Some(0)),
    (0x21, 0x22, 3, 1, 0, None),
    (0x21, 0x20, 0, 0, 3, None),
    (0x21, 0x20, 0, 0, 300, None),
    (0xA1, 0xFE, 0, 4, 1, Some(1)),
    (0xA1, 0xFE, 0, 4, 2, None),
    (0x21, 0xFF, 0, 4, 0, Some(0)),
    (0x21, 0xFF, 0, 3, 0, None),
    (0xA1, 5, 0, 5, 1, Some(1)),
    (0xA1, 3, 0, 5, 6, Some(6)),
    (0x21, 1, 0, 5, 0, None),
    (0x21, 1, 0, 5, 64, None),
    (0xA1, 2, 0, 5, 64, None),
    (0xC0, 0x20, 0, 7, 10, Some(10)),
    (0xC0, 0x20, 0, 4, 10, None),
    (0x40, 0x20, 0, 7, 0, None),
    (0xC1, 0x77, 0, 0, 8, None),
    (0xFF, 0x77, 0, 0, 8, None),
];

fn machine() -> Plugged {
    plug(two_ports().set("[system] msc_enable = true").set("[system] dfu_enable = true"))
}

#[test]
fn requests_end_as_the_table_says() {
    let mut plugged = machine();
    let mut wrong = Vec::new();
    for &(kind, request, value, index, length, expected) in ROWS {
        let setup = Setup { kind, request, value, index, length };
        let came = plugged.desk().control(setup.bytes(), &vec![0x11; length.into()]);
        let is_right = match (&came, expected) {
            (Ok(bytes), Some(count)) => kind & 0x80 == 0 || bytes.len() == count,
            (Err(error), None) => error.is_stall(),
            _ => false,
        };
        if !is_right {
            wrong.push(format!("{setup:?}: {came:?} for {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    plugged.open(1);
    plugged.assert_clean();
}

/// A stream of lines, cut into transfers of 1 to 129 bytes and some larger ones, each with an empty packet
/// behind it where it ends with a full one, every other time: each line comes to the machine whole, and each
/// answer back, whatever its length.
#[test]
fn transfers_of_every_size_carry_the_same_lines() {
    let mut plugged = machine();
    plugged.open(0);
    let sizes: Vec<usize> = (1..=129).chain([191, 192, 193, 255, 256, 257, 511, 512, 513]).collect();
    let total: usize = sizes.iter().sum();
    let mut lines = Vec::new();
    while lines.iter().map(|line: &String| line.len() + 6).sum::<usize>() < total {
        let length = 1 + lines.len() * 7 % 100;
        lines.push((0..length).map(|at| char::from(b'a' + (lines.len() + at) as u8 % 26)).collect());
    }
    let text: String = lines.iter().map(|line| format!("echo {line}\n")).collect();
    let said: String = lines.iter().map(|line| format!("{line}\nok\n")).collect();
    let port = plugged.ports[0];
    let (mut rest, mut heard) = (text.as_bytes(), String::new());
    for (number, size) in sizes.iter().chain(std::iter::once(&usize::MAX)).enumerate() {
        let (now, later) = rest.split_at((*size).min(rest.len()));
        rest = later;
        let id = plugged.desk().submit(port.output, Request::Out { data: now.to_vec(), zero: number % 2 == 0 });
        // The answers are read while the transfer waits for room.
        while heard.len() < said.len() {
            let Some(read) = port.listen(&mut plugged.desk(), 512) else { break };
            let _time = plugged.desk().pass(MS / 2);
            plugged.desk().cancel(read);
            let came = plugged.desk().ended(read);
            heard += &came.map(|came| String::from_utf8_lossy(&came.data).into_owned()).unwrap_or_default();
            if id.is_some_and(|id| plugged.desk().ended(id).is_some_and(|ended| ended.outcome == Outcome::Done)) {
                break;
            }
        }
    }
    while heard.len() < said.len() {
        heard += &plugged.hear_until(0, "ok\n");
    }
    assert_eq!(heard, said);
    plugged.assert_clean();
}

//! Checksums that the offload engine writes and checks, 61.5.11.

use rigless::soc::stm32h743::generated::{ethernet_mac as mac, ethernet_mtl as mtl};

use super::super::bits::maccr;
use super::super::descriptor::receive;
use super::bench::*;

/// An IPv4 packet with UDP, both checksums right: RFC 768 and RFC 791 by hand.
fn udp() -> Vec<u8> {
    let header = [0x45, 0, 0, 32, 0x12, 0x34, 0x40, 0, 64, 17, 0, 0, 192, 168, 1, 10, 192, 168, 1, 20];
    let mut bytes = header.to_vec();
    bytes.extend([0x30, 0x39, 0x00, 0x07, 0, 12, 0, 0, 1, 2, 3, 4]);
    let checksum = !add(&bytes[..20]);
    bytes[10..12].copy_from_slice(&checksum.to_be_bytes());
    let pseudo = [&bytes[12..20], &[0, 17, 0, 12], &bytes[20..]].concat();
    let checksum = !add(&pseudo);
    bytes[26..28].copy_from_slice(&checksum.to_be_bytes());
    bytes
}

/// Returns the one's complement sum.
fn add(bytes: &[u8]) -> u16 {
    let words = bytes.chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
    words.fold(0, |sum: u16, word| {
        let (low, carry) = sum.overflowing_add(word);
        low + u16::from(carry)
    })
}

fn checking() -> Bench {
    let mut bench = Bench::running();
    bench.mac(mac::Register::Maccr, maccr::RE | maccr::TE | maccr::FES | maccr::DM | maccr::CST | maccr::IPC);
    bench
}

#[test]
fn the_sums_of_the_tests_are_right() {
    assert_eq!(add(&udp()[..20]), 0xFFFF);
}

#[test]
fn checksums_are_written_as_cic_says() {
    let whole = frame(PARTNER, BOARD, 0x0800, &udp());
    let mut bare = whole.clone();
    bare[24..26].fill(0);
    bare[40..42].fill(0);
    let mut bench = Bench::running();
    let sent = |bench: &mut Bench, place, bytes: &[u8], cic: u32| {
        bench.send(place, bytes, cic << 16).expect("a frame").bytes[..whole.len()].to_vec()
    };
    assert_eq!(sent(&mut bench, 0, &bare, 0), bare);
    let mut with_header = bare.clone();
    with_header[24..26].copy_from_slice(&whole[24..26]);
    assert_eq!(sent(&mut bench, 1, &bare, 1), with_header);
    assert_eq!(sent(&mut bench, 2, &bare, 3), whole);
    // CIC = 2: the sum of the pseudo header is there already.
    let pseudo = [&bare[26..34], &[0, 17, 0, 12]].concat();
    bare[40..42].copy_from_slice(&add(&pseudo).to_be_bytes());
    assert_eq!(sent(&mut bench, 3, &bare, 2), whole);
}

#[test]
fn a_packet_with_right_checksums_comes_in_with_its_kind() {
    let mut bench = checking();
    bench.arrive(&frame(BOARD, PARTNER, 0x0800, &udp()));
    assert_eq!(bench.peek(RX_RING + 4), receive::IPV4 | 1);
}

#[test]
fn packets_with_wrong_checksums_are_dropped_or_marked() {
    let damaged = |at: usize| {
        let mut bytes = frame(BOARD, PARTNER, 0x0800, &udp());
        bytes[at] ^= 0x10;
        bytes
    };
    let (header, payload) = (damaged(14 + 8), damaged(14 + 30));
    let mut bench = checking();
    bench.arrive(&header);
    bench.arrive(&payload);
    assert_eq!(bench.wire(|wire| wire.counters().damaged), 2);
    bench.mtl(mtl::Register::Mtlrxqomr, 1 << 5 | 1 << 6);
    bench.arrive(&header);
    bench.arrive(&payload);
    assert_eq!(bench.peek(RX_RING + 4), receive::IPV4 | receive::IPHE | receive::IPCB);
    assert_eq!(bench.peek(RX_RING + 16 + 4), receive::IPV4 | receive::IPCE | 1);
    // Without IPC nobody looks.
    let mut bench = Bench::running();
    bench.arrive(&payload);
    assert_eq!(bench.received(0), Some([&payload[..], &[0; 14]].concat()));
}

#[test]
fn udp_without_a_checksum_and_fragments_pass() {
    let mut bench = checking();
    let mut without = frame(BOARD, PARTNER, 0x0800, &udp());
    without[40..42].fill(0);
    bench.arrive(&without);
    assert_eq!(bench.peek(RX_RING + 4), receive::IPV4 | 1);
    let mut fragment = udp();
    fragment[6] = 0x20;
    fragment[10..12].fill(0);
    let checksum = !add(&fragment[..20]);
    fragment[10..12].copy_from_slice(&checksum.to_be_bytes());
    bench.arrive(&frame(BOARD, PARTNER, 0x0800, &fragment));
    assert_eq!(bench.peek(RX_RING + 16 + 4), receive::IPV4 | receive::IPCB);
}

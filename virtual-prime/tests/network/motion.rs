//! Motion while the network is busy.

use super::{Net, plan};
use crate::common::velvet::SECOND;

/// Steps of a job while frames come as fast as the cable carries them.
#[test]
fn a_flood_of_pings_delays_no_step() {
    let mut net = Net::with_address(plan(&[]));
    net.ask("G28.3 X30 Y30 Z30");
    net.velvet.type_in("G1 X60 F1800");
    let end = net.velvet.now_ms() + 2 * SECOND;
    let ping = ping();
    while net.velvet.now_ms() < end {
        (0..2).for_each(|_| net.peer.put(&ping));
        net.run(1);
    }
    net.velvet.hear(100);
    let said = net.ask("get steps");
    assert!(said.contains("late: 0 (") && said.contains("delayed: 0\n"), "{said}");
}

/// An echo request of 1,000 bytes to the board's address, from the computer, to everybody's hardware address.
fn ping() -> Vec<u8> {
    let mut packet = vec![0x45, 0, 0, 0, 0, 0, 0, 0, 64, 1, 0, 0, 10, 0, 2, 2, 10, 0, 2, 15];
    let mut message = vec![8, 0, 0, 0, 0, 1, 0, 1];
    message.resize(1_000, 0x55);
    let length = (packet.len() + message.len()) as u16;
    packet[2..4].copy_from_slice(&length.to_be_bytes());
    let sum = checksum(&packet);
    packet[10..12].copy_from_slice(&sum.to_be_bytes());
    let sum = checksum(&message);
    message[2..4].copy_from_slice(&sum.to_be_bytes());
    [&[0xFF; 6][..], &[2, 0, 10, 0, 2, 2], &[8, 0], &packet, &message].concat()
}

/// The sum of RFC 1071.
fn checksum(bytes: &[u8]) -> u16 {
    let words = bytes.chunks(2).map(|pair| u32::from(u16::from_be_bytes([pair[0], pair.get(1).copied().unwrap_or(0)])));
    let sum: u32 = words.sum();
    let folded = (sum & 0xFFFF) + (sum >> 16);
    !((folded & 0xFFFF) + (folded >> 16)) as u16
}

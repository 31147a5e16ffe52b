//! Ethernet with its sender connected to its receiver: needs no cable, and of the PHY only its clock and its
//! answers.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicU32, Ordering};

use bsp_prime::ethernet::{self, Ethernet};
use bsp_prime::pac::interrupt;
use bsp_prime::time;
use bsp_prime::watchdog::Watchdog;
use smoltcp::phy::{Device, RxToken, TxToken};
use smoltcp::time::Instant;

/// Number of interrupts so far.
static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

#[interrupt]
fn ETH() {
    ethernet::on_interrupt();
    INTERRUPTS.fetch_add(1, Ordering::Relaxed);
}

/// The controller, and what keeps the board alive.
struct Net {
    ethernet: Ethernet,
    address: [u8; 6],
    watchdog: Watchdog,
}

/// Experimental type of frame, which no protocol has (IEEE 802).
const TYPE: [u8; 2] = [0x88, 0xB5];
/// Longest frame without its check sequence.
const LONGEST: usize = 1_514;

/// Byte of a frame's pattern.
fn pattern(seed: usize, place: usize) -> u8 {
    (seed.wrapping_mul(31) ^ place.wrapping_mul(7) ^ place >> 5) as u8
}

impl Net {
    /// Time as the stack has it.
    fn now() -> Instant {
        Instant::from_millis(time::now().millis() as i64)
    }

    /// Lets time pass with the controller watched, as a firmware does.
    fn run_us(&mut self, time_us: u64) {
        let end = time::now().0 + time_us;
        while time::now().0 < end {
            let _link = self.ethernet.supervise(time::now());
            self.watchdog.feed();
        }
    }

    /// Sends a frame with a pattern to an address; false without room.
    fn send_to(&mut self, destination: [u8; 6], seed: usize, length: usize) -> bool {
        let source = self.address;
        let Some(room) = self.ethernet.transmit(Self::now()) else { return false };
        room.consume(length, |frame| {
            defmt::assert_eq!(frame.len(), length);
            for (place, byte) in frame.iter_mut().enumerate() {
                *byte = match place {
                    0..6 => destination[place],
                    6..12 => source[place - 6],
                    12..14 => TYPE[place - 12],
                    _ => pattern(seed, place),
                };
            }
        });
        true
    }

    fn send(&mut self, seed: usize, length: usize) -> bool {
        self.send_to(self.address, seed, length)
    }

    /// Takes a frame, if one is there, and returns its length and its seed, of those below a limit, if it is
    /// whole.
    fn take(&mut self, seeds: usize) -> Option<(usize, Option<usize>)> {
        let (received, _) = self.ethernet.receive(Self::now())?;
        Some(received.consume(|frame| {
            let is = |seed: usize| (14..frame.len()).all(|place| frame[place] == pattern(seed, place));
            (frame.len(), (0..seeds).find(|&seed| is(seed)))
        }))
    }

    /// Waits for a frame, at most two milliseconds.
    fn await_frame(&mut self, seeds: usize) -> Option<(usize, Option<usize>)> {
        for _ in 0..200 {
            let taken = self.take(seeds);
            if taken.is_some() {
                return taken;
            }
            self.run_us(10);
        }
        None
    }

    /// Takes all frames that are there or on their way.
    fn drain(&mut self) -> usize {
        let mut count = 0;
        while self.await_frame(0).is_some() {
            count += 1;
        }
        count
    }
}

#[defmt_test::tests]
mod tests {
    use core::sync::atomic::Ordering;

    use bsp_prime::board::enable_interrupt;
    use bsp_prime::ethernet::{Ethernet, Link, LinkMode};
    use bsp_prime::pac::Interrupt;
    use bsp_prime::time;
    use on_target::bench;
    use smoltcp::phy::{ChecksumCapabilities, Device, RxToken, TxToken};
    use smoltcp::wire::{
        EthernetAddress, EthernetFrame, EthernetProtocol, IpProtocol, Ipv4Address, Ipv4Packet, Ipv4Repr, UdpPacket,
        UdpRepr,
    };

    use super::{INTERRUPTS, LONGEST, Net};

    #[init]
    fn init() -> Net {
        let bench = bench();
        enable_interrupt(Interrupt::ETH);
        let address = bench.identity.mac_address();
        match Ethernet::start(bench.ethernet, address, LinkMode::Auto) {
            Ok(ethernet) => Net { ethernet, address, watchdog: bench.watchdog },
            Err(error) => defmt::panic!("{=str}", error.message()),
        }
    }

    #[test]
    fn the_phy_gives_its_clock_and_answers(net: &mut Net) {
        net.run_us(1_000);
        defmt::assert!(!net.ethernet.has_work());
        net.run_us(200_000);
        if let Some(fault) = net.ethernet.fault() {
            defmt::panic!("{=str}", fault.message());
        }
    }

    #[test]
    fn without_a_link_frames_come_to_nothing(net: &mut Net) {
        for seed in 0..20 {
            defmt::assert!(net.send(seed, LONGEST), "none of them may wait for a cable");
        }
        defmt::assert_eq!(net.ethernet.counters().sent, 0);
    }

    #[test]
    fn a_loop_needs_no_cable(net: &mut Net) {
        net.ethernet.loop_back();
        net.run_us(1_000);
        defmt::assert!(matches!(net.ethernet.supervise(time::now()), Some(Link { .. })));
    }

    #[test]
    fn frames_of_every_length_come_back_round_and_round(net: &mut Net) {
        for length in 14..=LONGEST {
            let seed = length % 251;
            defmt::assert!(net.send(seed, length));
            let expected = length.max(60);
            match net.await_frame(251) {
                Some((taken, found)) => {
                    defmt::assert_eq!(taken, expected);
                    defmt::assert!(length < 60 || found == Some(seed), "{} bytes", length);
                }
                None => defmt::panic!("a frame of {} bytes is lost", length),
            }
        }
        let counters = net.ethernet.counters();
        let count = (LONGEST - 13) as u32;
        defmt::assert_eq!((counters.sent, counters.received), (count, count));
        defmt::assert_eq!((counters.damaged, counters.check_errors, counters.missed, counters.unsent), (0, 0, 0, 0));
    }

    #[test]
    fn a_full_ring_takes_and_gives_nothing_until_there_is_room(net: &mut Net) {
        let mut sent = 0;
        while net.send(sent, LONGEST) {
            sent += 1;
            defmt::assert!(sent <= 8, "the ring is never full");
        }
        defmt::assert!(sent >= 4);
        // What has come back meanwhile waits: there is no room for an answer to it.
        let is_held = |net: &mut Net| {
            let is_full = net.ethernet.transmit(Net::now()).is_none();
            is_full && !net.ethernet.has_work() && net.take(8).is_none()
        };
        defmt::assert!(is_held(net));
        let before = INTERRUPTS.load(Ordering::Relaxed);
        while is_held(net) {}
        defmt::assert!(INTERRUPTS.load(Ordering::Relaxed) > before, "room is told");
        for seed in 0..sent {
            defmt::assert_eq!(net.await_frame(8), Some((LONGEST, Some(seed))));
        }
        defmt::assert!(net.ethernet.transmit(Net::now()).is_some());
    }

    #[test]
    fn a_burst_that_nobody_takes_is_lost_from_its_end_and_leaves_no_trace(net: &mut Net) {
        let before = net.ethernet.counters();
        for seed in 0..50 {
            while !net.send(seed, 600) {
                net.run_us(10);
            }
        }
        net.run_us(2_000);
        for seed in 0..6 {
            defmt::assert_eq!(net.await_frame(50), Some((600, Some(seed))), "the first are in the buffers");
        }
        let more = net.drain();
        defmt::assert!(more < 10, "{} more were in the queue", more);
        net.run_us(10);
        let counters = net.ethernet.counters();
        let lost = counters.missed - before.missed;
        defmt::assert_eq!(lost as usize, 50 - 6 - more);
        for seed in 0..20 {
            defmt::assert!(net.send(seed, 100));
            defmt::assert_eq!(net.await_frame(20), Some((100, Some(seed))), "all goes on");
        }
    }

    #[test]
    fn only_frames_for_the_board_come_in(net: &mut Net) {
        let mut neighbour = net.address;
        neighbour[5] ^= 1;
        let wanted = [net.address, [0xFF; 6], [0x01, 0, 0x5E, 0, 0, 0xFB], [0x01, 0, 0x5E, 0, 0, 0x01]];
        for destination in wanted {
            defmt::assert!(net.send_to(destination, 3, 64));
            defmt::assert_eq!(net.await_frame(4), Some((64, Some(3))), "{=[u8]:02x}", destination);
        }
        let others = [neighbour, [0x01, 0, 0x5E, 0x7F, 0xFF, 0xFA], [0x33, 0x33, 0, 0, 0, 0xFB]];
        for destination in others {
            defmt::assert!(net.send_to(destination, 3, 64));
            defmt::assert_eq!(net.await_frame(4), None, "{=[u8]:02x}", destination);
        }
    }

    #[test]
    fn the_controller_inserts_checksums(net: &mut Net) {
        let [source, target] = [Ipv4Address::new(10, 0, 0, 1), Ipv4Address::new(10, 0, 0, 2)];
        let text = b"left to the controller";
        let udp = UdpRepr { src_port: 5_353, dst_port: 123 };
        let payload_len = udp.header_len() + text.len();
        let ip =
            Ipv4Repr { src_addr: source, dst_addr: target, next_header: IpProtocol::Udp, payload_len, hop_limit: 64 };
        let address = EthernetAddress(net.address);
        let none = ChecksumCapabilities::ignored();
        let Some(room) = net.ethernet.transmit(Net::now()) else { defmt::panic!("no room") };
        room.consume(14 + 20 + payload_len, |bytes| {
            let mut frame = EthernetFrame::new_unchecked(bytes);
            frame.set_dst_addr(address);
            frame.set_src_addr(address);
            frame.set_ethertype(EthernetProtocol::Ipv4);
            let mut packet = Ipv4Packet::new_unchecked(frame.payload_mut());
            ip.emit(&mut packet, &none);
            let mut datagram = UdpPacket::new_unchecked(packet.payload_mut());
            let fill = |bytes: &mut [u8]| bytes.copy_from_slice(text);
            udp.emit(&mut datagram, &source.into(), &target.into(), text.len(), fill, &none);
        });
        net.run_us(1_000);
        let Some((received, _)) = net.ethernet.receive(Net::now()) else { defmt::panic!("lost") };
        received.consume(|bytes| {
            let frame = EthernetFrame::new_unchecked(bytes);
            let packet = Ipv4Packet::new_unchecked(frame.payload());
            defmt::assert!(packet.verify_checksum(), "of the header");
            let datagram = UdpPacket::new_unchecked(packet.payload());
            defmt::assert!(datagram.checksum() != 0 && datagram.verify_checksum(&source.into(), &target.into()));
            defmt::assert_eq!(datagram.payload(), text);
        });
    }

    #[test]
    fn a_flood_of_broadcasts_does_not_get_through(net: &mut Net) {
        // All of it is in one window of time, as the stack has it.
        net.run_us(100_000);
        let before = net.ethernet.counters();
        let now = Net::now();
        let mut taken = 0;
        for seed in 0..300 {
            while !net.send_to([0xFF; 6], seed, 60) {
                net.run_us(10);
            }
            net.run_us(20);
            if let Some((received, _)) = net.ethernet.receive(now) {
                received.consume(|frame| defmt::assert_eq!(frame.len(), 60));
                taken += 1;
            }
        }
        defmt::assert_eq!(taken, 200);
        defmt::assert_eq!(net.ethernet.counters().too_many - before.too_many, 100);
        defmt::assert!(net.send(1, 60));
        defmt::assert_eq!(net.await_frame(2), Some((60, Some(1))), "what is for the board alone comes in");
    }

    #[test]
    fn the_interrupt_comes_once_until_all_is_taken(net: &mut Net) {
        defmt::assert_eq!(net.drain(), 0);
        let count = || INTERRUPTS.load(Ordering::Relaxed);
        let before = count();
        for seed in 0..4 {
            defmt::assert!(net.send(seed, 200));
        }
        net.run_us(1_000);
        defmt::assert_eq!(count() - before, 1);
        for seed in 0..4 {
            defmt::assert_eq!(net.take(4), Some((200, Some(seed))));
        }
        defmt::assert_eq!((net.take(4), count() - before), (None, 1));
        defmt::assert!(net.send(0, 200));
        net.run_us(1_000);
        defmt::assert_eq!(count() - before, 2);
        defmt::assert_eq!(net.drain(), 1);
    }
}

//! The controller on a bus of its own, with memory behind its DMA and a partner at the cable.

use std::collections::HashMap;

use rigless::device::{DeviceContext, ErasedDevice, Level, ResetCause};
use rigless::emulator::{Error, Memory};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::stm32h743::builder;
use rigless::soc::stm32h743::generated::{ETHERNET_DMA, ETHERNET_MAC, ETHERNET_MTL, rcc};
use rigless::soc::stm32h743::generated::{ethernet_dma as dma, ethernet_mac as mac, ethernet_mtl as mtl};
use rigless::soc::{Bus, Layout, Peripheral, Width};
use rigless::time::VirtualNanos;

use super::super::bits::{channel, maccr, status};
use super::super::descriptor::{FIRST, LAST, OWN, receive, transmit};
use super::super::link::{Link, Partner};
use super::super::state::{Ethernet, Place, Surroundings};
use super::super::wire::{Sent, Wire};

/// Rings and buffers, in SRAM3; a ring may be somewhere else in a test.
pub(super) const TX_RING: u32 = 0x3004_0000;
pub(super) const RX_RING: u32 = 0x3004_0100;
pub(super) const TX_BUFFERS: u32 = 0x3004_1000;
pub(super) const RX_BUFFERS: u32 = 0x3004_3000;
/// Descriptors of each ring, and distance of buffers.
pub(super) const RING: u32 = 4;
pub(super) const STRIDE: u32 = 1_536;
/// Station address of the board, and of the partner.
pub(super) const BOARD: [u8; 6] = [0x02, 0x11, 0x22, 0x33, 0x44, 0x55];
pub(super) const PARTNER: [u8; 6] = [0x02, 0xAA, 0xBB, 0xCC, 0xDD, 0xEE];
pub(super) const FULL: Link = Link { is_fast: true, is_full: true };
/// Longest negotiation.
pub(super) const NEGOTIATION_NS: u64 = 3_000_000_000;

/// Memory of the part: zero where nothing was written.
#[derive(Debug, Default)]
pub(super) struct Ram(HashMap<u64, u8>);

const fn bytes_of(width: Width) -> u64 {
    match width {
        Width::W8 => 1,
        Width::W16 => 2,
        Width::W32 => 4,
        Width::W64 => 8,
    }
}

impl Memory for Ram {
    fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
        let byte = |place| u64::from(self.0.get(&(address + place)).copied().unwrap_or(0)) << (8 * place);
        Ok((0..bytes_of(width)).map(byte).sum())
    }

    fn write(&mut self, address: u64, width: Width, value: u64) -> Result<(), Error> {
        for place in 0..bytes_of(width) {
            self.0.insert(address + place, (value >> (8 * place)) as u8);
        }
        Ok(())
    }
}

#[derive(Debug)]
struct Part {
    bus: Bus,
    ethernet: Ethernet,
    slots: [(usize, Place); 3],
}

impl Mcu for Part {
    fn bus(&self) -> &Bus {
        &self.bus
    }

    fn bus_mut(&mut self) -> &mut Bus {
        &mut self.bus
    }

    fn reset(&mut self, _: VirtualNanos, _: ResetCause) {
        self.reset_every_model();
    }

    fn poll(&mut self, _: VirtualNanos) {}

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        let place = self.slots.iter().find(|&&(own, _)| own == slot).map(|&(_, place)| place);
        let model = place.map(|place| self.ethernet.face(place) as &mut dyn ErasedDevice);
        (&mut self.bus, model)
    }
}

/// The controller with what is around it.
pub(super) struct Bench {
    part: Part,
    pub(super) ram: Ram,
    pub(super) now_ns: u64,
    pub(super) around: Surroundings,
    /// Level of interrupt 61.
    pub(super) interrupt: bool,
    told: Vec<&'static str>,
}

impl Bench {
    /// Creates the controller with its clocks and pins, out of reset and without a cable.
    pub(super) fn new() -> Self {
        let mut bus = builder().build().expect("a bus");
        let slot = |name| bus.slot(name).expect("a block");
        let slots = [
            (slot("Ethernet_MAC"), Place::Mac),
            (slot("Ethernet_MTL"), Place::Mtl),
            (slot("Ethernet_DMA"), Place::Dma),
        ];
        let clocks = slot("RCC");
        bus.slot_mut(clocks).registers_mut().set(rcc::Register::Ahb1enr, rcc::ahb1enr::ETH1MACEN.mask());
        let around = Surroundings {
            clocked: true,
            managed: true,
            hears: true,
            speaks: true,
            speaks_fast: true,
            hclk_hz: 200_000_000,
        };
        let mut part = Part { bus, ethernet: Ethernet::new(), slots };
        part.ethernet.look_around(around);
        Self { part, ram: Ram::default(), now_ns: 0, around, interrupt: false, told: Vec::new() }
    }

    /// Creates the controller with a link, both rings filled and everything started.
    pub(super) fn running() -> Self {
        let mut bench = Self::new();
        bench.link(Partner::default());
        bench.set_up();
        bench.start();
        bench
    }

    /// Plugs a cable in and waits for the link.
    pub(super) fn link(&mut self, partner: Partner) {
        self.wire(|wire| wire.plug(partner));
        self.run(NEGOTIATION_NS);
    }

    /// Writes station address, rings and buffers.
    pub(super) fn set_up(&mut self) {
        self.mac(mac::Register::Maca0hr, 0x5544);
        self.mac(mac::Register::Maca0lr, 0x3322_1102);
        self.mtl(mtl::Register::Mtlrxqomr, 1 << 5);
        self.dma(dma::Register::Dmactxdlar, TX_RING);
        self.dma(dma::Register::Dmactxrlr, RING - 1);
        self.dma(dma::Register::Dmacrxdlar, RX_RING);
        self.dma(dma::Register::Dmacrxrlr, RING - 1);
        for place in 0..RING {
            self.release(place);
        }
    }

    /// Starts MAC and DMA at 100 Mbit/s and full duplex, with the check sequence stripped.
    pub(super) fn start(&mut self) {
        let configuration = maccr::RE | maccr::TE | maccr::FES | maccr::DM | maccr::CST | maccr::ACS;
        self.mac(mac::Register::Maccr, configuration);
        self.dma(dma::Register::Dmactxcr, channel::START);
        self.dma(dma::Register::Dmacrxcr, channel::START | STRIDE << 1);
    }

    /// Gives a receive descriptor to the DMA.
    pub(super) fn release(&mut self, place: u32) {
        let at = RX_RING + place * 16;
        self.poke(at, RX_BUFFERS + place * STRIDE);
        self.poke(at + 12, OWN | receive::IOC | receive::BUF1V);
    }

    /// Puts a frame into a transmit descriptor, and gives that to the DMA.
    pub(super) fn fill(&mut self, place: u32, frame: &[u8], options: u32) {
        let (at, buffer) = (TX_RING + place * 16, TX_BUFFERS + place * STRIDE);
        self.poke_bytes(buffer, frame);
        self.poke(at, buffer);
        self.poke(at + 8, transmit::IOC | frame.len() as u32);
        self.poke(at + 12, OWN | FIRST | LAST | options);
    }

    /// Sends a frame by this descriptor, and waits for its end. Returns what the partner heard.
    pub(super) fn send(&mut self, place: u32, frame: &[u8], options: u32) -> Option<Sent> {
        self.fill(place, frame, options);
        self.dma(dma::Register::Dmactxdtpr, TX_RING);
        self.run(200_000);
        self.wire(Wire::take)
    }

    /// Puts a frame on the line to the board and waits until it has arrived.
    pub(super) fn arrive(&mut self, frame: &[u8]) {
        self.wire(|wire| wire.put(frame));
        self.run(200_000);
    }

    /// Returns the bytes of a receive descriptor's frame, when the DMA has closed it as the only one.
    pub(super) fn received(&mut self, place: u32) -> Option<Vec<u8>> {
        let des3 = self.peek(RX_RING + place * 16 + 12);
        let whole = des3 & (OWN | FIRST | LAST) == FIRST | LAST;
        whole.then(|| self.peek_bytes(RX_BUFFERS + place * STRIDE, des3 & 0x7FFF))
    }

    pub(super) fn status(&mut self) -> u32 {
        self.read_dma(dma::Register::Dmacsr)
    }

    pub(super) fn clear(&mut self) {
        self.dma(dma::Register::Dmacsr, u32::MAX);
    }

    /// Waits for these flags of DMACSR. Returns the time, ns.
    #[track_caller]
    pub(super) fn run_until(&mut self, flags: u32) -> u64 {
        let began_ns = self.now_ns;
        while self.status() & flags == 0 {
            assert!(self.now_ns - began_ns < 10_000_000, "no {flags:#x}: {:#x}", self.status());
            self.run(10);
        }
        self.now_ns - began_ns
    }

    pub(super) fn run(&mut self, nanoseconds: u64) {
        let end_ns = self.now_ns + nanoseconds;
        // A session steps from event to event.
        while let Some(at) = self.part.bus.next_event().filter(|at| at.0 <= end_ns) {
            self.part.advance_to(at);
            self.settle();
        }
        self.now_ns = end_ns;
    }

    fn settle(&mut self) {
        self.part.settle(&mut self.ram).expect("memory");
        for change in self.part.drain_interrupts() {
            assert_eq!(change.interrupt, 61);
            self.interrupt = change.level == Level::High;
        }
        self.told.extend(self.part.drain_told().iter().map(|told| told.reason));
    }

    /// Takes the complaints so far.
    pub(super) fn complaints(&mut self) -> Vec<&'static str> {
        std::mem::take(&mut self.told)
    }

    pub(super) fn wire<R>(&mut self, work: impl FnOnce(&mut Wire) -> R) -> R {
        self.with(|ethernet, context| ethernet.with_wire(context, work))
    }

    pub(super) fn with<R>(&mut self, work: impl FnOnce(&mut Ethernet, &mut DeviceContext<'_>) -> R) -> R {
        let (slot, place) = self.part.slots[0];
        let (_, mut context) = self.part.bus.drive(VirtualNanos(self.now_ns), slot);
        let done = work(self.part.ethernet.face(place), &mut context);
        self.settle();
        done
    }

    /// Resets the controller as RCC does, by all three of its blocks.
    pub(super) fn reset_controller(&mut self) {
        for (slot, place) in self.part.slots {
            let (registers, mut context) = self.part.bus.drive(VirtualNanos(self.now_ns), slot);
            ErasedDevice::reset_line(self.part.ethernet.face(place), registers, &mut context);
            self.settle();
        }
    }

    /// Changes the surroundings.
    pub(super) fn look_around(&mut self, around: Surroundings) {
        self.around = around;
        self.part.ethernet.look_around(around);
    }

    fn write(&mut self, block: &Peripheral, offset: u32, value: u32) {
        let address = block.base + u64::from(offset);
        self.part.write(VirtualNanos(self.now_ns), address, Width::W32, u64::from(value)).expect("a register");
        self.settle();
    }

    fn read(&mut self, block: &Peripheral, offset: u32) -> u32 {
        let address = block.base + u64::from(offset);
        let value = self.part.read(VirtualNanos(self.now_ns), address, Width::W32).expect("a register");
        self.settle();
        value as u32
    }

    pub(super) fn dma(&mut self, register: dma::Register, value: u32) {
        self.write(&ETHERNET_DMA, register.spec().offset, value);
    }

    pub(super) fn read_dma(&mut self, register: dma::Register) -> u32 {
        self.read(&ETHERNET_DMA, register.spec().offset)
    }

    pub(super) fn mac(&mut self, register: mac::Register, value: u32) {
        self.write(&ETHERNET_MAC, register.spec().offset, value);
    }

    pub(super) fn read_mac(&mut self, register: mac::Register) -> u32 {
        self.read(&ETHERNET_MAC, register.spec().offset)
    }

    pub(super) fn mtl(&mut self, register: mtl::Register, value: u32) {
        self.write(&ETHERNET_MTL, register.spec().offset, value);
    }

    pub(super) fn read_mtl(&mut self, register: mtl::Register) -> u32 {
        self.read(&ETHERNET_MTL, register.spec().offset)
    }

    pub(super) fn poke(&mut self, address: u32, word: u32) {
        self.ram.write(u64::from(address), Width::W32, u64::from(word)).expect("memory");
    }

    pub(super) fn peek(&mut self, address: u32) -> u32 {
        self.ram.read(u64::from(address), Width::W32).expect("memory") as u32
    }

    pub(super) fn poke_bytes(&mut self, address: u32, bytes: &[u8]) {
        for (at, &byte) in (u64::from(address)..).zip(bytes) {
            self.ram.write(at, Width::W8, u64::from(byte)).expect("memory");
        }
    }

    pub(super) fn peek_bytes(&mut self, address: u32, count: u32) -> Vec<u8> {
        (0..count).map(|place| self.ram.read(u64::from(address + place), Width::W8).expect("memory") as u8).collect()
    }

    /// Reads a register of the PHY.
    pub(super) fn phy(&mut self, register: u32) -> u16 {
        self.mac(mac::Register::Macmdioar, register << 16 | 4 << 8 | 3 << 2 | 1);
        self.run(40_000);
        assert_eq!(self.read_mac(mac::Register::Macmdioar) & 1, 0);
        self.read_mac(mac::Register::Macmdiodr) as u16
    }

    /// Writes a register of the PHY.
    pub(super) fn set_phy(&mut self, register: u32, value: u16) {
        self.mac(mac::Register::Macmdiodr, u32::from(value));
        self.mac(mac::Register::Macmdioar, register << 16 | 4 << 8 | 1 << 2 | 1);
        self.run(40_000);
    }

    /// Lets these interrupts through.
    pub(super) fn enable(&mut self, causes: u32) {
        self.dma(dma::Register::Dmacier, causes);
    }
}

/// Returns a frame with this payload.
pub(super) fn frame(to: [u8; 6], from: [u8; 6], kind: u16, payload: &[u8]) -> Vec<u8> {
    [&to[..], &from, &kind.to_be_bytes(), payload].concat()
}

/// Returns a frame for the board of so many bytes, each different from its neighbours.
pub(super) fn to_board(length: usize) -> Vec<u8> {
    let payload: Vec<u8> = (0..length - 14).map(|place| (place * 7 + length) as u8).collect();
    frame(BOARD, PARTNER, 0x88B5, &payload)
}

/// Returns a frame of the board's of so many bytes.
pub(super) fn from_board(length: usize) -> Vec<u8> {
    let payload: Vec<u8> = (0..length - 14).map(|place| (place * 5 + length) as u8).collect();
    frame(PARTNER, BOARD, 0x88B5, &payload)
}

/// All flags of DMACSR that stand for something that went wrong.
pub(super) const WRONG: u32 = status::ABNORMAL & !status::ETI;

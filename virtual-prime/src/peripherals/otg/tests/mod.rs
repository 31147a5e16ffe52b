//! Tests of the core from both sides: its registers, and the host at the other end of the cable.

mod control;
mod link;
mod receive;
mod set_up;
mod transmit;

use super::core::{Core, Surroundings};
use super::registers::*;
use usb_host::controller::{Controller, Port};
use usb_host::transfer::{Completion, Direction, Endpoint, Kind, Outcome, Request, TransferId};

const MS: u64 = 1_000_000;

/// Surroundings of the core as an image should have set them up.
const WIRED: Surroundings =
    Surroundings { kernel_hz: 48_000_000, pins: true, supply: true, ulpi: false, ulpi_asleep: false };

/// A core with a host, and the virtual time.
struct Bench {
    core: Core,
    host: Controller,
    now: u64,
    ended: Vec<Completion>,
}

impl Bench {
    /// Creates a core out of reset.
    fn new() -> Self {
        let mut core = Core::new();
        core.look_around(WIRED);
        Self { core, host: Controller::default(), now: 0, ended: Vec::new() }
    }

    /// Creates a core that is connected and enabled by a bus reset, with FIFOs and endpoint 0 ready for a
    /// SETUP, and all interrupts unmasked but SOF and the host's.
    fn ready() -> Self {
        let mut bench = Self::new();
        bench.connect();
        bench.enable();
        bench.set_up_fifos();
        bench.w(OUT + TSIZ, 3 << 29 | 1 << 19 | 64);
        bench.w(DIEPMSK, 0xFFFF);
        bench.w(DOEPMSK, 0xFFFF);
        bench.w(DAINTMSK, 0xFFFF_FFFF);
        bench.w(GINTMSK, !(gint::SOF | gint::NPTXFE | gint::PTXFE));
        bench.w(GAHBCFG, gahbcfg::GINT);
        bench.clear_all();
        bench
    }

    /// Switches the core on as a full-speed device and pulls up.
    fn connect(&mut self) {
        self.w(GUSBCFG, 0x1400 | gusbcfg::PHYSEL);
        self.w(GRSTCTL, grstctl::CSRST);
        self.w(GCCFG, gccfg::PWRDWN);
        self.w(GOTGCTL, gotgctl::BVALOEN | gotgctl::BVALOVAL);
        self.w(DCFG, 0x0220_0003);
        self.w(DCTL, 0);
    }

    /// Plugs in the cable and resets the bus.
    fn enable(&mut self) {
        self.host.plug(self.now, &mut self.core);
        self.run(MS);
        assert_eq!(self.host.port(), Port::Connected);
        self.host.reset(self.now, 10 * MS, &mut self.core);
        self.run(11 * MS);
        assert_eq!(self.host.port(), Port::Enabled);
    }

    /// Sets up the FIFOs: 128 words for reception, 16 for each of endpoints 0 to 2.
    fn set_up_fifos(&mut self) {
        self.w(GRXFSIZ, 128);
        self.w(HNPTXFSIZ, 16 << 16 | 128);
        self.w(DIEPTXF1, 32 << 16 | 144);
        self.w(DIEPTXF1 + 4, 16 << 16 | 176);
    }

    fn clear_all(&mut self) {
        self.w(GINTSTS, !0);
        for number in 0..ENDPOINTS as u32 {
            self.w(IN + number * STRIDE + INT, 0xFFFF);
            self.w(OUT + number * STRIDE + INT, 0xFFFF);
        }
    }

    /// Opens bulk endpoints 1, 64 bytes each way.
    fn open_bulk(&mut self) {
        let bulk = epctl::USBAEP | 0b10 << epctl::EPTYP_SHIFT | epctl::SD0PID | 64;
        self.w(IN + STRIDE + CTL, bulk | 1 << epctl::TXFNUM_SHIFT | epctl::SNAK);
        self.w(OUT + STRIDE + CTL, bulk | epctl::SNAK);
        self.clear_all();
    }

    /// Arms bulk OUT for so many packets and bytes.
    fn arm_out(&mut self, packets: u32, bytes: u32) {
        self.w(OUT + STRIDE + TSIZ, packets << 19 | bytes);
        let control = self.r(OUT + STRIDE + CTL);
        self.w(OUT + STRIDE + CTL, control | epctl::EPENA | epctl::CNAK);
    }

    /// Sends data on an IN endpoint.
    fn send(&mut self, number: u32, data: &[u8], packets: u32) {
        self.w(IN + number * STRIDE + TSIZ, packets << 19 | data.len() as u32);
        let control = self.r(IN + number * STRIDE + CTL);
        self.w(IN + number * STRIDE + CTL, control | epctl::EPENA | epctl::CNAK);
        self.fill(number, data);
    }

    fn fill(&mut self, number: u32, data: &[u8]) {
        // A packet begins with a new word.
        for packet in data.chunks(64) {
            for word in packet.chunks(4) {
                let mut bytes = [0; 4];
                bytes[..word.len()].copy_from_slice(word);
                self.w(FIFO + number * FIFO_STRIDE, u32::from_le_bytes(bytes));
            }
        }
    }

    /// Pops an entry with its data: PKTSTS, endpoint, bytes.
    fn pop(&mut self) -> (u32, u32, Vec<u8>) {
        let word = self.r(GRXSTSP);
        let count = (word >> rxsts::BCNT_SHIFT & 0x7FF) as usize;
        let words: Vec<u32> = (0..count.div_ceil(4)).map(|_| self.r(FIFO)).collect();
        let bytes = words.into_iter().flat_map(u32::to_le_bytes).take(count).collect();
        (word >> rxsts::PKTSTS_SHIFT & 0xF, word & 0xF, bytes)
    }

    fn w(&mut self, offset: u32, value: u32) {
        self.core.write(self.now, offset, value);
        self.host.run(self.now, &mut self.core);
    }

    fn r(&mut self, offset: u32) -> u32 {
        let value = self.core.read(self.now, offset);
        self.host.run(self.now, &mut self.core);
        value
    }

    /// Runs core and host for so many nanoseconds.
    fn run(&mut self, ns: u64) {
        let end = self.now + ns;
        self.host.run(self.now, &mut self.core);
        while let Some(at) = [self.core.next_change(), self.host.next()].into_iter().flatten().min()
            && at <= end
        {
            assert!(at >= self.now, "time goes on");
            self.now = at;
            self.core.advance(at);
            self.host.run(at, &mut self.core);
        }
        self.now = end;
        self.core.advance(end);
        self.ended.extend(self.host.take_completions());
    }

    /// Returns the level of the core's interrupt line.
    fn line(&self) -> bool {
        self.core.lines()[3]
    }

    fn submit(&mut self, endpoint: Endpoint, request: Request) -> TransferId {
        let id = self.host.submit(self.now, endpoint, request);
        self.host.run(self.now, &mut self.core);
        id
    }

    fn setup(&mut self, setup: [u8; 8], data: &[u8]) -> TransferId {
        self.submit(CONTROL, Request::Control { setup, data: data.to_vec() })
    }

    /// Takes the completion of a transfer, if it has ended.
    fn outcome(&mut self, id: TransferId) -> Option<Completion> {
        self.ended.extend(self.host.take_completions());
        self.ended.iter().position(|ended| ended.id == id).map(|place| self.ended.remove(place))
    }

    #[track_caller]
    fn expect(&mut self, id: TransferId, outcome: Outcome) -> Vec<u8> {
        let ended = self.outcome(id).expect("the transfer has ended");
        assert_eq!(ended.outcome, outcome);
        ended.data
    }

    /// Returns the registers named in the core's findings.
    fn found(&mut self) -> Vec<&'static str> {
        self.core.take_findings().into_iter().map(|finding| finding.register).collect()
    }
}

const CONTROL: Endpoint =
    Endpoint { device: 0, number: 0, direction: Direction::Out, kind: Kind::Control, max_packet: 64 };
const BULK_IN: Endpoint = Endpoint { device: 0, number: 1, direction: Direction::In, kind: Kind::Bulk, max_packet: 64 };
const BULK_OUT: Endpoint = Endpoint { direction: Direction::Out, ..BULK_IN };

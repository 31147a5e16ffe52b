//! A USB device of register accesses alone, driven by interrupts, asleep in between: control requests of
//! every shape, and a bulk loop on endpoint 1. The program follows RM0399 section 60.15 step by step.
//!
//! | vendor request | what it does |
//! |---|---|
//! | 1, OUT | keeps up to 64 bytes |
//! | 2, IN | gives them back |
//! | 3, IN | counts: bus resets, suspends, wake-ups, frames |
//! | 4, OUT, no data | wakes the host 5 ms after the next suspend |
//! | 5, OUT, no data | enables the ULPI's clock for sleep |
//! | 6, OUT, no data | disconnects for 20 ms |
//! | 7, OUT, no data | ends the run |
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::asm::{delay, wfi};
use cortex_m_rt::entry;
use images::pac::interrupt;
use images::{pac, pass, start_clocks, wait_for};

const BASE: usize = 0x4008_0000;
const GOTGCTL: usize = 0x000;
const GAHBCFG: usize = 0x008;
const GUSBCFG: usize = 0x00C;
const GRSTCTL: usize = 0x010;
const GINTSTS: usize = 0x014;
const GINTMSK: usize = 0x018;
const GRXSTSP: usize = 0x020;
const GRXFSIZ: usize = 0x024;
const DIEPTXF0: usize = 0x028;
const GCCFG: usize = 0x038;
const DIEPTXF1: usize = 0x104;
const DCFG: usize = 0x800;
const DCTL: usize = 0x804;
const DIEPMSK: usize = 0x810;
const DOEPMSK: usize = 0x814;
const DAINT: usize = 0x818;
const DAINTMSK: usize = 0x81C;
const DIEPEMPMSK: usize = 0x834;
const IN: usize = 0x900;
const OUT: usize = 0xB00;
const STRIDE: usize = 0x20;
const INT: usize = 8;
const TSIZ: usize = 0x10;
const FIFO: usize = 0x1000;

const SOF: u32 = 1 << 3;
const RXFLVL: u32 = 1 << 4;
const USBSUSP: u32 = 1 << 11;
const USBRST: u32 = 1 << 12;
const ENUMDNE: u32 = 1 << 13;
const IEPINT: u32 = 1 << 18;
const OEPINT: u32 = 1 << 19;
const WKUPINT: u32 = 1 << 31;
const EPENA: u32 = 1 << 31;
const SNAK: u32 = 1 << 27;
const CNAK: u32 = 1 << 26;
const STALL: u32 = 1 << 21;
const USBAEP: u32 = 1 << 15;
const BULK: u32 = 2 << 18;
const SD0PID: u32 = 1 << 28;
const XFRC: u32 = 1;
const STUP: u32 = 1 << 3;
const TXFE: u32 = 1 << 7;

static DEVICE: [u8; 18] = [18, 1, 0, 2, 0xFF, 0, 0, 64, 0x09, 0x12, 1, 0, 0, 1, 0, 0, 0, 1];
static CONFIGURATION: [u8; 32] =
    [9, 2, 32, 0, 1, 1, 0, 0xE0, 50, 9, 4, 0, 0, 2, 0xFF, 0, 0, 0, 7, 5, 0x81, 2, 64, 0, 0, 7, 5, 0x01, 2, 64, 0, 0];
/// Next task of the thread, set by the handler.
static TASK: AtomicU32 = AtomicU32::new(0);

fn r(offset: usize) -> u32 {
    // SAFETY: a register of OTG2, whose clock is on.
    unsafe { ((BASE + offset) as *const u32).read_volatile() }
}

fn w(offset: usize, value: u32) {
    // SAFETY: the same.
    unsafe { ((BASE + offset) as *mut u32).write_volatile(value) }
}

fn set(offset: usize, bits: u32) {
    w(offset, r(offset) | bits);
}

/// State of endpoint 0: data left to send, packet by packet, and data received.
struct Control {
    setup: [u8; 8],
    answer: [u8; 64],
    left: usize,
    at: usize,
    kept: [u8; 64],
    length: usize,
    writes: bool,
    wakes: bool,
    counts: [u32; 4],
    bulk: [u8; 64],
    bulk_length: usize,
}

impl Control {
    const fn new() -> Self {
        Self {
            setup: [0; 8],
            answer: [0; 64],
            left: 0,
            at: 0,
            kept: [0; 64],
            length: 0,
            writes: false,
            wakes: false,
            counts: [0; 4],
            bulk: [0; 64],
            bulk_length: 0,
        }
    }

    /// Handles a reset of the bus: section 60.15, "Endpoint initialization on USB reset".
    fn reset(&mut self) {
        self.counts[0] += 1;
        set(OUT, SNAK);
        w(DAINTMSK, 0x0001_0001);
        w(DOEPMSK, STUP | XFRC);
        w(DIEPMSK, XFRC);
        w(GRXFSIZ, 128);
        w(DIEPTXF0, 16 << 16 | 128);
        w(DIEPTXF1, 32 << 16 | 144);
        w(GRSTCTL, 0x10 << 6 | 1 << 5);
        wait_for("the flush", || r(GRSTCTL) & 1 << 5 == 0);
        w(DIEPEMPMSK, 0);
        w(OUT + TSIZ, 3 << 29);
        w(DCFG, r(DCFG) & !(0x7F << 4));
    }

    /// Pops an entry of the receive FIFO, with its bytes.
    fn receive(&mut self) {
        let status = r(GRXSTSP);
        let (endpoint, count) = (status & 0xF, (status >> 4 & 0x7FF) as usize);
        let mut packet = [0; 64];
        for word in packet[..count.next_multiple_of(4)].chunks_mut(4) {
            word.copy_from_slice(&r(FIFO).to_le_bytes());
        }
        match (status >> 17 & 0xF, endpoint) {
            (0b0110, 0) => self.setup.copy_from_slice(&packet[..8]),
            (0b0010, 0) => {
                self.kept[..count].copy_from_slice(&packet[..count]);
                self.length = count;
            }
            (0b0010, 1) => {
                self.bulk[..count].copy_from_slice(&packet[..count]);
                self.bulk_length = count;
            }
            _ => {}
        }
    }

    /// Starts the control transfer, as the SETUP stage is over.
    fn begin(&mut self) {
        let [kind, request, v0, v1, .., l0, l1] = self.setup;
        let wanted = usize::from(u16::from_le_bytes([l0, l1]));
        self.writes = false;
        match (kind, request) {
            (0x80, 6) if v1 == 1 => self.send(&DEVICE, wanted),
            (0x80, 6) if v1 == 2 => self.send(&CONFIGURATION, wanted),
            (0, 5) => {
                w(DCFG, r(DCFG) & !(0x7F << 4) | u32::from(v0) << 4);
                self.send(&[], 0);
            }
            (0, 9) => {
                open_bulk();
                self.send(&[], 0);
            }
            (0x40, 1) if wanted <= 64 => {
                self.writes = true;
                w(OUT + TSIZ, 3 << 29 | 1 << 19 | 64);
                set(OUT, EPENA | CNAK);
            }
            (0xC0, 2) => {
                let kept = self.kept;
                let length = self.length;
                self.send(&kept[..length], wanted);
            }
            (0xC0, 3) => {
                let mut bytes = [0; 16];
                for (place, count) in bytes.chunks_mut(4).zip(self.counts) {
                    place.copy_from_slice(&count.to_le_bytes());
                }
                self.send(&bytes, wanted);
            }
            (0x40, 4) => {
                self.wakes = true;
                self.send(&[], 0);
            }
            (0x40, 5..=7) => {
                self.send(&[], 0);
                TASK.store(u32::from(request), Ordering::Relaxed);
            }
            _ => {
                set(IN, STALL);
                set(OUT, STALL);
                w(OUT + TSIZ, 3 << 29);
            }
        }
    }

    fn send(&mut self, data: &[u8], wanted: usize) {
        let count = data.len().min(wanted);
        self.answer[..count].copy_from_slice(&data[..count]);
        (self.at, self.left) = (0, count);
        // A full packet is followed by one without data where the host would otherwise wait for more.
        let packets = if count == 64 && wanted > 64 { 2 } else { 1 };
        w(IN + TSIZ, packets << 19 | count as u32);
        set(IN, EPENA | CNAK);
        if count > 0 {
            w(DIEPEMPMSK, 1);
            // The status stage comes after the data.
            w(OUT + TSIZ, 3 << 29 | 1 << 19);
            set(OUT, EPENA | CNAK);
        }
    }

    /// Fills the transmit FIFO of endpoint 0, which has room.
    fn fill(&mut self) {
        w(DIEPEMPMSK, 0);
        for word in self.answer[self.at..self.at + self.left].chunks(4) {
            let mut bytes = [0; 4];
            bytes[..word.len()].copy_from_slice(word);
            w(FIFO, u32::from_le_bytes(bytes));
        }
        self.left = 0;
    }

    fn out_ended(&mut self) {
        let outs = r(DAINT) >> 16;
        if outs & 1 != 0 {
            let causes = r(OUT + INT);
            w(OUT + INT, causes);
            if causes & XFRC != 0 && self.writes {
                self.writes = false;
                self.send(&[], 0);
            }
            if causes & STUP != 0 {
                self.begin();
            }
        }
        if outs & 2 != 0 {
            w(OUT + STRIDE + INT, r(OUT + STRIDE + INT));
            // The packet goes back, and the next may come when it is gone.
            w(IN + STRIDE + TSIZ, 1 << 19 | self.bulk_length as u32);
            set(IN + STRIDE, EPENA | CNAK);
            for word in self.bulk[..self.bulk_length].chunks(4) {
                let mut bytes = [0; 4];
                bytes[..word.len()].copy_from_slice(word);
                w(FIFO + 0x1000, u32::from_le_bytes(bytes));
            }
        }
    }

    fn in_ended(&mut self) {
        let ins = r(DAINT) & 0xFFFF;
        if ins & 1 != 0 {
            let causes = r(IN + INT);
            w(IN + INT, causes & XFRC);
            if causes & TXFE != 0 && self.left > 0 {
                self.fill();
            }
        }
        if ins & 2 != 0 {
            w(IN + STRIDE + INT, XFRC);
            arm_bulk();
        }
    }
}

fn open_bulk() {
    w(IN + STRIDE, USBAEP | BULK | 1 << 22 | SD0PID | 64);
    w(OUT + STRIDE, USBAEP | BULK | SD0PID | 64);
    w(DAINTMSK, 0x0003_0003);
    arm_bulk();
}

fn arm_bulk() {
    w(OUT + STRIDE + TSIZ, 1 << 19 | 64);
    set(OUT + STRIDE, EPENA | CNAK);
}

#[interrupt]
fn OTG_FS() {
    static mut CONTROL: Control = Control::new();
    let flags = r(GINTSTS) & r(GINTMSK);
    w(GINTSTS, flags);
    CONTROL.counts[3] += u32::from(flags & SOF != 0);
    CONTROL.counts[2] += u32::from(flags & WKUPINT != 0);
    if flags & USBSUSP != 0 {
        CONTROL.counts[1] += 1;
        if CONTROL.wakes {
            CONTROL.wakes = false;
            // The signal comes after 5 ms and lasts as long.
            delay(2_000_000);
            set(DCTL, 1);
            delay(2_000_000);
            w(DCTL, r(DCTL) & !1);
        }
    }
    if flags & USBRST != 0 {
        CONTROL.reset();
    }
    if flags & ENUMDNE != 0 {
        w(IN, 0);
        w(GUSBCFG, r(GUSBCFG) & !(0xF << 10) | 6 << 10);
    }
    while r(GINTSTS) & RXFLVL != 0 {
        CONTROL.receive();
    }
    if r(GINTSTS) & OEPINT != 0 {
        CONTROL.out_ended();
    }
    if r(GINTSTS) & IEPINT != 0 {
        CONTROL.in_ended();
    }
}

/// Starts 48 MHz from PLL3: 25 MHz / 25 * 336 / 7.
fn start_usb_clock(dp: &pac::Peripherals) {
    let rcc = &dp.RCC;
    // SAFETY: RM0399 section 9.7: DIVM3; PLL3 takes 1 to 2 MHz, medium VCO, output Q; N, P, Q, R minus one.
    unsafe {
        rcc.pllckselr.modify(|r, w| w.bits(r.bits() & !(0x3F << 20) | 25 << 20));
        rcc.pllcfgr.modify(|r, w| w.bits(r.bits() | 1 << 9 | 1 << 23));
        rcc.pll3divr.write(|w| w.bits(335 | 1 << 9 | 6 << 16 | 1 << 24));
    }
    rcc.cr.modify(|_, w| w.pll3on().set_bit());
    wait_for("PLL3RDY", || rcc.cr.read().pll3rdy().bit());
    rcc.d2ccip2r.modify(|_, w| w.usbsel().pll3_q());
}

/// Starts the core by section 60.15, "Core initialization" and "Device initialization".
fn start_usb(dp: &pac::Peripherals) {
    dp.PWR.cr3.modify(|_, w| w.usb33den().set_bit());
    wait_for("USB33RDY", || dp.PWR.cr3.read().usb33rdy().bit());
    dp.RCC.ahb4enr.modify(|_, w| w.gpioaen().set_bit());
    // SAFETY: alternate function 10 for PA11 and PA12.
    dp.GPIOA.afrh.modify(|r, w| unsafe { w.bits(r.bits() & !0xF_F000 | 0xA_A000) });
    dp.GPIOA.moder.modify(|_, w| w.moder11().alternate().moder12().alternate());
    dp.RCC.ahb1enr.modify(|_, w| w.usb2otgen().set_bit());
    // SAFETY: USB2OTGHSULPILPEN cleared: there is no external transceiver.
    dp.RCC.ahb1lpenr.modify(|r, w| unsafe { w.bits(r.bits() & !(1 << 28)) });
    w(GUSBCFG, r(GUSBCFG) | 1 << 6);
    wait_for("AHBIDL", || r(GRSTCTL) >> 31 == 1);
    w(GRSTCTL, 1);
    wait_for("CSRST", || r(GRSTCTL) & 1 == 0);
    w(GCCFG, 1 << 16);
    w(GOTGCTL, r(GOTGCTL) | 0b11 << 6);
    w(DCFG, r(DCFG) | 3);
    w(GINTSTS, !0);
    w(GINTMSK, USBRST | ENUMDNE | USBSUSP | WKUPINT | SOF | RXFLVL | IEPINT | OEPINT);
    w(GAHBCFG, 1 | 1 << 7);
    w(DCTL, r(DCTL) & !2);
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    start_usb_clock(&dp);
    start_usb(&dp);
    // SAFETY: what the handler uses is its own.
    unsafe { pac::NVIC::unmask(pac::Interrupt::OTG_FS) };
    loop {
        wfi();
        match TASK.swap(0, Ordering::Relaxed) {
            // SAFETY: USB2OTGHSULPILPEN.
            5 => dp.RCC.ahb1lpenr.modify(|r, w| unsafe { w.bits(r.bits() | 1 << 28) }),
            6 => {
                // The disconnection comes after the status stage.
                delay(400_000);
                set(DCTL, 2);
                delay(8_000_000);
                w(DCTL, r(DCTL) & !2);
            }
            7 => {
                delay(400_000);
                pass();
            }
            _ => {}
        }
    }
}

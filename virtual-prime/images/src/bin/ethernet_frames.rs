//! Moves frames through the Ethernet controller, polled: rings of other lengths than a driver has, small
//! buffers in the AXI SRAM, words between the descriptors, no interrupt. Frames of type 88B5 are commands:
//! `E` is sent back, `W` has the image look away for 20 ms, `Q` ends the run.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{Ordering, fence};

use cortex_m::asm::{delay, dsb};
use cortex_m_rt::entry;
use images::{Console, pac, pass, start_clocks, wait_for};

/// Descriptors of the rings, words of each with those between two, bytes of a receive buffer.
const SENDING: usize = 3;
const RECEIVING: usize = 5;
const WORDS: usize = 6;
const BUFFER: usize = 512;
const LONGEST: usize = 1_600;
const OWN: u32 = 1 << 31;
const FIRST: u32 = 1 << 29;
const LAST: u32 = 1 << 28;
const IOC: u32 = 1 << 30;
const BUF1V: u32 = 1 << 24;
const RBU: u32 = 1 << 7;
const ADDRESS: [u8; 6] = [0x02, 0x11, 0x22, 0x33, 0x44, 0x55];
/// A group that the hash table lets through: 01:00:5E:00:00:FB is number 48 of 64.
const GROUP_NUMBER: u32 = 48;

#[repr(C, align(32))]
struct Memory {
    sending: [[u32; WORDS]; SENDING],
    receiving: [[u32; WORDS]; RECEIVING],
    sent: [[u8; LONGEST]; SENDING],
    received: [[u8; BUFFER]; RECEIVING],
}

static mut MEMORY: Memory = Memory {
    sending: [[0; WORDS]; SENDING],
    receiving: [[0; WORDS]; RECEIVING],
    sent: [[0; LONGEST]; SENDING],
    received: [[0; BUFFER]; RECEIVING],
};

struct Frames<'a> {
    dp: &'a pac::Peripherals,
    memory: *mut Memory,
    next_sent: usize,
    next_received: usize,
}

impl Frames<'_> {
    fn word(&self, receives: bool, place: usize, word: usize) -> *mut u32 {
        // SAFETY: places and words are within the rings of the one static memory.
        unsafe {
            if receives {
                &raw mut (*self.memory).receiving[place][word]
            } else {
                &raw mut (*self.memory).sending[place][word]
            }
        }
    }

    fn read(&self, receives: bool, place: usize, word: usize) -> u32 {
        // SAFETY: a word of a ring; the DMA writes it as well.
        let value = unsafe { read_volatile(self.word(receives, place, word)) };
        fence(Ordering::SeqCst);
        value
    }

    fn write(&self, receives: bool, place: usize, word: usize, value: u32) {
        fence(Ordering::SeqCst);
        // SAFETY: a word of a ring, whose descriptor is ours.
        unsafe { write_volatile(self.word(receives, place, word), value) };
    }

    /// Gives a receive descriptor to the DMA, with the address that the write-back has destroyed.
    fn release(&self, place: usize) {
        // SAFETY: the address of a static buffer.
        let buffer = unsafe { &raw const (*self.memory).received[place] } as u32;
        self.write(true, place, 0, buffer);
        self.write(true, place, 1, 0);
        self.write(true, place, 2, 0);
        self.write(true, place, 3, OWN | IOC | BUF1V);
    }

    fn write_tails(&self) {
        dsb();
        let dma = &self.dp.ETHERNET_DMA;
        // SAFETY: addresses of the rings; any write is a poll demand.
        dma.dmacrx_dtpr.write(|w| unsafe { w.bits(self.word(true, 0, 0) as u32) });
        dma.dmactx_dtpr.write(|w| unsafe { w.bits(self.word(false, 0, 0) as u32) });
    }

    /// Takes a frame that is whole. Returns its length.
    fn take(&mut self, frame: &mut [u8; LONGEST]) -> Option<usize> {
        let mut place = self.next_received;
        let mut taken = 0;
        loop {
            let des3 = self.read(true, place, 3);
            if des3 & OWN != 0 {
                return None;
            }
            let upto = if des3 & LAST != 0 { (des3 & 0x7FFF) as usize } else { taken + BUFFER };
            // SAFETY: a buffer whose descriptor is ours.
            let buffer = unsafe { &(*self.memory).received[place] };
            frame[taken..upto].copy_from_slice(&buffer[..upto - taken]);
            taken = upto;
            place = (place + 1) % RECEIVING;
            if des3 & LAST != 0 {
                break;
            }
        }
        while self.next_received != place {
            self.release(self.next_received);
            self.next_received = (self.next_received + 1) % RECEIVING;
        }
        self.write_tails();
        Some(taken)
    }

    /// Sends a frame out of two buffers.
    fn send(&mut self, frame: &[u8]) {
        let place = self.next_sent;
        self.next_sent = (place + 1) % SENDING;
        wait_for("a transmit descriptor", || self.read(false, place, 3) & OWN == 0);
        // SAFETY: a buffer whose descriptor is ours.
        let buffer = unsafe { &mut (*self.memory).sent[place] };
        buffer[..frame.len()].copy_from_slice(frame);
        let start = buffer.as_ptr() as u32;
        let second = frame.len() as u32 - 33;
        self.write(false, place, 0, start);
        self.write(false, place, 1, start + 33);
        self.write(false, place, 2, second << 16 | 33);
        self.write(false, place, 3, OWN | FIRST | LAST | frame.len() as u32);
        self.write_tails();
    }

    fn phy(&self, register: u32) -> u32 {
        let mac = &self.dp.ETHERNET_MAC;
        // SAFETY: RM0399 ETH_MACMDIOAR: RDA, CR = 4, GOC = 3, MB.
        mac.macmdioar.write(|w| unsafe { w.bits(register << 16 | 4 << 8 | 3 << 2 | 1) });
        wait_for("the management frame", || mac.macmdioar.read().bits() & 1 == 0);
        mac.macmdiodr.read().bits() & 0xFFFF
    }

    /// Sets up queues, filter and rings, and starts everything for 100 Mbit/s and full duplex.
    fn start(&self) {
        let (mac, mtl, dma) = (&self.dp.ETHERNET_MAC, &self.dp.ETHERNET_MTL, &self.dp.ETHERNET_DMA);
        let [a, b, c, d, e, f] = ADDRESS.map(u32::from);
        (0..RECEIVING).for_each(|place| self.release(place));
        // SAFETY: RM0399 section 61.11: the address, hash of multicasts; store and forward both ways; rings,
        // two words between descriptors, buffers of 512 bytes; at last ST, SR, TE, RE, FES, DM, CST, ACS.
        unsafe {
            mac.maca0hr.write(|w| w.bits(f << 8 | e));
            mac.maca0lr.write(|w| w.bits(d << 24 | c << 16 | b << 8 | a));
            mac.macpfr.write(|w| w.bits(1 << 2));
            mac.macht1r.write(|w| w.bits(1 << (GROUP_NUMBER - 32)));
            mtl.mtltx_qomr.modify(|r, w| w.bits(r.bits() | 1 << 1));
            mtl.mtlrx_qomr.modify(|r, w| w.bits(r.bits() | 1 << 5));
            dma.dmaccr.write(|w| w.bits((WORDS as u32 - 4) << 18));
            dma.dmactx_dlar.write(|w| w.bits(self.word(false, 0, 0) as u32));
            dma.dmactx_rlr.write(|w| w.bits(SENDING as u32 - 1));
            dma.dmacrx_dlar.write(|w| w.bits(self.word(true, 0, 0) as u32));
            dma.dmacrx_rlr.write(|w| w.bits(RECEIVING as u32 - 1));
            dma.dmactx_cr.write(|w| w.bits(1));
            dma.dmacrx_cr.write(|w| w.bits((BUFFER as u32) << 1 | 1));
            mac.maccr.write(|w| w.bits(1 | 1 << 1 | 1 << 13 | 1 << 14 | 1 << 20 | 1 << 21));
        }
        self.write_tails();
    }
}

/// Connects RMII and management to the MAC, alternate function 11: PA1, PA2, PA7, PC1, PC4, PC5, PG11 to
/// PG13.
fn connect(dp: &pac::Peripherals) {
    dp.RCC.ahb4enr.modify(|_, w| w.gpioaen().set_bit().gpiocen().set_bit().gpiogen().set_bit());
    // SAFETY: AF11 and mode 2 of these pins, and the highest speed of the outputs.
    unsafe {
        dp.GPIOA.afrl.modify(|r, w| w.bits(r.bits() & !0xF000_0FF0 | 0xB000_0BB0));
        dp.GPIOC.afrl.modify(|r, w| w.bits(r.bits() & !0x00FF_00F0 | 0x00BB_00B0));
        dp.GPIOG.afrh.modify(|r, w| w.bits(r.bits() & !0x00FF_F000 | 0x00BB_B000));
        dp.GPIOA.moder.modify(|r, w| w.bits(r.bits() & !0x0000_C03C | 0x0000_8028));
        dp.GPIOC.moder.modify(|r, w| w.bits(r.bits() & !0x0000_0F0C | 0x0000_0A08));
        dp.GPIOG.ospeedr.modify(|r, w| w.bits(r.bits() | 0x0FC0_0000));
        dp.GPIOG.moder.modify(|r, w| w.bits(r.bits() & !0x0FC0_0000 | 0x0A80_0000));
    }
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    let mut console = Console::new(&dp);
    dp.RCC.apb4enr.modify(|_, w| w.syscfgen().set_bit());
    // SAFETY: EPIS = 100, RMII.
    dp.SYSCFG.pmcr.modify(|r, w| unsafe { w.bits(r.bits() & !(7 << 21) | 4 << 21) });
    dp.RCC.ahb1enr.modify(|_, w| w.eth1macen().set_bit().eth1txen().set_bit().eth1rxen().set_bit());
    connect(&dp);
    let dma = &dp.ETHERNET_DMA;
    // SAFETY: SWR.
    dma.dmamr.write(|w| unsafe { w.bits(1) });
    wait_for("the software reset", || dma.dmamr.read().bits() & 1 == 0);

    let mut frames = Frames { dp: &dp, memory: &raw mut MEMORY, next_sent: 0, next_received: 0 };
    while frames.phy(1) & 1 << 2 == 0 {
        delay(10_000_000);
    }
    frames.start();
    let _ = writeln!(console, "link {:04x}", frames.phy(31));
    let mut frame = [0; LONGEST];
    let mut looked_away = 0;
    loop {
        let state = dma.dmacsr.read().bits();
        if state & RBU != 0 {
            looked_away += 1;
            // SAFETY: the flag is cleared by a one.
            dma.dmacsr.write(|w| unsafe { w.bits(RBU) });
            frames.write_tails();
        }
        let Some(length) = frames.take(&mut frame) else { continue };
        assert_eq!(frame[12..14], [0x88, 0xB5]);
        match frame[14] {
            b'E' => {
                let from: [u8; 6] = frame[6..12].try_into().unwrap();
                frame[..6].copy_from_slice(&from);
                frame[6..12].copy_from_slice(&ADDRESS);
                frames.send(&frame[..length]);
            }
            b'W' => delay(8_000_000),
            b'Q' => break,
            other => panic!("command {other}"),
        }
    }
    assert!(looked_away > 0, "no RBU");
    let _ = writeln!(console, "done");
    console.drain();
    pass()
}

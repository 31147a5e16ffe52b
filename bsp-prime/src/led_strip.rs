//! Strips of lights with a chip each (WS2812, SK6812 and their kin) on the pins of a PWM timer.
//!
//! A bit is a pulse, long for 1 and short for 0. The timer makes the pulses; with each of its periods a DMA
//! brings the compare value of the next one, so each edge is exact whatever the processor does, and nothing
//! waits. The last two values are 0: the line stays low, and after [`LATCH_US`] the chips show the colours
//! sent. The interrupt at the end of the transfer stops the timer; it is the only one.
//!
//! The pulses suit all of these chips. Data sheets, high and low times of 0 and of 1 in ns, and the pause:
//!
//! | chip | 0 high | 0 low | 1 high | 1 low | pause |
//! |---|---|---|---|---|---|
//! | WS2812B (Worldsemi, V1) | 250 to 550 | 700 to 1000 | 650 to 950 | 300 to 600 | 50 us |
//! | WS2812B-V5 (Worldsemi) | 220 to 380 | 580 to 1000 | 580 to 1000 | 580 to 1000 | 280 us |
//! | SK6812, SK6812RGBW (Normand, Opsco) | 150 to 450 | 750 to 1050 | 450 to 750 | 450 to 750 | 80 us |
//! | here | 320 | 970 | 700 | 590 | 300 us |

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use stm32h7xx_hal::pac;

use crate::clocks::TIMER_HZ;
use crate::dma_buffer;
use crate::time;

/// Converts a time to periods of the timers' clock.
const fn counts(nanoseconds: u32) -> u16 {
    (nanoseconds * (TIMER_HZ / 1_000_000) / 1_000) as u16
}

/// Length of a bit, in timer counts.
const BIT: u16 = counts(1_290);
/// Length of the pulse of a 0 and of a 1, in timer counts.
const ZERO: u16 = counts(320);
const ONE: u16 = counts(700);
const _: () = assert!(BIT == 258 && ZERO == 64 && ONE == 140, "these times are whole counts of 5 ns");
/// Least time between two transmissions, in which the line is low, us.
const LATCH_US: u32 = 300;
/// Most bytes of a transmission: 256 lights of 4 bytes.
const MOST_BYTES: usize = 256 * 4;
/// Number of values behind the last bit: the first is loaded when its pulse has ended, the second never.
const TAIL: usize = 2;
/// Limit of a transmission, longer than any takes (10.6 ms): after it, a transmission never ends.
const LIMIT_US: u32 = 50_000;

dma_buffer! { in D2,
    /// Compare values, in the order in which they are due.
    static VALUES: [u16; MOST_BYTES * 8 + TAIL]
}

/// The timer that sends, from 1; 0: none.
static SENDING: AtomicU8 = AtomicU8::new(0);
/// Begin or end of the last transmission, microseconds.
static SINCE_US: AtomicU32 = AtomicU32::new(0);

/// DMA2's stream; its channel of the request multiplexer is 8 further on (RM0399 section 18.3.2).
const STREAM: usize = 0;
const CHANNEL: usize = 8 + STREAM;
/// Requests of the timers' updates (RM0399 section 18.3.2, table of DMAMUX1 inputs: TIM1_UP, TIM8_UP).
const UPDATE_REQUESTS: [u8; 2] = [15, 51];
/// Flags of stream 0 in DMA_LIFCR: FIFO, direct mode, transfer errors, half and whole (RM0399 section
/// 16.5.3).
const STREAM_FLAGS: u32 = 0b11_1101;

fn now_us() -> u32 {
    time::now().0 as u32
}

fn registers(timer: usize) -> &'static pac::tim1::RegisterBlock {
    // SAFETY: TIM1 and TIM8 have the same registers (RM0399 section 42.4); one that is used here was given
    // away by `Pwm`, so this module is its only user.
    unsafe { &*(if timer == 0 { pac::TIM1::ptr() } else { pac::TIM8::ptr() }) }
}

fn dma() -> &'static pac::dma2::RegisterBlock {
    // SAFETY: `LedSender` has the token of DMA2, whose first stream alone is used, here.
    unsafe { &*pac::DMA2::ptr() }
}

/// Timer reserved for strips of lights. Made by [`crate::pwm::Pwm::give_away`].
#[derive(Debug)]
pub struct LedTimer(pub(crate) usize);

/// Sender to strips of lights, one after the other.
pub struct LedSender {
    _dma: pac::DMA2,
    /// Timers that may be used, TIM1 and TIM8.
    timers: [bool; 2],
}

impl LedSender {
    pub(crate) const fn new(dma: pac::DMA2) -> Self {
        Self { _dma: dma, timers: [false; 2] }
    }

    /// Sets up a timer, all of whose lines are low from then on.
    pub fn add(&mut self, LedTimer(timer): LedTimer) {
        // SAFETY: this register's other bits stay as they are, and it runs once or twice, from the executor
        // alone, which is also the only one to change it after start.
        unsafe { (*pac::RCC::ptr()).ahb1enr.modify(|_, w| w.dma2en().enabled()) };
        if let Some(mine) = self.timers.get_mut(timer) {
            *mine = true;
        }
        let timer = registers(timer);
        timer.psc.reset();
        timer.arr.write(|w| w.arr().bits(BIT - 1));
        // RM0399 section 42.4.7: OCxM = 110 (PWM mode 1), buffered compare values, in both channels of both
        // registers.
        const BOTH_CHANNELS: u32 = 0x6868;
        // SAFETY: that is a valid pattern of the two mode registers; four channels enabled, active high.
        unsafe {
            timer.ccmr1_output().write(|w| w.bits(BOTH_CHANNELS));
            timer.ccmr2_output().write(|w| w.bits(BOTH_CHANNELS));
            timer.ccer.write(|w| w.bits(0x1111));
        }
        // RM0399 section 42.4.1, URS: only overflows ask the DMA, and not the update below.
        timer.cr1.write(|w| w.arpe().set_bit().urs().set_bit());
        timer.egr.write(|w| w.ug().set_bit());
        timer.bdtr.write(|w| w.moe().set_bit());
    }

    /// Sends bytes to the strip on a timer (0, 1) and channel (0 to 3), first bits first. False, and nothing
    /// happens, while another transmission is on its way or the line has not been low for long enough.
    pub fn send(&mut self, timer: usize, channel: usize, bytes: &[u8]) -> bool {
        if self.timers.get(timer) != Some(&true) || bytes.len() > MOST_BYTES {
            // A transmission that can never be sent counts as done, so that nobody asks again.
            return true;
        }
        let since_us = now_us().wrapping_sub(SINCE_US.load(Ordering::Relaxed));
        if SENDING.load(Ordering::Acquire) != 0 {
            if since_us < LIMIT_US {
                return false;
            }
            stop();
        } else if since_us < LATCH_US {
            return false;
        }
        let Some(values) = VALUES.address() else { return true };
        let bits = bytes.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1 != 0));
        let count = bytes.len() * 8 + TAIL;
        let pulses = bits.map(|one| if one { ONE } else { ZERO }).chain([0; TAIL]);
        for (place, value) in pulses.enumerate() {
            // All values fit into the buffer.
            let _fits = VALUES.write(place, value);
        }
        let compare = compare_address(registers(timer), channel);
        start(timer, compare, values, count);
        true
    }
}

/// The address of a channel's compare value.
fn compare_address(timer: &pac::tim1::RegisterBlock, channel: usize) -> u32 {
    let compare = match channel {
        0 => timer.ccr1().as_ptr(),
        1 => timer.ccr2().as_ptr(),
        2 => timer.ccr3().as_ptr(),
        _ => timer.ccr4().as_ptr(),
    };
    compare as u32
}

fn start(timer: usize, compare: u32, values: u32, count: usize) {
    let (dma, registers) = (dma(), registers(timer));
    let stream = &dma.st[STREAM];
    let request = UPDATE_REQUESTS.get(timer).copied().unwrap_or_default();
    SINCE_US.store(now_us(), Ordering::Relaxed);
    SENDING.store(timer as u8 + 1, Ordering::Release);
    // SAFETY: the multiplexer's channel of this stream is used here alone; the request is from its table. The
    // addresses are those of a compare register and of a buffer that lives for ever and has as many values.
    unsafe {
        (*pac::DMAMUX1::ptr()).ccr[CHANNEL].write(|w| w.dmareq_id().bits(request));
        dma.lifcr.write(|w| w.bits(STREAM_FLAGS));
        stream.par.write(|w| w.bits(compare));
        stream.m0ar.write(|w| w.bits(values));
        stream.ndtr.write(|w| w.bits(count as u32));
    }
    // RM0399 section 16.5.5: memory to peripheral, 16 bits, interrupt at the end and on an error. Urgent: it
    // has a period's time for each value.
    stream.cr.write(|w| {
        w.dir().memory_to_peripheral().msize().bits16().psize().bits16().minc().set_bit();
        w.pl().very_high().tcie().set_bit().teie().set_bit()
    });
    stream.cr.modify(|_, w| w.en().set_bit());
    registers.cnt.reset();
    registers.dier.write(|w| w.ude().set_bit());
    registers.cr1.modify(|_, w| w.cen().set_bit());
}

/// Ends a transmission. The line is low and stays so: the timer stands within a period that has no pulse, or
/// is made to.
fn stop() {
    let timer = SENDING.load(Ordering::Relaxed);
    let Some(timer) = usize::from(timer).checked_sub(1) else { return };
    let registers = registers(timer);
    registers.cr1.modify(|_, w| w.cen().clear_bit());
    registers.dier.reset();
    for channel in 0..4 {
        // SAFETY: a half-word store to a compare register of a timer that is this module's alone.
        unsafe { (compare_address(registers, channel) as *mut u16).write_volatile(0) };
    }
    // UG loads the registers.
    registers.egr.write(|w| w.ug().set_bit());
    dma().st[STREAM].cr.modify(|_, w| w.en().clear_bit());
    // SAFETY: these are flags of this stream alone, cleared by a 1.
    dma().lifcr.write(|w| unsafe { w.bits(STREAM_FLAGS) });
    SINCE_US.store(now_us(), Ordering::Relaxed);
    SENDING.store(0, Ordering::Release);
}

/// The body of the interrupt of DMA2's first stream.
pub fn on_interrupt() {
    stop();
}

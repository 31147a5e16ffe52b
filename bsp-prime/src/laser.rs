//! The laser: one channel of a PWM timer of its own, and an output that is on while the laser has power.
//!
//! A change of power acts at once, in the middle of a period: the compare value has no buffer, and after it
//! is written the period begins anew. So both edges are as exact as the step interrupt is, whatever the
//! frequency. The step interrupt plays the power of moves ([`play`]); the executor locks the laser, and gives
//! it power at rest. Locked, the timer forces its output inactive, so that no compare value counts.
//!
//! Power that is not renewed goes off: [`renew`] by the step feed, and for power at rest [`Laser::look`] by
//! the executor, put off an interrupt that ends it.

use core::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32, Ordering};

use motion::queue::StepEvent;
use stm32h7xx_hal::pac;
use units::{STEP_CLOCK_HZ, Ticks};

use crate::clocks::TIMER_HZ;
use crate::pins::{FastPin, PinError, PinSpec, Pins, Pull, table};
use crate::time::{self, alarm};

/// Most counts of a period: one less than a compare value of 16 bits can be, so that full power is above all.
const MOST_PERIOD: u32 = 65_535;

/// Output compare modes of a channel (RM0399 section 42.4.8, OCxM): 100, forced inactive, and 110, PWM mode
/// 1. OCxPE = 0 in both: a compare value acts when it is written.
const FORCED_INACTIVE: u32 = 0x40;
const PWM_MODE_1: u32 = 0x60;

/// Time by which a run of the step feed may be late before the power goes off.
const LATE_US: u32 = 250;
/// Time within which the executor has to look at its power at rest.
const LOOKS_WITHIN_US: u32 = 100_000;

/// What the step interrupt knows of the laser. Seldom looked at, so not in the fastest memory.
struct Shared {
    /// 0 while the laser is locked.
    is_open: AtomicU32,
    compare: AtomicPtr<u32>,
    generate: AtomicPtr<u32>,
    /// Counts of the period.
    counts: AtomicU32,
    gate: AtomicPtr<u32>,
    /// BSRR word that switches the gate on; 0, which does nothing, without one, and while the output is dark.
    gate_on: AtomicU32,
    /// BSRR word that switches the gate off; 0 without one.
    gate_off: AtomicU32,
    /// Duty that the executor has given, until something moves.
    at_rest: AtomicU32,
    /// Time of the executor's last look, low half of the microseconds.
    looked: AtomicU32,
    /// Whether power was not renewed in time, since the executor last looked.
    lapsed: AtomicBool,
}

/// All zero, as the section is.
#[unsafe(link_section = ".axizero")]
static SHARED: Shared = Shared {
    is_open: AtomicU32::new(0),
    compare: AtomicPtr::new(core::ptr::null_mut()),
    generate: AtomicPtr::new(core::ptr::null_mut()),
    counts: AtomicU32::new(0),
    gate: AtomicPtr::new(core::ptr::null_mut()),
    gate_on: AtomicU32::new(0),
    gate_off: AtomicU32::new(0),
    at_rest: AtomicU32::new(0),
    looked: AtomicU32::new(0),
    lapsed: AtomicBool::new(false),
};

/// Whether there is a laser, so that the above is to be looked at at all: the memory of that is cleared later
/// than the first fault may come.
static IS_SET_UP: AtomicBool = AtomicBool::new(false);

/// Timer reserved for the laser. Made by [`crate::pwm::Pwm::give_to_laser`].
#[derive(Debug)]
pub struct LaserTimer(pub(crate) usize);

/// How the output is driven.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Frequency of the duty, 4 Hz to 50 kHz.
    pub frequency_hz: u32,
    /// The pin is low while the laser is on, and high while it is off.
    pub is_inverted: bool,
    /// The output only pulls low.
    pub is_open_drain: bool,
    /// The chip's resistor pulls it up.
    pub is_pulled_up: bool,
}

/// The laser's timer and channel, in the hands of the executor. Exists once.
#[derive(Debug)]
pub struct Laser {
    timer: usize,
    channel: usize,
    /// BSRR word that switches the gate on; 0 without one.
    gate_on: u32,
    /// Whether the output is kept off, whatever the duty is.
    is_dark: bool,
}

fn registers(timer: usize) -> &'static pac::tim1::RegisterBlock {
    // SAFETY: TIM1 and TIM8 have the same registers (RM0399 section 42.4); the one that is used here was
    // given away by `Pwm`, so this module is its only user.
    unsafe { &*(if timer == 0 { pac::TIM1::ptr() } else { pac::TIM8::ptr() }) }
}

/// Returns the divider of the timer's clock, and the counts of a period at this rate: as many as can be.
const fn divided(rate_hz: u32) -> (u32, u32) {
    let counts = TIMER_HZ / if rate_hz == 0 { 1 } else { rate_hz };
    let divider = counts.div_ceil(MOST_PERIOD);
    (divider, counts / divider)
}

const _: () = {
    let ((fast, fast_counts), (usual, usual_counts), (slow, slow_counts)) =
        (divided(50_000), divided(20_000), divided(1_000));
    assert!(fast == 1 && fast_counts == 4_000 && usual == 1 && usual_counts == 10_000);
    assert!(slow == 4 && slow_counts == 50_000);
    let (slowest, counts) = divided(4);
    assert!(slowest <= 65_536 && counts <= MOST_PERIOD);
};

impl Laser {
    /// Sets up the laser, off and locked, and gives it its pins.
    ///
    /// # Errors
    /// [`PinError`] when a pin is taken; there is no laser then.
    #[inline(never)]
    pub fn set_up(
        LaserTimer(timer): LaserTimer,
        channel: usize,
        drive: Drive,
        gate: Option<FastPin>,
        pins: &mut Pins,
        owner: &str,
    ) -> Result<Self, PinError> {
        let gate = gate.unwrap_or(FastPin::NONE);
        let mut laser = Self { timer, channel: channel & 3, gate_on: gate.on_word(), is_dark: false };
        let channel = laser.channel;
        let registers = registers(timer);
        laser.set_mode(FORCED_INACTIVE);
        // RM0399 section 42.4.11: CCxE and CCxP of the channel, four bits each; the polarity also decides
        // which level inactive is.
        let enable = (1 | u32::from(drive.is_inverted) << 1) << (4 * channel);
        // SAFETY: a valid pattern; the other channels stay disabled.
        registers.ccer.write(|w| unsafe { w.bits(enable) });
        SHARED.compare.store(compare_register(registers, channel), Ordering::Relaxed);
        SHARED.generate.store(registers.egr.as_ptr(), Ordering::Relaxed);
        SHARED.gate.store(gate.register(), Ordering::Relaxed);
        SHARED.gate_on.store(laser.gate_on, Ordering::Relaxed);
        SHARED.gate_off.store(gate.off_word(), Ordering::Relaxed);
        laser.set_frequency(drive.frequency_hz);
        // RM0399 section 42.4.20, MOE: outputs follow their channels.
        registers.bdtr.write(|w| w.moe().set_bit());
        registers.cr1.write(|w| w.cen().set_bit());
        IS_SET_UP.store(true, Ordering::Release);
        // The pin follows the timer last, when its level is that of off.
        let (_, pin) = table::PWM[(timer * 4 + channel) & 7];
        let pull = if drive.is_pulled_up && drive.is_open_drain { Pull::Up } else { Pull::Floating };
        let spec = PinSpec { pull, open_drain: drive.is_open_drain, ..PinSpec::plain(pin) };
        pins.alternate(spec, if timer == 0 { 1 } else { 3 }, owner)?;
        Ok(laser)
    }

    /// Sets the frequency of the duty, hertz; the duty becomes 0. Only while nothing moves.
    #[inline(never)]
    pub fn set_frequency(&mut self, hertz: u32) {
        let (divider, counts) = divided(hertz);
        let registers = registers(self.timer);
        SHARED.counts.store(counts, Ordering::Relaxed);
        play(0);
        registers.psc.write(|w| w.psc().bits((divider - 1) as u16));
        registers.arr.write(|w| w.arr().bits((counts - 1) as u16));
        write(&SHARED.compare, 0);
        write(&SHARED.generate, UPDATE);
    }

    /// Locks the laser off, or lets what comes from now on through to it.
    #[inline(never)]
    pub fn lock(&mut self, is_locked: bool) {
        // The interrupt switches nothing on from here on, whenever it comes.
        SHARED.is_open.store(0, Ordering::Release);
        self.set_mode(FORCED_INACTIVE);
        close_gate();
        write(&SHARED.compare, 0);
        SHARED.at_rest.store(0, Ordering::Relaxed);
        alarm::enable(false);
        if !is_locked {
            if !self.is_dark {
                self.set_mode(PWM_MODE_1);
            }
            alarm::put_off(LOOKS_WITHIN_US);
            alarm::enable(true);
            SHARED.is_open.store(1, Ordering::Release);
        }
    }

    /// Keeps the output off while the duty follows the path, or lets the duty that is by now come out, unless
    /// the laser is locked.
    #[inline(never)]
    pub fn darken(&mut self, is_dark: bool) {
        self.is_dark = is_dark;
        if is_dark {
            // The interrupt leaves the gate off from here on, whenever it comes.
            SHARED.gate_on.store(0, Ordering::Release);
            self.set_mode(FORCED_INACTIVE);
            close_gate();
            return;
        }
        SHARED.gate_on.store(self.gate_on, Ordering::Release);
        if SHARED.is_open.load(Ordering::Relaxed) != 0 {
            self.set_mode(PWM_MODE_1);
        }
        // Locked, the duty is 0. The interrupt may change it meanwhile, but not that often.
        for _ in 0..4 {
            if brings_gate_after() {
                break;
            }
        }
    }

    /// Gives the laser a duty, 1/65535, for as long as [`Self::look`] follows [`Self::look`]. Only while
    /// nothing moves: the path's next power replaces it.
    pub fn set(&mut self, duty: u16) {
        SHARED.looked.store(time::now().0 as u32, Ordering::Relaxed);
        SHARED.at_rest.store(u32::from(duty), Ordering::Relaxed);
        play(duty);
    }

    /// Keeps the power at rest up. Returns whether power was not renewed in time, at rest or not, so that no
    /// power has come through since: true once, and the laser stays locked.
    pub fn look(&mut self) -> bool {
        SHARED.looked.store(time::now().0 as u32, Ordering::Relaxed);
        SHARED.lapsed.swap(false, Ordering::Relaxed)
    }

    #[inline(never)]
    fn set_mode(&self, mode: u32) {
        let (registers, bits) = (registers(self.timer), mode << (8 * (self.channel as u32 & 1)));
        // SAFETY: a valid pattern of the mode register (RM0399 sections 42.4.8 and 42.4.10), whose other
        // channel is not enabled.
        unsafe {
            match self.channel {
                0 | 1 => registers.ccmr1_output().write(|w| w.bits(bits)),
                _ => registers.ccmr2_output().write(|w| w.bits(bits)),
            }
        }
    }
}

/// Whether the laser may burn: the executor keeps it on at rest, or something moves while it is not locked.
#[inline]
#[must_use]
pub fn may_burn(is_moving: bool) -> bool {
    if !IS_SET_UP.load(Ordering::Acquire) || SHARED.is_open.load(Ordering::Relaxed) == 0 {
        return false;
    }
    is_moving || SHARED.at_rest.load(Ordering::Relaxed) != 0
}

/// Lets the laser burn until the step feed's next run, which comes in so many ticks, and 250 us longer.
/// Called at the end of each run, by the feed alone.
#[inline]
pub fn renew(next_run: Ticks) {
    if !IS_SET_UP.load(Ordering::Acquire) || SHARED.is_open.load(Ordering::Relaxed) == 0 {
        return;
    }
    let looked = SHARED.looked.load(Ordering::Relaxed);
    let is_looked_at = (time::now().0 as u32).wrapping_sub(looked) < LOOKS_WITHIN_US;
    if is_looked_at || SHARED.at_rest.load(Ordering::Relaxed) == 0 {
        alarm::put_off(next_run.0 as u32 / (STEP_CLOCK_HZ / 1_000_000) + LATE_US);
    }
}

/// Interrupt of the watch: ends power that was not renewed. It stays off until the executor has unlocked the
/// laser anew.
pub fn on_alarm() {
    if alarm::acknowledge() && SHARED.is_open.swap(0, Ordering::Relaxed) != 0 {
        write(&SHARED.compare, 0);
        write(&SHARED.generate, UPDATE);
        close_gate();
        SHARED.lapsed.store(true, Ordering::Relaxed);
    }
}

fn compare_register(registers: &pac::tim1::RegisterBlock, channel: usize) -> *mut u32 {
    match channel {
        0 => registers.ccr1().as_ptr(),
        1 => registers.ccr2().as_ptr(),
        2 => registers.ccr3().as_ptr(),
        _ => registers.ccr4().as_ptr(),
    }
}

/// RM0399 section 42.4.6, UG: the counter begins anew.
const UPDATE: u32 = 1;

#[inline(always)]
fn write(register: &AtomicPtr<u32>, word: u32) {
    let register = register.load(Ordering::Relaxed);
    if !register.is_null() {
        // SAFETY: `Laser::set_up` stores pointers to a compare register and the event register of the laser's
        // own timer, and to a port's BSRR, where a word names the gate's pin or none.
        unsafe { register.write_volatile(word) };
    }
}

fn read(register: &AtomicPtr<u32>) -> u32 {
    let register = register.load(Ordering::Relaxed);
    // SAFETY: as in `write`; none of these registers changes by being read.
    if register.is_null() { 0 } else { unsafe { register.read_volatile() } }
}

#[inline(never)]
fn close_gate() {
    write(&SHARED.gate, SHARED.gate_off.load(Ordering::Relaxed));
}

/// Switches the gate on or off, as the compare value has power or none.
#[inline(always)]
fn follow_with_gate(compare: u32) {
    let word = if compare == 0 { &SHARED.gate_off } else { &SHARED.gate_on };
    write(&SHARED.gate, word.load(Ordering::Acquire));
}

/// Brings the gate after the duty. False when the interrupt has changed the duty meanwhile.
#[inline(never)]
fn brings_gate_after() -> bool {
    let compare = read(&SHARED.compare);
    follow_with_gate(compare);
    read(&SHARED.compare) == compare
}

/// Gives the laser a duty, 1/65535, from this moment on, unless it is locked. The step interrupt's part:
/// integers only, no wait.
#[inline(never)]
#[unsafe(link_section = ".itcm.laser")]
pub(crate) extern "C" fn play(duty: u16) {
    if SHARED.is_open.load(Ordering::Acquire) == 0 {
        return;
    }
    // Full power is 65536, so that the pulse fills the period; the product fits 32 bits.
    let share = u32::from(duty) + u32::from(duty >> 15);
    let compare = (share * SHARED.counts.load(Ordering::Relaxed) + 0x8000) >> 16;
    write(&SHARED.compare, compare);
    write(&SHARED.generate, UPDATE);
    follow_with_gate(compare);
}

/// Returns the laser's duty of an event whose pins have been written, as a motor's turn: the laser's place
/// has none. Looked at only then, so that a turn is as quick as a step: both are only as far apart as the
/// driver asks.
#[inline(always)]
pub(crate) fn duty_behind_pins(event: StepEvent) -> Option<u16> {
    let mut word = event.word;
    // SAFETY: no instruction. The compiler orders it behind the write of the pin, and what needs the word
    // behind it.
    unsafe { core::arch::asm!("/* {0} */", inout(reg) word, options(nostack, preserves_flags)) };
    StepEvent { word, ..event }.laser_duty()
}

/// Forces the outputs of both PWM timers inactive, and the laser's gate off: for faults, from any context,
/// before a reset.
pub(crate) fn force_off() {
    // SAFETY: whoever owns the timers does nothing more. A timer without a clock has no outputs, and its
    // registers are not touched (RM0399 section 9.7.45, RCC_APB2ENR: TIM1EN, TIM8EN).
    unsafe {
        let enabled = (*pac::RCC::ptr()).apb2enr.read();
        let running = [enabled.tim1en().bit_is_set(), enabled.tim8en().bit_is_set()];
        for (timer, _) in running.into_iter().enumerate().filter(|(_, runs)| *runs) {
            const BOTH_CHANNELS: u32 = FORCED_INACTIVE | FORCED_INACTIVE << 8;
            registers(timer).ccmr1_output().write(|w| w.bits(BOTH_CHANNELS));
            registers(timer).ccmr2_output().write(|w| w.bits(BOTH_CHANNELS));
        }
    }
    if IS_SET_UP.load(Ordering::Acquire) {
        SHARED.is_open.store(0, Ordering::Relaxed);
        close_gate();
    }
}

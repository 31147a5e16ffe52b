//! Step pulses: plays [`StepQueue`] on the pins at the times it names, on TIM2 (200 MHz, 32 bit, free running).
//!
//! Compare 1 wakes the interrupt for the next event, compare 2 for the end of a pulse. The interrupt keeps no position and takes no decision: it writes
//! the pins, and arms the timer for the next event. A motor steps by toggling: its BSRR word, rotated by 16 after each edge, always holds the opposite
//! level. What the interrupt needs to know of the motors lies in a static of atomics, written by [`configure`] while nothing is queued: plain loads
//! for the interrupt, no lock for anybody.
//!
//! Budget: 75 instructions for a step of one motor, 40 more for each further motor due at the same tick. It runs in ITCM from DTCM data, integers only.
//! When it is entered with nothing due (the feed pends it after writing) it only arms the timer.

use core::sync::atomic::{AtomicU32, Ordering};

use motion::queue::{StepEvent, StepQueue};
use stm32h7xx_hal::pac;
use units::{MAX_ACTUATORS, STEP_CLOCK_HZ};

use crate::pins::FastPin;
use core::sync::atomic::AtomicPtr;

/// An event played later than this counts as late: 250 ns.
const LATE_TICKS: i32 = 50;

/// What the interrupt has to tell; read by reports, written by the interrupt alone.
#[derive(Debug)]
pub struct Statistics {
    late: AtomicU32,
    worst_ticks: AtomicU32,
}

impl Statistics {
    /// How many events were played more than 250 ns late, ever.
    #[must_use]
    pub fn late_events(&self) -> u32 {
        self.late.load(Ordering::Relaxed)
    }

    /// The worst lateness so far in ticks of 5 ns.
    #[must_use]
    pub fn worst_ticks(&self) -> u32 {
        self.worst_ticks.load(Ordering::Relaxed)
    }

    /// Starts the worst lateness afresh.
    pub fn reset_worst(&self) {
        self.worst_ticks.store(0, Ordering::Relaxed);
    }
}

/// The step interrupt's statistics.
pub static STATISTICS: Statistics = Statistics { late: AtomicU32::new(0), worst_ticks: AtomicU32::new(0) };

/// Pins of one motor, as the configuration has them.
#[derive(Clone, Copy, Debug)]
pub struct MotorLines {
    /// The step pin, off.
    pub step: FastPin,
    /// The direction pin; on is forward.
    pub direction: FastPin,
    /// Every edge is a step (the driver is set so), rather than every pulse.
    pub double_edge: bool,
}

impl MotorLines {
    /// A motor that is not there.
    pub const NONE: Self = Self { step: FastPin::NONE, direction: FastPin::NONE, double_edge: true };
}

/// One motor, as the interrupt sees it: two BSRR registers and the words for them.
struct Motor {
    step_register: AtomicPtr<u32>,
    /// Word of the next edge. Rotated by the interrupt.
    next: AtomicU32,
    direction_register: AtomicPtr<u32>,
    /// Word for forward.
    forward: AtomicU32,
}

impl Motor {
    /// Nowhere to write to: the words are zero, which no port takes notice of.
    const fn absent() -> Self {
        Self {
            step_register: AtomicPtr::new(FastPin::NONE.register()),
            next: AtomicU32::new(0),
            direction_register: AtomicPtr::new(FastPin::NONE.register()),
            forward: AtomicU32::new(0),
        }
    }
}

/// Eight, so that a three-bit index needs no test.
static MOTORS: [Motor; 8] = [const { Motor::absent() }; 8];
/// Motors that step by pulses, one bit each.
static PULSED: AtomicU32 = AtomicU32::new(0);
/// Length of a pulse.
static PULSE_TICKS: AtomicU32 = AtomicU32::new(STEP_CLOCK_HZ / 1_000_000);

/// Sets the pins of all motors. Only while nothing is queued or moving: the caller sees to that, at boot.
pub fn configure(motors: &[MotorLines; MAX_ACTUATORS], pulse_us: u32) {
    let mut pulsed = 0;
    for (index, (motor, lines)) in MOTORS.iter().zip(motors).enumerate() {
        motor.step_register.store(lines.step.register(), Ordering::Relaxed);
        motor.next.store(lines.step.on_word(), Ordering::Relaxed);
        motor.direction_register.store(lines.direction.register(), Ordering::Relaxed);
        motor.forward.store(lines.direction.on_word(), Ordering::Relaxed);
        if !lines.double_edge {
            pulsed |= 1 << index;
        }
    }
    PULSED.store(pulsed, Ordering::Relaxed);
    // A pulse is at least as long as the fastest driver asks and at most 1 ms.
    PULSE_TICKS.store((STEP_CLOCK_HZ / 1_000_000) * pulse_us.clamp(1, 1000), Ordering::Release);
}

/// Writes a word to a port's BSRR.
#[inline(always)]
fn write(register: &AtomicPtr<u32>, word: u32) {
    // SAFETY: the pointers in MOTORS are to BSRR registers only; a word names the one pin that its handle owns, or none.
    unsafe { register.load(Ordering::Relaxed).write_volatile(word) };
}

/// The interrupt's state.
#[derive(Debug)]
pub struct StepEngine {
    timer: pac::TIM2,
    queue: &'static StepQueue,
    /// Motors whose pulse is high now.
    raised: u32,
}

/// Every motor's bit.
const ALL_MOTORS: u32 = (1 << MAX_ACTUATORS) - 1;

/// Calls `action` for the motor of each bit of `set`. The mask and the table's eight places leave no bound to test.
#[inline(always)]
fn for_each(mut set: u32, mut action: impl FnMut(&'static Motor, u32)) {
    while set != 0 {
        let index = set.trailing_zeros();
        set &= set - 1;
        action(&MOTORS[(index & 7) as usize], index);
    }
}

/// The next edge of a motor's step pin.
#[inline(always)]
fn toggle(motor: &Motor) {
    let word = motor.next.load(Ordering::Relaxed);
    write(&motor.step_register, word);
    motor.next.store(word.rotate_left(16), Ordering::Relaxed);
}

impl StepEngine {
    pub(crate) fn new(timer: pac::TIM2, queue: &'static StepQueue) -> Self {
        // RM0399 section 43.4.5: compare interrupts on channels 1 and 2; nothing is output by the timer itself.
        timer.dier.write(|w| w.cc1ie().set_bit().cc2ie().set_bit());
        Self { timer, queue, raised: 0 }
    }

    /// The interrupt: ends pulses, plays what is due, arms for the next.
    #[inline(always)]
    pub fn on_interrupt(&mut self) {
        // RM0399 section 43.4.6: flags are cleared by writing zero to them.
        let pulse_over = self.timer.sr.read().cc2if().bit_is_set();
        self.timer.sr.reset();
        if pulse_over && self.raised != 0 {
            self.lower();
        }
        let queue = self.queue;
        queue.play_on_this_core(|event| {
            let due = self.is_due(event.at);
            if due {
                self.play(event);
            }
            due
        });
    }

    /// Whether `at` has come. When it has not, the timer is armed for it; when it comes while arming, it is due.
    #[inline(always)]
    fn is_due(&mut self, at: u32) -> bool {
        let mut late = self.now().wrapping_sub(at) as i32;
        if late < 0 {
            self.timer.ccr1().write(|w| w.ccr().bits(at));
            late = self.now().wrapping_sub(at) as i32;
            if late < 0 {
                return false;
            }
        }
        if late > LATE_TICKS {
            STATISTICS.late.store(STATISTICS.late.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        }
        if late as u32 > STATISTICS.worst_ticks.load(Ordering::Relaxed) {
            STATISTICS.worst_ticks.store(late as u32, Ordering::Relaxed);
        }
        true
    }

    #[inline(always)]
    fn play(&mut self, event: StepEvent) {
        let stepping = event.word & ALL_MOTORS;
        if event.word > 0xFF {
            turn(event);
        }
        let pulsing = stepping & PULSED.load(Ordering::Relaxed);
        if pulsing & self.raised != 0 {
            // Faster than the pulse is long: the edge is kept, the pulse is cut.
            self.lower();
        }
        for_each(stepping, |motor, _| toggle(motor));
        if pulsing != 0 {
            self.raised |= pulsing;
            let end = self.now().wrapping_add(PULSE_TICKS.load(Ordering::Relaxed));
            self.timer.ccr2().write(|w| w.ccr().bits(end));
        }
    }

    /// Ends the pulses that are high.
    #[inline(always)]
    fn lower(&mut self) {
        for_each(self.raised, |motor, _| toggle(motor));
        self.raised = 0;
    }

    #[inline(always)]
    fn now(&self) -> u32 {
        self.timer.cnt.read().bits()
    }
}

/// New levels of direction pins.
#[inline(always)]
fn turn(event: StepEvent) {
    let (forward, backward) = (u32::from(event.turning_forward()), u32::from(event.turning_backward()));
    for_each((forward | backward) & ALL_MOTORS, |motor, index| {
        let word = motor.forward.load(Ordering::Relaxed);
        write(&motor.direction_register, if forward & (1 << index) != 0 { word } else { word.rotate_left(16) });
    });
}

/// Asks the interrupt to look at the queue again: the feed calls this after it has written.
#[inline]
pub fn wake() {
    cortex_m::peripheral::NVIC::pend(pac::Interrupt::TIM2);
}

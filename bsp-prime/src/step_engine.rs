//! Step pulses: plays the [`queue`] on the pins at the times it names, on TIM2 (200 MHz, 32 bit, free running).
//!
//! Compare 1 wakes the interrupt for the next event, compare 2 for the end of a pulse. The interrupt keeps no position and takes no decision: it writes
//! the pins, and arms the timer for the next event. A motor steps by toggling: its BSRR word, rotated by 16 after each edge, always holds the opposite
//! level. What the interrupt needs to know of the motors lies in a static of atomics, written by [`configure`] while nothing is queued: plain loads
//! for the interrupt, no lock for anybody. The queue lies in the same static, so that one base register reaches everything.
//!
//! Where every motor steps on both edges (all on-board drivers do), a step costs about fifty instructions from entry to return, twenty when it comes
//! together with another. External drivers that need pulses take the longer way. It runs in ITCM from DTCM data, integers only. When it is
//! entered with nothing due (the feed pends it after writing) it only arms the timer.
//!
//! The interrupt has the highest priority of all, which nothing can mask but PRIMASK: no resource of any framework is shared with it, and none
//! wraps it. Within it the queue's cut flag cannot change, so it is looked at once.

use core::sync::atomic::{AtomicPtr, AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use motion::queue::StepQueue;
use stm32h7xx_hal::pac;
use units::{MAX_ACTUATORS, STEP_CLOCK_HZ};

use crate::pins::FastPin;

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

    /// The worst lateness of these in ticks of 5 ns; zero when there was none.
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

/// Everything the interrupt reads and writes.
#[repr(C)]
struct Shared {
    /// Motors that step by pulses, one bit each.
    pulsed: AtomicU32,
    /// Length of a pulse.
    pulse_ticks: AtomicU32,
    /// Motors whose pulse is high now, one bit each. The interrupt's own.
    raised: AtomicU32,
    /// Eight, so that a three-bit index needs no test.
    motors: [Motor; 8],
    /// Last: it is large.
    queue: StepQueue,
}

static SHARED: Shared = Shared {
    pulsed: AtomicU32::new(0),
    pulse_ticks: AtomicU32::new(STEP_CLOCK_HZ / 1_000_000),
    raised: AtomicU32::new(0),
    motors: [const { Motor::absent() }; 8],
    queue: StepQueue::new(),
};

/// What the feed writes ahead and the interrupt plays.
#[must_use]
pub fn queue() -> &'static StepQueue {
    &SHARED.queue
}

/// Sets the pins of all motors. Only while nothing is queued or moving: the caller sees to that, at boot.
pub fn configure(motors: &[MotorLines; MAX_ACTUATORS], pulse_us: u32) {
    let mut pulsed = 0;
    for (index, (motor, lines)) in SHARED.motors.iter().zip(motors).enumerate() {
        motor.step_register.store(lines.step.register(), Ordering::Relaxed);
        motor.next.store(lines.step.on_word(), Ordering::Relaxed);
        motor.direction_register.store(lines.direction.register(), Ordering::Relaxed);
        motor.forward.store(lines.direction.on_word(), Ordering::Relaxed);
        if !lines.double_edge {
            pulsed |= 1 << index;
        }
    }
    SHARED.pulsed.store(pulsed, Ordering::Relaxed);
    // A pulse is at least as long as the fastest driver asks and at most 1 ms.
    SHARED.pulse_ticks.store((STEP_CLOCK_HZ / 1_000_000) * pulse_us.clamp(1, 1000), Ordering::Release);
}

/// Writes a word to a port's BSRR.
#[inline(always)]
fn write(register: &AtomicPtr<u32>, word: u32) {
    // SAFETY: the pointers in SHARED are to BSRR registers only; a word names the one pin that its handle owns, or none.
    unsafe { register.load(Ordering::Relaxed).write_volatile(word) };
}

/// The next edge of a motor's step pin.
#[inline(always)]
fn toggle(motor: &Motor) {
    let word = motor.next.load(Ordering::Relaxed);
    write(&motor.step_register, word);
    motor.next.store(word.rotate_left(16), Ordering::Relaxed);
}

/// A new level of a motor's direction pin.
#[inline(always)]
fn turn(motor: &Motor, forward: bool) {
    let word = motor.forward.load(Ordering::Relaxed);
    write(&motor.direction_register, if forward { word } else { word.rotate_left(16) });
}

/// The interrupt: ends pulses, plays what is due, arms for the next.
#[unsafe(export_name = "TIM2")]
#[unsafe(link_section = ".itcm.step")]
extern "C" fn on_step_timer() {
    if SHARED.pulsed.load(Ordering::Relaxed) != 0 {
        return play_pulses();
    }
    acknowledge();
    SHARED.queue.play_on_this_core(|event| {
        let due = is_due(event.at);
        if due {
            let motor = &SHARED.motors[event.motor()];
            if event.is_turn() {
                turn(motor, event.is_forward());
            } else {
                toggle(motor);
            }
        }
        due
    });
}

/// The same where some motors need pulses.
#[inline(never)]
#[unsafe(link_section = ".itcm.pulses")]
fn play_pulses() {
    let pulsed = SHARED.pulsed.load(Ordering::Relaxed);
    if timer().sr.read().cc2if().bit_is_set() {
        lower_all();
    }
    acknowledge();
    SHARED.queue.play_on_this_core(|event| {
        if !is_due(event.at) {
            return false;
        }
        let motor = &SHARED.motors[event.motor()];
        if event.is_turn() {
            turn(motor, event.is_forward());
            return true;
        }
        let (bit, raised) = (1 << event.motor(), SHARED.raised.load(Ordering::Relaxed));
        if raised & bit != 0 {
            // Faster than the pulse is long: the edge is kept, the pulse is cut.
            toggle(motor);
        }
        toggle(motor);
        if pulsed & bit != 0 {
            SHARED.raised.store(raised | bit, Ordering::Relaxed);
            let end = now().wrapping_add(SHARED.pulse_ticks.load(Ordering::Relaxed));
            timer().ccr2().write(|w| w.ccr().bits(end));
        }
        true
    });
}

/// Ends the pulses that are high.
#[inline(always)]
fn lower_all() {
    let mut raised = SHARED.raised.load(Ordering::Relaxed);
    while raised != 0 {
        // The mask leaves no bound to test.
        toggle(&SHARED.motors[(raised.trailing_zeros() & 7) as usize]);
        raised &= raised - 1;
    }
    SHARED.raised.store(0, Ordering::Relaxed);
}

/// Whether `at` has come. When it has not, the timer is armed for it; when it comes while arming, it is due.
#[inline(always)]
fn is_due(at: u32) -> bool {
    let mut late = now().wrapping_sub(at) as i32;
    if late < 0 {
        timer().ccr1().write(|w| w.ccr().bits(at));
        late = now().wrapping_sub(at) as i32;
        if late < 0 {
            return false;
        }
    }
    if late > LATE_TICKS {
        count_late(late as u32);
    }
    true
}

#[cold]
#[inline(never)]
#[unsafe(link_section = ".itcm.late")]
extern "C" fn count_late(late: u32) {
    STATISTICS.late.store(STATISTICS.late.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    if late > STATISTICS.worst_ticks.load(Ordering::Relaxed) {
        STATISTICS.worst_ticks.store(late, Ordering::Relaxed);
    }
}

/// RM0399 section 43.4.6: flags are cleared by writing zero to them.
#[inline(always)]
fn acknowledge() {
    timer().sr.reset();
}

#[inline(always)]
fn now() -> u32 {
    timer().cnt.read().bits()
}

/// The step timer's registers.
#[inline(always)]
fn timer() -> &'static pac::tim2::RegisterBlock {
    // SAFETY: `start` took the timer from whoever else might have had it; from then on only the interrupt writes to it.
    unsafe { &*pac::TIM2::ptr() }
}

/// Lets the interrupt run.
pub(crate) fn start(timer: pac::TIM2, nvic: &mut NVIC) {
    // RM0399 section 43.4.5: compare interrupts on channels 1 and 2; nothing is output by the timer itself.
    timer.dier.write(|w| w.cc1ie().set_bit().cc2ie().set_bit());
    // SAFETY: the interrupt shares nothing but atomics: it may come at any time, and before anything else.
    unsafe {
        nvic.set_priority(pac::Interrupt::TIM2, 0);
        NVIC::unmask(pac::Interrupt::TIM2);
    }
}

/// Asks the interrupt to look at the queue again: the feed calls this after it has written.
#[inline]
pub fn wake() {
    NVIC::pend(pac::Interrupt::TIM2);
}

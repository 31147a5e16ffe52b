//! Step pulses: plays the [`queue`] on the pins at the times it names, on TIM2 (200 MHz, 32 bit, free
//! running).
//!
//! Compare 1 wakes the interrupt for the next event, compare 2 for the end of a pulse. The interrupt keeps no
//! position and takes no decision: it writes the pins, and arms the timer for the next event. A motor steps
//! by toggling: its BSRR word, rotated by 16 after each edge, always holds the opposite level. The
//! interrupt's data of the motors lie in a static of atomics, written by [`configure`] while nothing is
//! queued: plain loads for the interrupt, no lock for anybody. The queue lies in the same static, so that one
//! base register reaches everything.
//!
//! If all motors step on both edges (all on-board drivers do), a step costs about fifty instructions from
//! entry to return, twenty if another came with it. If a motor needs pulses, a longer handler stands in the
//! vector table; a pulse's end does not look at the queue. The code runs in ITCM from DTCM data, integers
//! only. Entered with nothing due (the feed pends the interrupt after writing), the handler only arms the
//! timer.
//!
//! An event later than 250 ns is the sign that something kept the interrupt from running. From then on, until
//! all is on time again, [`catch_up`] plays: it keeps every motor's events as far apart as its driver needs,
//! so that no step is lost, and counts what it had to delay.
//!
//! The interrupt has the highest priority of all, which nothing can mask but PRIMASK: no resource of any
//! framework is shared with it, and none wraps it. Within it the queue's cut flag cannot change, so it is
//! looked at once.

use core::sync::atomic::{AtomicPtr, AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use motion::queue::{StepEvent, StepQueue};
use stm32h7xx_hal::pac;
use units::{MAX_ACTUATORS, STEP_CLOCK_HZ};

use crate::pins::FastPin;
use crate::{laser, memory};

/// An event played later than this counts as late: 250 ns.
const LATE_TICKS: i32 = 50;

/// Statistics of late events; read by reports, written by the interrupt alone.
#[derive(Debug)]
pub struct Statistics {
    late: AtomicU32,
    delayed: AtomicU32,
    worst_ticks: AtomicU32,
}

impl Statistics {
    /// Returns the number of events played more than 250 ns late so far.
    #[must_use]
    pub fn late_events(&self) -> u32 {
        self.late.load(Ordering::Relaxed)
    }

    /// Returns the number of late events delayed further, to more than 10 us, since playing them at once
    /// would have followed the motor's last event faster than its driver can.
    #[must_use]
    pub fn delayed_events(&self) -> u32 {
        self.delayed.load(Ordering::Relaxed)
    }

    /// Returns the worst lateness in ticks of 5 ns; zero when no event was late.
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
pub static STATISTICS: Statistics =
    Statistics { late: AtomicU32::new(0), delayed: AtomicU32::new(0), worst_ticks: AtomicU32::new(0) };

/// Pins of one motor, as the configuration has them.
#[derive(Clone, Copy, Debug)]
pub struct MotorLines {
    /// The step pin, off.
    pub step: FastPin,
    /// The direction pin; off is forward. So on this board a low level counts up, and `!` makes that a high
    /// one.
    pub direction: FastPin,
    /// Whether every edge is a step (the driver is set so), rather than every pulse.
    pub double_edge: bool,
    /// Least time that the driver needs between two steps, and between a step and a turn, ticks.
    pub least_distance_ticks: u32,
}

impl MotorLines {
    /// Entry of a motor that does not exist.
    pub const NONE: Self =
        Self { step: FastPin::NONE, direction: FastPin::NONE, double_edge: true, least_distance_ticks: 0 };
}

/// Motor data of the interrupt: two BSRR registers and the words for them.
struct Motor {
    step_register: AtomicPtr<u32>,
    /// Word of the next edge. Rotated by the interrupt.
    next: AtomicU32,
    direction_register: AtomicPtr<u32>,
    /// Word of the forward direction.
    forward: AtomicU32,
}

impl Motor {
    /// Creates an entry of zeros. Call [`Self::disconnect`] before the interrupt runs.
    const fn zero() -> Self {
        Self {
            step_register: AtomicPtr::new(core::ptr::null_mut()),
            next: AtomicU32::new(0),
            direction_register: AtomicPtr::new(core::ptr::null_mut()),
            forward: AtomicU32::new(0),
        }
    }

    /// Disconnects the motor: the words are zero, which no port takes notice of.
    fn disconnect(&self) {
        self.step_register.store(FastPin::NONE.register(), Ordering::Relaxed);
        self.direction_register.store(FastPin::NONE.register(), Ordering::Relaxed);
    }
}

/// Data of a motor for [`catch_up`].
struct Spacing {
    least_distance: AtomicU32,
    /// Time of the motor's last event. Valid while its bit of [`Shared::caught`] is set.
    acted_at: AtomicU32,
}

/// Raised pulses: the end of each, in the order they began. All are of one length, so this is the order of
/// their ends as well.
struct Pulses {
    /// Counts of pulses ever ended and begun, wrapping.
    ended: AtomicU32,
    begun: AtomicU32,
    /// Ends of the pulses. A motor has one pulse at most, so eight are enough. The lowest three bits of the
    /// tick are the motor.
    ends: [AtomicU32; 8],
}

/// Bit of [`Shared::careful`]: something was late, [`catch_up`] plays.
const CATCHING_UP: u32 = 1 << 31;
/// Delay of a step that harms no motor: 10 us. Six motors that turn at one tick take half a microsecond to
/// play, and each one's first step is due at the least distance behind.
const HARMLESS_TICKS: u32 = STEP_CLOCK_HZ / 100_000;
/// Longer than any driver's least distance: 50 ms.
const LONG_TICKS: u32 = STEP_CLOCK_HZ / 20;

/// Everything the interrupt reads and writes. All zero until [`start`], so that the image carries none of it.
#[repr(C)]
struct Shared {
    /// At the start of the structure, so that an access needs no offset. Eight, so that a three-bit index
    /// needs no test.
    motors: [Motor; 8],
    /// Reasons against the short handler: motors that step by pulses, one bit each, and [`CATCHING_UP`].
    careful: AtomicU32,
    /// Length of a pulse.
    pulse_ticks: AtomicU32,
    /// Motors whose pulse is high now, one bit each. The interrupt's own, as are these pulses.
    raised: AtomicU32,
    pulses: Pulses,
    /// The interrupt was asked to look at the queue. The end of a pulse may cause the interrupt in the same
    /// moment.
    woken: AtomicU32,
    spacings: [Spacing; 8],
    /// Motors with an event since catching up began, one bit each.
    caught: AtomicU32,
    /// Time at which the last late event was played.
    late_at: AtomicU32,
    /// Greatest of the motors' least distances. After so long without a late event, no coming event can
    /// follow a late one too closely.
    recovery: AtomicU32,
    /// At the end, as the queue is large.
    queue: StepQueue,
}

static SHARED: Shared = Shared {
    careful: AtomicU32::new(0),
    pulse_ticks: AtomicU32::new(0),
    raised: AtomicU32::new(0),
    pulses: Pulses { ended: AtomicU32::new(0), begun: AtomicU32::new(0), ends: [const { AtomicU32::new(0) }; 8] },
    woken: AtomicU32::new(0),
    motors: [const { Motor::zero() }; 8],
    spacings: [const { Spacing { least_distance: AtomicU32::new(0), acted_at: AtomicU32::new(0) } }; 8],
    caught: AtomicU32::new(0),
    late_at: AtomicU32::new(0),
    recovery: AtomicU32::new(0),
    queue: StepQueue::new(),
};

/// Returns the queue that the feed writes and the interrupt plays.
#[must_use]
pub fn queue() -> &'static StepQueue {
    &SHARED.queue
}

/// Sets the pins of all motors. Only while nothing is queued or moving: the caller sees to that, at boot.
pub fn configure(motors: &[MotorLines; MAX_ACTUATORS], pulse_us: u32) {
    let (mut pulsed, mut recovery) = (0, 0);
    for (index, (motor, lines)) in SHARED.motors.iter().zip(motors).enumerate() {
        motor.step_register.store(lines.step.register(), Ordering::Relaxed);
        motor.next.store(lines.step.on_word(), Ordering::Relaxed);
        motor.direction_register.store(lines.direction.register(), Ordering::Relaxed);
        motor.forward.store(lines.direction.off_word(), Ordering::Relaxed);
        SHARED.spacings[index].least_distance.store(lines.least_distance_ticks, Ordering::Relaxed);
        recovery = recovery.max(lines.least_distance_ticks);
        if !lines.double_edge {
            pulsed |= 1 << index;
        }
    }
    memory::set_vector(pac::Interrupt::TIM2, if pulsed == 0 { on_step_timer } else { play_carefully });
    SHARED.careful.store(pulsed, Ordering::Relaxed);
    SHARED.recovery.store(recovery, Ordering::Relaxed);
    // A pulse is at least as long as the fastest driver asks and at most 1 ms.
    SHARED.pulse_ticks.store((STEP_CLOCK_HZ / 1_000_000) * pulse_us.clamp(1, 1000), Ordering::Release);
}

/// Writes a word to a port's BSRR.
#[inline(always)]
fn write(register: &AtomicPtr<u32>, word: u32) {
    // SAFETY: the pointers in SHARED are to BSRR registers only, from before the interrupt first runs
    // (`start`); a word names the one pin that its handle owns, or none.
    unsafe { register.load(Ordering::Relaxed).write_volatile(word) };
}

/// Outputs the next edge of a motor's step pin.
#[inline(always)]
fn toggle(motor: &Motor) {
    let word = motor.next.load(Ordering::Relaxed);
    write(&motor.step_register, word);
    motor.next.store(word.rotate_left(16), Ordering::Relaxed);
}

/// Outputs a new level of a motor's direction pin.
#[inline(always)]
fn turn(motor: &Motor, forward: bool) {
    let word = motor.forward.load(Ordering::Relaxed);
    write(&motor.direction_register, if forward { word } else { word.rotate_left(16) });
}

/// Interrupt handler: ends pulses, plays due events, arms the timer for the next event.
#[unsafe(export_name = "TIM2")]
#[unsafe(link_section = ".itcm.step")]
extern "C" fn on_step_timer() {
    if SHARED.careful.load(Ordering::Relaxed) != 0 {
        return play_carefully();
    }
    acknowledge();
    let mut burns = false;
    SHARED.queue.play_on_this_core(|event| {
        let due = is_due(event.at);
        if due {
            let motor = &SHARED.motors[event.motor()];
            if event.is_turn() {
                turn(motor, event.is_forward());
                // No call from here: the way of a step would save registers for it.
                burns = laser::duty_behind_pins(event).is_some();
                return !burns;
            }
            toggle(motor);
        }
        due
    });
    if burns {
        play_with_power();
    }
}

/// Plays what is due from a power of the laser on, where no motor needs pulses.
#[inline(never)]
#[unsafe(link_section = ".itcm.power")]
extern "C" fn play_with_power() {
    SHARED.queue.play_on_this_core(|event| is_due(event.at) && act(event, 0));
}

/// Plays events as `play` does, for motors that need pulses, or after something was late. If motors need
/// pulses, this is the timer's interrupt handler itself.
#[inline(never)]
#[unsafe(link_section = ".itcm.pulses")]
extern "C" fn play_carefully() {
    let careful = SHARED.careful.load(Ordering::Relaxed);
    let flags = timer().sr.read();
    // Flags are cleared before the timer is armed anew: what comes from then on counts. Writing one leaves a
    // flag as it is.
    if flags.cc2if().bit_is_set() {
        timer().sr.write(|w| w.cc1if().set_bit().cc2if().clear_bit());
        lower();
        if flags.cc1if().bit_is_clear() && SHARED.woken.load(Ordering::Relaxed) == 0 {
            // The interrupt only ended a pulse: the timer is armed for the next event, or will be when the
            // feed has written one.
            return;
        }
    }
    timer().sr.write(|w| w.cc1if().clear_bit().cc2if().set_bit());
    SHARED.woken.store(0, Ordering::Relaxed);
    if careful & CATCHING_UP != 0 {
        return catch_up(careful);
    }
    SHARED.queue.play_on_this_core(|event| is_due(event.at) && act(event, careful));
}

/// Plays an event of a motor that may need pulses. Returns false while its last pulse is still high: the
/// event is looked at again after a pulse's length.
#[inline(always)]
fn act(event: StepEvent, pulsed: u32) -> bool {
    let motor = &SHARED.motors[event.motor()];
    if event.is_turn() {
        turn(motor, event.is_forward());
        if let Some(duty) = laser::duty_behind_pins(event) {
            laser::play(duty);
        }
        return true;
    }
    let bit = 1 << event.motor();
    if pulsed & bit == 0 {
        toggle(motor);
        return true;
    }
    let raised = SHARED.raised.load(Ordering::Relaxed);
    if raised & bit != 0 {
        wait_for_low(event.motor());
        return false;
    }
    toggle(motor);
    SHARED.raised.store(raised | bit, Ordering::Relaxed);
    let pulses = &SHARED.pulses;
    let begun = pulses.begun.load(Ordering::Relaxed);
    // The end is rounded up to the next multiple of eight, 40 ns at most, as its low bits hold the motor.
    let end = now().wrapping_add(SHARED.pulse_ticks.load(Ordering::Relaxed) + 7) & !7 | event.motor() as u32;
    pulses.ends[(begun & 7) as usize].store(end, Ordering::Relaxed);
    pulses.begun.store(begun.wrapping_add(1), Ordering::Relaxed);
    if raised == 0 {
        // Otherwise the timer is armed for the end of an earlier pulse.
        timer().ccr2().write(|w| w.ccr().bits(end));
    }
    true
}

/// The interrupt was kept so long that a motor's pulse is high when the next is due: [`catch_up`] plays that
/// when it is low for long enough.
#[cold]
#[inline(never)]
#[unsafe(link_section = ".itcm.wait")]
extern "C" fn wait_for_low(motor: usize) {
    fall_behind();
    lower();
    SHARED.spacings[motor & 7].acted_at.store(now(), Ordering::Relaxed);
    SHARED.caught.store(1 << (motor & 7), Ordering::Relaxed);
}

/// Ends the pulses whose time has come, and arms the timer for the end of the next.
#[inline(always)]
fn lower() {
    let (pulses, mut raised) = (&SHARED.pulses, SHARED.raised.load(Ordering::Relaxed));
    let mut ended = pulses.ended.load(Ordering::Relaxed);
    while raised != 0 {
        let end = pulses.ends[(ended & 7) as usize].load(Ordering::Relaxed);
        if (now().wrapping_sub(end) as i32) < 0 {
            timer().ccr2().write(|w| w.ccr().bits(end));
            if (now().wrapping_sub(end) as i32) < 0 {
                break;
            }
        }
        // The mask spares a bounds check.
        let motor = (end & 7) as usize;
        toggle(&SHARED.motors[motor]);
        raised &= !(1 << motor);
        ended = ended.wrapping_add(1);
    }
    pulses.ended.store(ended, Ordering::Relaxed);
    SHARED.raised.store(raised, Ordering::Relaxed);
}

/// Returns the delay against `at`, ticks. Negative: not yet, and the timer is armed for it; an event that
/// comes while arming has come.
#[inline(always)]
fn lateness(at: u32) -> i32 {
    let late = now().wrapping_sub(at) as i32;
    if late >= 0 {
        return late;
    }
    timer().ccr1().write(|w| w.ccr().bits(at));
    now().wrapping_sub(at) as i32
}

/// Returns whether `at` has come just now. A missed event makes [`catch_up`] take over.
#[inline(always)]
fn is_due(at: u32) -> bool {
    let late = lateness(at);
    // A single comparison on the way of every step: an early event gives a large number.
    if late as u32 <= LATE_TICKS as u32 {
        return true;
    }
    if late > 0 {
        fall_behind();
    }
    false
}

/// Sets the interrupt to catch up: after a late event it comes again at once.
#[cold]
#[inline(never)]
#[unsafe(link_section = ".itcm.late")]
extern "C" fn fall_behind() {
    SHARED.caught.store(0, Ordering::Relaxed);
    SHARED.late_at.store(now(), Ordering::Relaxed);
    SHARED.careful.store(SHARED.careful.load(Ordering::Relaxed) | CATCHING_UP, Ordering::Relaxed);
    wake();
}

/// Plays what is due, but no motor's events closer than its driver allows. The first late event of a motor
/// follows the one before at more than its planned distance; from then on it is known when each was played.
#[cold]
#[inline(never)]
#[unsafe(link_section = ".itcm.catch_up")]
fn catch_up(careful: u32) {
    SHARED.queue.play_on_this_core(|event| {
        let late = lateness(event.at);
        if late < 0 {
            if now().wrapping_sub(SHARED.late_at.load(Ordering::Relaxed)) > SHARED.recovery.load(Ordering::Relaxed) {
                SHARED.careful.store(careful & !CATCHING_UP, Ordering::Relaxed);
            }
            return false;
        }
        let (bit, spacing) = (1 << event.motor(), &SHARED.spacings[event.motor()]);
        let caught = SHARED.caught.load(Ordering::Relaxed);
        let acted_at = spacing.acted_at.load(Ordering::Relaxed);
        let earliest = acted_at.wrapping_add(spacing.least_distance.load(Ordering::Relaxed));
        // Long ago, the clock has come round since, so the time of the last event is unknown.
        let known = caught & bit != 0 && now().wrapping_sub(acted_at) < LONG_TICKS;
        let crowded = known && earliest.wrapping_sub(event.at) as i32 > 0;
        if crowded && lateness(earliest) < 0 {
            return false;
        }
        let at = now();
        if !act(event, careful) {
            return false;
        }
        spacing.acted_at.store(at, Ordering::Relaxed);
        SHARED.caught.store(caught | bit, Ordering::Relaxed);
        count(at.wrapping_sub(event.at), crowded);
        true
    });
}

/// Enters a played event into the statistics, if it was late.
#[inline(always)]
fn count(late: u32, delayed: bool) {
    let add = |counter: &AtomicU32, one: bool| {
        counter.store(counter.load(Ordering::Relaxed).wrapping_add(u32::from(one)), Ordering::Relaxed);
    };
    let is_late = late > LATE_TICKS as u32;
    add(&STATISTICS.late, is_late);
    add(&STATISTICS.delayed, delayed && late > HARMLESS_TICKS);
    if is_late {
        SHARED.late_at.store(now(), Ordering::Relaxed);
        STATISTICS.worst_ticks.store(STATISTICS.worst_ticks.load(Ordering::Relaxed).max(late), Ordering::Relaxed);
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
    // SAFETY: `start` took the timer from whoever else might have had it; from then on only the interrupt
    // writes to it.
    unsafe { &*pac::TIM2::ptr() }
}

/// Starts the timer and its interrupt.
pub(crate) fn start(timer: pac::TIM2, nvic: &mut NVIC) {
    SHARED.motors.iter().for_each(Motor::disconnect);
    SHARED.pulse_ticks.store(STEP_CLOCK_HZ / 1_000_000, Ordering::Relaxed);
    // RM0399 section 43.4.5: compare interrupts on channels 1 and 2; nothing is output by the timer itself.
    timer.dier.write(|w| w.cc1ie().set_bit().cc2ie().set_bit());
    // SAFETY: the interrupt shares nothing but atomics: it may come at any time, and before anything else.
    unsafe {
        nvic.set_priority(pac::Interrupt::TIM2, 0);
        NVIC::unmask(pac::Interrupt::TIM2);
    }
}

/// Asks the interrupt to look at the queue again: the feed calls this after it has written.
#[inline(always)]
pub fn wake() {
    SHARED.woken.store(1, Ordering::Release);
    NVIC::pend(pac::Interrupt::TIM2);
}

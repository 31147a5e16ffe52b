//! The image for the Smoothieboard v2 Prime: thin tasks, and the wiring of the board to the machine.
//!
//! Priorities, high to low, with each task's deadline:
//!
//! | | task | woken by | deadline |
//! |--:|---|---|---|
//! | 8 | `step` | TIM2 compare | 250 ns after the event's tick |
//! | 7 | `edge_*` | EXTI | 1 us: the stamp of a trigger |
//! | 7 | `supply_falls` | PVD: the chip's 3.3 V | none: it ends the firmware, outputs off first |
//! | 6 | `*_bytes` | USART2, USART3, UART4 | 16 characters of the line |
//! | 6 | `card` | SDMMC1 | none: until then the card waits |
//! | 6 | `usb_packets` | OTG_FS | none: until then the host waits |
//! | 5 | `heat` | TIM7, 2 kHz | half a millisecond |
//! | 4 | `feed` | TIM6, at the queue's need | 0.125 ms: steps written ahead. Polls the RTT console |
//! | 3 | `plan` | the executor, `heat` | the next corner |
//! | 2 | `lights_sent` | DMA2, stream 0 | none: it ends a transmission to a strip of lights |
//! | 1 | `slow` | `heat`, 10 Hz | a second |
//! | 1 | `sensors` | `heat`, 100 Hz, where there are some | 50 ms |
//! | 1 | `frames` | ETH | none: it wakes the executor, which takes them |
//! | 0 | `idle` | bytes, the card, and the feed | none: consoles and executor |
//!
//! The task bodies live in `base`, `machine` and `motion`; here are only priorities and ownership.
#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "interrupt placement and fault handlers need it")]

use stm32h7xx_hal::pac::Interrupt;

mod consoles;
mod disk;
mod drivers;
mod executor;
mod fault;
mod feed;
mod heat_io;
mod lock_free;
mod log;
mod manifest;
mod network;
mod page;
mod ports;
mod rtt_console;
mod slow;
mod start;
mod storage;
mod triggers;
mod update;
mod usb;
mod wiring;
mod workspace;

/// Interrupts of peripherals that the board does not use, for the tasks that software pends. A task pended
/// while it runs runs once more.
const PLANNER: Interrupt = Interrupt::LPTIM2;
const SLOW: Interrupt = Interrupt::LPTIM1;
const SENSORS: Interrupt = Interrupt::LPTIM3;

// No task is `async`: a task that only software asks for has an interrupt of its own that nothing else uses,
// and is pended.
#[rtic::app(device = stm32h7xx_hal::pac, peripherals = true)]
mod app {
    use core::marker::PhantomData;
    use core::mem::MaybeUninit;

    use base::sessions::Intake;
    use base::tasks::{FEED_PERIOD_US, FeedTask, HEAT_PERIOD_US};
    use base::watchdog::Reporter;
    use bsp_prime::flash::BoardFlash;
    use bsp_prime::sd::CardService;
    use bsp_prime::step_engine;
    use bsp_prime::time::{self, Ticker};
    use bsp_prime::uart::UartInterrupt;
    use bsp_prime::watchdog::Watchdog;
    use bsp_prime::{Board, kept, rtt, sd, trigger};
    use motion::laser::PowerStore;
    use motion::{BlockRing, FeedSchedule, Motion, Store};
    use units::Ticks;

    use crate::consoles::Console;
    use crate::heat_io::Heat;
    use crate::lock_free::{LATCH, REACHED, REPORTS};
    use crate::network::{self, BoardNetwork, Hardware};
    use crate::ports::{self, BoardPorts, Owned};
    use crate::rtt_console::{Said, Typed};
    use crate::slow::Slow;
    use crate::triggers::TriggerInputs;
    use crate::{PLANNER, SENSORS, SLOW, executor, fault, feed::Locked, log, start, update, usb};
    use thermal::HeatControl;

    /// Least time between two rounds of the feed's other duties. Runs of the feed that come sooner skip
    /// them.
    const LOOK_EVERY: Ticks = Ticks::from_micros(400);

    /// Time between two turns of the executor while a laser may burn: door, kill button and interlocks are
    /// looked at in a turn that comes 250 us after the last look or later.
    const TURN_EVERY_LIT: Ticks = Ticks::from_micros(255);

    /// Memory of motion that no step waits for. All zero, as the section is. In AXI SRAM: DTCM is for the
    /// data that the step interrupt, the feed and the planner touch all the time.
    #[unsafe(link_section = ".axizero")]
    static mut STORE: Store = Store::new();

    /// The look-ahead queue, in DTCM as every static without a section of its own.
    static mut BLOCKS: BlockRing = BlockRing::new();

    /// Places of a laser's power along the path: looked at by the core alone. All zero, as the section is.
    #[unsafe(link_section = ".itcm_data")]
    static mut POWER: PowerStore = PowerStore::new();

    /// Creates the one motion object.
    fn motion() -> Motion {
        let (blocks, store) = (&raw mut BLOCKS, &raw mut STORE);
        // SAFETY: called once, by `init`; the statics have no other user.
        unsafe { Motion::new(&mut *blocks, &mut *store) }
    }

    /// Gives the motion object the processor's square root, and the memory of a laser's power. Call once,
    /// when `Board::take` has zeroed that.
    #[inline(never)]
    fn equip(motion: &mut Motion) {
        motion::use_square_root(&bsp_prime::fpu::SQUARE_ROOT);
        let power = &raw mut POWER;
        // SAFETY: called once, by `init`, and the static has no other user. The section is zeroed by now,
        // which is what the static is at first.
        motion.give_power_store(unsafe { &mut *power });
    }

    /// Makes an object at its place. An initial value would lie in flash, and it is nearly all zeros; `init`
    /// itself would keep a copy on its stack.
    #[inline(never)]
    fn made<T>(place: &'static mut MaybeUninit<T>, make: fn() -> T) -> &'static mut T {
        place.write(make())
    }

    #[shared]
    struct Shared {
        motion: &'static mut Motion,
        heat: Heat,
        slow: Slow,
        triggers: TriggerInputs,
        card: &'static mut CardService,
    }

    #[local]
    struct Local {
        step_feed: FeedTask,
        feed_tick: Ticker,
        heat_tick: Ticker,
        watchdog: Watchdog,
        debug: UartInterrupt,
        uart0: UartInterrupt,
        uart1: UartInterrupt,
        owned: Owned,
        typed: Typed,
        flash: Option<BoardFlash>,
    }

    #[init(local = [
        motion: MaybeUninit<Motion> = MaybeUninit::uninit(),
        heat: MaybeUninit<HeatControl> = MaybeUninit::uninit(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (motion, heat) = (made(cx.local.motion, motion), made(cx.local.heat, HeatControl::new));
        let board = match Board::take(cx.core, cx.device) {
            Ok(board) => board,
            Err(error) => fault::board_failed(error),
        };
        equip(motion);
        let identity = &board.identity;
        // RTT is started only here, or by a board that did not come up.
        let Some(ends) = rtt::start() else { fault::reset_as_asked() };
        bsp_prime::log::start(ends.log);
        log::record_start(identity);
        // Nobody is on the console before a byte has come.
        Console::Rtt.inbox().set_open(false);
        let reset_cause = defmt::Display2Format(&identity.reset_cause);
        defmt::info!("velvet {=str}, board id {=u8}, reset: {}", env!("VELVET_VERSION"), identity.board, reset_cause);
        let (mut feed_tick, mut heat_tick) = (board.feed_tick, board.heat_tick);
        feed_tick.start(FEED_PERIOD_US);
        heat_tick.start(HEAT_PERIOD_US);
        let owned = Owned {
            pins: board.pins,
            spi: board.spi,
            motors_enable: board.guards.motors,
            leds: board.leds,
            led_sender: board.led_sender,
            second_lamp: None,
            debug: board.debug.1,
            uarts: [board.uart0.1, board.uart1.1],
            board_id: board.identity.board,
            start: start::reason(identity),
            second_core_starts: board.identity.second_core_starts,
            rtc: board.rtc,
            rtt: Said::new(ends.console),
            usb: Some((board.usb, board.identity.unique_id)),
            network: BoardNetwork::new(Hardware {
                ethernet: board.ethernet,
                random: board.random,
                mac: board.identity.mac_address(),
            }),
            disk_lamp: None,
        };
        let shared = Shared {
            motion,
            heat: Heat::new(heat, board.thermistors, board.guards.fets, board.guards.fets_power, board.pwm),
            slow: Slow::new(board.supplies),
            triggers: TriggerInputs::default(),
            card: board.sd.into_service(),
        };
        let local = Local {
            step_feed: FeedTask::new(FeedSchedule::OnDemand, step_engine::wake),
            feed_tick,
            heat_tick,
            watchdog: board.watchdog,
            debug: board.debug.0,
            uart0: board.uart0.0,
            uart1: board.uart1.0,
            owned,
            typed: Typed::new(ends.typed),
            flash: Some(board.flash),
        };
        (shared, local)
    }

    #[task(binds = EXTI0, priority = 7)]
    fn edge_0(_: edge_0::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = EXTI1, priority = 7)]
    fn edge_1(_: edge_1::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = EXTI2, priority = 7)]
    fn edge_2(_: edge_2::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = EXTI3, priority = 7)]
    fn edge_3(_: edge_3::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = EXTI4, priority = 7)]
    fn edge_4(_: edge_4::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = EXTI9_5, priority = 7)]
    fn edge_9_to_5(_: edge_9_to_5::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = EXTI15_10, priority = 7)]
    fn edge_15_to_10(_: edge_15_to_10::Context) {
        trigger::on_interrupt(|input, tick| LATCH.report(input, tick, step_engine::queue()));
    }

    #[task(binds = PVD_PVM, priority = 7)]
    fn supply_falls(_: supply_falls::Context) {
        fault::supply_falls();
    }

    // Ends the laser's power when the step feed, or what keeps it up at rest, is late.
    #[task(binds = TIM5, priority = 7)]
    fn laser_not_renewed(_: laser_not_renewed::Context) {
        bsp_prime::laser::on_alarm();
    }

    #[task(binds = USART2, priority = 6, local = [debug, intake: Intake = Intake::new()])]
    fn debug_bytes(cx: debug_bytes::Context) {
        let (inbox, intake) = (Console::Debug.inbox(), cx.local.intake);
        cx.local.debug.on_interrupt(|byte| {
            // A full inbox counts what it loses.
            let _taken = inbox.receive(intake, byte);
        });
        executor::wake_for_session();
    }

    #[task(binds = USART3, priority = 6, local = [uart0, intake: Intake = Intake::new()])]
    fn uart0_bytes(cx: uart0_bytes::Context) {
        let (inbox, intake) = (Console::Uart0.inbox(), cx.local.intake);
        cx.local.uart0.on_interrupt(|byte| {
            // A full inbox counts what it loses.
            let _taken = inbox.receive(intake, byte);
        });
        executor::wake_for_session();
    }

    #[task(binds = UART4, priority = 6, local = [uart1, intake: Intake = Intake::new()])]
    fn uart1_bytes(cx: uart1_bytes::Context) {
        let (inbox, intake) = (Console::Uart1.inbox(), cx.local.intake);
        cx.local.uart1.on_interrupt(|byte| {
            // A full inbox counts what it loses.
            let _taken = inbox.receive(intake, byte);
        });
        executor::wake_for_session();
    }

    // Handles an event of the bus and a few packets; anything left interrupts again.
    #[task(binds = OTG_FS, priority = 6, shared = [card], local = [device: Option<&'static mut usb::Device> = None])]
    fn usb_packets(mut cx: usb_packets::Context) {
        usb::on_interrupt(cx.local.device, &mut cx.shared.card);
    }

    // Moves the card on: some hundred instructions, up to some thousand if blocks have come in. Then the
    // waiting users look again: the executor, or the disk of the computer that has it.
    #[task(binds = SDMMC1, priority = 6, shared = [card])]
    fn card(mut cx: card::Context) {
        sd::on_interrupt();
        cx.shared.card.lock(|card| {
            card.advance(time::now().0);
            usb::tell_disk(card);
        });
        executor::wake();
    }

    // Runs heaters and slow outputs. Above planning, so that no job can starve heat safety.
    #[task(binds = TIM7, priority = 5, shared = [heat], local = [heat_tick, watchdog])]
    fn heat(mut cx: heat::Context) {
        let on_time = cx.local.heat_tick.acknowledge();
        time::keep_clocks();
        if !on_time {
            return cx.shared.heat.lock(|heat| heat.run_early());
        }
        let (due, reads_chips) = cx.shared.heat.lock(|heat| (heat.run(), heat.io.reads_chips));
        if !due.controlled {
            return;
        }
        REPORTS.report(Reporter::Heat);
        if REPORTS.look(time::now(), kept::events()) {
            cx.local.watchdog.feed();
        }
        if due.slow {
            rtic::pend(SLOW);
            // Pended so that the planner reports, whether or not anything moves.
            rtic::pend(PLANNER);
        }
        if reads_chips {
            rtic::pend(SENSORS);
        }
    }

    // Keeps 0.125 to 0.625 ms of steps written ahead, more at a start and where jerk is limited; the timer is
    // set anew at each run. Other work due twice a millisecond is not done at each run: short lines have up
    // to twice as many.
    #[task(
        binds = TIM6_DAC,
        priority = 4,
        shared = [motion, triggers],
        local = [feed_tick, step_feed, typed, looked: Ticks = Ticks(0), turned: Ticks = Ticks(0)]
    )]
    fn feed(mut cx: feed::Context) {
        cx.local.feed_tick.acknowledge();
        let now = time::now_ticks();
        let looks = now.since(*cx.local.looked) >= LOOK_EVERY;
        if looks {
            *cx.local.looked = now;
            cx.shared.triggers.lock(|triggers| triggers.look(&LATCH));
        }
        let mut motion = Locked(&mut cx.shared.motion);
        let feed = &mut cx.local.step_feed;
        if feed.run(now, &mut motion, step_engine::queue(), &LATCH, &REACHED) {
            time::pend_heat_tick();
        }
        if !step_engine::queue().is_empty() {
            step_engine::wake();
        }
        let mut wait = feed.wait(time::now_ticks());
        if bsp_prime::laser::may_burn(feed.is_moving()) {
            let passed = now.since(*cx.local.turned);
            if passed >= TURN_EVERY_LIT {
                *cx.local.turned = now;
                executor::wake();
            }
            wait = wait.min(TURN_EVERY_LIT.since(if passed < TURN_EVERY_LIT { passed } else { Ticks(0) }));
        }
        cx.local.feed_tick.next_in(wait);
        bsp_prime::laser::renew(wait);
        if looks {
            // The console is polled often enough for an M112.
            if cx.local.typed.look(Console::Rtt.inbox()) {
                executor::wake_for_session();
            }
            REPORTS.report(Reporter::StepFeed);
            executor::wake();
        }
    }

    // Plans one slice of look-ahead.
    #[task(binds = LPTIM2, priority = 3, shared = [motion])]
    fn plan(mut cx: plan::Context) {
        cx.shared.motion.lock(|motion| motion.plan());
        REPORTS.report(Reporter::Planner);
    }

    // The data for a strip of lights are on their way, and the timer must stop.
    #[task(binds = DMA2_STR0, priority = 2)]
    fn lights_sent(_: lights_sent::Context) {
        bsp_prime::led_strip::on_interrupt();
    }

    // Checks driver faults and supply voltages.
    #[task(binds = LPTIM1, priority = 1, shared = [slow, heat])]
    fn slow(mut cx: slow::Context) {
        let celsius = cx.shared.slow.lock(|slow| {
            slow.tick();
            slow.chip_celsius()
        });
        cx.shared.heat.lock(|heat| heat.io.set_chip(celsius));
        REPORTS.report(Reporter::Supervisor);
    }

    // Polls one temperature sensor chip. Same priority as `slow`, because both share a bus: neither
    // interrupts the other. At worst a chip is found reset and set up, four frames of up to 9 bytes: half a
    // millisecond.
    #[task(binds = LPTIM3, priority = 1, shared = [slow, heat])]
    fn sensors(mut cx: sensors::Context) {
        let read = cx.shared.slow.lock(|slow| slow.sensors.poll(time::now()));
        if let Some((controller, reading)) = read {
            cx.shared.heat.lock(|heat| heat.io.set_reading(controller, reading));
        }
    }

    // Frames have come, or there is room for more: the executor looks.
    #[task(binds = ETH, priority = 1)]
    fn frames(_: frames::Context) {
        bsp_prime::ethernet::on_interrupt();
        network::note_event();
        executor::wake();
    }

    /// The executor's locks.
    struct ExecutorLocks<'a>(PhantomData<&'a ()>);

    impl<'a> ports::Locks for ExecutorLocks<'a> {
        type Motion = shared_resources::motion_that_needs_to_be_locked<'a>;
        type Heat = shared_resources::heat_that_needs_to_be_locked<'a>;
        type Slow = shared_resources::slow_that_needs_to_be_locked<'a>;
        type Triggers = shared_resources::triggers_that_needs_to_be_locked<'a>;
        type Card = shared_resources::card_that_needs_to_be_locked<'a>;
    }

    // Runs consoles and executor.
    #[idle(local = [owned, flash], shared = [motion, heat, slow, triggers, card])]
    fn idle(cx: idle::Context) -> ! {
        bsp_prime::memory::paint_main_stack();
        let idle::SharedResources { motion, heat, slow, triggers, card, .. } = cx.shared;
        let shared = ports::Shared::<ExecutorLocks<'_>> { motion, heat, slow, triggers };
        let wake_planner = || rtic::pend(PLANNER);
        let owned = cx.local.owned;
        // The flash is present, as only this code takes it.
        let Some(flash) = cx.local.flash.take() else { fault::reset_as_asked() };
        let updates = update::start(flash);
        // Made in place on the thread stack, as the ports are large.
        executor::run(|| BoardPorts::<ExecutorLocks<'_>>::new(owned, updates, card, shared, wake_planner))
    }
}

//! The second image for the Smoothieboard v2 Prime: the board as a micro-controller of a Klipper host. Thin
//! tasks around `klipper`, which holds the protocol and all objects that the host configures.
//!
//! Priorities, high to low, with each task's deadline:
//!
//! | | task | woken by | deadline |
//! |--:|---|---|---|
//! | 8 | `step` | TIM2 compare | 250 ns after the event's tick |
//! | 7 | `supply_falls` | PVD: the chip's 3.3 V | none: it ends the firmware, outputs off first |
//! | 6 | `uart_bytes` | USART2 | 16 characters of the line |
//! | 6 | `usb_packets` | OTG_FS | none: until then the host waits |
//! | 5 | `timers` | TIM6, at the next timer; idle | the clock of what the host has scheduled |
//! | 5 | `watch` | TIM7, 20 Hz | 0.9 s: the watchdog |
//! | 4 | `lights_sent` | DMA2, stream 0 | none: it ends a transmission to a strip of lights |
//! | 0 | `idle` | bytes, and `timers` | none: blocks of the host, buses, answers |
#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "interrupt placement and fault handlers need it")]

mod analog;
mod board;
#[path = "../../firmware/src/fault.rs"]
mod fault;
mod lines;
#[path = "../../firmware/src/manifest.rs"]
mod manifest;
mod pwm;
mod rescue;
mod service;
mod update;
mod usb;
mod wake;

// No task is `async`: see the image `firmware`.
#[rtic::app(device = stm32h7xx_hal::pac, peripherals = true)]
mod app {
    use core::mem::MaybeUninit;

    use bsp_prime::time::{self, Ticker};
    use bsp_prime::uart::{Frame, UartInterrupt};
    use bsp_prime::watchdog::Watchdog;
    use bsp_prime::{Board, rtt, step_engine};
    use klipper::{Controller, Moves};
    use units::Ticks;

    use crate::board::PrimeBoard;
    use crate::lines::{FROM_UART, Lines};
    use crate::service::Service;
    use crate::update::Updates;
    use crate::{fault, rescue, usb, wake};

    /// Rate of the serial port, as Klipper's hosts have it.
    const BAUD: u32 = 250_000;
    /// Longest time between two runs of the timers, and time between two looks at the watchdog.
    const PERIOD_US: u32 = 50_000;

    #[shared]
    struct Shared {
        controller: &'static mut Controller<PrimeBoard>,
    }

    #[local]
    struct Local {
        tick: Ticker,
        watch_tick: Ticker,
        watchdog: Watchdog,
        uart: UartInterrupt,
        device: Option<&'static mut usb::Device>,
        service: Service,
    }

    /// Makes the controller at its place, so that no copy of it is on the stack of `init`.
    #[inline(never)]
    fn made(
        place: &'static mut MaybeUninit<Controller<PrimeBoard>>,
        board: PrimeBoard,
        moves: &'static mut Moves,
    ) -> &'static mut Controller<PrimeBoard> {
        place.write(Controller::new(board, moves, step_engine::queue()))
    }

    #[init(local = [
        controller: MaybeUninit<Controller<PrimeBoard>> = MaybeUninit::uninit(),
        // All zero, as the section is; DTCM is for what interrupts touch all the time.
        #[unsafe(link_section = ".axizero")]
        moves: Moves = Moves::new(),
        place: usb::Place = usb::Place::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = match Board::take(cx.core, cx.device) {
            Ok(board) => board,
            Err(error) => fault::board_failed(error),
        };
        // RTT is started only here, or by a board that did not come up.
        let Some(ends) = rtt::start() else { fault::reset_as_asked() };
        bsp_prime::log::start(ends.log);
        let identity = &board.identity;
        let reset_cause = defmt::Display2Format(&identity.reset_cause);
        defmt::info!(
            "velvet controller {=str}, board id {=u8}, reset: {}",
            env!("VELVET_VERSION"),
            identity.board,
            reset_cause
        );
        if let Some(words) = &identity.last_words {
            defmt::warn!("the run before ended: {=str}", words.as_str());
        }
        let device = match usb::connect(cx.local.place, board.usb, identity.unique_id) {
            Ok(device) => Some(device),
            Err(why) => {
                defmt::error!("USB: {=str}", why);
                None
            }
        };
        let (uart, mut port) = board.debug;
        port.open(BAUD, Frame::PLAIN);
        let (mut tick, mut watch_tick) = (board.feed_tick, board.heat_tick);
        tick.start(PERIOD_US);
        watch_tick.start(PERIOD_US);
        let analog = (board.thermistors, board.supplies);
        let prime = PrimeBoard::new(board.pins, board.guards, board.spi, analog, (board.pwm, board.led_sender));
        let controller = made(cx.local.controller, prime, cx.local.moves);
        let service = Service::new(Lines::new(port), Updates::new(board.flash, board.sd, board.identity.reset_cause));
        (Shared { controller }, Local { tick, watch_tick, watchdog: board.watchdog, uart, device, service })
    }

    #[task(binds = PVD_PVM, priority = 7)]
    fn supply_falls(_: supply_falls::Context) {
        fault::supply_falls();
    }

    #[task(binds = USART2, priority = 6, local = [uart])]
    fn uart_bytes(cx: uart_bytes::Context) {
        cx.local.uart.on_interrupt(|byte| {
            // A full ring counts what it loses, and the host sends it again.
            let _taken = FROM_UART.push(byte);
        });
        wake::wake();
    }

    // Handles an event of the bus and a few packets; anything left interrupts again.
    #[task(binds = OTG_FS, priority = 6, local = [device])]
    fn usb_packets(cx: usb_packets::Context) {
        if let Some(device) = cx.local.device {
            usb::on_interrupt(device);
        }
    }

    // Runs what the host has scheduled, and keeps steps written ahead.
    #[task(binds = TIM6_DAC, priority = 5, shared = [controller], local = [tick])]
    fn timers(mut cx: timers::Context) {
        cx.local.tick.acknowledge();
        let (wait, has_news) = cx.shared.controller.lock(|controller| (controller.run(), controller.has_news()));
        cx.local.tick.next_in(Ticks(u64::from(wait)));
        wake::note_run(has_news);
    }

    // The colours of a strip of lights are sent, and its timer must stop.
    #[task(binds = DMA2_STR0, priority = 4)]
    fn lights_sent(_: lights_sent::Context) {
        bsp_prime::led_strip::on_interrupt();
    }

    // Feeds the watchdog if both idle and the timers have run.
    #[task(binds = TIM7, priority = 5, local = [watch_tick, watchdog])]
    fn watch(cx: watch::Context) {
        cx.local.watch_tick.acknowledge();
        time::keep_clocks();
        if wake::all_have_run(rescue::is_looking()) {
            cx.local.watchdog.feed();
        }
        wake::wake();
    }

    // Executes blocks of the host and does the work on buses.
    #[idle(local = [service], shared = [controller])]
    fn idle(cx: idle::Context) -> ! {
        bsp_prime::memory::paint_main_stack();
        cx.local.service.run(cx.shared.controller)
    }
}

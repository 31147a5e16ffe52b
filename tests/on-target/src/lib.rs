//! Shared parts of the test images: the report of a failure, and the interrupts that let waits sleep.
#![no_std]

use core::cell::RefCell;
use core::panic::PanicInfo;

use bsp_prime::board::{Board, enable_interrupt, make_outputs_safe};
use bsp_prime::pac::{self, Interrupt, interrupt};
use bsp_prime::time::Ticker;
use critical_section::Mutex;
use motion::Latch;

/// Latch into which watched inputs report.
pub static LATCH: Latch = Latch::new();
static TICK: Mutex<RefCell<Option<Ticker>>> = Mutex::new(RefCell::new(None));

/// Parts of the board that remain for a test once its interrupts are placed.
pub struct Bench {
    /// Pins of the board, without those of the heat tick.
    pub pins: &'static mut bsp_prime::pins::Pins,
    /// Enable outputs, all off.
    pub guards: bsp_prime::board::Guards,
    /// The motor drivers' bus.
    pub spi: bsp_prime::spi::SpiBuses,
    /// Scan of the thermistor inputs.
    pub thermistors: bsp_prime::adc::Thermistors,
    /// Measurement of the supply voltages.
    pub supplies: bsp_prime::adc::Supplies,
    /// Driver of the SD card.
    pub sd: bsp_prime::sd::SdCard,
    /// Identity of the board.
    pub identity: bsp_prime::identity::Identity,
    /// Hardware PWM, not started.
    pub pwm: bsp_prime::pwm::Pwm,
    /// The Ethernet controller, not started.
    pub ethernet: bsp_prime::ethernet::Parts,
    /// Clock of date and time.
    pub rtc: bsp_prime::rtc::Rtc,
    /// Watchdog, which long tests must feed.
    pub watchdog: bsp_prime::watchdog::Watchdog,
}

/// Brings the board up with a tick of a millisecond and the card's interrupt.
pub fn bench() -> Bench {
    let (Some(core), Some(device)) = (cortex_m::Peripherals::take(), pac::Peripherals::take()) else {
        defmt::panic!("the peripherals are taken once");
    };
    let board = match Board::take(core, device) {
        Ok(board) => board,
        Err(error) => {
            start_log();
            defmt::panic!("the board does not come up: {}", defmt::Debug2Format(&error))
        }
    };
    start_log();
    let mut tick = board.heat_tick;
    tick.start(1_000);
    critical_section::with(|cs| {
        TICK.borrow(cs).replace(Some(tick));
    });
    for interrupt in [Interrupt::TIM7, Interrupt::SDMMC1, Interrupt::EXTI0, Interrupt::EXTI9_5] {
        enable_interrupt(interrupt);
    }
    Bench {
        pins: board.pins,
        guards: board.guards,
        spi: board.spi,
        thermistors: board.thermistors,
        supplies: board.supplies,
        sd: board.sd,
        identity: board.identity,
        pwm: board.pwm,
        ethernet: board.ethernet,
        rtc: board.rtc,
        watchdog: board.watchdog,
    }
}

fn start_log() {
    if let Some(ends) = bsp_prime::rtt::start() {
        bsp_prime::log::start(ends.log);
    }
}

/// Sleeps for at least this long.
pub fn sleep_ms(milliseconds: u64) {
    let end = bsp_prime::time::now().millis() + milliseconds;
    while bsp_prime::time::now().millis() < end {
        cortex_m::asm::wfi();
    }
}

#[interrupt]
fn TIM7() {
    critical_section::with(|cs| {
        bsp_prime::time::keep_clocks();
        if let Some(tick) = TICK.borrow(cs).borrow_mut().as_mut() {
            tick.acknowledge();
        }
    });
}

#[interrupt]
fn EXTI0() {
    bsp_prime::trigger::on_interrupt(|input, tick| LATCH.report(input, tick, bsp_prime::step_engine::queue()));
}

#[interrupt]
fn EXTI9_5() {
    bsp_prime::trigger::on_interrupt(|input, tick| LATCH.report(input, tick, bsp_prime::step_engine::queue()));
}

#[interrupt]
fn SDMMC1() {
    bsp_prime::sd::on_interrupt();
}

/// Reports a failed test; the run then ends with an error status.
#[panic_handler]
fn failed(info: &PanicInfo) -> ! {
    make_outputs_safe();
    defmt::error!("{}", defmt::Display2Format(info));
    semihosting::process::exit(1)
}

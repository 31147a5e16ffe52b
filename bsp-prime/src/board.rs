//! The board as a struct of roles, and the order in which it comes up.

use stm32h7xx_hal::pac;

use crate::adc::{Supplies, Thermistors};
use crate::clocks::{self, ClockError};
use crate::ethernet;
use crate::flash::BoardFlash;
use crate::identity::{self, Identity};
use crate::kept;
use crate::laser;
use crate::last_words;
use crate::led_strip::LedSender;
use crate::memory::{self, FlashUse};
use crate::pins::{self, Output, PinSpec, Pins, table};
use crate::pwm::Pwm;
use crate::random::RandomWords;
use crate::rtc::{self, Rtc};
use crate::sd::SdCard;
use crate::silicon;
use crate::spi::SpiBuses;
use crate::step_engine;
use crate::supply;
use crate::time::{self, Ticker};
use crate::uart::{self, PortName, UartInterrupt, UartPort};
use crate::usb::UsbSocket;
use crate::watchdog::Watchdog;

/// Longest time between two feedings, which come ten times a second: a pin that nobody controls any more
/// may be on for so long.
const WATCHDOG_LIMIT_MS: u32 = 900;
/// Rate of the debug console.
pub(crate) const DEBUG_BAUD: u32 = 115_200;

/// Failure to bring up the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardError {
    /// Failure of the crystal or the clock tree.
    Clock(ClockError),
}

/// Outputs that guard all others.
#[derive(Debug)]
pub struct Guards {
    /// Enables the four motor drivers.
    pub motors: Output,
    /// Enables the MOSFET and relay buffer.
    pub fets: Output,
    /// Switches the supply of hot ends and fans. The bed's cannot be switched.
    pub fets_power: Output,
}

/// The board, by roles.
pub struct Board {
    /// Board, chip and cause of the reset.
    pub identity: Identity,
    /// Pins without one fixed use.
    pub pins: &'static mut Pins,
    /// Enables of drivers and power outputs, all off.
    pub guards: Guards,
    /// LED1 to LED4, off.
    pub leds: [Output; 4],
    /// The mass-storage LED, off.
    pub msc_led: Output,
    /// The step feed's tick, not started.
    pub feed_tick: Ticker,
    /// Heat control's tick, not started.
    pub heat_tick: Ticker,
    /// The debug console, open.
    pub debug: (UartInterrupt, UartPort),
    /// Serial port UART 0, closed.
    pub uart0: (UartInterrupt, UartPort),
    /// Serial port UART 1, closed.
    pub uart1: (UartInterrupt, UartPort),
    /// SPI1, and SPI4 of the motor drivers.
    pub spi: SpiBuses,
    /// The thermistor scan, not started.
    pub thermistors: Thermistors,
    /// Hardware PWM, not started.
    pub pwm: Pwm,
    /// Sender to strips of lights, none of which has been added yet.
    pub led_sender: LedSender,
    /// Supply voltages, not started.
    pub supplies: Supplies,
    /// The SD card, not identified, for calls that wait or as a service.
    pub sd: SdCard,
    /// The USB socket, not started.
    pub usb: UsbSocket,
    /// The Ethernet controller, not started.
    pub ethernet: ethernet::Parts,
    /// The chip's random numbers.
    pub random: RandomWords,
    /// Clock of date and time.
    pub rtc: Rtc,
    /// The flash, for the log of updates and copies of the image.
    pub flash: BoardFlash,
    /// Watchdog, running since the first microseconds; to be fed.
    pub watchdog: Watchdog,
}

/// Every output of the board to off, whatever state the chip is in. The first thing at start and the first
/// thing in any disaster.
///
/// The motors are released too: a crashed firmware cannot hold them in a known way.
pub fn make_outputs_safe() {
    // The beam first: of all outputs it is the quickest to do harm.
    laser::force_off();
    pins::enable_ports();
    let guards = [table::MOTORS_ENABLE, table::FETS_ENABLE, table::FETS_POWER_ENABLE, table::USB_HOST_POWER];
    for spec in guards.into_iter().chain(table::MOSFETS).chain(table::RELAYS) {
        let _stays_off = Output::off(spec);
    }
}

/// Lets an interrupt through, for images without RTIC (which does this itself): its handler must exist.
pub fn enable_interrupt(interrupt: pac::Interrupt) {
    // SAFETY: no code of this package relies on an interrupt being masked in the NVIC.
    unsafe { cortex_m::peripheral::NVIC::unmask(interrupt) };
}

/// All zero, as the section is. Static, because `Board` itself is moved about.
#[unsafe(link_section = ".axizero")]
static mut PINS: Pins = Pins::new();

impl Board {
    /// Brings the board up.
    ///
    /// # Errors
    /// [`BoardError`]; outputs are off and the watchdog runs then.
    pub fn take(mut core: cortex_m::Peripherals, device: pac::Peripherals) -> Result<Self, BoardError> {
        make_outputs_safe();
        let watchdog = Watchdog::start(device.IWDG1, WATCHDOG_LIMIT_MS);
        // Every bounded wait counts core cycles.
        core.DCB.enable_trace();
        cortex_m::peripheral::DWT::unlock();
        core.DWT.enable_cycle_counter();
        silicon::prepare(&device.RCC);
        memory::prepare(&mut core.SCB, &mut core.MPU, &mut core.CPUID, FlashUse::Application);
        let is_open = rtc::open_backup_domain(&device.PWR, &device.RCC);
        let reset = identity::take_reset(&device.RCC);
        kept::prepare(reset.lost_memory);
        clocks::start_crystal(&device.RCC).map_err(BoardError::Clock)?;
        let rtc = Rtc::start(device.RTC, &device.RCC, is_open);
        let last_words = last_words::take();
        clocks::freeze(device.PWR, device.RCC, &device.SYSCFG).map_err(BoardError::Clock)?;
        clocks::watch_crystal();
        clocks::enable_peripherals();
        supply::watch();
        memory::prepare_d2();
        silicon::compensate_outputs();
        time::start();
        let pins = &raw mut PINS;
        // SAFETY: the peripherals exist once, so this comes here once, and nothing else names the table.
        let pins = unsafe { &mut *pins };
        let guards = claim_guards(pins);
        step_engine::start(device.TIM2, &mut core.NVIC);
        let mut debug = uart::port(PortName::Debug);
        debug.1.open(DEBUG_BAUD, uart::Frame::PLAIN);
        Ok(Self {
            identity: Identity::read(reset.cause, last_words),
            pins,
            guards,
            leds: table::LEDS.map(|led| Output::off(PinSpec::plain(led))),
            msc_led: Output::off(PinSpec::plain(table::MSC_LED)),
            feed_tick: Ticker::feed(device.TIM6),
            heat_tick: Ticker::heat(device.TIM7),
            debug,
            uart0: uart::port(PortName::Uart0),
            uart1: uart::port(PortName::Uart1),
            spi: SpiBuses::new(device.SPI1, device.SPI4),
            thermistors: Thermistors::new(device.ADC1, &device.ADC12_COMMON, device.DMA1),
            supplies: Supplies::new(device.ADC3, &device.ADC3_COMMON),
            pwm: Pwm::new(device.TIM1, device.TIM8),
            led_sender: LedSender::new(device.DMA2),
            sd: SdCard::new(device.SDMMC1),
            usb: UsbSocket::new(device.OTG2_HS_GLOBAL, device.OTG2_HS_DEVICE, device.OTG2_HS_PWRCLK),
            ethernet: ethernet::Parts::new(device.ETHERNET_MAC, device.ETHERNET_MTL, device.ETHERNET_DMA),
            random: RandomWords::new(device.RNG),
            rtc,
            flash: BoardFlash::new(device.FLASH, &mut core.SCB),
            watchdog,
        })
    }
}

/// Claims the guards for the board; a configuration that names one of their pins gets an error.
fn claim_guards(pins: &mut Pins) -> Guards {
    let mut guard = |spec: PinSpec, owner| {
        // The table is empty and the pins differ, so the claim cannot fail.
        let _claimed = pins.claim(spec.pin, owner);
        Output::off(spec)
    };
    Guards {
        motors: guard(table::MOTORS_ENABLE, "the board's motors_enable"),
        fets: guard(table::FETS_ENABLE, "the board's fets_enable"),
        fets_power: guard(table::FETS_POWER_ENABLE, "the board's fets_power_enable"),
    }
}

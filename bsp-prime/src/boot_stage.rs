//! The board as far as the boot stage needs it, and the hand-over of the chip to the application.

use cortex_m::peripheral::{NVIC, SCB};
use stm32h7xx_hal::pac;

use crate::board::{DEBUG_BAUD, make_outputs_safe};
use crate::boot_request;
use crate::clocks::{self, ClockError};
use crate::flash::BoardFlash;
use crate::identity::{self, Cause};
use crate::memory::{self, FlashUse};
use crate::pins::{Output, PinSpec, table};
use crate::rtc;
use crate::sd::SdCard;
use crate::silicon;
use crate::time::{self, Ticker};
use crate::uart::{self, PortName, UartInterrupt, UartPort};
use crate::usb::UsbSocket;
use crate::watchdog::Watchdog;

/// Longest time between two feedings. Erasing a sector takes up to 4 s (data sheet DS12923, "flash memory
/// programming"), the wait for a silent card a second and a half.
const WATCHDOG_LIMIT_MS: u32 = 10_000;

/// The board as set up by the boot stage: only the parts that install an image are on.
pub struct BootStage {
    /// Flash: all sectors but the first.
    pub flash: BoardFlash,
    /// LED1 to LED4, off.
    pub leds: [Output; 4],
    /// The debug console, open.
    pub debug: (UartInterrupt, UartPort),
    /// The SD card, not identified.
    pub sd: SdCard,
    /// The USB socket, not started, and the chip's unique id.
    pub usb: (UsbSocket, [u32; 3]),
    /// Timer that ends waits, not started.
    pub tick: Ticker,
    /// Running watchdog; the application finds it so and sets it up anew.
    pub watchdog: Watchdog,
    /// Cause of the chip's reset.
    pub reset_cause: Cause,
    /// Whether the application, or a person by the button, asks for firmware over USB.
    pub download: bool,
    /// Means of releasing the chip to the application.
    pub hand_over: HandOver,
}

impl BootStage {
    /// Brings up the parts needed. The causes of the reset and the last words are left to the application.
    ///
    /// # Errors
    /// The clocks do not come up; outputs are off and the watchdog runs then.
    pub fn take(mut core: cortex_m::Peripherals, device: pac::Peripherals) -> Result<Self, Crippled> {
        make_outputs_safe();
        let watchdog = Watchdog::start(device.IWDG1, WATCHDOG_LIMIT_MS);
        core.DCB.enable_trace();
        cortex_m::peripheral::DWT::unlock();
        core.DWT.enable_cycle_counter();
        silicon::prepare(&device.RCC);
        memory::prepare(&mut core.SCB, &mut core.MPU, &mut core.CPUID, FlashUse::BootStage);
        rtc::open_backup_domain(&device.PWR, &device.RCC);
        let reset_cause = identity::hand_on_reset(&device.RCC).cause;
        let download = boot_request::take(reset_cause);
        if let Err(why) = clocks::start_crystal(&device.RCC) {
            return Err(Crippled::new(why, watchdog));
        }
        if let Err(why) = clocks::freeze(device.PWR, device.RCC, &device.SYSCFG) {
            return Err(Crippled::new(why, watchdog));
        }
        clocks::enable_peripherals();
        time::start();
        let mut debug = uart::port(PortName::Debug);
        debug.1.open(DEBUG_BAUD, uart::Frame::PLAIN);
        Ok(Self {
            flash: BoardFlash::new(device.FLASH, &mut core.SCB),
            leds: table::LEDS.map(|led| Output::off(PinSpec::plain(led))),
            debug,
            sd: SdCard::new(device.SDMMC1),
            usb: (
                UsbSocket::new(device.OTG2_HS_GLOBAL, device.OTG2_HS_DEVICE, device.OTG2_HS_PWRCLK),
                identity::unique_id(),
            ),
            tick: Ticker::heat(device.TIM7),
            watchdog,
            reset_cause,
            download,
            hand_over: HandOver { core },
        })
    }
}

/// Board whose clock tree failed: the core runs at the clock of a reset.
pub struct Crippled {
    /// Failure of the clocks.
    pub why: ClockError,
    /// LED1 to LED4, off.
    pub leds: [Output; 4],
    /// Running watchdog, to be fed.
    pub watchdog: Watchdog,
}

/// The clock of core and buses after a reset, HSI (RM0399 section 9.5.2), in MHz.
const RESET_MHZ: u32 = 64;
/// Baud rate to ask of [`uart::UartPort::open`], which assumes a bus of 100 MHz, for 115200 baud on this bus.
const DEBUG_BAUD_AT_RESET: u32 = DEBUG_BAUD * (clocks::PCLK_HZ / 1_000_000) / RESET_MHZ;

impl Crippled {
    fn new(why: ClockError, watchdog: Watchdog) -> Self {
        clocks::enable_peripherals();
        let (_, mut debug) = uart::port(PortName::Debug);
        debug.open(DEBUG_BAUD_AT_RESET, uart::Frame::PLAIN);
        Self { why, leds: table::LEDS.map(|led| Output::off(PinSpec::plain(led))), watchdog }
    }

    /// Prints a text on the debug console, and waits until it is out. Nothing else runs meanwhile.
    pub fn say(&mut self, words: &str) {
        uart::say_at_once(PortName::Debug, words.as_bytes());
    }

    /// Waits about so many milliseconds, feeding the watchdog.
    pub fn pause(&mut self, milliseconds: u32) {
        self.watchdog.feed();
        cortex_m::asm::delay(milliseconds * RESET_MHZ * 1_000);
    }
}

/// Control of the core, to be given up at the start of an image.
pub struct HandOver {
    core: cortex_m::Peripherals,
}

impl HandOver {
    /// Starts the image whose vector table is at this address, with the chip as a reset leaves it, but for
    /// these: the watchdog runs, the outputs that [`make_outputs_safe`] names are held off, the supply is
    /// chosen, the regulator gives what the full clock needs, and the cycle counter counts. Memory holds
    /// what it holds.
    ///
    /// The table must be that of an image that has been verified.
    pub fn start(self, table: u32) -> ! {
        let mut core = self.core;
        cortex_m::interrupt::disable();
        clocks::release();
        core.SYST.disable_counter();
        core.SYST.disable_interrupt();
        forget_interrupts(&core.NVIC);
        // The stack is in DTCM, which no cache covers.
        core.SCB.disable_dcache(&mut core.CPUID);
        core.SCB.disable_icache();
        // SAFETY: interrupts are off and pending ones forgotten; nothing of this image's memory regions is
        // used any more. ARMv7-M ARM B3.5.5, B3.2.4 (PENDSVCLR, PENDSTCLR), B3.2.8 (STKALIGN as after a
        // reset).
        unsafe {
            core.MPU.ctrl.write(0);
            core.SCB.icsr.write(1 << 27 | 1 << 25);
            core.SCB.ccr.write(1 << 9);
            core.SCB.vtor.write(table);
        }
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        // SAFETY: the first two words of a vector table are the stack's top and the entry (B1.5.5). CONTROL
        // is what it is after a reset, main stack and no floating-point state, before the stack moves;
        // PRIMASK as well. Nothing returns.
        unsafe {
            let stack = (table as *const u32).read_volatile();
            let entry = (table as *const u32).add(1).read_volatile();
            core::arch::asm!(
                "msr control, {zero}",
                "isb",
                "msr msp, {stack}",
                "cpsie i",
                "bx {entry}",
                stack = in(reg) stack,
                entry = in(reg) entry,
                zero = in(reg) 0,
                options(noreturn)
            )
        }
    }
}

/// No interrupt is enabled or pending afterwards.
fn forget_interrupts(nvic: &NVIC) {
    for (enabled, pending) in nvic.icer.iter().zip(&nvic.icpr) {
        // SAFETY: ones disable and forget; whoever handles them is gone.
        unsafe {
            enabled.write(u32::MAX);
            pending.write(u32::MAX);
        }
    }
}

/// Resets the chip, so that the boot stage begins again.
pub fn reset() -> ! {
    SCB::sys_reset()
}

//! Identity of the board and cause of its start: unique id, silicon revision, driver chips by the identity
//! resistors, cause of the last reset.

pub use events::Cause;
use stm32h7xx_hal::pac;

use crate::boot_request;
use crate::last_words::Text;
use crate::pins::{self, Input, Mode, PinSpec, Pull, table};
use crate::silicon;

/// Type of the motor drivers fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorChips {
    /// TMC2590, identity 0; also assumed for any unknown identity.
    Tmc2590,
    /// TMC2660, identity 1 of the resistors.
    Tmc2660,
}

/// Identity of the board and cause of its start.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// The chip's 96-bit unique id, as three words.
    pub unique_id: [u32; 3],
    /// Device id (0x450) and silicon revision (0x2003 = V).
    pub device: (u16, u16),
    /// The four identity resistors as a number.
    pub board: u8,
    /// Motor drivers that the board number stands for.
    pub chips: MotorChips,
    /// Cause of the last reset.
    pub reset_cause: Cause,
    /// Message of a firmware that ended itself, if that was the cause.
    pub last_words: Option<Text>,
    /// The option bytes wrongly start the Cortex-M4 as well.
    pub second_core_starts: bool,
}

/// Base of the unique id (RM0399 section 64.1).
const UNIQUE_ID: *const u32 = 0x1FF1_E800 as *const u32;

/// Cause of the reset and its effect on memory, read once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reset {
    pub cause: Cause,
    /// The supply was gone, and with it what was in memory. After a mere sag, memory has kept its contents:
    /// the core's supply falls later than the brown-out's threshold.
    pub lost_memory: bool,
}

/// RCC_RSR (RM0399 section 9.7.39).
mod flag {
    pub const BROWN_OUT: u32 = 1 << 21;
    pub const PIN: u32 = 1 << 22;
    pub const POWER_ON: u32 = 1 << 23;
    pub const SOFTWARE: u32 = 1 << 24;
    pub const WATCHDOG: u32 = 1 << 26;
    pub const WINDOW_WATCHDOG: u32 = 1 << 28;
}

/// Reads the cause and clears the flags, so that the next reset shows its own. The boot stage has done so
/// already, and left them.
pub(crate) fn take_reset(rcc: &pac::RCC) -> Reset {
    let left = boot_request::take_flags();
    reset(left.unwrap_or_else(|| take_flags(rcc)))
}

/// Reads the cause of the reset for the boot stage, which leaves the flags to the application: after another
/// reset before the application has cleared them, the button could not be told from power-on.
pub(crate) fn hand_on_reset(rcc: &pac::RCC) -> Reset {
    let flags = take_flags(rcc);
    boot_request::leave_flags(flags);
    reset(flags)
}

fn take_flags(rcc: &pac::RCC) -> u32 {
    let flags = rcc.rsr.read().bits();
    rcc.rsr.modify(|_, w| w.rmvf().set_bit());
    flags
}

fn reset(flags: u32) -> Reset {
    // A watchdog or software reset also raises PINRSTF, a power-on BORRSTF: most telling first.
    let causes = [
        (flag::WATCHDOG | flag::WINDOW_WATCHDOG, Cause::Watchdog),
        (flag::SOFTWARE, Cause::Software),
        (flag::POWER_ON, Cause::PowerOn),
        (flag::BROWN_OUT, Cause::BrownOut),
        (flag::PIN, Cause::Pin),
    ];
    let cause = causes.into_iter().find(|(flag, _)| flags & flag != 0).map_or(Cause::Unknown, |(_, cause)| cause);
    Reset { cause, lost_memory: flags & flag::POWER_ON != 0 }
}

/// The chip's unique id.
pub(crate) fn unique_id() -> [u32; 3] {
    // SAFETY: three words of read-only memory that every chip of the family has.
    unsafe { [0, 1, 2].map(|word| UNIQUE_ID.add(word).read_volatile()) }
}

/// Returns the address of the network interface: of those that anybody may give away (locally administered,
/// for one station), the one that the chip's unique id leads to. The id's words have few bits that differ
/// from chip to chip, letters and small numbers, so all of them go into each byte (FNV-1a).
#[must_use]
pub fn mac_address(unique_id: [u32; 3]) -> [u8; 6] {
    let bytes = unique_id.into_iter().flat_map(u32::to_le_bytes);
    let hash =
        bytes.fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3));
    // The upper 16 bits folded into the lower 48, as its authors do.
    let [a, b, c, d, e, f, g, h] = hash.to_le_bytes();
    [(a ^ g) & 0xFC | 0x02, b ^ h, c, d, e, f]
}

impl Identity {
    /// Returns the address of the network interface.
    #[must_use]
    pub fn mac_address(&self) -> [u8; 6] {
        mac_address(self.unique_id)
    }

    pub(crate) fn read(reset_cause: Cause, last_words: Option<Text>) -> Self {
        let unique_id = unique_id();
        // SAFETY: read-only register.
        let code = unsafe { (*pac::DBGMCU::ptr()).idc.read().bits() };
        let board = read_identity_resistors();
        let chips = if board == 1 { MotorChips::Tmc2660 } else { MotorChips::Tmc2590 };
        Self {
            unique_id,
            device: ((code & 0xFFF) as u16, (code >> 16) as u16),
            board,
            chips,
            reset_cause,
            last_words,
            second_core_starts: silicon::second_core_starts(),
        }
    }
}

/// Reads the identity resistors: a resistor to ground is a one. The pins are released afterwards.
fn read_identity_resistors() -> u8 {
    let mut id = 0;
    for pin in table::BOARD_ID {
        let input = Input::new(PinSpec::inverted(pin));
        // The pull-up charges some 10 pF through 40 kOhm: 0.4 us.
        crate::wait::pause(5);
        id = (id << 1) | u8::from(input.is_on());
        pins::configure(pin, Mode::Analog, Pull::Floating, false);
    }
    id
}

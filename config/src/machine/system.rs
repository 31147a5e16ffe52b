//! The board and the program itself: `[general]`, `[system]`, consoles, kill button, player.

use units::{Micros, Volts};

use super::Command;
use crate::pin::Pin;

/// Which board the image runs on; decides the default driver chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoardId {
    /// Prime with TMC2590 drivers (board id 0, and any unknown id).
    #[default]
    Prime2590,
    /// Prime with TMC2660 drivers (board id 1).
    Prime2660,
}

impl BoardId {
    /// From the four identity pins.
    #[must_use]
    pub const fn from_id(id: u8) -> Self {
        if id == 1 { Self::Prime2660 } else { Self::Prime2590 }
    }
}

/// `[general]`
#[derive(Clone, Copy, Debug, Default)]
pub struct General {
    /// Replies and G4/G28/G30/M30 meanings in the GRBL style.
    pub grbl_mode: bool,
    /// Reports have the extensions of grblHAL (with `grbl_mode`).
    pub grblhal: bool,
    /// Replay the saved settings at the end of boot.
    pub config_override: bool,
    /// What consoles speak without `grbl_mode`.
    pub dialect: PrinterDialect,
}

/// What is spoken to a printer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PrinterDialect {
    /// Smoothieware's.
    #[default]
    Smoothie,
    /// Marlin's.
    Marlin,
    /// RepRapFirmware's.
    RepRapFirmware,
    /// Klipper's.
    Klipper,
}

/// `[drillingcycles]`
#[derive(Clone, Copy, Debug, Default)]
pub struct CyclesConfig {
    /// Canned cycles are understood.
    pub enable: bool,
    /// P of a cycle is in milliseconds, not in seconds.
    pub dwell_in_ms: bool,
}

/// `[system]` and `[consoles]`
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemConfig {
    /// Step pulse length of external drivers, microseconds.
    pub step_pulse_us: u32,
    /// Highest step rate an actuator may ask for, steps per second.
    pub step_frequency_hz: u32,
    /// Mirror of board LED 2.
    pub aux_play_led: Option<Pin>,
    /// Flash `/sd/flashme.bin` at boot.
    pub flash_on_boot: bool,
    /// Offer USB DFU.
    pub dfu_enable: bool,
    /// Allow the SD card to be exported over USB.
    pub msc_enable: bool,
    /// LED of USB mass storage.
    pub msc_led: Option<Pin>,
    /// Enable of the MOSFET buffer; always an open-drain output.
    pub fets_enable_pin: Option<Pin>,
    /// Switches the supply of the MOSFET outputs.
    pub fets_power_enable_pin: Option<Pin>,
    /// Below this a supply falls while the machine works; none: below three quarters of what it usually has.
    pub brown_out_volts: Option<Volts>,
    /// A second USB serial port.
    pub second_usb_serial_enable: bool,
}

/// `[update]`
#[derive(Clone, Copy, Debug, Default)]
pub struct UpdateConfig {
    /// The owner's Ed25519 public key.
    pub key: Option<[u8; 32]>,
    /// What was written for it is no key.
    pub key_is_flawed: bool,
    /// Only firmware that is signed with the key.
    pub locked: bool,
}

impl UpdateConfig {
    /// Whether it says who may, and not something that nobody can mean.
    #[must_use]
    pub const fn is_sound(&self) -> bool {
        !self.key_is_flawed && (self.key.is_some() || !self.locked)
    }

    /// Takes the key as 64 hexadecimal digits; nothing for no key.
    pub(crate) fn set_key(&mut self, text: &str) {
        let digit = |byte: u8| char::from(byte).to_digit(16).map(|digit| digit as u8);
        let mut key = [0; 32];
        let mut is_good = text.len() == 2 * key.len();
        for (place, pair) in key.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
            match pair {
                [high, low] => match (digit(*high), digit(*low)) {
                    (Some(high), Some(low)) => *place = high << 4 | low,
                    _ => is_good = false,
                },
                _ => is_good = false,
            }
        }
        self.key = is_good.then_some(key);
        self.key_is_flawed = !is_good && !text.is_empty();
    }
}

/// Parity of the auxiliary UART.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Parity {
    #[default]
    None,
    Odd,
    Even,
}

/// `[uart console]`
#[derive(Clone, Copy, Debug, Default)]
pub struct UartConfig {
    /// Whether the port is used at all.
    pub enable: bool,
    /// A console, rather than output only.
    pub console: bool,
    /// 0: USART3 (PB11, PD8); 1: UART4 (PH14, PB9).
    pub channel: u8,
    /// Bits per second.
    pub baudrate: u32,
    /// Word length, 7 to 9, parity bit included.
    pub bits: u8,
    /// 1 or 2.
    pub stop_bits: u8,
    /// Parity.
    pub parity: Parity,
}

/// `[kill button]`
#[derive(Clone, Copy, Debug, Default)]
pub struct KillButton {
    /// Whether there is one.
    pub enable: bool,
    /// The input; pressed is low.
    pub pin: Option<Pin>,
    /// A latching emergency stop: release may clear the halt.
    pub toggle: bool,
    /// Whether the button may clear a halt.
    pub unkill: bool,
}

/// `[safety door]`
#[derive(Clone, Copy, Debug, Default)]
pub struct SafetyDoor {
    /// Whether there is one.
    pub enable: bool,
    /// The input; open is high.
    pub pin: Option<Pin>,
}

/// `[player]`
#[derive(Clone, Debug, Default)]
pub struct PlayerConfig {
    /// File played once after boot.
    pub on_boot_gcode: Command,
    /// Whether to play it.
    pub on_boot_gcode_enable: bool,
    /// Keep heaters on while suspended.
    pub leave_heaters_on_suspend: bool,
    /// Line executed once suspended; empty for none.
    pub after_suspend_gcode: Command,
    /// Line executed before resuming; empty for none.
    pub before_resume_gcode: Command,
    /// Line executed before the first line of a job; empty for none.
    pub before_job_gcode: Command,
    /// Line executed behind the last one.
    pub after_job_gcode: Command,
    /// Line executed once a job has been aborted and the machine stands.
    pub after_abort_gcode: Command,
    /// The next file of the queue begins by itself.
    pub queue_auto: bool,
    /// What files are written in.
    pub dialect: FileDialect,
    /// What a look ahead at the file of a job is for.
    pub preflight: JobPreflight,
    /// How long a job waits for [`JobPreflight::Travel`].
    pub preflight_wait: Micros,
    /// A job pauses at a code that levels the bed where nothing can.
    pub unleveled_pauses: bool,
    /// Going on after a power cut.
    pub power_loss: PowerLossConfig,
}

/// What a look ahead at the file of a job is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JobPreflight {
    /// There is none.
    Off,
    /// How much time is left.
    Time,
    /// That, and the job pauses before a line that was found to stop it.
    Warn,
    /// The file is looked at first for a while, and not begun when it leaves the travel; what is found later
    /// is as with [`Self::Warn`].
    #[default]
    Travel,
    /// The whole file is looked at first, and not begun when something stops it.
    Refuse,
}

/// `[player] power_loss_...`
#[derive(Clone, Debug, Default)]
pub struct PowerLossConfig {
    /// A journal of jobs is kept.
    pub enable: bool,
    /// Time between entries.
    pub period: Micros,
    /// Below this supply of the motors the job is noted at once; 0: never.
    pub motor_volts: f32,
    /// How far Z is lifted first, mm.
    pub lift: f64,
    /// How far Z sinks without current, mm.
    pub sag: f64,
    /// Line executed before going back to the part.
    pub gcode: Command,
}

/// `[tool change]`
#[derive(Clone, Debug, Default)]
pub struct ToolChangeConfig {
    /// Line executed before the tool is changed; empty for none.
    pub before_gcode: Command,
    /// The operator is asked to change it.
    pub prompt: bool,
    /// Line executed once it has been changed; empty for none.
    pub after_gcode: Command,
}

/// What files are written in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileDialect {
    /// What they say of themselves; else what the machine's consoles speak.
    #[default]
    Auto,
    /// Smoothieware's.
    Smoothie,
    /// Marlin's.
    Marlin,
    /// RepRapFirmware's.
    RepRapFirmware,
    /// Klipper's.
    Klipper,
    /// GRBL's.
    Grbl,
}

//! The board and the program itself: `[general]`, `[system]`, consoles, kill button, player.

use units::{Micros, Volts};

use super::Command;
use crate::pin::Pin;

/// Kind of board the image runs on; decides the default driver chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoardId {
    /// Prime with TMC2590 drivers (board id 0, and any unknown id).
    #[default]
    Prime2590,
    /// Prime with TMC2660 drivers (board id 1).
    Prime2660,
}

impl BoardId {
    /// Returns the board for the number on its four identity pins.
    #[must_use]
    pub const fn from_id(id: u8) -> Self {
        if id == 1 { Self::Prime2660 } else { Self::Prime2590 }
    }
}

/// Section `[general]`: dialects and saved settings.
#[derive(Clone, Copy, Debug, Default)]
pub struct General {
    /// Whether replies and the meanings of G4/G28/G30/M30 follow GRBL.
    pub grbl_mode: bool,
    /// Whether reports have the extensions of grblHAL (with `grbl_mode`).
    pub grblhal: bool,
    /// Whether the saved settings are replayed at the end of boot.
    pub config_override: bool,
    /// Dialect of the consoles without `grbl_mode`.
    pub dialect: PrinterDialect,
}

/// G-code dialect of a printer's console.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PrinterDialect {
    /// Dialect of Smoothieware consoles.
    #[default]
    Smoothie,
    /// Dialect of Marlin consoles.
    Marlin,
    /// Dialect of RepRapFirmware consoles.
    RepRapFirmware,
    /// Dialect of Klipper consoles.
    Klipper,
}

/// Section `[drillingcycles]`: canned cycles.
#[derive(Clone, Copy, Debug, Default)]
pub struct CyclesConfig {
    /// Whether canned cycles are understood.
    pub enable: bool,
    /// Whether P of a cycle is in milliseconds instead of seconds.
    pub dwell_in_ms: bool,
}

/// Sections `[system]` and `[consoles]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemConfig {
    /// Step pulse length of external drivers, microseconds.
    pub step_pulse_us: u32,
    /// Highest step rate an actuator may ask for, steps per second.
    pub step_frequency_hz: u32,
    /// Output that mirrors board LED 2.
    pub aux_play_led: Option<Pin>,
    /// Whether `/sd/flashme.bin` is flashed at boot.
    pub flash_on_boot: bool,
    /// Whether USB DFU is offered.
    pub dfu_enable: bool,
    /// Whether the SD card may be exported over USB.
    pub msc_enable: bool,
    /// LED that shows USB mass storage.
    pub msc_led: Option<Pin>,
    /// Enable output of the MOSFET buffer; always an open-drain output.
    pub fets_enable_pin: Option<Pin>,
    /// Output that switches the supply of the MOSFET outputs.
    pub fets_power_enable_pin: Option<Pin>,
    /// Supply voltage below which a brown-out is detected while the machine works; 0: never; none: three
    /// quarters of the usual voltage.
    pub brown_out_volts: Option<Volts>,
    /// Whether there is a second USB serial port.
    pub second_usb_serial_enable: bool,
}

/// Section `[update]`: signed firmware.
#[derive(Clone, Copy, Debug, Default)]
pub struct UpdateConfig {
    /// The owner's Ed25519 public key.
    pub key: Option<[u8; 32]>,
    /// Whether the text written for `key` is no valid key.
    pub key_is_flawed: bool,
    /// Whether only firmware signed with the key is accepted.
    pub locked: bool,
}

impl UpdateConfig {
    /// Returns whether the section is consistent: the key is valid, and a lock has a key.
    #[must_use]
    pub const fn is_sound(&self) -> bool {
        !self.key_is_flawed && (self.key.is_some() || !self.locked)
    }

    /// Parses the key from 64 hexadecimal digits; an empty text means no key.
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

/// Section `[uart console]`: the auxiliary UART.
#[derive(Clone, Copy, Debug, Default)]
pub struct UartConfig {
    /// Whether the port is used at all.
    pub enable: bool,
    /// Whether the port is a console, rather than output only.
    pub console: bool,
    /// UART of the board; 0: USART3 (PB11, PD8); 1: UART4 (PH14, PB9).
    pub channel: u8,
    /// Baud rate, bits per second.
    pub baudrate: u32,
    /// Word length, 7 to 9, parity bit included.
    pub bits: u8,
    /// Number of stop bits, 1 or 2.
    pub stop_bits: u8,
    /// Parity of each character.
    pub parity: Parity,
}

/// Section `[kill button]`: the emergency stop.
#[derive(Clone, Copy, Debug, Default)]
pub struct KillButton {
    /// Whether there is a kill button.
    pub enable: bool,
    /// The input; pressed is low.
    pub pin: Option<Pin>,
    /// Whether the button is a latching emergency stop: release may clear the halt.
    pub toggle: bool,
    /// Whether the button may clear a halt.
    pub unkill: bool,
}

/// Section `[safety door]`: the door switch.
#[derive(Clone, Copy, Debug, Default)]
pub struct SafetyDoor {
    /// Whether there is a safety door.
    pub enable: bool,
    /// The input; open is high.
    pub pin: Option<Pin>,
}

/// Section `[player]`: jobs from files.
#[derive(Clone, Debug, Default)]
pub struct PlayerConfig {
    /// File played once after boot.
    pub on_boot_gcode: Command,
    /// Whether the file is played after boot.
    pub on_boot_gcode_enable: bool,
    /// Whether heaters stay on while suspended.
    pub leave_heaters_on_suspend: bool,
    /// Line executed once suspended; empty for none.
    pub after_suspend_gcode: Command,
    /// Line executed before resuming; empty for none.
    pub before_resume_gcode: Command,
    /// Line executed before the first line of a job; empty for none.
    pub before_job_gcode: Command,
    /// Line executed after the last line of a job; empty for none.
    pub after_job_gcode: Command,
    /// Line executed once a job has been aborted and the machine stands; empty for none.
    pub after_abort_gcode: Command,
    /// Whether the next file of the queue begins automatically.
    pub queue_auto: bool,
    /// Dialect of the G-code files.
    pub dialect: FileDialect,
    /// Use of the preflight check of a job's file.
    pub preflight: JobPreflight,
    /// Time for which a job waits for [`JobPreflight::Travel`].
    pub preflight_wait: Micros,
    /// Whether a job pauses at a leveling code on a machine that cannot level; otherwise the code is left
    /// out.
    pub unleveled_pauses: bool,
    /// Settings for resuming after a power cut.
    pub power_loss: PowerLossConfig,
}

/// Use of a preflight check, which reads the file of a job ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JobPreflight {
    /// Preflight check is off.
    Off,
    /// The check estimates the time left.
    Time,
    /// The check estimates the time left, and the job pauses before a line that was found to stop it.
    Warn,
    /// The file is checked for a while before the job, which does not begin when the file leaves the travel;
    /// later findings act as with [`Self::Warn`].
    #[default]
    Travel,
    /// The whole file is checked before the job, which does not begin when a line would stop it.
    Refuse,
}

/// Settings `power_loss_*` in `[player]`.
#[derive(Clone, Debug, Default)]
pub struct PowerLossConfig {
    /// Whether a journal of jobs is kept.
    pub enable: bool,
    /// Time between entries of the journal.
    pub period: Micros,
    /// Motor supply voltage below which the job's place is stored at once; 0: never.
    pub motor_volts: f32,
    /// Height by which Z is lifted before resuming, mm.
    pub lift: f64,
    /// Distance by which Z sinks without motor current, mm.
    pub sag: f64,
    /// Line executed before the tool returns to the part.
    pub gcode: Command,
}

/// Section `[tool change]`: scripts and prompt.
#[derive(Clone, Debug, Default)]
pub struct ToolChangeConfig {
    /// Line executed before the tool is changed; empty for none.
    pub before_gcode: Command,
    /// Whether the operator is asked to change the tool.
    pub prompt: bool,
    /// Line executed once the tool has been changed; empty for none.
    pub after_gcode: Command,
}

/// Dialect of G-code files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileDialect {
    /// Dialect named in the file itself; otherwise that of the consoles.
    #[default]
    Auto,
    /// Dialect of Smoothieware files.
    Smoothie,
    /// Dialect of Marlin files.
    Marlin,
    /// Dialect of RepRapFirmware files.
    RepRapFirmware,
    /// Dialect of Klipper files.
    Klipper,
    /// Dialect of GRBL files.
    Grbl,
}

//! Reports of board and firmware: M115, `version`, `mem`.

use core::fmt;

use base::ports::{Arrival, Board, FailedBy, Running, Updates};
use base::sessions::Reply;
use config::MachineConfig;
use program::Dialect;
use units::Micros;

/// Capabilities that M115 declares to hosts, with Marlin's names.
const CAPABILITIES: [&str; 9] = [
    "EEPROM",
    "AUTOREPORT_TEMP",
    "AUTOREPORT_SD_STATUS",
    "EMERGENCY_PARSER",
    "HOST_ACTION_COMMANDS",
    "SDCARD",
    "SD_WRITE",
    "THERMAL_PROTECTION",
    "ARCS",
];

/// Answers M115 with firmware and capabilities.
pub fn firmware(board: &impl Board, config: &MachineConfig, dialect: Dialect, reply: &mut Reply<'_>) {
    let board = board.board();
    let axes = config.actuators().count();
    let grbl = u8::from(dialect == Dialect::Grbl);
    reply.say(format_args!(
        "FIRMWARE_NAME:Velvet, FIRMWARE_VERSION:{}, PROTOCOL_VERSION:1.0, X-FIRMWARE_BUILD_DATE:{}, X-SYSTEM_CLOCK:{}MHz, \
         X-AXES:{axes}, X-PAXIS:3, X-GRBL_MODE:{grbl}, X-ARCS:1\n",
        board.version, board.build_date, board.core_mhz
    ));
    if dialect == Dialect::Grbl {
        return;
    }
    CAPABILITIES.iter().for_each(|name| reply.say(format_args!("Cap:{name}:1\n")));
    let has_probe = u8::from(config.probe.enable);
    reply.say(format_args!("Cap:Z_PROBE:{has_probe}\nCap:AUTOLEVEL:{has_probe}\nCap:PROMPT_SUPPORT:0\n"));
}

/// Reports firmware and board (`version`).
pub fn version(board: &mut (impl Board + Updates), config: &MachineConfig, reply: &mut Reply<'_>) {
    let running = board.running();
    let board = board.board();
    let axes = config.actuators().count();
    reply.say(format_args!(
        "{} on Prime. board_id: {:02X}\nBuild version: {}, Build date: {}, System Clock: {}MHz\r\n{axes} axis, 3 primary axis\n",
        board.mcu, board.board_id, board.version, board.build_date, board.core_mhz
    ));
    reply.say(format_args!("Firmware: {}\n", Came(&running)));
}

/// Text of how the firmware came to run.
pub struct Came<'r>(pub &'r Running);

impl fmt::Display for Came<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.arrival {
            Arrival::Known => f.write_str("runs as before"),
            Arrival::Probe => f.write_str("put there by a debug probe or the chip's own loader"),
            Arrival::Trial { by_usb, start, of } => {
                let from = if by_usb { "over USB" } else { "from the card" };
                write!(f, "new firmware, {from}: start {start} of {of}, it stays when it has run for 10 s")
            }
            Arrival::FellBack(by) => {
                write!(f, "the previous firmware is back, because the new one did not run for 10 s: {}", failure(by))
            }
        }
    }
}

/// Returns the reason why new firmware failed.
pub const fn failure(by: FailedBy) -> &'static str {
    match by {
        FailedBy::Watchdog => "the watchdog reset the board",
        FailedBy::Itself => "it ended itself",
        FailedBy::Early => "it was reset, or the power went",
    }
}

/// `mem`: reports memory use; `config_took` is the time in which the configuration was read.
pub fn memory(board: &impl Board, config_took: Micros, reply: &mut Reply<'_>) {
    let memory = board.memory();
    reply.say(format_args!("static: {} bytes\n", memory.static_bytes));
    if let Some(bytes) = memory.stack_unused_bytes {
        reply.say(format_args!("stack never used: {bytes} bytes\n"));
    }
    if let Some(bytes) = memory.interrupt_stack_unused_bytes {
        reply.say(format_args!("stack of interrupts never used: {bytes} bytes\n"));
    }
    let (millis, bytes) = (config_took.0 as f64 / 1_000.0, config::READING_BYTES);
    reply.say(format_args!("configuration: read in {millis:.2} ms within {bytes} bytes\n"));
}

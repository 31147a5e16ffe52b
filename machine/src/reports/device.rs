//! What board and firmware this is: M115, `version`, `mem`.

use config::MachineConfig;
use program::Dialect;
use units::Micros;

use crate::ports::Board;
use crate::sessions::Reply;

/// M115.
pub(crate) fn firmware(board: &impl Board, config: &MachineConfig, dialect: Dialect, reply: &mut Reply<'_>) {
    let board = board.board();
    let axes = config.actuators().count();
    let grbl = u8::from(dialect == Dialect::Grbl);
    reply.say(format_args!(
        "FIRMWARE_NAME:Velvet, FIRMWARE_VERSION:{}, PROTOCOL_VERSION:1.0, X-FIRMWARE_BUILD_DATE:{}, X-SYSTEM_CLOCK:{}MHz, \
         X-AXES:{axes}, X-PAXIS:3, X-GRBL_MODE:{grbl}, X-ARCS:1\n",
        board.version, board.build_date, board.core_mhz
    ));
}

/// `version`
pub(crate) fn version(board: &impl Board, config: &MachineConfig, reply: &mut Reply<'_>) {
    let board = board.board();
    let axes = config.actuators().count();
    reply.say(format_args!(
        "{} on Prime. board_id: {:02X}\nBuild version: {}, Build date: {}, System Clock: {}MHz\r\n{axes} axis, 3 primary axis\n",
        board.mcu, board.board_id, board.version, board.build_date, board.core_mhz
    ));
}

/// `mem`; `config_took` is how long reading the configuration took.
pub(crate) fn memory(board: &impl Board, config_took: Micros, reply: &mut Reply<'_>) {
    let memory = board.memory();
    reply.say(format_args!("static: {} bytes\n", memory.static_bytes));
    if let Some(bytes) = memory.stack_unused_bytes {
        reply.say(format_args!("stack never used: {bytes} bytes\n"));
    }
    let (millis, bytes) = (config_took.0 as f64 / 1_000.0, config::READING_BYTES);
    reply.say(format_args!("configuration: read in {millis:.2} ms within {bytes} bytes\n"));
}

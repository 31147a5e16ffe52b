//! Check of SPI clock polarity and phase, which the emulated SPI ignores and real chips need.

use board_facts::wiring;
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::generated::spi1;
use sim::models::converter::Kind;
use sim::world::{DriverConfig, OutsidePort};

use crate::board::PrimeBoard;
use crate::pins::pin;

/// Control register 1 of SPI1 and SPI4, with the emulator's names and the channels of configurations.
const BUSES: [(u64, &str, u8); 2] = [(0x4001_3000, "SPI1", 0), (0x4001_3400, "SPI4", 1)];
/// Bit CSTART, set while a frame is on its way (RM0399 section 53.11.1).
const CSTART: u64 = 1 << 9;

/// Whether the external driver is on this bus with its chip select low.
fn is_selected(board: &PrimeBoard, driver: DriverConfig, channel: u8) -> bool {
    matches!(driver, DriverConfig::Outside { port: OutsidePort::Spi { channel: of, select: Some(select) }, .. }
        if of == channel && !board.level(select))
}

/// Returns the mistake in the frame that begins with a write to this address: the selected chip and the clock
/// mode it needs.
#[must_use]
pub fn wrong(board: &PrimeBoard, address: u64) -> Option<String> {
    let (_, name, channel) = BUSES.into_iter().find(|(control, _, _)| *control == address & !3)?;
    let file = board.mcu.bus().registers(name)?;
    if file.get(spi1::Register::Cr1) & CSTART == 0 {
        return None;
    }
    // CPOL is bit 25, CPHA bit 24: together the mode's number.
    let mode = file.get(spi1::Register::Cfg2) >> 24 & 3;
    let is_driver = channel == 1 && wiring::DRIVERS.iter().any(|driver| !board.level(pin(driver.select)));
    let (who, needs): (&str, &[u64]) = if is_driver {
        // TMC2590 data sheet, "SPI signals".
        ("the drivers", &[3])
    } else {
        let world = board.world().lock();
        let mut outside = world.config().actuators.iter().map(|entry| entry.driver);
        if outside.any(|driver| is_selected(board, driver, channel)) {
            // TMC2130, TMC5160 and TMC2240 data sheets, "SPI interface".
            return (mode != 3).then(|| format!("{name}: CPOL and CPHA make mode {mode}, a driver outside needs 3"));
        }
        let mut converters = world.config().heaters.iter().filter_map(|heater| heater.converter);
        match converters.find(|converter| converter.channel == channel && !board.level(converter.select))?.kind {
            // Data sheets: figure 1 of the MAX31855's; "Serial Interface" of the others.
            Kind::Max31855 => ("a MAX31855", &[0]),
            Kind::Max31856 { .. } => ("a MAX31856", &[1, 3]),
            Kind::Max31865 { .. } => ("a MAX31865", &[1, 3]),
        }
    };
    (!needs.contains(&mode)).then(|| format!("{name}: CPOL and CPHA make mode {mode}, {who} needs one of {needs:?}"))
}

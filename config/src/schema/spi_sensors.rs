//! `[temperature control]`: sensors behind a converter chip on SPI.

use super::build::{POSITIVE, integer, number, pin, word};
use super::heat::heater;
use super::{PinRole, Setting, Words};
use crate::machine::ThermocoupleType;
use crate::pin::PinName;
use units::Ohms;

const AVERAGING: [&str; 5] = ["1", "2", "4", "8", "16"];

pub const SPI_CHANNEL: Setting = integer(
    "spi_channel",
    "-1",
    &(-1, 1),
    heater!(|h, v| h.sensor.spi.channel = u8::try_from(v).ok()),
    "SPI bus of a max31855, max31856 or max31865: 0 is SPI1 (SCK PA5, MISO PA6, MOSI PB5), 1 is SPI4 (SCK PE12, MISO \
     PE5, MOSI PE6), which the motor drivers have as well. Any number of sensors may be on either.",
);
pub const SPI_SELECT_PIN: Setting = pin(
    "spi_select_pin",
    "nc",
    PinRole::Output,
    heater!(|h, v| h.sensor.spi.select_pin = v.and_then(PinName::digital)),
    "Chip select of a max31855, max31856 or max31865, one of its own for each. It is low to select, with or without a \
     `!`.",
);
pub const TC_TYPE: Setting = word(
    "tc_type",
    "K",
    &Words(&ThermocoupleType::WORDS),
    heater!(|h, v| h.sensor.spi.thermocouple = ThermocoupleType::ALL.get(v).copied().unwrap_or_default()),
    "Type of the thermocouple on a max31856. A max31855 is made for one type, which its name ends with.",
)
.klipper("[extruder] tc_type")
.velvet();
pub const TC_AVERAGING: Setting = word(
    "tc_averaging",
    "4",
    &Words(&AVERAGING),
    heater!(|h, v| h.sensor.spi.averaging = 1 << v),
    "So many readings of a max31855, or so many samples of a max31856, make one temperature. More is calmer and later: \
     the last readings of a max31855 come 0.1 s apart; each sample more of a max31856 takes 0.02 s.",
)
.klipper("[extruder] tc_averaging_count")
.velvet();
pub const MAINS_FREQUENCY: Setting = word(
    "mains_frequency",
    "50",
    &Words(&["50", "60"]),
    heater!(|h, v| h.sensor.spi.mains_60_hz = v == 1),
    "Frequency of the mains, which the filter of a max31856 or max31865 takes out.",
)
.klipper("[extruder] tc_use_50Hz_filter, rtd_use_50Hz_filter")
.unit("Hz")
.velvet();
pub const RTD_WIRES: Setting = word(
    "rtd_wires",
    "2",
    &Words(&["2", "3", "4"]),
    heater!(|h, v| h.sensor.spi.rtd_wires = v as u8 + 2),
    "Wires of the platinum sensor on a max31865, as the bridges on its board are soldered.",
)
.klipper("[extruder] rtd_num_of_wires")
.velvet();
pub const RTD_NOMINAL: Setting = number(
    "rtd_nominal",
    "100",
    POSITIVE,
    heater!(|h, v| h.sensor.spi.rtd_nominal = Ohms(v as f32)),
    "Resistance at 0 C of the platinum sensor on a max31865: 100 for a PT100, 1000 for a PT1000.",
)
.klipper("[extruder] rtd_nominal_r")
.unit("Ohm")
.velvet();
pub const RTD_REFERENCE: Setting = number(
    "rtd_reference",
    "430",
    POSITIVE,
    heater!(|h, v| h.sensor.spi.rtd_reference = Ohms(v as f32)),
    "Reference resistor on the board of a max31865: 430 on most for a PT100, 4300 on most for a PT1000.",
)
.klipper("[extruder] rtd_reference_r")
.unit("Ohm")
.velvet();

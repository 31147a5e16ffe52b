//! Makes the dictionary that a host fetches: a zlib stream of JSON (Klipper, `docs/Protocol.md`).
#![allow(dead_code, reason = "the table has functions for the board")]

use std::fmt::Write;
use std::path::PathBuf;

#[path = "src/numbers.rs"]
mod numbers;
#[path = "src/reason.rs"]
mod reason;
#[path = "src/table.rs"]
mod table;

use numbers::{ADC_MAX, CHIP_TEMPERATURE, CLOCK_HZ, I2C_STATUS, PAD_PA0_C, PWM_MAX, RECEIVE_WINDOW, STATS_SUMSQ_BASE};
use reason::Reason;
use table::{Command, Response};

fn object(pairs: impl IntoIterator<Item = (String, String)>) -> String {
    let members: Vec<_> = pairs.into_iter().map(|(name, value)| format!("\"{name}\":{value}")).collect();
    format!("{{{}}}", members.join(","))
}

fn text(words: &str) -> String {
    format!("\"{words}\"")
}

/// Pins by number: sixteen to a port, and what has no digital side.
fn pins() -> String {
    let ports = ('A'..='K').enumerate().map(|(index, port)| (format!("P{port}0"), format!("[{},16]", index * 16)));
    let others = [("PA0_C", PAD_PA0_C), ("ADC_TEMPERATURE", CHIP_TEMPERATURE)];
    object(ports.chain(others.map(|(name, number)| (name.to_owned(), number.to_string()))))
}

fn numbered(names: &[&str]) -> String {
    object(names.iter().enumerate().map(|(number, name)| ((*name).to_owned(), number.to_string())))
}

fn enumerations() -> String {
    let reasons = Reason::ALL.iter().map(|reason| (reason.text().to_owned(), reason.number().to_string()));
    object([
        ("pin".to_owned(), pins()),
        ("spi_bus".to_owned(), numbered(&["spi1", "spi4"])),
        ("i2c_bus_status".to_owned(), numbered(&I2C_STATUS)),
        ("static_string_id".to_owned(), object(reasons)),
    ])
}

/// Constants of the board. `SERIAL_BAUD` is missing on purpose: a host that sees it resets the board by DTR.
fn constants() -> String {
    let numbers = [
        ("CLOCK_FREQ", CLOCK_HZ),
        ("STATS_SUMSQ_BASE", STATS_SUMSQ_BASE),
        ("STEPPER_STEP_BOTH_EDGE", 1),
        ("ADC_MAX", u32::from(ADC_MAX)),
        ("PWM_MAX", u32::from(PWM_MAX)),
        ("RECEIVE_WINDOW", RECEIVE_WINDOW),
    ];
    // Pins that the board keeps for itself, and those of its buses: MISO, MOSI, clock.
    let texts = [
        ("MCU", "stm32h745xx"),
        ("BUS_PINS_spi1", "PA6,PB5,PA5"),
        ("BUS_PINS_spi4", "PE5,PE6,PE12"),
        ("RESERVE_PINS_USB", "PA10,PA11,PA12"),
        ("RESERVE_PINS_crystal", "PH0,PH1,PC14,PC15"),
        ("RESERVE_PINS_debug", "PA13,PA14,PB3,PD5,PD6"),
        ("RESERVE_PINS_outputs", "PF14,PD7"),
        ("RESERVE_PINS_card", "PG10,PC8,PC9,PC10,PC11,PC12,PD2"),
        ("RESERVE_PINS_Ethernet", "PA1,PA2,PA7,PG11,PC1,PC4,PC5,PG12,PG13"),
        ("RESERVE_PINS_USB_host", "PB13,PB14,PB15"),
        ("RESERVE_PINS_QSPI_flash", "PD11,PF9,PE2,PD13,PB6,PB2"),
    ];
    let numbers = numbers.map(|(name, value)| (name.to_owned(), value.to_string()));
    object(numbers.into_iter().chain(texts.map(|(name, value)| (name.to_owned(), text(value)))))
}

fn main() {
    for file in ["build.rs", "src/table.rs", "src/reason.rs", "src/numbers.rs"] {
        println!("cargo:rerun-if-changed={file}");
    }
    let commands = Command::ALL.iter().map(|command| (command.format().to_owned(), command.number().to_string()));
    let responses = Response::ALL.iter().map(|response| (response.format().to_owned(), response.number().to_string()));
    let json = object([
        ("app".to_owned(), text("Velvet")),
        ("version".to_owned(), text(concat!("velvet-", env!("CARGO_PKG_VERSION")))),
        ("build_versions".to_owned(), text("rust")),
        ("license".to_owned(), text("MIT OR Apache-2.0")),
        ("config".to_owned(), constants()),
        ("enumerations".to_owned(), enumerations()),
        ("commands".to_owned(), object(commands)),
        ("responses".to_owned(), object(responses)),
    ]);
    let packed = miniz_oxide::deflate::compress_to_vec_zlib(json.as_bytes(), 10);
    let mut code = String::new();
    let _ = writeln!(code, "/// Dictionary of {} bytes of JSON, as a zlib stream.", json.len());
    let _ = writeln!(code, "pub static DICTIONARY: [u8; {}] = {packed:?};", packed.len());
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    std::fs::write(out.join("dictionary.rs"), code).expect("OUT_DIR can be written");
}

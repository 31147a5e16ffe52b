//! Temperature sensors and the Ethernet transceiver by their datasheets, as pure functions and small state
//! machines. No pin in here, and no bus but one that is handed in: the caller reads the converter and hands
//! over the number, or hands over a device on a bus.
//!
//! ```
//! use drivers::thermistor::{AdcCode, Thermistor};
//!
//! let hotend = Thermistor::built_in("Semitec").ok_or("no such thermistor")?;
//! let reading = hotend.celsius(AdcCode(4_000)).map_err(|fault| fault.message())?;
//! assert!((200.0..250.0).contains(&reading.0));
//! # Ok::<(), &str>(())
//! ```
#![cfg_attr(not(test), no_std)]

pub mod lan8720;
pub mod max31855;
pub mod max31856;
pub mod max31865;
pub mod platinum;
pub mod thermistor;
pub mod voltage_sensor;

//! Requests of an enumeration, in their order.

use super::Found;
use crate::descriptors::{Configuration, DeviceDescriptor};
use crate::request::{self, Setup};

/// Length of a configuration descriptor's head.
const HEAD_BYTES: u16 = 9;
/// Length of a device descriptor.
const DEVICE_BYTES: u16 = 18;

/// Request to a device before it may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The first 8 bytes of the device descriptor, of which the last is the packet size of endpoint 0.
    Begin,
    /// SET_ADDRESS with the device's address.
    Address,
    /// The whole device descriptor.
    Device,
    /// The head of a configuration descriptor, by its index.
    Head(u8),
    /// The whole configuration descriptor, by its index.
    Whole(u8),
}

impl Question {
    /// Returns the SETUP packet of the request.
    pub fn setup(self, address: u8, reading: &Reading) -> Setup {
        let get = |kind, index, length| Setup {
            kind: request::DEVICE_IN,
            request: request::GET_DESCRIPTOR,
            value: u16::from_be_bytes([kind, index]),
            index: 0,
            length,
        };
        match self {
            Self::Begin => get(request::DEVICE, 0, 8),
            Self::Address => Setup {
                kind: request::DEVICE_OUT,
                request: request::SET_ADDRESS,
                value: u16::from(address),
                index: 0,
                length: 0,
            },
            Self::Device => get(request::DEVICE, 0, DEVICE_BYTES),
            Self::Head(index) => get(request::CONFIGURATION, index, HEAD_BYTES),
            Self::Whole(index) => get(request::CONFIGURATION, index, reading.total),
        }
    }
}

/// Descriptors read so far.
#[derive(Debug, Default)]
pub struct Reading {
    /// Descriptors of the device.
    pub found: Found,
    /// Total length of the configuration that is being read, wTotalLength.
    total: u16,
}

impl Reading {
    /// Takes an answer and returns the next question, if there is one.
    pub fn take(&mut self, question: Question, answer: &[u8]) -> Result<Option<Question>, String> {
        match question {
            Question::Begin | Question::Address => Ok(Some(Question::Device)),
            Question::Device => {
                self.found.device = DeviceDescriptor::parse(answer)?;
                self.next(0)
            }
            Question::Head(index) => {
                let &[_, _, low, high, ..] = answer else {
                    return Err(format!("a configuration descriptor of {} bytes", answer.len()));
                };
                self.total = u16::from_le_bytes([low, high]);
                Ok(Some(Question::Whole(index)))
            }
            Question::Whole(index) => {
                self.found.configurations.push(Configuration::parse(answer)?);
                self.next(index + 1)
            }
        }
    }

    fn next(&self, index: u8) -> Result<Option<Question>, String> {
        if self.found.device.configurations == 0 {
            return Err("it has no configuration".to_owned());
        }
        Ok((index < self.found.device.configurations).then_some(Question::Head(index)))
    }
}

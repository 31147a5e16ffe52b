//! The memory controller (RM0399 section 23): its registers are only stored; the board has no memory behind
//! its banks.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::fmc::Register;

/// The flexible memory controller.
#[derive(Debug, Default)]
pub struct Fmc;

impl Device for Fmc {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, _: &mut DeviceContext<'_>) -> Option<u64> {
        Some(file.get(register))
    }

    fn write(&mut self, _: Register, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn reset(&mut self) {}
}

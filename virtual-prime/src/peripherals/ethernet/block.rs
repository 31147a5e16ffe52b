//! Registers of one of the controller's blocks, as the part's table describes them.

use std::marker::PhantomData;

use rigless::soc::{Layout, RegisterSpec};

/// Values of a block's registers, by their rows in the table.
#[derive(Debug)]
pub(super) struct Block<R> {
    values: Vec<u32>,
    registers: PhantomData<R>,
}

impl<R: Layout> Default for Block<R> {
    fn default() -> Self {
        let values = R::REGISTERS.iter().map(|register| register.reset as u32).collect();
        Self { values, registers: PhantomData }
    }
}

impl<R: Layout> Block<R> {
    pub(super) fn get(&self, register: R) -> u32 {
        self.values[register.index()]
    }

    /// Sets a register as the hardware does.
    pub(super) fn set(&mut self, register: R, value: u32) {
        self.values[register.index()] = value;
    }

    pub(super) fn set_bits(&mut self, register: R, bits: u32) {
        self.values[register.index()] |= bits;
    }

    pub(super) fn clear_bits(&mut self, register: R, bits: u32) {
        self.values[register.index()] &= !bits;
    }

    /// Takes the register's value and leaves zero, as a read does that clears.
    pub(super) fn take(&mut self, register: R) -> u32 {
        std::mem::take(&mut self.values[register.index()])
    }

    /// Writes a register as firmware does: fields that are read-only keep their values, reserved bits stay 0.
    pub(super) fn write(&mut self, register: R, value: u32) {
        let mask = writable(register.spec());
        let kept = self.get(register) & !mask;
        self.set(register, kept | value & mask);
    }

    pub(super) fn reset(&mut self) {
        *self = Self::default();
    }
}

/// Returns the bits of a register that firmware can change. ST's file calls bit 27 of both masks of the MMC
/// read-only, which RM0399 (ETH_MMC_RX_INTERRUPT_MASK, ETH_MMC_TX_INTERRUPT_MASK) does not.
fn writable(register: &RegisterSpec) -> u32 {
    if !register.access.is_writable() {
        return 0;
    }
    let mask = |mask: u64| u32::try_from(mask).unwrap_or(u32::MAX);
    let every = |bits: u32, field: &rigless::soc::FieldSpec| bits | mask(field.mask());
    if matches!(register.name, "MMC_RX_INTERRUPT_MASK" | "MMC_TX_INTERRUPT_MASK") {
        return register.fields.iter().fold(0, every);
    }
    register.fields.iter().filter(|field| field.access.is_writable()).fold(0, every)
}

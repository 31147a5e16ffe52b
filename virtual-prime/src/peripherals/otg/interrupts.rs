//! The tree of interrupts, RM0399 section 60.13: causes of endpoints, OTG_DAINT, OTG_GINTSTS and the lines.

use super::core::Core;
use super::registers::*;

/// OTG_DAINT and OTG_DEACHINT: bits of OUT endpoints.
const OUT_SHIFT: u32 = 16;

impl Core {
    /// Returns OTG_DIEPINTx. TXFE follows the FIFO: empty, or half empty by OTG_GAHBCFG.TXFELVL.
    pub(super) fn in_causes(&self, number: usize) -> u32 {
        let endpoint = &self.ins[number];
        let fifo = endpoint.fifo();
        let (Some(span), Some(held)) = (self.span(fifo), self.tx.get(fifo).map(super::fifo::TransmitFifo::held)) else {
            return endpoint.causes;
        };
        let level = if self.gahbcfg & gahbcfg::TXFELVL != 0 { 0 } else { span.depth / 2 };
        endpoint.causes | if held <= level { epint::TXFE } else { 0 }
    }

    /// Returns OTG_DAINT: the endpoints with an unmasked cause. OTG_DIEPEMPMSK unmasks TXFE, endpoint by
    /// endpoint.
    pub(super) fn endpoint_interrupts(&self) -> u32 {
        let ins = (0..ENDPOINTS).filter(|&number| {
            let causes = self.in_causes(number);
            let empty = causes & epint::TXFE != 0 && self.diepempmsk >> number & 1 != 0;
            empty || causes & self.diepmsk & !epint::TXFE != 0
        });
        let outs = (0..ENDPOINTS).filter(|&number| self.outs[number].causes & self.doepmsk != 0);
        ins.fold(0, |bits, number| bits | 1 << number)
            | outs.fold(0, |bits, number| bits | 1 << (OUT_SHIFT + number as u32))
    }

    /// Returns OTG_GINTSTS as it reads.
    pub(super) fn core_interrupts(&self) -> u32 {
        let pending = self.endpoint_interrupts() & self.daintmsk;
        let live = [
            (gint::OTGINT, self.gotgint != 0),
            (gint::RXFLVL, !self.rx.is_empty()),
            (gint::GINAKEFF, self.global_in_nak),
            (gint::GONAKEFF, self.out_nak_effective),
            (gint::IEPINT, pending & 0xFFFF != 0),
            (gint::OEPINT, pending >> OUT_SHIFT != 0),
            // FIFOs of host mode, which are always empty.
            (gint::NPTXFE | gint::PTXFE, true),
        ];
        live.into_iter().filter(|&(_, set)| set).fold(self.latched, |bits, (bit, _)| bits | bit)
    }

    /// Returns OTG_DEACHINT: endpoint 1 has lines of its own for either direction.
    pub(super) fn each_interrupt(&self) -> u32 {
        let [ins, outs] = [DIEPEACHMSK1, DOEPEACHMSK1].map(|offset| self.kept(offset));
        let input = self.in_causes(1) & ins & !epint::TXFE != 0;
        let output = self.outs[1].causes & outs != 0;
        u32::from(input) << 1 | u32::from(output) << (OUT_SHIFT + 1)
    }

    /// Returns the levels of the core's lines, in the order of the part's table: endpoint 1 OUT (98),
    /// endpoint 1 IN (99), wake-up (100, by EXTI out of the Stop modes, which have no model) and the core's
    /// own (101).
    #[must_use]
    pub fn lines(&self) -> [bool; 4] {
        let each = self.each_interrupt() & self.deachintmsk;
        let open = self.gahbcfg & gahbcfg::GINT != 0;
        let core = self.core_interrupts() & self.gintmsk != 0;
        [open && each >> OUT_SHIFT != 0, open && each & 0xFFFF != 0, false, open && core]
    }
}

//! Offsets of the core's registers and names of their bits, RM0399 section 60.14.
//!
//! Offsets count from the core's base, 0x4008_0000 for the second core.

/// Number of endpoints of either direction, with endpoint 0.
pub const ENDPOINTS: usize = 9;

pub const GOTGCTL: u32 = 0x000;
pub const GOTGINT: u32 = 0x004;
pub const GAHBCFG: u32 = 0x008;
pub const GUSBCFG: u32 = 0x00C;
pub const GRSTCTL: u32 = 0x010;
pub const GINTSTS: u32 = 0x014;
pub const GINTMSK: u32 = 0x018;
pub const GRXSTSR: u32 = 0x01C;
pub const GRXSTSP: u32 = 0x020;
pub const GRXFSIZ: u32 = 0x024;
/// OTG_DIEPTXF0 in device mode.
pub const HNPTXFSIZ: u32 = 0x028;
pub const HNPTXSTS: u32 = 0x02C;
pub const GCCFG: u32 = 0x038;
pub const CID: u32 = 0x03C;
pub const GLPMCFG: u32 = 0x054;
pub const HPTXFSIZ: u32 = 0x100;
/// OTG_DIEPTXF1; the registers of the other FIFOs follow.
pub const DIEPTXF1: u32 = 0x104;
/// Registers for host mode, up to those for device mode.
pub const HOST: u32 = 0x400;
pub const DCFG: u32 = 0x800;
pub const DCTL: u32 = 0x804;
pub const DSTS: u32 = 0x808;
pub const DIEPMSK: u32 = 0x810;
pub const DOEPMSK: u32 = 0x814;
pub const DAINT: u32 = 0x818;
pub const DAINTMSK: u32 = 0x81C;
pub const DVBUSDIS: u32 = 0x828;
pub const DVBUSPULSE: u32 = 0x82C;
pub const DTHRCTL: u32 = 0x830;
pub const DIEPEMPMSK: u32 = 0x834;
pub const DEACHINT: u32 = 0x838;
pub const DEACHINTMSK: u32 = 0x83C;
pub const DIEPEACHMSK1: u32 = 0x844;
pub const DOEPEACHMSK1: u32 = 0x884;
/// Registers of IN endpoint 0; the next endpoint's are [`STRIDE`] further on.
pub const IN: u32 = 0x900;
/// Registers of OUT endpoint 0; the next endpoint's are [`STRIDE`] further on.
pub const OUT: u32 = 0xB00;
pub const STRIDE: u32 = 0x20;
/// Offsets within an endpoint's registers: DIEPCTLx or DOEPCTLx, and so on.
pub const CTL: u32 = 0x00;
pub const INT: u32 = 0x08;
pub const TSIZ: u32 = 0x10;
pub const DMA: u32 = 0x14;
pub const DTXFSTS: u32 = 0x18;
pub const PCGCCTL: u32 = 0xE00;
/// FIFO window of endpoint 0; every 4 KB another endpoint's follows, then the debug window on the whole RAM.
pub const FIFO: u32 = 0x1000;
pub const FIFO_STRIDE: u32 = 0x1000;
pub const FIFO_END: u32 = FIFO + FIFO_STRIDE * ENDPOINTS as u32;

/// Bits of register OTG_GOTGCTL.
pub mod gotgctl {
    pub const BVALOEN: u32 = 1 << 6;
    pub const BVALOVAL: u32 = 1 << 7;
    pub const CIDSTS: u32 = 1 << 16;
    pub const BSVLD: u32 = 1 << 19;
    /// Bits that the core alone writes.
    pub const READ_ONLY: u32 = 1 | 1 << 8 | CIDSTS | 1 << 17 | 1 << 18 | BSVLD | 1 << 21;
}

/// Bits of register OTG_GOTGINT.
pub mod gotgint {
    pub const SEDET: u32 = 1 << 2;
}

/// Bits of register OTG_GAHBCFG.
pub mod gahbcfg {
    pub const GINT: u32 = 1;
    pub const DMAEN: u32 = 1 << 5;
    pub const TXFELVL: u32 = 1 << 7;
}

/// Bits of register OTG_GUSBCFG.
pub mod gusbcfg {
    pub const PHYSEL: u32 = 1 << 6;
    pub const FHMOD: u32 = 1 << 29;
    /// The selection of the transceiver, which the core soft reset leaves: PHYSEL and the ULPI's bits.
    pub const KEPT: u32 = PHYSEL | 0b111 << 17 | 1 << 22;
}

/// Bits of register OTG_GRSTCTL.
pub mod grstctl {
    pub const CSRST: u32 = 1;
    pub const RXFFLSH: u32 = 1 << 4;
    pub const TXFFLSH: u32 = 1 << 5;
    pub const TXFNUM_SHIFT: u32 = 6;
    pub const TXFNUM: u32 = 0x1F << TXFNUM_SHIFT;
    /// Value of TXFNUM for every transmit FIFO.
    pub const ALL: u32 = 0x10;
    pub const AHBIDL: u32 = 1 << 31;
}

/// Bits of OTG_GINTSTS and OTG_GINTMSK.
pub mod gint {
    pub const OTGINT: u32 = 1 << 2;
    pub const SOF: u32 = 1 << 3;
    pub const RXFLVL: u32 = 1 << 4;
    pub const NPTXFE: u32 = 1 << 5;
    pub const GINAKEFF: u32 = 1 << 6;
    pub const GONAKEFF: u32 = 1 << 7;
    pub const ESUSP: u32 = 1 << 10;
    pub const USBSUSP: u32 = 1 << 11;
    pub const USBRST: u32 = 1 << 12;
    pub const ENUMDNE: u32 = 1 << 13;
    pub const IEPINT: u32 = 1 << 18;
    pub const OEPINT: u32 = 1 << 19;
    pub const RSTDET: u32 = 1 << 23;
    pub const PTXFE: u32 = 1 << 26;
    pub const CIDSCHG: u32 = 1 << 28;
    pub const SRQINT: u32 = 1 << 30;
    pub const WKUPINT: u32 = 1 << 31;
    /// Bits that are cleared by writing 1; the rest follow their causes.
    pub const LATCHED: u32 = 1 << 1
        | SOF
        | ESUSP
        | USBSUSP
        | USBRST
        | ENUMDNE
        | 0b11 << 14
        | 0b111 << 20
        | RSTDET
        | 1 << 27
        | CIDSCHG
        | 1 << 29
        | SRQINT
        | WKUPINT;
}

/// PKTSTS of an entry of the receive FIFO, and positions of the entry's fields: OTG_GRXSTSR.
pub mod rxsts {
    pub const GLOBAL_OUT_NAK: u32 = 0b0001;
    pub const OUT_DATA: u32 = 0b0010;
    pub const OUT_DONE: u32 = 0b0011;
    pub const SETUP_DONE: u32 = 0b0100;
    pub const SETUP_DATA: u32 = 0b0110;
    pub const BCNT_SHIFT: u32 = 4;
    pub const DPID_SHIFT: u32 = 15;
    pub const PKTSTS_SHIFT: u32 = 17;
    pub const FRMNUM_SHIFT: u32 = 21;
    /// Value of DPID for DATA1; for DATA0 it is 0.
    pub const DATA1: u32 = 0b10;
}

/// Bits of register OTG_GCCFG.
pub mod gccfg {
    /// Power of the transceiver: 1 is on, despite the bit's name.
    pub const PWRDWN: u32 = 1 << 16;
    pub const VBDEN: u32 = 1 << 21;
    /// Battery charger detection: DCDET, PDET, SDET and PS2DET are the core's.
    pub const READ_ONLY: u32 = 0xF;
}

/// Bits of register OTG_DCFG.
pub mod dcfg {
    pub const DSPD: u32 = 0b11;
    /// Value of DSPD for full speed by the internal transceiver.
    pub const FULL_SPEED: u32 = 0b11;
    pub const NZLSOHSK: u32 = 1 << 2;
    pub const DAD_SHIFT: u32 = 4;
    pub const DAD: u32 = 0x7F << DAD_SHIFT;
}

/// Bits of register OTG_DCTL.
pub mod dctl {
    pub const RWUSIG: u32 = 1;
    pub const SDIS: u32 = 1 << 1;
    pub const GINSTS: u32 = 1 << 2;
    pub const GONSTS: u32 = 1 << 3;
    pub const SGINAK: u32 = 1 << 7;
    pub const CGINAK: u32 = 1 << 8;
    pub const SGONAK: u32 = 1 << 9;
    pub const CGONAK: u32 = 1 << 10;
    /// Bits that only trigger actions and read zero.
    pub const ACTIONS: u32 = SGINAK | CGINAK | SGONAK | CGONAK;
}

/// Bits of register OTG_DSTS.
pub mod dsts {
    pub const SUSPSTS: u32 = 1;
    /// Value of ENUMSPD for full speed.
    pub const FULL_SPEED: u32 = 0b11 << 1;
    pub const FNSOF_SHIFT: u32 = 8;
    pub const FNSOF: u32 = 0x3FFF;
}

/// Bits of OTG_DIEPCTLx and OTG_DOEPCTLx.
pub mod epctl {
    pub const MPSIZ: u32 = 0x7FF;
    pub const USBAEP: u32 = 1 << 15;
    pub const DPID: u32 = 1 << 16;
    pub const NAKSTS: u32 = 1 << 17;
    pub const EPTYP_SHIFT: u32 = 18;
    pub const EPTYP: u32 = 0b11 << EPTYP_SHIFT;
    /// Value of EPTYP for an isochronous endpoint.
    pub const ISOCHRONOUS: u32 = 0b01;
    pub const STALL: u32 = 1 << 21;
    pub const TXFNUM_SHIFT: u32 = 22;
    pub const TXFNUM: u32 = 0xF << TXFNUM_SHIFT;
    pub const CNAK: u32 = 1 << 26;
    pub const SNAK: u32 = 1 << 27;
    pub const SD0PID: u32 = 1 << 28;
    pub const SD1PID: u32 = 1 << 29;
    pub const EPDIS: u32 = 1 << 30;
    pub const EPENA: u32 = 1 << 31;
}

/// Bits of OTG_DIEPINTx and OTG_DOEPINTx.
pub mod epint {
    pub const XFRC: u32 = 1;
    pub const EPDISD: u32 = 1 << 1;
    /// OUT: the SETUP stage is over.
    pub const STUP: u32 = 1 << 3;
    /// IN: a token came while the transmit FIFO was empty.
    pub const ITTXFE: u32 = 1 << 4;
    /// OUT: a token came while the endpoint was disabled.
    pub const OTEPDIS: u32 = 1 << 4;
    /// OUT: the host has gone on to the status stage of a control write.
    pub const STSPHSRX: u32 = 1 << 5;
    /// IN: NAK is in force.
    pub const INEPNE: u32 = 1 << 6;
    /// OUT: more SETUP packets than the core keeps, one after another.
    pub const B2BSTUP: u32 = 1 << 6;
    /// IN: the transmit FIFO is empty, or half empty.
    pub const TXFE: u32 = 1 << 7;
    /// OUT: more bytes than the endpoint takes.
    pub const BERR: u32 = 1 << 12;
    pub const NAK: u32 = 1 << 13;
}

/// Fields of OTG_DIEPTSIZx and OTG_DOEPTSIZx.
pub mod tsiz {
    pub const PKTCNT_SHIFT: u32 = 19;
    /// PKTCNT of endpoint 0 in the IN direction; the OUT direction has one bit.
    pub const PKTCNT0: u32 = 0b11;
    pub const PKTCNT: u32 = 0x3FF;
    pub const XFRSIZ0: u32 = 0x7F;
    pub const XFRSIZ: u32 = 0x7_FFFF;
    pub const STUPCNT_SHIFT: u32 = 29;
}

/// Bits of register OTG_PCGCCTL.
pub mod pcgcctl {
    pub const STPPCLK: u32 = 1;
    pub const WRITABLE: u32 = 0b11 | 1 << 5;
    /// The transceiver is suspended.
    pub const PHYSUSP: u32 = 1 << 4;
}

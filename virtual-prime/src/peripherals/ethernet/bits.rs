//! Bits of the controller's registers, RM0399 rev 4 sections 61.11.2 ("Ethernet DMA registers"), 61.11.3
//! ("Ethernet MTL registers") and 61.11.4 ("Ethernet MAC and MMC registers").

/// Register ETH_DMAMR.
pub(super) mod dmamr {
    /// Software reset.
    pub(in super::super) const SWR: u32 = 1;
}

/// Registers ETH_DMACSR and ETH_DMACIER, which have the same positions.
pub(super) mod status {
    pub(in super::super) const TI: u32 = 1;
    pub(in super::super) const TPS: u32 = 1 << 1;
    pub(in super::super) const TBU: u32 = 1 << 2;
    pub(in super::super) const RI: u32 = 1 << 6;
    pub(in super::super) const RBU: u32 = 1 << 7;
    pub(in super::super) const RPS: u32 = 1 << 8;
    pub(in super::super) const RWT: u32 = 1 << 9;
    pub(in super::super) const ETI: u32 = 1 << 10;
    pub(in super::super) const ERI: u32 = 1 << 11;
    pub(in super::super) const FBE: u32 = 1 << 12;
    pub(in super::super) const CDE: u32 = 1 << 13;
    pub(in super::super) const AIS: u32 = 1 << 14;
    pub(in super::super) const NIS: u32 = 1 << 15;
    /// Position of the transmit channel's error bits, and of the receive channel's.
    pub(in super::super) const TEB: u32 = 16;
    pub(in super::super) const REB: u32 = 19;
    /// Error bits: in a transfer of data, at a descriptor, in a read.
    pub(in super::super) const IN_DATA: u32 = 4;
    pub(in super::super) const AT_DESCRIPTOR: u32 = 2;
    pub(in super::super) const IN_READ: u32 = 1;
    /// Causes that NIS sums up, and AIS.
    pub(in super::super) const NORMAL: u32 = TI | TBU | RI | ERI;
    pub(in super::super) const ABNORMAL: u32 = TPS | RBU | RPS | RWT | ETI | FBE | CDE;
}

/// Registers ETH_DMACTXCR and ETH_DMACRXCR.
pub(super) mod channel {
    /// Start: ST, or SR.
    pub(in super::super) const START: u32 = 1;
    /// Operate on second packet, of the transmit channel.
    pub(in super::super) const OSF: u32 = 1 << 4;
    /// Packet flush, of the receive channel.
    pub(in super::super) const RPF: u32 = 1 << 31;
    /// Receive buffer size, whose last two bits read as zero.
    pub(in super::super) const RBSZ: u32 = 0x7FF8;
}

/// Register ETH_MACCR.
pub(super) mod maccr {
    pub(in super::super) const RE: u32 = 1;
    pub(in super::super) const TE: u32 = 1 << 1;
    pub(in super::super) const LM: u32 = 1 << 12;
    pub(in super::super) const DM: u32 = 1 << 13;
    pub(in super::super) const FES: u32 = 1 << 14;
    pub(in super::super) const JE: u32 = 1 << 16;
    pub(in super::super) const JD: u32 = 1 << 17;
    pub(in super::super) const WD: u32 = 1 << 19;
    pub(in super::super) const ACS: u32 = 1 << 20;
    pub(in super::super) const CST: u32 = 1 << 21;
    pub(in super::super) const IPC: u32 = 1 << 27;
}

/// Register ETH_MACPFR.
pub(super) mod macpfr {
    pub(in super::super) const PR: u32 = 1;
    pub(in super::super) const HUC: u32 = 1 << 1;
    pub(in super::super) const HMC: u32 = 1 << 2;
    pub(in super::super) const DAIF: u32 = 1 << 3;
    pub(in super::super) const PM: u32 = 1 << 4;
    pub(in super::super) const DBF: u32 = 1 << 5;
    pub(in super::super) const SAIF: u32 = 1 << 8;
    pub(in super::super) const SAF: u32 = 1 << 9;
    pub(in super::super) const HPF: u32 = 1 << 10;
    pub(in super::super) const RA: u32 = 1 << 31;
}

/// Registers ETH_MACAxHR.
pub(super) mod address {
    pub(in super::super) const AE: u32 = 1 << 31;
    /// Compares with source addresses.
    pub(in super::super) const SA: u32 = 1 << 30;
}

/// Registers ETH_MTLTXQOMR and ETH_MTLRXQOMR.
pub(super) mod queue {
    pub(in super::super) const FTQ: u32 = 1;
    pub(in super::super) const FUP: u32 = 1 << 3;
    pub(in super::super) const FEP: u32 = 1 << 4;
    pub(in super::super) const RSF: u32 = 1 << 5;
    pub(in super::super) const DIS_TCP_EF: u32 = 1 << 6;
}

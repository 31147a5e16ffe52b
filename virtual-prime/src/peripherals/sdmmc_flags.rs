//! The bits of SDMMC_STAR, RM0399 rev 4 section 58.10.14.

pub const CCRCFAIL: u64 = 1;
pub const DCRCFAIL: u64 = 1 << 1;
pub const CTIMEOUT: u64 = 1 << 2;
pub const DTIMEOUT: u64 = 1 << 3;
pub const TXUNDERR: u64 = 1 << 4;
pub const RXOVERR: u64 = 1 << 5;
pub const CMDREND: u64 = 1 << 6;
pub const CMDSENT: u64 = 1 << 7;
pub const DATAEND: u64 = 1 << 8;
pub const DABORT: u64 = 1 << 11;
pub const DPSMACT: u64 = 1 << 12;
pub const CPSMACT: u64 = 1 << 13;
pub const TXFIFOHE: u64 = 1 << 14;
pub const RXFIFOHF: u64 = 1 << 15;
pub const TXFIFOF: u64 = 1 << 16;
pub const RXFIFOF: u64 = 1 << 17;
pub const TXFIFOE: u64 = 1 << 18;
pub const RXFIFOE: u64 = 1 << 19;
pub const BUSYD0: u64 = 1 << 20;
pub const BUSYD0END: u64 = 1 << 21;
pub const IDMATE: u64 = 1 << 27;
pub const IDMABTC: u64 = 1 << 28;
/// Flags that SDMMC_ICR clears: all but the state flags.
pub const CLEARABLE: u64 = 0x1FE0_0FFF;

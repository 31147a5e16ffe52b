//! Workarounds for errors of the silicon, and the check of an option byte: all of it outside the HAL.

use stm32h7xx_hal::pac;

/// The first revision (X) whose AXI SRAM needs no help; Y is 0x1003, V 0x2003 (RM0399 section 63.5.8,
/// DBGMCU_IDC).
const REVISION_X: u32 = 0x2001;
/// FLASH_OPTSR_CUR.BCM4: the Cortex-M4 starts after reset (RM0399 section 4.9.8). The device crate gives this
/// bit no name.
const BCM4: u32 = 1 << 22;

/// Applies the workarounds. Call before anything reads the AXI SRAM or may speculate.
pub(crate) fn prepare(rcc: &pac::RCC) {
    serialise_axi_sram_reads();
    close_external_memory(rcc);
}

/// On revisions before X, two reads of the AXI SRAM under way at once may give wrong data (errata ES0445,
/// "Reading from AXI SRAM may lead to data read corruption"): one at a time then.
fn serialise_axi_sram_reads() {
    // SAFETY: a read-only register.
    let revision = unsafe { (*pac::DBGMCU::ptr()).idc.read().bits() } >> 16;
    if revision < REVISION_X {
        // RM0399 section 2.2.4, AXI_TARG7_FN_MOD: READ_ISS_OVERRIDE. Target 7 is the AXI SRAM.
        // SAFETY: nothing else touches the interconnect's settings.
        unsafe { (*pac::AXI::ptr()).targ7_fn_mod.modify(|_, w| w.read_iss_override().set_bit()) };
    }
}

/// Bank 1 of the memory controller is on after reset with nothing behind it. A speculative read of its
/// addresses would stall the core for up to 24 us, many steps long.
fn close_external_memory(rcc: &pac::RCC) {
    // RM0399 section 9.7.38, RCC_AHB3ENR: the controller's clock, for as long as the write takes.
    rcc.ahb3enr.modify(|_, w| w.fmcen().enabled());
    // RM0399 section 3.2: two cycles after the write before the first access; the read back is longer.
    let _settled = rcc.ahb3enr.read().bits();
    // RM0399 section 23.7.6, FMC_BCR1: MBKEN.
    // SAFETY: no code of ours uses the memory controller.
    unsafe { (*pac::FMC::ptr()).bcr1.modify(|_, w| w.mbken().clear_bit()) };
    cortex_m::asm::dsb();
    rcc.ahb3enr.modify(|_, w| w.fmcen().disabled());
}

/// Lets the I/O compensation cell match the drivers' edges to temperature and supply. Needs the clock of
/// SYSCFG. Nothing waits for it: pins work without, only with edges less even, and the cell takes over when
/// it is ready.
pub(crate) fn compensate_outputs() {
    // RM0399 section 9.7.2, RCC_CR: CSION, the cell's clock; section 13.3.7, SYSCFG_CCCSR: EN.
    // SAFETY: called once, by the board's start, after which nobody holds these two.
    unsafe {
        (*pac::RCC::ptr()).cr.modify(|_, w| w.csion().on());
        (*pac::SYSCFG::ptr()).cccsr.modify(|_, w| w.en().set_bit());
    }
}

/// Returns whether the option bytes start the second core. The second core would run whatever lies in flash
/// bank 2, into our peripherals and our memory.
pub(crate) fn second_core_starts() -> bool {
    // SAFETY: a read-only register.
    unsafe { (*pac::FLASH::ptr()).optsr_cur().read().bits() & BCM4 != 0 }
}

//! Brings the Ethernet controller as far up as its PHY: the software reset, with and without the PHY's clock,
//! then the management frames to the PHY and to an address where nobody is.
#![no_std]
#![no_main]

use core::fmt::Write;

use cortex_m::asm::delay;
use cortex_m_rt::entry;
use images::{Console, pac, pass, start_clocks, wait_for};

const MB: u32 = 1;
const WRITE: u32 = 1 << 2;
const READ: u32 = 3 << 2;
/// Clock range: MDC = HCLK / 102, for 150 to 250 MHz.
const RANGE: u32 = 4 << 8;
const SWR: u32 = 1;
/// Duration of a frame: 64 bits of 102 clocks of 200 MHz, in cycles of the core at 400 MHz.
const FRAME_CYCLES: u32 = 64 * 102 * 2;

struct Mac<'a>(&'a pac::Peripherals);

impl Mac<'_> {
    fn frame(&self, phy: u32, register: u32, operation: u32) {
        let mac = &self.0.ETHERNET_MAC;
        let start = cortex_m::peripheral::DWT::cycle_count();
        // SAFETY: RM0399 ETH_MACMDIOAR: PA, RDA, CR, GOC, MB.
        mac.macmdioar.write(|w| unsafe { w.bits(phy << 21 | register << 16 | RANGE | operation | MB) });
        wait_for("the frame", || mac.macmdioar.read().bits() & MB == 0);
        let took = cortex_m::peripheral::DWT::cycle_count().wrapping_sub(start);
        assert!((FRAME_CYCLES..FRAME_CYCLES + 400).contains(&took), "a frame took {took} cycles");
    }

    fn read(&self, phy: u32, register: u32) -> u32 {
        self.frame(phy, register, READ);
        self.0.ETHERNET_MAC.macmdiodr.read().bits() & 0xFFFF
    }

    fn write(&self, phy: u32, register: u32, value: u32) {
        // SAFETY: MD alone.
        self.0.ETHERNET_MAC.macmdiodr.write(|w| unsafe { w.bits(value) });
        self.frame(phy, register, WRITE);
    }
}

/// Connects PA1 (REF_CLK), PA2 (MDIO) and PC1 (MDC) to the MAC: alternate function 11.
fn connect(dp: &pac::Peripherals) {
    dp.RCC.ahb4enr.modify(|_, w| w.gpioaen().set_bit().gpiocen().set_bit());
    // SAFETY: AF11 in AFRL1 and AFRL2.
    dp.GPIOA.afrl.modify(|r, w| unsafe { w.bits(r.bits() & !0xFF0 | 0xBB0) });
    dp.GPIOC.afrl.modify(|r, w| unsafe { w.bits(r.bits() & !0xF0 | 0xB0) });
    dp.GPIOA.moder.modify(|_, w| w.moder1().alternate().moder2().alternate());
    dp.GPIOC.moder.modify(|_, w| w.moder1().alternate());
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    let mut core = cortex_m::Peripherals::take().unwrap();
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    start_clocks(&dp);
    let mut console = Console::new(&dp);
    dp.RCC.apb4enr.modify(|_, w| w.syscfgen().set_bit());
    // SAFETY: EPIS = 100, RMII.
    dp.SYSCFG.pmcr.modify(|r, w| unsafe { w.bits(r.bits() & !(7 << 21) | 4 << 21) });
    dp.RCC.ahb1enr.modify(|_, w| w.eth1macen().set_bit().eth1txen().set_bit().eth1rxen().set_bit());

    // The reset waits for the PHY's clock, and takes the MAC's registers along.
    let (mac, dma) = (&dp.ETHERNET_MAC, &dp.ETHERNET_DMA);
    mac.macecr.write(|w| unsafe { w.bits(0x1234) });
    assert_eq!(mac.macecr.read().bits(), 0x1234);
    dma.dmamr.write(|w| unsafe { w.bits(SWR) });
    delay(4_000_000);
    assert_eq!(dma.dmamr.read().bits() & SWR, SWR, "reset without a clock");
    connect(&dp);
    wait_for("the software reset", || dma.dmamr.read().bits() & SWR == 0);
    assert_eq!(mac.macecr.read().bits(), 0, "MACECR out of reset");
    let _ = writeln!(console, "reset");

    let mac = Mac(&dp);
    let _ = writeln!(console, "phy {:04x} {:04x}", mac.read(0, 2), mac.read(0, 3));
    assert_eq!(mac.read(1, 2), 0xFFFF, "nobody at address 1");
    mac.write(0, 4, 0x0061);
    assert_eq!(mac.read(0, 4), 0x0061);
    mac.write(1, 4, 0x01A1);
    assert_eq!(mac.read(0, 4), 0x0061);
    // Software reset of the PHY, which clears itself.
    mac.write(0, 0, 0x8000);
    assert_eq!((mac.read(0, 0), mac.read(0, 4)), (0x3000, 0x01E1));
    // Without a cable there are 100 and 10 Mbit/s, neither link nor a finished negotiation.
    let _ = writeln!(console, "status {:04x}", mac.read(0, 1));
    console.drain();
    pass()
}

//! Sets up the alpha driver over SPI4 and turns its motor by both edges of STEP until its switch closes,
//! which arrives as an EXTI pending bit.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use images::{pac, pass, start_clocks, wait_for};

/// Sends 24 bits in three bytes, mode 3. Returns the 20 bits of the reply.
fn frame(dp: &pac::Peripherals, word: u32) -> u32 {
    dp.GPIOJ.bsrr.write(|w| w.br13().set_bit());
    let mut reply = 0;
    for shift in [16, 8, 0] {
        wait_for("TXP", || dp.SPI4.sr.read().txp().bit());
        // SAFETY: a byte access of the data register moves one byte, RM0399 section 53.5.
        unsafe { core::ptr::write_volatile(dp.SPI4.txdr.as_ptr().cast::<u8>(), (word >> shift) as u8) };
        wait_for("RXP", || dp.SPI4.sr.read().rxp().bit());
        // SAFETY: as above.
        reply = reply << 8 | u32::from(unsafe { core::ptr::read_volatile(dp.SPI4.rxdr.as_ptr().cast::<u8>()) });
    }
    dp.GPIOJ.bsrr.write(|w| w.bs13().set_bit());
    reply >> 4
}

fn open_spi(dp: &pac::Peripherals) {
    dp.RCC.apb2enr.modify(|_, w| w.spi4en().set_bit());
    // SAFETY: alternate function 5 for PE5, PE6 and PE12.
    unsafe {
        dp.GPIOE.afrl.modify(|r, w| w.bits(r.bits() | 0x0550_0000));
        dp.GPIOE.afrh.modify(|r, w| w.bits(r.bits() | 0x0005_0000));
        // The SPI clock is 100 MHz / 256, with eight bits.
        dp.SPI4.cfg1.write(|w| w.bits(7 << 28 | 7));
    }
    dp.GPIOE.moder.modify(|_, w| w.moder5().alternate().moder6().alternate().moder12().alternate());
    dp.SPI4.cr1.write(|w| w.ssi().set_bit());
    dp.SPI4.cfg2.write(|w| w.master().set_bit().ssm().set_bit().cpol().set_bit().cpha().set_bit().afcntr().set_bit());
    dp.SPI4.cr1.modify(|_, w| w.spe().set_bit());
    dp.SPI4.cr1.modify(|_, w| w.cstart().set_bit());
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    dp.RCC.ahb4enr.modify(|_, w| w.gpioden().set_bit().gpioeen().set_bit().gpiohen().set_bit().gpiojen().set_bit());
    dp.RCC.apb4enr.modify(|_, w| w.syscfgen().set_bit());
    // The chip select is idle before it is an output; ENN is high (off) until the chip is set up.
    dp.GPIOJ.bsrr.write(|w| w.bs13().set_bit());
    dp.GPIOJ.moder.modify(|_, w| w.moder13().output());
    dp.GPIOH.bsrr.write(|w| w.bs13().set_bit());
    dp.GPIOH.moder.modify(|_, w| w.moder13().output());
    open_spi(&dp);

    // The settings are 16 microsteps, both edges; chopper on; CS = 15; RDSEL = 0.
    frame(&dp, 0x0_0104);
    frame(&dp, 0x9_0135);
    frame(&dp, 0xD_000F);
    frame(&dp, 0xE_0000);
    assert_eq!(frame(&dp, 0x0_0104) >> 10, 0, "the microstep counter starts at zero");
    dp.GPIOH.bsrr.write(|w| w.br13().set_bit());

    // PD0 (X minimum) rises when the switch opens the line: EXTI line 0 from port D, rising edge.
    dp.GPIOD.pupdr.modify(|_, w| w.pupdr0().pull_up());
    dp.GPIOD.moder.modify(|_, w| w.moder0().input().moder3().output().moder4().output());
    // SAFETY: port D is 3.
    dp.SYSCFG.exticr1.modify(|_, w| unsafe { w.exti0().bits(3) });
    dp.EXTI.rtsr1.modify(|_, w| w.tr0().set_bit());
    dp.EXTI.c1imr1.modify(|_, w| w.mr0().set_bit());

    // The motor turns towards the switch: direction high. 30 mm at 80 edges a millimetre, at 100 kHz.
    dp.GPIOD.bsrr.write(|w| w.bs4().set_bit());
    let mut edges = 0;
    while !dp.EXTI.c1pr1.read().pr0().bit() {
        if edges % 2 == 0 {
            dp.GPIOD.bsrr.write(|w| w.bs3().set_bit());
        } else {
            dp.GPIOD.bsrr.write(|w| w.br3().set_bit());
        }
        edges += 1;
        cortex_m::asm::delay(4_000);
        assert!(edges < 10_000, "the switch never closed");
    }
    assert_eq!(edges, 30 * 80, "the switch closes at the edge that reaches it");
    assert_eq!(frame(&dp, 0x0_0104) >> 10, (30 * 80 * 16) % 1024, "microsteps counted up");
    pass()
}

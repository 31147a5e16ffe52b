//! Converts a thermistor input and the motor supply, modulates a timer output, and switches a heater on and
//! off.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use images::{pac, pass, start_clocks, wait_for};

macro_rules! convert {
    ($adc:expr, $channel:expr) => {{
        let adc = &$adc;
        adc.cr.modify(|_, w| w.deeppwd().clear_bit());
        adc.cr.modify(|_, w| w.advregen().set_bit());
        // Start-up time of the regulator, TADCVREG_SETUP: 10 us.
        cortex_m::asm::delay(4_000);
        adc.cr.modify(|_, w| w.aden().set_bit());
        wait_for("ADRDY", || adc.isr.read().adrdy().bit());
        // SAFETY: one conversion of this channel; the longest sampling time for all.
        unsafe {
            adc.pcsel.modify(|r, w| w.bits(r.bits() | 1 << $channel));
            adc.smpr1.write(|w| w.bits(0x3FFF_FFFF));
            adc.smpr2.write(|w| w.bits(0x3FFF_FFFF));
            adc.sqr1.write(|w| w.bits($channel << 6));
        }
        adc.cr.modify(|_, w| w.adstart().set_bit());
        wait_for("EOC", || adc.isr.read().eoc().bit());
        adc.dr.read().bits()
    }};
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    dp.RCC.d3ccipr.modify(|_, w| w.adcsel().per());
    dp.RCC.ahb1enr.modify(|_, w| w.adc12en().set_bit());
    dp.RCC.ahb4enr.modify(|_, w| w.adc3en().set_bit().gpioden().set_bit().gpioeen().set_bit().gpiofen().set_bit());
    // SAFETY: PRESC = /6.
    unsafe {
        dp.ADC12_COMMON.ccr.write(|w| w.bits(3 << 18));
        dp.ADC3_COMMON.ccr.write(|w| w.bits(3 << 18));
    }
    // T1: EPCOS 100 kOhm at 22 C is about 115 kOhm behind 4.7 kOhm: 0.961 of full scale.
    let thermistor = convert!(dp.ADC1, 2);
    assert!((62_900..63_100).contains(&thermistor), "T1 reads {thermistor}");
    // The motor supply is 24 V, divided by 11, of 3.3 V full scale.
    let motor = convert!(dp.ADC3, 16);
    assert!((43_290..43_360).contains(&motor), "the motor supply reads {motor}");

    // PWM1_1 is set to a quarter: TIM1 channel 1, PWM mode 1.
    dp.RCC.apb2enr.modify(|_, w| w.tim1en().set_bit());
    // SAFETY: a period of 1000 counts, high for 250 of them.
    unsafe {
        dp.TIM1.arr.write(|w| w.bits(999));
        dp.TIM1.ccr1().write(|w| w.bits(250));
        dp.TIM1.ccmr1_output().write(|w| w.bits(0b110 << 4));
    }
    dp.TIM1.ccer.write(|w| w.cc1e().set_bit());
    dp.TIM1.bdtr.write(|w| w.moe().set_bit());
    dp.TIM1.cr1.write(|w| w.cen().set_bit());

    // The buffer goes on (low, open drain), then the supply, then the heater for 20 ms.
    dp.GPIOF.otyper.modify(|_, w| w.ot14().set_bit());
    dp.GPIOF.moder.modify(|_, w| w.moder14().output());
    dp.GPIOD.bsrr.write(|w| w.bs7().set_bit());
    dp.GPIOD.moder.modify(|_, w| w.moder7().output());
    dp.GPIOE.bsrr.write(|w| w.bs0().set_bit());
    dp.GPIOE.moder.modify(|_, w| w.moder0().output());
    cortex_m::asm::delay(8_000_000);
    dp.GPIOE.bsrr.write(|w| w.br0().set_bit());
    pass()
}

//! Serial ports, the card's bus, timers.

use board_facts::figures::{CARD_HZ, DEBUG_BAUD, PWM_COUNTS};
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::generated::{rcc, tim1, usart1};

use crate::common::machine::everything;
use crate::common::velvet::SECOND;

/// SDMMC1_CLKCR (RM0399 section 58.10.2) and the kernel clock that its divider divides: PLL1 Q.
const CARD_CLOCK: u64 = 0x5200_7004;
const CARD_KERNEL_HZ: u64 = 200_000_000;
const PCLK_HZ: u64 = 100_000_000;
const TIMER_HZ: u64 = 200_000_000;
const CRYSTAL_HZ: u64 = 25_000_000;

#[test]
fn the_card_is_identified_at_400_khz_and_read_at_50_mhz() {
    let mut velvet = everything().watching(CARD_CLOCK..CARD_CLOCK + 4).start();
    // CLKDIV divides by twice its value; WIDBUS 0 is one line, 1 is four.
    let clocks: Vec<(u64, u64)> = velvet
        .bench
        .writes
        .take()
        .iter()
        .map(|write| (CARD_KERNEL_HZ / (2 * (write.value & 0x3FF)), write.value >> 14 & 3))
        .collect();
    assert_eq!(clocks, [(CARD_HZ[0], 0), (CARD_HZ[1], 1), (CARD_HZ[2], 1)]);
    let select = velvet.bench.vm.with(|stopped| {
        stopped.session.board().mcu.bus().registers("RCC").map(|file| file.get(rcc::Register::D1ccipr))
    });
    // RM0399 chapter 9, RCC_D1CCIPR: SDMMCSEL = 0 is PLL1 Q.
    assert_eq!(select.flatten().map(|select| select >> 16 & 1), Some(0));
}

#[test]
fn the_consoles_are_8n1_at_their_rates() {
    let mut velvet = everything().start();
    for port in ["USART2", "USART3"] {
        let registers = velvet.bench.vm.with(move |stopped| {
            let registers = [usart1::Register::Cr1, usart1::Register::Cr2, usart1::Register::Brr];
            stopped.session.board().mcu.bus().registers(port).map(|file| registers.map(|register| file.get(register)))
        });
        let [cr1, cr2, brr] = registers.flatten().expect("a port");
        // RM0399 section 51.8: M1, M0, PCE, OVER8 clear; STOP = 0 is one stop bit. 16-fold oversampling.
        assert_eq!(cr1 & (1 << 28 | 1 << 12 | 1 << 10 | 1 << 15), 0, "{port}: {cr1:#010x}");
        assert_eq!(cr2 >> 12 & 3, 0, "{port}");
        let baud = PCLK_HZ / brr;
        assert!(baud.abs_diff(DEBUG_BAUD) * 1_000 < DEBUG_BAUD, "{port}: {baud}");
    }
}

#[test]
fn hardware_pwm_has_1000_counts_and_is_on_while_high() {
    let mut velvet = everything().start();
    velvet.ask("M3 S25", SECOND);
    velvet.ask("M66 S50", SECOND);
    velvet.hear(50);
    // The columns are timer, frequency of the configuration, channel, share.
    for (timer, hertz, channel, share) in [("TIM1", 10_000, 1, 25), ("TIM8", 4_000, 2, 50)] {
        let registers = velvet.bench.vm.with(move |stopped| {
            let compare = if channel == 1 { tim1::Register::Ccr1 } else { tim1::Register::Ccr2 };
            let registers =
                [tim1::Register::Psc, tim1::Register::Arr, tim1::Register::Ccmr1Output, tim1::Register::Ccer, compare];
            stopped.session.board().mcu.bus().registers(timer).map(|file| registers.map(|register| file.get(register)))
        });
        let [prescaler, reload, mode, enable, compare] = registers.flatten().expect("a timer");
        assert_eq!(reload + 1, PWM_COUNTS, "{timer}");
        assert_eq!(TIMER_HZ / ((prescaler + 1) * PWM_COUNTS), hertz, "{timer}");
        assert_eq!(compare * 100, share * PWM_COUNTS, "{timer}");
        // RM0399 section 42.4.7: OCxM = 110, PWM mode 1. Section 42.4.9: CCxP clear, CCxE set: active high.
        assert_eq!(mode >> (8 * (channel - 1) + 4) & 0b111, 0b110, "{timer}: {mode:#x}");
        assert_eq!(enable >> (4 * (channel - 1)) & 0b11, 0b01, "{timer}: {enable:#x}");
    }
}

#[test]
fn the_usb_socket_is_otg2_at_48_mhz() {
    let mut velvet = everything().start();
    let registers = velvet.bench.vm.with(|stopped| {
        use rcc::Register::{Ahb1enr, Ahb1lpenr, Cr, D2ccip2r, Pll3divr, Pllcfgr, Pllckselr};
        let registers = [Cr, Pllckselr, Pllcfgr, Pll3divr, D2ccip2r, Ahb1enr, Ahb1lpenr];
        stopped.session.board().mcu.bus().registers("RCC").map(|file| registers.map(|register| file.get(register)))
    });
    let [control, inputs, ranges, dividers, select, clocks, sleeping] = registers.flatten().expect("the image runs");
    // RM0399 section 9.7.2: PLL3ON, PLL3RDY.
    assert_eq!(control >> 28 & 3, 3);
    // RCC_PLLCKSELR: DIVM3; RCC_PLL3DIVR: DIVN3 and DIVQ3 count from 0.
    let (input, multiplier, divider) = (inputs >> 20 & 0x3F, (dividers & 0x1FF) + 1, (dividers >> 16 & 0x7F) + 1);
    let oscillator = CRYSTAL_HZ / input * multiplier;
    assert_eq!(oscillator / divider, 48_000_000);
    // RCC_PLLCFGR: an input of 1 to 2 MHz (PLL3RGE 00), the oscillator of 150 to 420 MHz (PLL3VCOSEL), no
    // fraction; Q on, P and R off.
    assert!(
        (1_000_000..2_000_000).contains(&(CRYSTAL_HZ / input)) && (150_000_000..=420_000_000).contains(&oscillator)
    );
    assert_eq!((ranges >> 8 & 0xF, ranges >> 22 & 7), (0b0010, 0b010));
    // RCC_D2CCIP2R: USBSEL 10 is PLL3 Q. Clocks of OTG2 in run and in sleep; a ULPI clock asked for in sleep
    // would stop the core there.
    assert_eq!(select >> 20 & 3, 0b10);
    assert_eq!((clocks >> 27 & 1, sleeping >> 27 & 3), (1, 0b01));
}

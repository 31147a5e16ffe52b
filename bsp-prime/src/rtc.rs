//! The real-time clock on the 32.768 kHz crystal: date and time of day, through resets of the processor.
//!
//! No coin cell is fitted, so a board without power forgets them: it begins at 2000-01-01. RM0399 rev 4
//! chapter 49. The crystal takes up to two seconds to start (data sheet DS12923, "LSE oscillator
//! characteristics"); nobody waits for it, the clock stands until then.

use events::DateTime;
use stm32h7xx_hal::pac;

use crate::wait;

/// Limit of the wait until the calendar may be written, two periods of the crystal, 61 us (RM0399 section
/// 49.3.9); ten times that.
const WRITE_LIMIT_US: u32 = 600;
/// Limit of the backup domain's opening, which takes a few bus clocks.
const OPEN_LIMIT_US: u32 = 100;
/// The keys of WPR, in order (RM0399 section 49.3.9).
const KEYS: [u32; 2] = [0xCA, 0x53];
/// INIT and INITF of ISR.
const INIT: u32 = 1 << 7;
const INITF: u32 = 1 << 6;
/// BYPSHAD of CR: what is read is the counter itself.
const BYPSHAD: u32 = 1 << 5;
/// RTCSEL of BDCR: the LSE crystal.
const LSE: u32 = 0b01 << 8;
const RTCSEL: u32 = 0b11 << 8;
const RTCEN: u32 = 1 << 15;
/// LSEDRV: the most drive, as this board's crystal is run everywhere.
const MOST_DRIVE: u32 = 0b11 << 3;
const LSEON: u32 = 1;

/// Opens clock and backup registers for writing; false if the domain does not open.
pub(crate) fn open_backup_domain(pwr: &pac::PWR, rcc: &pac::RCC) -> bool {
    // RM0399 section 7.4.4: DBP lets the backup domain be written.
    pwr.cr1.modify(|_, w| w.dbp().set_bit());
    let opened = wait::until(OPEN_LIMIT_US, || pwr.cr1.read().dbp().bit_is_set());
    rcc.apb4enr.modify(|_, w| w.rtcapben().set_bit());
    opened.is_ok()
}

/// Real-time clock, to be started and set.
#[derive(Debug)]
pub struct Rtc {
    registers: pac::RTC,
}

impl Rtc {
    /// Starts the clock. Call before the clock tree is frozen, as the backup domain belongs to it.
    pub(crate) fn start(registers: pac::RTC, rcc: &pac::RCC, is_open: bool) -> Self {
        let now = rcc.bdcr.read().bits();
        if is_open && now & RTCEN == 0 {
            // SAFETY: RM0399 section 9.7.21: drive and source are chosen before they are switched on; the
            // other bits keep their values.
            unsafe {
                rcc.bdcr.write(|w| w.bits(now | MOST_DRIVE));
                rcc.bdcr.write(|w| w.bits(now | MOST_DRIVE | LSEON));
                rcc.bdcr.write(|w| w.bits(now & !RTCSEL | MOST_DRIVE | LSEON | LSE | RTCEN));
            }
        }
        let clock = Self { registers };
        clock.unlocked(|registers| {
            // SAFETY: BYPSHAD alone changes.
            registers.cr.modify(|r, w| unsafe { w.bits(r.bits() | BYPSHAD) });
        });
        clock
    }

    fn unlocked<R>(&self, action: impl FnOnce(&pac::RTC) -> R) -> R {
        for key in KEYS {
            // SAFETY: a key, as RM0399 section 49.3.9 gives it.
            self.registers.wpr.write(|w| unsafe { w.bits(key) });
        }
        let done = action(&self.registers);
        // SAFETY: any other value locks again.
        self.registers.wpr.write(|w| unsafe { w.bits(0xFF) });
        done
    }

    /// Sets the clock. False when its crystal does not run.
    pub fn set(&mut self, to: DateTime) -> bool {
        let bcd = |number: u8| u32::from(number / 10) << 4 | u32::from(number % 10);
        let time = bcd(to.hour) << 16 | bcd(to.minute) << 8 | bcd(to.second);
        // The day of the week must not be 0, and nobody asks for it.
        let date = bcd((to.year % 100) as u8) << 16 | 1 << 13 | bcd(to.month) << 8 | bcd(to.day);
        self.unlocked(|registers| {
            // SAFETY: RM0399 section 49.3.9, calendar initialization; fields are in BCD and in range.
            unsafe {
                registers.isr.write(|w| w.bits(INIT));
                let begun = wait::until(WRITE_LIMIT_US, || registers.isr.read().bits() & INITF != 0);
                if begun.is_ok() {
                    registers.tr.write(|w| w.bits(time));
                    registers.dr.write(|w| w.bits(date));
                }
                registers.isr.write(|w| w.bits(0));
                begun.is_ok()
            }
        })
    }
}

/// Returns the date and time of the clock; valid from [`Rtc::start`] on.
#[must_use]
pub fn now() -> DateTime {
    // SAFETY: it is only read; [`Rtc`] alone writes it.
    let registers = unsafe { &*pac::RTC::ptr() };
    // Both are counters: a second may end between them (RM0399 section 49.3.10).
    let (mut time, mut date) = (registers.tr.read().bits(), registers.dr.read().bits());
    for _ in 0..3 {
        let again = (registers.tr.read().bits(), registers.dr.read().bits());
        if again == (time, date) {
            break;
        }
        (time, date) = again;
    }
    let number = |register: u32, from: u32, mask: u32| {
        let bits = register >> from & mask;
        (bits >> 4) as u8 * 10 + (bits & 0xF) as u8
    };
    DateTime {
        year: 2_000 + u16::from(number(date, 16, 0xFF)),
        month: number(date, 8, 0x1F),
        day: number(date, 0, 0x3F),
        hour: number(time, 16, 0x3F),
        minute: number(time, 8, 0x7F),
        second: number(time, 0, 0x7F),
    }
}

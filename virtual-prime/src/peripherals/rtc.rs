//! The real-time clock, RM0399 rev 4 chapter 49 ("RTC"): the calendar with its initialisation mode, shadow
//! registers and write protection, on the clock that RCC_BDCR selects.
//!
//! The clock belongs to the backup domain: a system reset leaves time and configuration alone. Left out:
//! alarms, the wake-up timer, time stamps, tampering, shifting and calibration; their registers are stored,
//! and the flags that say "may be written" stay set.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::rtc::Register;
use rigless::time::{EventId, VirtualNanos};

use super::rtc_calendar::{Calendar, DateTime};

/// Address of register RCC_BDCR.
const RCC_BDCR: u64 = 0x5802_4470;
/// Bits of RCC_BDCR: RTCEN, RTCSEL (bits 9..8: 1 is the LSE, 2 the LSI), LSERDY.
const RTCEN: u64 = 1 << 15;
const LSERDY: u64 = 1 << 1;
const LSE_HZ: u64 = 32_768;
const LSI_HZ: u64 = 32_000;
/// Bits of register RTC_ISR.
const INITS: u64 = 1 << 4;
const RSF: u64 = 1 << 5;
const INITF: u64 = 1 << 6;
const INIT: u64 = 1 << 7;
/// Reset value of RTC_ISR: alarms and wake-up timer may be written.
const ISR_RESET: u64 = 0x7;
/// Periods of RTCCLK until INITF rises, and until RSF does: "It takes around two RTCCLK clock cycles".
const SYNC_CLOCKS: u64 = 2;
/// The keys of RTC_WPR, in order.
const KEYS: [u64; 2] = [0xCA, 0x53];
/// Bit BYPSHAD of RTC_CR.
const BYPSHAD: u64 = 1 << 5;

/// State of the real-time clock.
#[derive(Debug)]
pub struct Rtc {
    /// Rate of RTCCLK, as last seen selected by RCC_BDCR; zero is none.
    hz: u64,
    calendar: Calendar,
    /// Instant at which the calendar was last right.
    since: VirtualNanos,
    unlocked: usize,
    initialising: bool,
    initialised: Option<EventId>,
    synchronised: Option<EventId>,
    flags: u64,
    /// Contents of the protected registers, to undo a forbidden write.
    kept: Vec<(Register, u64)>,
    /// Date as of a read of TR or SSR, until DR is read.
    latched_date: Option<u64>,
}

impl Default for Rtc {
    fn default() -> Self {
        Self {
            hz: 0,
            calendar: Calendar::default(),
            since: VirtualNanos(0),
            unlocked: 0,
            initialising: false,
            initialised: None,
            synchronised: None,
            flags: ISR_RESET,
            kept: Vec::new(),
            latched_date: None,
        }
    }
}

const PROTECTED: [Register; 5] =
    [Register::RtcTr, Register::RtcDr, Register::RtcCr, Register::RtcPrer, Register::RtcWutr];

impl Rtc {
    /// Returns the periods of RTCCLK since the calendar was set.
    fn periods(&self, now: VirtualNanos) -> u64 {
        let elapsed = u128::from(now.0 - self.since.0);
        (elapsed * u128::from(self.hz) / 1_000_000_000) as u64
    }

    /// Returns the present date, time and sub-second counter.
    fn now(&self, now: VirtualNanos, file: &RegisterFile) -> (DateTime, u64) {
        let prescaler = file.get(Register::RtcPrer);
        let (asynchronous, synchronous) = ((prescaler >> 16 & 0x7F) + 1, (prescaler & 0x7FFF) + 1);
        let ticks = if self.initialising { 0 } else { self.periods(now) / asynchronous };
        let second = self.calendar.after(ticks / synchronous);
        (second, synchronous - 1 - ticks % synchronous)
    }

    fn clocks_ns(&self, count: u64) -> u64 {
        count * 1_000_000_000 / self.hz.max(1)
    }

    /// Asks the clock controller for RTCCLK; the answer comes to `on_access`.
    fn look_at_clock(context: &mut DeviceContext<'_>) {
        context.read_from(RCC_BDCR, Width::W32, 0);
    }

    fn write_status(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        // RSF and the event flags are cleared by writing zero; INIT follows what is written.
        self.flags &= value | !(RSF | 0x3_FF00);
        if value & INIT != 0 && !self.initialising {
            self.flags |= INIT;
        } else if value & INIT == 0 && self.flags & INIT != 0 {
            self.flags &= !(INIT | INITF);
            if self.initialising {
                self.initialising = false;
                self.since = context.now();
            }
        }
        // The time until the flags rise depends on the clock.
        Self::look_at_clock(context);
    }

    fn set_calendar(&mut self, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        if !self.initialising {
            context.tell("TR", "RM0399 RTC: time and date are written in initialisation mode only");
            return;
        }
        self.calendar = Calendar::from_registers(file.get(Register::RtcTr), file.get(Register::RtcDr));
        self.flags |= if self.calendar.is_set() { INITS } else { 0 };
    }

    fn protect(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> bool {
        if self.unlocked == KEYS.len() || !PROTECTED.contains(&register) {
            return false;
        }
        let before = self.kept.iter().find(|(kept, _)| *kept == register).map(|&(_, value)| value);
        if let Some(before) = before {
            file.set(register, before);
        }
        context.tell("WPR", "RM0399 RTC: write-protected until 0xCA and 0x53 are written to RTC_WPR");
        true
    }

    fn keep(&mut self, file: &RegisterFile) {
        self.kept = PROTECTED.into_iter().map(|register| (register, file.get(register))).collect();
    }
}

impl Device for Rtc {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        self.keep(file);
        let (second, fraction) = self.now(context.now(), file);
        let bypass = file.get(Register::RtcCr) & BYPSHAD != 0;
        match register {
            Register::RtcTr | Register::RtcSsr => {
                if !bypass {
                    self.latched_date.get_or_insert(second.date_register());
                }
                Some(if register == Register::RtcTr { second.time_register() } else { fraction })
            }
            Register::RtcDr => Some(self.latched_date.take().unwrap_or_else(|| second.date_register())),
            Register::RtcIsr => {
                Self::look_at_clock(context);
                Some(self.flags)
            }
            _ => None,
        }
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if register == Register::RtcWpr {
            // Any wrong key closes the lock, the right keys in order open it.
            self.unlocked = match KEYS.iter().position(|&key| key == value & 0xFF) {
                Some(0) => 1,
                Some(1) if self.unlocked == 1 => 2,
                _ => 0,
            };
            return;
        }
        if self.kept.is_empty() {
            self.kept = vec![(Register::RtcPrer, 0x007F_00FF), (Register::RtcDr, 0x2101)];
        }
        if !self.protect(register, file, context) {
            match register {
                Register::RtcIsr => self.write_status(value, context),
                Register::RtcTr | Register::RtcDr => self.set_calendar(file, context),
                _ => {}
            }
        }
        self.keep(file);
    }

    fn on_access(&mut self, _token: u64, backup: u64, _file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.hz = match (backup & RTCEN != 0, backup >> 8 & 3) {
            (true, 1) if backup & LSERDY != 0 => LSE_HZ,
            (true, 2) => LSI_HZ,
            _ => 0,
        };
        if self.hz == 0 {
            return;
        }
        let soon = VirtualNanos(context.now().0 + self.clocks_ns(SYNC_CLOCKS));
        if self.flags & (INIT | INITF) == INIT && self.initialised.is_none() {
            self.initialised = Some(context.schedule(soon));
        }
        if self.flags & (RSF | INIT) == 0 && self.synchronised.is_none() {
            self.synchronised = Some(context.schedule(soon));
        }
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.initialised == Some(event) {
            self.initialised = None;
            if self.flags & INIT != 0 {
                let (second, _) = self.now(context.now(), file);
                self.calendar = second.into();
                self.initialising = true;
                self.flags |= INITF;
            }
        }
        if self.synchronised == Some(event) {
            self.synchronised = None;
            self.flags |= RSF;
        }
    }

    /// Closes the lock and the shadow registers, as a system reset does; the clock runs on.
    fn reset(&mut self) {
        self.unlocked = 0;
        self.flags &= !(RSF | INIT | INITF);
        self.initialising = false;
        self.initialised = None;
        self.synchronised = None;
        self.latched_date = None;
    }
}

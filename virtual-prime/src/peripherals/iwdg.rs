//! The independent watchdog, RM0399 rev 4 chapter 50 ("IWDG"): a 12-bit down-counter on the 32 kHz LSI that
//! resets the part when it reaches zero, or when it is reloaded while above the window.

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::stm32h743::generated::iwdg::Register;
use rigless::soc::stm32h743::peripherals::rcc::IWDG_STARTED;
use rigless::time::{EventId, VirtualNanos};

const KEY_START: u64 = 0xCCCC;
const KEY_RELOAD: u64 = 0xAAAA;
const KEY_ACCESS: u64 = 0x5555;
const COUNT_MASK: u64 = 0xFFF;
/// Frequency of the LSI, the datasheet's typical value.
const LSI_HZ: u64 = 32_000;
/// A register update reaches the counter's clock domain within five prescaled LSI periods (section "Register
/// access protection"); the status bits show it under way. The model takes the five periods of the undivided
/// clock.
const UPDATE_NS: u64 = 5 * 1_000_000_000 / LSI_HZ;

/// The watchdog of one core.
#[derive(Debug, Default)]
pub struct Iwdg {
    unlocked: bool,
    /// Instant and value of the counter's last reload, once started.
    started: Option<Running>,
    expiry: Option<EventId>,
    updated: Option<EventId>,
}

#[derive(Clone, Copy, Debug)]
struct Running {
    since: VirtualNanos,
    period_ns: u64,
    reload: u64,
}

impl Iwdg {
    fn reload(&mut self, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        let divider = 4_u64 << file.get(Register::Pr).min(6);
        let running = Running {
            since: context.now(),
            period_ns: divider * 1_000_000_000 / LSI_HZ,
            reload: file.get(Register::Rlr) & COUNT_MASK,
        };
        self.started = Some(running);
        self.expiry = Some(context.schedule(VirtualNanos(context.now().0 + (running.reload + 1) * running.period_ns)));
    }

    /// Returns the counter's present value.
    fn count(&self, now: VirtualNanos) -> Option<u64> {
        let running = self.started?;
        Some(running.reload.saturating_sub((now.0 - running.since.0) / running.period_ns))
    }
}

impl Device for Iwdg {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, _: &mut DeviceContext<'_>) -> Option<u64> {
        // The key register reads zero.
        (register == Register::Kr).then_some(0).or_else(|| Some(file.get(register)))
    }

    fn steady(&self, _register: Register, _: &RegisterFile) -> bool {
        true
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match register {
            Register::Kr => {
                file.set(Register::Kr, 0);
                self.unlocked = value == KEY_ACCESS;
                match value {
                    KEY_START => {
                        context.request(IWDG_STARTED, Level::High);
                        self.reload(file, context);
                    }
                    KEY_RELOAD if self.started.is_some() => {
                        let window = file.get(Register::Winr) & COUNT_MASK;
                        if self.count(context.now()).is_some_and(|count| count > window) {
                            context.request_reset();
                        } else {
                            self.reload(file, context);
                        }
                    }
                    _ => {}
                }
            }
            Register::Pr | Register::Rlr | Register::Winr if !self.unlocked => {
                context
                    .tell(register_name(register), "RM0399 IWDG: write-protected until 0x5555 is written to IWDG_KR");
            }
            Register::Pr | Register::Rlr | Register::Winr => {
                let busy = match register {
                    Register::Pr => 1,
                    Register::Rlr => 2,
                    _ => 4,
                };
                file.set(Register::Sr, file.get(Register::Sr) | busy);
                self.updated = Some(context.schedule(VirtualNanos(context.now().0 + UPDATE_NS)));
                // The manual says: "Changing the window reloads the counter."
                if register == Register::Winr && self.started.is_some() {
                    self.reload(file, context);
                }
            }
            Register::Sr => {}
        }
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.updated == Some(event) {
            self.updated = None;
            file.set(Register::Sr, 0);
        }
        if self.expiry == Some(event) {
            context.request_reset();
        }
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

fn register_name(register: Register) -> &'static str {
    match register {
        Register::Kr => "KR",
        Register::Pr => "PR",
        Register::Rlr => "RLR",
        Register::Sr => "SR",
        Register::Winr => "WINR",
    }
}

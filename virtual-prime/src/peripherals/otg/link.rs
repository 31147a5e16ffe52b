//! The core's end of the cable: the pull-up, reset, suspend and resume, RM0399 sections 60.6 ("OTG_HS as a
//! USB peripheral") and 60.14 (OTG_DCTL, OTG_DSTS, OTG_PCGCCTL).

use super::core::{Core, Surroundings};
use super::registers::*;
use usb_host::wire::Drive;

/// Idle time until the early suspend interrupt, and again until suspend, ns.
const IDLE_NS: u64 = 3_000_000;
/// Rate of the kernel clock, and its tolerance: USB 2.0 section 7.1.11, 0.25 %.
const KERNEL_HZ: u64 = 48_000_000;
const TOLERANCE_HZ: u64 = KERNEL_HZ / 400;
/// Time for a connection that firmware asked for to be complete, before it is reported.
const PATIENCE_NS: u64 = 10_000_000;
/// Time that the core is without a clock when the processor sleeps and an external transceiver is waited for.
const DEAF_NS: u64 = 1_000_000;

impl Core {
    /// Sets the core's surroundings.
    pub fn look_around(&mut self, around: Surroundings) {
        if self.around != around {
            self.around = around;
            self.settle();
        }
    }

    /// Sets the rate of the kernel clock.
    pub fn set_clock(&mut self, hz: u64) {
        self.look_around(Surroundings { kernel_hz: hz, ..self.around });
    }

    /// Whether the session of a B device is valid. The board has no VBUS on PA9, so only the override makes a
    /// session.
    pub(super) const fn b_valid(&self) -> bool {
        const OVERRIDE: u32 = gotgctl::BVALOEN | gotgctl::BVALOVAL;
        self.gotgctl & OVERRIDE == OVERRIDE
    }

    /// Whether the transceiver has its clock. With OTG_GUSBCFG.PHYSEL clear, or with the ULPI's clock
    /// enabled, the core waits for that of an external transceiver.
    const fn is_clocked(&self) -> bool {
        self.around.kernel_hz > 0 && self.gusbcfg & gusbcfg::PHYSEL != 0 && !self.around.ulpi
    }

    /// Returns the reason why the pull-up stays off though firmware has asked for it.
    fn obstacle(&self) -> Option<(&'static str, &'static str)> {
        let list = [
            (
                self.gccfg & gccfg::PWRDWN == 0,
                ("GCCFG", "connected with the transceiver powered down (PWRDWN = 0), RM0399 OTG_GCCFG"),
            ),
            (self.around.kernel_hz == 0, ("GRSTCTL", "no kernel clock: RCC_D2CCIP2R.USBSEL, RM0399 section 9.7")),
            (
                self.gusbcfg & gusbcfg::PHYSEL == 0,
                ("GUSBCFG", "PHYSEL = 0 waits for an external transceiver, which the board does not have"),
            ),
            (self.around.ulpi, ("GRSTCTL", "RCC_AHB1ENR.USB2OTGHSULPIEN waits for an external transceiver's clock")),
            (
                !self.around.supply,
                ("GCCFG", "PWR_CR3.USB33DEN is clear: the transceiver has no valid supply, RM0399 section 7.4.7"),
            ),
            (!self.around.pins, ("GCCFG", "PA11 and PA12 are not connected to the core: alternate function 10")),
            (
                !self.b_valid() && self.gccfg & gccfg::VBDEN != 0,
                ("GCCFG", "VBDEN senses VBUS on PA9, which is an end stop on this board: override the B session"),
            ),
            (
                !self.b_valid(),
                ("GOTGCTL", "no valid B session: the board does not sense VBUS, so BVALOEN and BVALOVAL must be set"),
            ),
            (self.gusbcfg & gusbcfg::FHMOD != 0, ("GUSBCFG", "FHMOD: a host has no pull-up")),
        ];
        list.into_iter().find(|&(stands, _)| stands).map(|(_, why)| why)
    }

    /// Whether the pull-up on D+ is on.
    pub(super) fn is_connected(&self) -> bool {
        self.dctl & dctl::SDIS == 0 && self.grstctl & grstctl::CSRST == 0 && self.obstacle().is_none()
    }

    /// Whether the core understands the traffic and can answer. An obstacle becomes a finding.
    pub(super) fn can_talk(&mut self) -> bool {
        if self.around.kernel_hz.abs_diff(KERNEL_HZ) > TOLERANCE_HZ {
            self.find("GRSTCTL", "the kernel clock is not 48 MHz within 0.25 %, USB 2.0 section 7.1.11");
            return false;
        }
        if self.pcgcctl & pcgcctl::STPPCLK != 0 {
            self.find("PCGCCTL", "RM0399 OTG_PCGCCTL: the transceiver's clock is stopped while the host talks");
            return false;
        }
        if self.gahbcfg & gahbcfg::DMAEN != 0 || self.now_ns < self.link.deaf_until {
            return false;
        }
        self.is_connected()
    }

    /// Follows a sleep of the processor. With the ULPI's clock enabled for sleep, the core waits in vain for
    /// an external transceiver's clock meanwhile (RCC_AHB1LPENR.USB2OTGHSULPILPEN, set out of reset).
    pub fn processor_slept(&mut self, now_ns: u64) {
        self.advance(now_ns);
        if self.around.ulpi_asleep && self.is_connected() && self.link.is_plugged() {
            self.link.deaf_until = now_ns + DEAF_NS;
            self.find(
                "GRSTCTL",
                "RCC_AHB1LPENR.USB2OTGHSULPILPEN is set: while the processor sleeps the core waits for the clock of an \
                 external transceiver, and hears nothing",
            );
        }
    }

    /// Returns OTG_DCTL as it reads.
    pub(super) const fn device_control(&self) -> u32 {
        let in_nak = if self.global_in_nak { dctl::GINSTS } else { 0 };
        let out_nak = if self.global_out_nak { dctl::GONSTS } else { 0 };
        self.dctl | in_nak | out_nak
    }

    pub(super) fn write_device_control(&mut self, value: u32) {
        let connects = self.dctl & !value & dctl::SDIS != 0;
        self.dctl = value & !(dctl::ACTIONS | dctl::GINSTS | dctl::GONSTS);
        if connects {
            self.link.judged_at = Some(self.now_ns + PATIENCE_NS);
        }
        if value & dctl::SGINAK != 0 {
            self.global_in_nak = true;
        } else if value & dctl::CGINAK != 0 {
            self.global_in_nak = false;
        }
        if value & dctl::SGONAK != 0 && !self.global_out_nak {
            self.global_out_nak = true;
            self.receive(rxsts::GLOBAL_OUT_NAK, 0, usb_host::wire::Toggle::Data0, &[]);
        } else if value & dctl::CGONAK != 0 {
            self.global_out_nak = false;
            self.out_nak_effective = false;
        }
        if value & dctl::RWUSIG != 0 && self.link.suspended {
            // The core's own signal ends suspend (OTG_DSTS, SUSPSTS).
            self.link.suspended = false;
            self.link.idle_since = None;
        }
    }

    /// Returns OTG_DSTS as it reads.
    pub(super) const fn device_status(&self) -> u32 {
        let suspended = if self.link.suspended { dsts::SUSPSTS } else { 0 };
        suspended | dsts::FULL_SPEED | (self.link.frame as u32 & dsts::FNSOF) << dsts::FNSOF_SHIFT
    }

    /// Follows a change of the lines by the host's port.
    pub(super) fn follow_port(&mut self, drive: Drive) {
        let before = std::mem::replace(&mut self.link.drive, drive);
        if before == Drive::Unplugged && drive != before && self.dctl & dctl::SDIS == 0 {
            self.link.judged_at = Some(self.now_ns + PATIENCE_NS);
        }
        if drive != Drive::Reset {
            self.link.unannounced = false;
        }
        if self.is_connected() {
            match (before, drive) {
                (Drive::Reset, Drive::Idle | Drive::Frames) if self.pcgcctl & pcgcctl::STPPCLK == 0 => {
                    self.latched |= gint::ENUMDNE;
                }
                (_, Drive::Reset) => self.begin_bus_reset(),
                (_, Drive::Resume) => self.wake(gint::WKUPINT),
                _ => {}
            }
        }
        self.settle();
    }

    /// Leaves suspend, with this interrupt cause.
    fn wake(&mut self, cause: u32) {
        if std::mem::take(&mut self.link.suspended) {
            self.latched |= cause;
        }
    }

    fn begin_bus_reset(&mut self) {
        if self.pcgcctl & pcgcctl::STPPCLK != 0 {
            // Without its clock the core can only ask for it, by interrupt.
            self.wake(gint::RSTDET | gint::WKUPINT);
            self.link.unannounced = true;
            return;
        }
        self.link.suspended = false;
        self.latched |= gint::USBRST;
        self.control = super::core::Control::default();
        self.take_address();
        // The manual says: "The core clears this bit for all endpoints (other than EP 0) after detecting a
        // USB reset."
        self.ins.iter_mut().chain(&mut self.outs).for_each(super::endpoint::Endpoint::deactivate);
    }

    /// Brings the core up to this instant, as suspend comes with time.
    pub fn advance(&mut self, now_ns: u64) {
        self.now_ns = self.now_ns.max(now_ns);
        if let Some(since) = self.link.idle_since {
            if !self.link.early && self.now_ns >= since + IDLE_NS {
                self.link.early = true;
                self.latched |= gint::ESUSP;
            }
            if !self.link.suspended && self.now_ns >= since + 2 * IDLE_NS {
                self.link.suspended = true;
                self.link.idle_since = None;
                self.latched |= gint::USBSUSP;
            }
        }
        if self.link.judged_at.is_some_and(|at| self.now_ns >= at) {
            self.link.judged_at = None;
            if self.dctl & dctl::SDIS == 0
                && self.link.is_plugged()
                && let Some((register, reason)) = self.obstacle()
            {
                self.find(register, reason);
            }
        }
    }

    /// Returns the instant of the core's next change by itself.
    #[must_use]
    pub fn next_change(&self) -> Option<u64> {
        let suspend = self.link.idle_since.map(|since| since + if self.link.early { 2 * IDLE_NS } else { IDLE_NS });
        let judged = self.link.judged_at.filter(|_| self.link.is_plugged());
        [suspend, judged].into_iter().flatten().min()
    }

    /// Carries out all effects of the present registers and line state.
    pub(super) fn settle(&mut self) {
        if self.grstctl & grstctl::CSRST != 0 {
            // The reset ends in the transceiver's clock domain, if that has a clock.
            if self.is_clocked() {
                self.soft_reset();
            } else {
                self.find(
                    "GRSTCTL",
                    "CSRST waits for the clock of the transceiver: USBSEL in RCC_D2CCIP2R, PHYSEL in OTG_GUSBCFG, and no \
                     USB2OTGHSULPIEN in RCC_AHB1ENR",
                );
            }
        }
        let connected = self.is_connected();
        let idle = connected && matches!(self.link.drive, Drive::Unplugged | Drive::Idle) && !self.wakes_itself();
        if !idle || self.link.suspended {
            self.link.idle_since = None;
        } else if self.link.idle_since.is_none() {
            self.link.idle_since = Some(self.now_ns);
            self.link.early = false;
        }
        if !connected {
            self.link.suspended = false;
        }
        if self.link.unannounced && self.pcgcctl & pcgcctl::STPPCLK == 0 {
            self.link.unannounced = false;
            if connected && self.link.drive == Drive::Reset {
                self.begin_bus_reset();
            }
        }
    }

    const fn wakes_itself(&self) -> bool {
        self.dctl & dctl::RWUSIG != 0
    }
}

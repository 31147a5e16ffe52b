//! The computer at the USB socket: the machine's USB port.

use base::ports::{Disk, NotLent, Storage, Usb};
use bsp_prime::sd::CardService;
use bsp_prime::time;
use card::sd::SdError;
use config::SystemConfig;
use storage::Card;
use units::Micros;

use super::{BoardPorts, Locks};
use crate::storage::Slot;
use crate::{disk, usb};

/// Time of silence on the bus after which the computer has gone, or sleeps soundly. Shorter silences have
/// harmless causes: a hub that is reset, a cable that is put in anew.
const GONE_US: u64 = 5_000_000;

impl<L: Locks> BoardPorts<L> {
    fn service<R>(&mut self, action: impl FnOnce(&mut CardService) -> R) -> R {
        self.storage.card(|slot| slot.with(action))
    }
}

impl<L: Locks> Usb for BoardPorts<L> {
    fn connect(&mut self, system: &SystemConfig) -> Result<(), &'static str> {
        self.owned.usb.take().map_or(Ok(()), |(socket, unique_id)| usb::connect(socket, unique_id, system))
    }

    fn lend_card(&mut self) -> Result<bool, NotLent> {
        if usb::is_silent() {
            return Err(NotLent::NoComputer);
        }
        if !self.is_kept().map_err(NotLent::Storage)? {
            return Ok(false);
        }
        let reason = |error: SdError| NotLent::Storage(<Slot<L::Card> as Card>::reason(&error));
        if !self.service(CardService::lend).map_err(reason)? {
            return Ok(false);
        }
        // Unmounted last, so that a card that is not lent after all is still the machine's.
        if let Err(error) = self.storage.unmount() {
            self.service(CardService::take_back);
            return Err(NotLent::Storage(error));
        }
        self.silent_since = None;
        disk::lent();
        bsp_prime::usb::wake();
        Ok(true)
    }

    fn disk(&mut self) -> Disk {
        let (is_lent, is_busy) = self.service(|card| (card.is_lent(), card.is_lent_busy()));
        if !is_lent {
            return Disk::Kept;
        }
        let now = time::now();
        self.silent_since = if usb::is_silent() { self.silent_since.or(Some(now)) } else { None };
        let is_gone = self.silent_since.is_some_and(|since: Micros| now.0.saturating_sub(since.0) >= GONE_US);
        if is_gone {
            disk::end_loan();
        }
        match (disk::is_over() && !is_busy, is_gone) {
            (false, _) => Disk::Lent,
            (true, false) => Disk::GivenBack,
            (true, true) => Disk::Gone,
        }
    }

    fn revoke_card(&mut self) {
        disk::end_loan();
        bsp_prime::usb::wake();
    }

    fn take_card_back(&mut self) {
        self.service(CardService::take_back);
        bsp_prime::usb::wake();
    }

    fn set_disk_lamp(&mut self, on: bool) {
        if let Some(lamp) = &mut self.owned.disk_lamp {
            lamp.set(on);
        }
    }
}

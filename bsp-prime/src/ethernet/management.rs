//! The PHY behind the management interface (MDIO): moves the frames that its driver asks for, without waiting
//! for one (RM0399 chapter 61, "Station management agent").

use drivers::lan8720::{Access, Fault, Lan8720, Link, LinkMode};
use stm32h7xx_hal::pac;
use units::Micros;

/// Bits of ETH_MACMDIOAR: busy, the operation in GOC (01 writes, 11 reads), and the divider in CR from an
/// HCLK of 150 to 250 MHz to 1.5 to 2.5 MHz.
const BUSY: u32 = 1 << 0;
const WRITE: u32 = 0b01 << 2;
const READ: u32 = 0b11 << 2;
const DIVIDER: u32 = 0b0100 << 8;
const _: () = assert!(crate::clocks::HCLK_HZ >= 150_000_000 && crate::clocks::HCLK_HZ < 250_000_000);

/// Limit of a frame, which takes 33 us.
const LIMIT: Micros = Micros::from_millis(1);

/// The PHY, and the frame to it that is under way.
pub(super) struct Management {
    phy: Lan8720,
    since: Option<Micros>,
}

impl Management {
    pub(super) const fn new(mode: LinkMode) -> Self {
        Self { phy: Lan8720::new(mode), since: None }
    }

    pub(super) const fn link(&self) -> Option<Link> {
        self.phy.link()
    }

    pub(super) const fn fault(&self) -> Option<Fault> {
        self.phy.fault()
    }

    /// Ends a frame that is over, and begins the next if one is due.
    pub(super) fn poll(&mut self, mac: &pac::ETHERNET_MAC, now: Micros) {
        if let Some(since) = self.since {
            if mac.macmdioar.read().bits() & BUSY == 0 {
                self.since = None;
                self.phy.answer(now, mac.macmdiodr.read().md().bits());
            } else if now.since(since) > LIMIT {
                self.since = None;
                self.phy.fail(now);
            }
        } else if let Some(access) = self.phy.next(now) {
            if mac.macmdioar.read().bits() & BUSY != 0 {
                return self.phy.fail(now);
            }
            begin(mac, access);
            self.since = Some(now);
        }
    }
}

fn begin(mac: &pac::ETHERNET_MAC, access: Access) {
    if let Some(value) = access.write {
        // SAFETY: any value can be written to a register of the PHY.
        mac.macmdiodr.write(|w| unsafe { w.md().bits(value) });
    }
    let operation = if access.write.is_some() { WRITE } else { READ };
    let place = u32::from(access.address & 0x1F) << 21 | u32::from(access.register & 0x1F) << 16;
    // SAFETY: a pattern of the register's fields; the frame before it is over.
    mac.macmdioar.write(|w| unsafe { w.bits(place | DIVIDER | operation | BUSY) });
}

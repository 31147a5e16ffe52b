//! Another computer's USB at the board's socket, over TCP: `usbredir` and `usbip`, each on a port of its own.
//!
//! There is one socket, so one computer at a time has the cable: the first that comes, until its connection
//! closes, which pulls the cable out. [`Remote::serve`] never waits; it is called between two spans of
//! virtual time, as often as answers are to be prompt.

mod clients;
mod connection;
mod peer;

#[cfg(test)]
mod tests;

use std::io;
use std::net::SocketAddr;

use super::controller::Controller;
use super::hub::{Hub, HubEvent, Root};
use super::wire::Function;

use self::clients::Clients;
use self::peer::Peer;

/// Protocol of the computer that has the cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holder {
    Nobody,
    Usbredir,
    Usbip,
}

/// The listening ports, with their connections.
#[derive(Debug)]
pub struct Remote {
    hub: Hub,
    holder: Holder,
    usbredir: Peer,
    usbip: Clients,
    notes: Vec<String>,
    sent: [u64; 16],
}

impl Remote {
    /// Begins to listen on these addresses; port 0 lets the system choose.
    ///
    /// # Errors
    /// Which one cannot be had, and why.
    pub fn listen(usbredir: SocketAddr, usbip: SocketAddr) -> io::Result<Self> {
        let words = |name, address: SocketAddr| {
            move |error: io::Error| io::Error::new(error.kind(), format!("port {} for {name}: {error}", address.port()))
        };
        Ok(Self {
            hub: Hub::default(),
            holder: Holder::Nobody,
            usbredir: Peer::listen(usbredir).map_err(words("usbredir", usbredir))?,
            usbip: Clients::listen(usbip).map_err(words("usbip", usbip))?,
            notes: Vec::new(),
            sent: [0; 16],
        })
    }

    /// Returns the listening addresses for usbredir and for usbip.
    ///
    /// # Errors
    /// What the system says.
    pub fn addresses(&self) -> io::Result<[SocketAddr; 2]> {
        Ok([self.usbredir.address()?, self.usbip.address()?])
    }

    /// Whether a computer has the cable.
    #[must_use]
    pub fn is_plugged(&self) -> bool {
        self.hub.is_plugged()
    }

    /// Returns the bytes that the device has acknowledged since power-on, by OUT endpoint.
    #[must_use]
    pub const fn sent(&self) -> [u64; 16] {
        self.sent
    }

    /// Takes the notes on events since the last call, as text.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Has the cable pulled out at the next call of [`Self::serve`], which hears nothing more of its holder.
    /// A holder that unplugs by itself takes its transfers back first, one message for each: it may see some
    /// of them gone and the next ones not.
    pub fn unplug(&mut self) {
        self.usbredir.unplug(&mut self.notes);
        self.usbip.unplug(&mut self.notes);
    }

    /// Takes received bytes and serves the connections, at this instant.
    pub fn serve(&mut self, now_ns: u64, controller: &mut Controller, device: &mut impl Function) {
        self.usbredir.hear(&mut self.notes);
        let busy = self.holder == Holder::Usbredir || self.usbredir.wants_device();
        self.usbip.hear(&self.hub, now_ns, busy, &mut self.notes);
        let mut root = Root { hub: &mut self.hub, controller, device, now_ns };
        let (redir_left, usbip_left) = (self.usbredir.take_departure(), self.usbip.take_departure());
        let stays = match self.holder {
            Holder::Nobody => false,
            Holder::Usbredir => self.usbredir.wants_device() && !redir_left,
            Holder::Usbip => self.usbip.wants_device() && !usbip_left,
        };
        if root.hub.is_plugged() && !stays {
            // The next computer plugs in afresh, at the next call.
            root.unplug();
            self.holder = Holder::Nobody;
        } else if !stays {
            self.holder = match () {
                () if self.usbredir.wants_device() => Holder::Usbredir,
                () if self.usbip.wants_device() => Holder::Usbip,
                () => Holder::Nobody,
            };
            if self.holder != Holder::Nobody {
                root.plug();
            }
        }
        loop {
            let (news, completions) = root.run();
            let again = !completions.is_empty();
            self.notes.extend(news.iter().map(|event| words(event, root.hub)));
            match self.holder {
                Holder::Usbredir => self.usbredir.serve(&mut root, completions, &mut self.notes),
                Holder::Usbip => self.usbip.serve(&mut root, completions, &mut self.notes),
                // The completions belong to the holder before.
                Holder::Nobody => {}
            }
            if !again && !root.controller.has_completions() {
                break;
            }
        }
        self.sent = root.controller.tally.sent;
        self.usbredir.say();
        self.usbip.say(&mut self.notes);
    }
}

fn words(event: &HubEvent, hub: &Hub) -> String {
    match event {
        HubEvent::Found => match hub.found() {
            Some(found) => format!("USB: device {:04x}:{:04x} is there", found.device.vendor, found.device.product),
            None => "USB: a device was there".into(),
        },
        HubEvent::Gone => "USB: the device has gone".into(),
        HubEvent::Unusable(why) => format!("USB: a device that cannot be used: {why}"),
    }
}

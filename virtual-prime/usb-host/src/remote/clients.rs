//! The port for usbip: any number of clients may ask for the list of devices, and one has the device.

use std::io;
use std::net::{SocketAddr, TcpListener};

use super::connection::{Connection, listen};
use crate::hub::{Hub, Root};
use crate::transfer::Completion;
use crate::usbip::packet::Refusal;
use crate::usbip::session::Session;
use crate::wire::Function;

#[derive(Debug)]
struct Client {
    connection: Connection,
    session: Session,
    /// The client has asked for something, so the cable stays in until its connection closes.
    wants_cable: bool,
    /// The client does not speak the protocol.
    failed: bool,
}

/// The port with its clients.
#[derive(Debug)]
pub struct Clients {
    listener: TcpListener,
    clients: Vec<Client>,
    /// Whether a client that had the device has gone since the last question.
    departed: bool,
}

impl Clients {
    /// Listens at a TCP address. Fails where that is taken or not of this computer.
    pub fn listen(address: SocketAddr) -> io::Result<Self> {
        Ok(Self { listener: listen(address)?, clients: Vec::new(), departed: false })
    }

    /// Returns the TCP address, with the port that the system chose if none was named.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Whether a client needs the cable plugged in.
    pub fn wants_device(&self) -> bool {
        self.clients.iter().any(|client| client.wants_cable)
    }

    /// Whether a client that had the device has gone since the last call.
    pub const fn take_departure(&mut self) -> bool {
        std::mem::replace(&mut self.departed, false)
    }

    /// Closes the connection of the client that has the device, if there is one.
    pub fn unplug(&mut self, notes: &mut Vec<String>) {
        self.clients.retain(|client| {
            let has_device = client.session.has_device();
            if has_device {
                self.departed = true;
                notes.push(format!("usbip: {} is unplugged", client.connection.peer));
            }
            !has_device
        });
    }

    /// Takes received bytes, answers clients without a device, and notices new and closed connections.
    /// `busy`: the cable belongs to a usbredir peer.
    pub fn hear(&mut self, hub: &Hub, now_ns: u64, busy: bool, notes: &mut Vec<String>) {
        while let Some(connection) = Connection::accept(&self.listener) {
            let session = Session::default();
            self.clients.push(Client { connection, session, wants_cable: false, failed: false });
        }
        let mut had = self.clients.iter().any(|client| client.session.has_device());
        for client in &mut self.clients {
            let came = client.connection.read(client.session.unread());
            client.session.receive(&came);
            let others = (busy || had).then_some(Refusal::Busy);
            match client.session.answer(hub, now_ns, others) {
                Ok(needs_cable) => client.wants_cable |= needs_cable,
                Err(why) => client.fail(&why, notes),
            }
            if !had && client.session.has_device() {
                had = true;
                client.wants_cable = true;
                notes.push(format!("usbip: {} plugs in", client.connection.peer));
            }
        }
        self.clients.retain(|client| {
            let goes = client.connection.is_closed || client.failed;
            if goes && client.session.has_device() {
                self.departed = true;
                notes.push(format!("usbip: {} has unplugged", client.connection.peer));
            }
            !goes
        });
    }

    /// Serves the client that has the device.
    pub fn serve<F: Function>(
        &mut self,
        root: &mut Root<'_, F>,
        completions: Vec<Completion>,
        notes: &mut Vec<String>,
    ) {
        if let Some(client) = self.clients.iter_mut().find(|client| client.session.has_device())
            && let Err(why) = client.session.serve(root, completions)
        {
            client.fail(&why, notes);
        }
    }

    /// Sends the output, and closes sessions that are over.
    pub fn say(&mut self, notes: &mut Vec<String>) {
        for client in &mut self.clients {
            client.connection.write(client.session.output());
        }
        self.clients.retain_mut(|client| {
            let over = client.session.is_over() && client.session.output().is_empty();
            if over && client.session.had_device() {
                self.departed = true;
                notes.push(format!("usbip: {} has lost the device, and has to attach again", client.connection.peer));
            }
            !over
        });
    }
}

impl Client {
    fn fail(&mut self, why: &str, notes: &mut Vec<String>) {
        notes.push(format!("usbip: {} is not understood: {why}", self.connection.peer));
        self.failed = true;
    }
}

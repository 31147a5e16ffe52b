//! The port for usbredir: one peer at a time.

use std::io;
use std::net::{SocketAddr, TcpListener};

use super::connection::{Connection, listen};
use crate::hub::Root;
use crate::transfer::Completion;
use crate::usbredir::session::Session;
use crate::wire::Function;

/// The port with its peer.
#[derive(Debug)]
pub struct Peer {
    listener: TcpListener,
    peer: Option<(Connection, Session)>,
    /// Whether a peer has gone since the last question.
    departed: bool,
}

impl Peer {
    /// Listens at a TCP address. Fails where that is taken or not of this computer.
    pub fn listen(address: SocketAddr) -> io::Result<Self> {
        Ok(Self { listener: listen(address)?, peer: None, departed: false })
    }

    /// Returns the TCP address, with the port that the system chose if none was named.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Whether there is a peer that wants the device.
    pub fn wants_device(&self) -> bool {
        self.peer.as_ref().is_some_and(|(_, session)| session.wants_device())
    }

    /// Whether a peer has gone since the last call.
    pub const fn take_departure(&mut self) -> bool {
        std::mem::replace(&mut self.departed, false)
    }

    fn leave(&mut self) {
        self.peer = None;
        self.departed = true;
    }

    /// Closes the connection of the peer, if there is one.
    pub fn unplug(&mut self, notes: &mut Vec<String>) {
        if let Some((connection, _)) = &self.peer {
            notes.push(format!("usbredir: {} is unplugged", connection.peer));
            self.leave();
        }
    }

    /// Takes received bytes, and notices a peer that comes or goes.
    pub fn hear(&mut self, notes: &mut Vec<String>) {
        if let Some((connection, session)) = &mut self.peer {
            let came = connection.read(session.stream().unread());
            session.stream().receive(&came);
            if connection.is_closed {
                notes.push(format!("usbredir: {} has unplugged", connection.peer));
                self.leave();
            }
        }
        while let Some(connection) = Connection::accept(&self.listener) {
            // There is only one socket, so a second peer is turned away.
            if self.peer.is_none() {
                notes.push(format!("usbredir: {} plugs in", connection.peer));
                self.peer = Some((connection, Session::default()));
            }
        }
        if let Some((connection, session)) = &mut self.peer
            && let Err(why) = session.begin()
        {
            notes.push(format!("usbredir: {} does not speak it: {why}", connection.peer));
            self.leave();
        }
    }

    /// Serves the peer with the device at hand.
    pub fn serve<F: Function>(
        &mut self,
        root: &mut Root<'_, F>,
        completions: Vec<Completion>,
        notes: &mut Vec<String>,
    ) {
        let Some((connection, session)) = &mut self.peer else { return };
        let wanted = session.wants_device();
        if let Err(why) = session.serve(root, completions) {
            notes.push(format!("usbredir: {} is not understood: {why}", connection.peer));
            self.leave();
        } else if wanted && session.is_rejected() {
            notes.push(format!("usbredir: {} does not want this device", connection.peer));
        }
    }

    /// Sends the output to the peer.
    pub fn say(&mut self) {
        if let Some((connection, session)) = &mut self.peer {
            connection.write(session.stream().output());
        }
    }
}

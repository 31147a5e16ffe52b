//! A serial port of the board on TCP.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use virtual_prime::console::Line;
use virtual_prime::typed::AHEAD;

use super::clock_file::Traffic;

/// A serial port on TCP: the latest client to connect has the wire.
pub struct SerialSocket {
    listener: TcpListener,
    client: Option<TcpStream>,
    /// Bytes from all clients so far, and to them.
    heard: u64,
    said: u64,
    /// Serial line to the board.
    pub line: Line,
}

impl SerialSocket {
    /// Begins to listen on this port of the loopback interface; 0 lets the system choose.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn open(port: u16, line: Line) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, client: None, heard: 0, said: 0, line })
    }

    /// Returns the listening address.
    ///
    /// # Errors
    /// What the system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Accepts a new client, and takes as much of the present client's bytes as the wire takes.
    pub fn hear(&mut self) {
        if let Ok((client, _)) = self.listener.accept() {
            // A byte on a wire does not wait for those that follow.
            let is_ready = client.set_nonblocking(true).and_then(|()| client.set_nodelay(true)).is_ok();
            self.client = is_ready.then_some(client);
        }
        let mut bytes = [0; AHEAD];
        if let Some(client) = &mut self.client
            && self.line.unsent() < AHEAD
        {
            match client.read(&mut bytes) {
                Ok(0) => self.client = None,
                Ok(count) => {
                    self.heard += count as u64;
                    self.line.send(&bytes[..count]);
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => self.client = None,
            }
        }
    }

    /// Sends bytes to the client. A client that does not take its bytes loses them, as on a wire.
    pub fn say(&mut self, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let Some(client) = &mut self.client else { return };
        self.said += bytes.len() as u64;
        if client.write_all(bytes).is_err_and(|error| error.kind() != io::ErrorKind::WouldBlock) {
            self.client = None;
        }
    }

    /// Returns what has passed so far.
    pub fn traffic(&self) -> Traffic {
        Traffic { heard: self.heard, said: self.said, has_room: self.line.unsent() < AHEAD }
    }
}

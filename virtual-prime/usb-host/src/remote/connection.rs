//! A non-blocking TCP connection.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

/// Most unread bytes; beyond them the sender is held back.
const MOST_UNREAD: usize = 1 << 20;

/// Returns a non-blocking listener.
pub fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let listener = TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// A connection to a computer.
#[derive(Debug)]
pub struct Connection {
    stream: TcpStream,
    /// Address of the other end.
    pub peer: SocketAddr,
    /// Whether the other end has closed the connection, or it has broken.
    pub is_closed: bool,
}

impl Connection {
    /// Accepts the next incoming connection.
    pub fn accept(listener: &TcpListener) -> Option<Self> {
        let (stream, peer) = listener.accept().ok()?;
        stream.set_nonblocking(true).ok()?;
        // An answer must not wait for the acknowledgement of the answer before.
        stream.set_nodelay(true).ok()?;
        Some(Self { stream, peer, is_closed: false })
    }

    /// Reads received bytes, while fewer than the most are unread. `unread` counts those from earlier calls.
    pub fn read(&mut self, unread: usize) -> Vec<u8> {
        let mut all = Vec::new();
        let mut bytes = [0; 16_384];
        while !self.is_closed && unread + all.len() < MOST_UNREAD {
            match self.stream.read(&mut bytes) {
                Ok(0) => self.is_closed = true,
                Ok(count) => all.extend(&bytes[..count]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => self.is_closed = true,
            }
        }
        all
    }

    /// Sends as much as the system takes; the rest stays in `bytes`.
    pub fn write(&mut self, bytes: &mut Vec<u8>) {
        let mut sent = 0;
        while !self.is_closed && sent < bytes.len() {
            match self.stream.write(&bytes[sent..]) {
                Ok(count) => sent += count,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => self.is_closed = true,
            }
        }
        bytes.drain(..sent);
    }
}

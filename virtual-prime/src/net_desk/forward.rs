//! TCP ports of this computer that lead to ports of the board: every connection to one of them is carried on
//! to the board by the computer at the other end of its cable. No rights and no network device are needed.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};

use super::peer::{Connection, Peer};

/// Bytes that are taken from either side at once.
const PIECE: usize = 4_096;

/// A port of this computer's, and the connections to it.
pub struct Forward {
    listener: TcpListener,
    board_port: u16,
    links: Vec<Link>,
}

/// A connection from a program here to the board.
struct Link {
    stream: TcpStream,
    /// Connection on the board's side, once the board's address is known.
    connection: Option<Connection>,
    /// Bytes for the board, and for the program.
    to_board: VecDeque<u8>,
    to_program: VecDeque<u8>,
    /// Whether the program has ended its direction, and whether that has been passed on.
    program_ended: bool,
    is_closed: bool,
    is_dead: bool,
}

/// Whether an error of a socket means that there is nothing to do now.
fn waits(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

impl Forward {
    /// Listens on a port of this computer's; zero lets the system choose.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn listen(port: u16, board_port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, board_port, links: Vec::new() })
    }

    /// Returns the address that it listens on.
    ///
    /// # Errors
    /// When the system does not know it.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Port of the board's that it leads to.
    #[must_use]
    pub const fn board_port(&self) -> u16 {
        self.board_port
    }

    /// Returns the number of connections.
    #[must_use]
    pub const fn links(&self) -> usize {
        self.links.len()
    }

    /// Returns the connections to the board.
    pub fn connections(&self) -> Vec<Connection> {
        self.links.iter().filter_map(|link| link.connection).collect()
    }

    /// Takes new connections, and carries bytes both ways.
    pub fn serve(&mut self, peer: &mut Peer) {
        while let Ok((stream, _)) = self.listener.accept() {
            if stream.set_nonblocking(true).is_ok() {
                // Without this, short answers wait for the acknowledgement of those before them.
                let _ = stream.set_nodelay(true);
                self.links.push(Link::new(stream));
            }
        }
        for link in &mut self.links {
            link.serve(peer, self.board_port);
        }
        self.links.retain(|link| !link.is_dead);
    }
}

impl Link {
    const fn new(stream: TcpStream) -> Self {
        Self {
            stream,
            connection: None,
            to_board: VecDeque::new(),
            to_program: VecDeque::new(),
            program_ended: false,
            is_closed: false,
            is_dead: false,
        }
    }

    fn serve(&mut self, peer: &mut Peer, board_port: u16) {
        self.hear();
        let Some(connection) = self.connection else {
            // The program waits while the board has no address.
            self.connection = peer.connect(board_port);
            return;
        };
        let (front, _) = self.to_board.as_slices();
        let sent = peer.send(connection, front);
        self.to_board.drain(..sent);
        if self.to_program.len() < PIECE {
            self.to_program.extend(peer.receive_at_most(connection, PIECE));
        }
        self.speak();
        if self.program_ended && self.to_board.is_empty() && !self.is_closed {
            peer.close(connection);
            self.is_closed = true;
        }
        let has_ended = peer.has_ended(connection) && self.to_program.is_empty();
        if has_ended && peer.is_over(connection) || self.is_dead {
            self.end(peer, connection);
        } else if has_ended {
            // The program may still have something to say.
            let _ = self.stream.shutdown(Shutdown::Write);
        }
    }

    /// Takes what the program has sent.
    fn hear(&mut self) {
        let mut piece = [0; PIECE];
        while !self.program_ended && self.to_board.len() < PIECE {
            match self.stream.read(&mut piece) {
                Ok(0) => self.program_ended = true,
                Ok(count) => self.to_board.extend(&piece[..count]),
                Err(error) if waits(&error) => return,
                Err(_) => {
                    self.is_dead = true;
                    return;
                }
            }
        }
    }

    /// Hands on what the board has sent.
    fn speak(&mut self) {
        while !self.to_program.is_empty() {
            let (front, _) = self.to_program.as_slices();
            match self.stream.write(front) {
                Ok(count) => drop(self.to_program.drain(..count)),
                Err(error) if waits(&error) => return,
                Err(_) => {
                    self.is_dead = true;
                    return;
                }
            }
        }
    }

    /// Ends both connections: the board's is reset if it still stands.
    fn end(&mut self, peer: &mut Peer, connection: Connection) {
        self.is_dead = true;
        peer.retire(connection);
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

//! A connection to a console over TCP. The board is heard on a thread of its own, so that a board that waits
//! for its answers to be taken goes on while lines are sent.

use std::io::{Error, ErrorKind, Read, Result, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use super::telnet::{self, Decoder};

/// Time that a connection may take to be made.
const CONNECTING: Duration = Duration::from_secs(5);
/// Longest wait for an answer of a reader as of a serial port.
const POLL: Duration = Duration::from_millis(100);
/// Time after which a board that takes nothing is given up.
const PATIENCE: Duration = Duration::from_secs(600);

/// Result of listening to the board for a moment.
#[derive(Debug, PartialEq, Eq)]
pub enum Heard {
    /// Nothing to read yet.
    Nothing,
    /// Text of the board.
    Text(Vec<u8>),
    /// The board has closed the connection.
    End,
}

/// Bytes of the board, decoded by the listening thread.
struct Piece {
    text: Vec<u8>,
    /// Answers of telnet, to be sent.
    answers: Vec<u8>,
    /// Whether the peer has shown that it speaks telnet.
    is_telnet: bool,
}

/// TCP connection to a board's console, with telnet's negotiation taken out of what comes.
pub struct Connection {
    stream: TcpStream,
    pieces: Receiver<Result<Piece>>,
    is_telnet: bool,
    /// Text that a reader with a small buffer has not taken yet.
    unread: Vec<u8>,
}

impl Connection {
    /// Connects to the first of these addresses that answers.
    pub fn open(addresses: &[SocketAddr]) -> Result<Self> {
        let mut last = Error::new(ErrorKind::NotFound, "no address");
        for address in addresses {
            match TcpStream::connect_timeout(address, CONNECTING) {
                Ok(stream) => return Self::new(stream),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    fn new(stream: TcpStream) -> Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let (to, pieces) = channel();
        let ear = stream.try_clone()?;
        std::thread::spawn(move || listen(ear, &to));
        Ok(Self { stream, pieces, is_telnet: false, unread: Vec::new() })
    }

    /// Waits for text of the board, so long at the most.
    pub fn hear(&mut self, wait: Duration) -> Result<Heard> {
        let piece = match self.pieces.recv_timeout(wait) {
            Ok(piece) => piece?,
            Err(RecvTimeoutError::Timeout) => return Ok(Heard::Nothing),
            Err(RecvTimeoutError::Disconnected) => return Ok(Heard::End),
        };
        self.is_telnet = piece.is_telnet;
        if !piece.answers.is_empty() {
            // A board that hears nothing any more may still have said something.
            let _heard = self.stream.write_all(&piece.answers);
        }
        Ok(if piece.text.is_empty() { Heard::Nothing } else { Heard::Text(piece.text) })
    }
}

/// Reads until the connection ends.
fn listen(mut ear: TcpStream, to: &Sender<Result<Piece>>) {
    let (mut decoder, mut bytes) = (Decoder::default(), [0; 4_096]);
    loop {
        let heard = match ear.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => {
                let (text, answers) = decoder.hear(bytes.get(..count).unwrap_or_default());
                Ok(Piece { text, answers, is_telnet: decoder.is_telnet() })
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            // Some boards break a connection off rather than close it.
            Err(error) if error.kind() == ErrorKind::ConnectionReset => return,
            Err(error) => Err(error),
        };
        let is_over = heard.is_err();
        if to.send(heard).is_err() || is_over {
            return;
        }
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        let _is_closed = self.stream.shutdown(Shutdown::Both);
    }
}

/// Reads as from a serial port: an error of the kind `TimedOut` says that there is nothing yet.
impl Read for Connection {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.unread.is_empty() {
            match self.hear(POLL)? {
                Heard::Text(text) => self.unread = text,
                Heard::Nothing => return Err(ErrorKind::TimedOut.into()),
                Heard::End => return Ok(0),
            }
        }
        let count = self.unread.as_slice().read(buffer)?;
        self.unread.drain(..count);
        Ok(count)
    }
}

/// Writes text in the form that the board understands.
impl Write for Connection {
    fn write(&mut self, text: &[u8]) -> Result<usize> {
        self.stream.write_all(&telnet::encode(text, self.is_telnet))?;
        Ok(text.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

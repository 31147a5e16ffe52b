//! Messages one after another on a connection, each with its head: kind, length of the body, identifier.
//!
//! The identifier has 32 bits in HELLO, and 64 in everything after it if both sides know them. Only with the
//! peer's HELLO is that known, so nothing but our own HELLO may be sent before.

use super::codec::Malformed;
use super::message::{Capabilities, Message, number};

/// Greatest length of a body that is accepted: a bulk packet of a program on the peer's side that asks for a
/// lot.
const MOST_BYTES: usize = 64 << 20;
const SHORT_HEAD: usize = 12;
const LONG_HEAD: usize = 16;

/// The two directions of a connection.
#[derive(Debug)]
pub struct Stream {
    ours: Capabilities,
    /// Capabilities that both sides have, once the peer's HELLO has come.
    agreed: Option<Capabilities>,
    input: Vec<u8>,
    /// Bytes of `input` that have been read.
    read: usize,
    output: Vec<u8>,
}

impl Stream {
    /// Creates a connection that begins with our HELLO.
    #[must_use]
    pub fn new(name: &str, ours: Capabilities) -> Self {
        let mut stream = Self { ours, agreed: None, input: Vec::new(), read: 0, output: Vec::new() };
        stream.put(0, &Message::Hello(name.to_owned(), ours), Capabilities::default());
        stream
    }

    /// Returns the capabilities that both sides have, once the peer's HELLO has come.
    #[must_use]
    pub const fn agreed(&self) -> Option<Capabilities> {
        self.agreed
    }

    /// Takes received bytes as input.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.input.extend(bytes);
    }

    /// Received bytes that no message has been read from yet.
    #[must_use]
    pub const fn unread(&self) -> usize {
        self.input.len() - self.read
    }

    /// Returns the bytes that are to go to the peer.
    pub const fn output(&mut self) -> &mut Vec<u8> {
        &mut self.output
    }

    /// Returns the next complete message, with its identifier.
    ///
    /// # Errors
    /// The peer does not speak the protocol. Nothing after that can be made sense of.
    pub fn take_message(&mut self) -> Result<Option<(u64, Message)>, Malformed> {
        let input = &self.input[self.read..];
        let wide = self.agreed.is_some_and(|agreed| agreed.has(Capabilities::WIDE_IDS));
        let head_bytes = if wide { LONG_HEAD } else { SHORT_HEAD };
        let Some((head, rest)) = input.split_at_checked(head_bytes) else { return Ok(self.wait()) };
        let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (kind, length, low) = (word(0), word(4) as usize, word(8));
        let id = u64::from(if wide { word(12) } else { 0 }) << 32 | u64::from(low);
        if (kind == number::HELLO) != self.agreed.is_none() {
            return Err(Malformed(format!("message {kind} where HELLO should be, or HELLO where it should not")));
        }
        if length > MOST_BYTES {
            return Err(Malformed(format!("message {kind} of {length} bytes")));
        }
        let Some(body) = rest.get(..length) else { return Ok(self.wait()) };
        let message = Message::parse(kind, body, self.agreed.unwrap_or_default())
            .map_err(|why| Malformed(format!("message {kind}: {why}")))?;
        if let Message::Hello(_, known) = message {
            self.agreed = Some(known.and(self.ours));
        }
        self.read += head_bytes + length;
        Ok(Some((id, message)))
    }

    /// Forgets the bytes that were read, as no complete message is left.
    fn wait<T>(&mut self) -> Option<T> {
        self.input.drain(..std::mem::take(&mut self.read));
        None
    }

    /// Sends a message, which before the peer's HELLO is ignored.
    pub fn send(&mut self, id: u64, message: &Message) {
        if let Some(agreed) = self.agreed {
            self.put(id, message, agreed);
        }
    }

    fn put(&mut self, id: u64, message: &Message, agreed: Capabilities) {
        let body = message.body(agreed);
        self.output.extend(message.kind().to_le_bytes());
        self.output.extend((body.len() as u32).to_le_bytes());
        if agreed.has(Capabilities::WIDE_IDS) {
            self.output.extend(id.to_le_bytes());
        } else {
            self.output.extend((id as u32).to_le_bytes());
        }
        self.output.extend(body);
    }
}

//! Connection between a visitor and a console of the machine.

use core::net::Ipv4Addr;
use core::ops::Range;

use crate::settings::Service;

/// Rights of a visitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Runs the machine.
    Operate,
    /// Changes how the machine is set up, too.
    Own,
}

/// Peer that a console is opened for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visitor {
    /// Service that the visitor came to.
    pub service: Service,
    /// Rights of the visitor.
    pub role: Role,
    /// Address that the visitor came from.
    pub from: Ipv4Addr,
}

/// Console of the machine that a visitor is connected to.
///
/// The order of calls: `open`, then `receive` and `look_ahead` any number of times, then `close`.
pub trait Line {
    /// Returns how many bytes surely fit now.
    fn room(&self) -> usize;

    /// Takes bytes that have room.
    fn receive(&mut self, bytes: &[u8]);

    /// Looks through bytes that have no room yet, for one that acts at once.
    ///
    /// `waiting` is all that has come behind what was received, in order; the first `looked` bytes of it were
    /// looked through before. If something at or behind `looked` acts at once, it acts now, and the bytes
    /// that are not to be received any more are returned: the byte itself, or all up to it where it drops
    /// what was sent before. `None` if nothing acts.
    fn look_ahead(&mut self, waiting: &[u8], looked: usize) -> Option<Range<usize>>;

    /// A visitor has come.
    fn open(&mut self, visitor: Visitor);

    /// The visitor has gone.
    fn close(&mut self);
}

//! Tests of connections as a whole.

mod answers;
mod life;
mod refusals;
mod sockets;

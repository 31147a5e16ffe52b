//! Tests of connections.

mod answers;
mod life;
mod refusals;
mod sockets;

//! Devices at the other end of the board's Ethernet cable: [`peer`] is a computer with servers and clients
//! behind a line that can be bad, [`forward`] leads ports of this computer through it, [`tap`] is a device of
//! Linux; [`frames`] makes what no stack would send.

pub mod answers;
pub mod dhcp;
pub mod forward;
pub mod frames;
pub mod impairment;
pub mod peer;
pub mod tap;

mod port;

#[cfg(test)]
mod tests;

use rigless::time::VirtualNanos;

use crate::peripherals::ethernet::Wire;
use crate::vm::Vm;

/// Runs `work` with the cable and its far end, at the instant at which the board is held; `None` once the run
/// has ended.
pub fn wire<R: Send + 'static>(vm: &mut Vm, work: impl FnOnce(&mut Wire) -> R + Send + 'static) -> Option<R> {
    vm.with(move |stopped| {
        let at = VirtualNanos(stopped.stop.at.0);
        stopped.session.board_mut().mcu.wire(at, work)
    })
}

//! The network: joined when the configuration asks for it, its news told to every console, its time set on
//! the board's clock; the question `net`, and the password of network consoles.
//!
//! Frames, addresses, names and connections are below the port ([`base::ports::Network`]). Consoles over the
//! network are sessions as any others.

mod kept;
mod keys;
mod password;
mod report;

use base::failure::{Answer, Outcome};
use base::ports::{DateTime, Network as _, NetworkAddress, NetworkNews};
use base::secrets::{KEYS_PATH, PASSWORD_PATH};
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use config::MachineConfig;
use units::Micros;

use crate::machine::moments::Moments;
use crate::machine::work_hands::WorldHands;

pub(crate) use password::set as set_password;

/// The network at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: WorldHands<'c>> Moments<M> for Feature {
    fn started(hands: &mut M, _is_usable: bool) {
        let world = hands.world();
        if is_wanted(world.config) {
            join(world);
        }
    }

    fn each_10_ms(hands: &mut M, _now: Micros) {
        let world = hands.world();
        while let Some(news) = world.ports.take_network_news() {
            tell_news(world, &news);
        }
    }
}

/// Whether the configuration asks for the network, without an error there.
fn is_wanted(config: &MachineConfig) -> bool {
    config.network.enable && config.off("network", "").is_none()
}

fn join<P: Ports>(world: &mut World<'_, P>) {
    if let Err(why) = world.ports.join_network(&world.config.network) {
        world.announce(format_args!("ERROR: the network does not work: {why}\n"));
    }
    if let Err(why) = password::load(&mut world.ports) {
        world.announce(format_args!("ERROR: {PASSWORD_PATH}: {why}; no password is known\n"));
    }
    if let Err(why) = keys::load(&mut world.ports) {
        world.announce(format_args!("ERROR: {KEYS_PATH}: {why}; no key lets anybody in\n"));
    }
}

/// Tells everybody of a change, or sets the clock.
fn tell_news<P: Ports>(world: &mut World<'_, P>, news: &NetworkNews) {
    match news {
        NetworkNews::Address(NetworkAddress { address, origin, .. }) => {
            let name = world.ports.network_report().map(|report| report.name).unwrap_or_default();
            let origin = origin.words();
            if name.is_empty() {
                world.announce(format_args!("// network: {address} ({origin})\n"));
            } else {
                world.announce(format_args!("// network: {address} ({origin}), {name}.local\n"));
            }
        }
        NetworkNews::NoAddress => world.announce(format_args!("// network: no address any more\n")),
        NetworkNews::AddressTaken(address) => {
            world.announce(format_args!(
                "WARNING: another machine has the address {address}: change [network] ip_address, or switch that machine off\n"
            ));
        }
        NetworkNews::Renamed(name) => {
            world.announce(format_args!("// network: another machine has the name; this one is {name}.local now\n"));
        }
        NetworkNews::WrongPassword(from) => {
            world.announce(format_args!("// network: a wrong password came from {from}\n"));
        }
        NetworkNews::Code(code, from) => world.tell_at_machine(format_args!(
            "// network: code {code:06} sets the password that was chosen on the page at {from}: type it there, if that was you\n"
        )),
        NetworkNews::NewPassword => password::keep(&mut world.ports),
        NetworkNews::NewKeys => keys::keep(&mut world.ports),
        NetworkNews::Fault(why) => world.announce(format_args!("ERROR: the network does not work: {why}\n")),
        NetworkNews::Time(seconds) => {
            let offset = i64::from(world.config.network.timezone_minutes) * 60;
            if let Some(date) = DateTime::from_unix(seconds.saturating_add_signed(offset)) {
                // A clock that does not run has been reported at the start.
                let _ = world.ports.set_date(date);
            }
        }
    }
}

/// Tells the state of the network: `net`.
pub(crate) fn tell<P: Ports>(world: &mut World<'_, P>, to: Recipient) -> Outcome {
    let World { ports, sessions, config, .. } = world;
    report::tell(ports.network_report(), is_wanted(config), &mut Reply::new(sessions, to));
    Ok(Answer::Ok)
}

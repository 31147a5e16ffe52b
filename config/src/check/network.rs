//! Checks of addresses and of the machine's name in the network.

use core::net::Ipv4Addr;

use super::findings::Checks;
use crate::machine::Address;

/// Checks that texts are addresses, that a fixed address fits its netmask and gateway, and that ports differ.
pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let network = checks.config.network.clone();
    if !network.enable {
        return;
    }
    let texts = [
        ("ip_address", network.address, "write four numbers, as 192.168.1.45, or auto"),
        ("ip_mask", network.mask, "write four numbers, as 255.255.255.0"),
        ("ip_gateway", network.gateway, "write four numbers, as 192.168.1.1, or nothing"),
        ("dns_server", network.dns, "write four numbers, as 192.168.1.1, or auto"),
    ];
    for (key, _, fix) in texts.into_iter().filter(|(_, address, _)| *address == Address::Flawed) {
        checks.error(("network", 0, key), format_args!("this is no IPv4 address"), format_args!("{fix}"));
    }
    if !network.has_good_name() {
        let reason = format_args!("this cannot be a name in the network");
        checks.error(("network", 0, "hostname"), reason, format_args!("write letters, digits and hyphens, as velvet"));
    }
    if network.shell && network.grbl && network.shell_port == network.grbl_port {
        let reason = format_args!("the other console has TCP port {} already", network.shell_port);
        checks.error(("network", 0, "grbl_port"), reason, format_args!("write another port, as 2323"));
    }
    let consoles = [(network.shell, network.shell_port), (network.grbl, network.grbl_port)];
    if network.web && consoles.contains(&(true, network.web_port)) {
        let reason = format_args!("a console has TCP port {} already", network.web_port);
        checks.error(("network", 0, "webserver_port"), reason, format_args!("write another port, as 80"));
    }
    if let Some(address) = network.address.given() {
        fixed(checks, address);
    }
}

/// Checks a fixed address against its netmask and gateway.
fn fixed(checks: &mut Checks<'_, '_>, address: Ipv4Addr) {
    let network = &checks.config.network;
    let (gateway, is_flawed) = (network.gateway.given().map(Ipv4Addr::to_bits), network.mask == Address::Flawed);
    let Some(bits) = network.mask_bits().filter(|bits| (1..=30).contains(bits)) else {
        if !is_flawed {
            let reason = format_args!("this is no netmask of a network with several machines");
            checks.error(
                ("network", 0, "ip_mask"),
                reason,
                format_args!("write 255.255.255.0, if nobody says otherwise"),
            );
        }
        return;
    };
    let hosts = u32::MAX.checked_shr(u32::from(bits)).unwrap_or(0);
    let first = address.octets()[0];
    let address = address.to_bits();
    if address & hosts == 0 || address & hosts == hosts || first == 0 || first == 127 || first >= 224 {
        let reason = format_args!("no machine can have this address");
        checks.error(
            ("network", 0, "ip_address"),
            reason,
            format_args!("write a free address of your network, or auto"),
        );
    } else if gateway.is_some_and(|gateway| gateway & !hosts != address & !hosts || gateway == address) {
        let reason = format_args!("the gateway is not in the network of ip_address and ip_mask");
        checks.warn(("network", 0, "ip_gateway"), reason, format_args!("write the router's address, or nothing"));
    }
}

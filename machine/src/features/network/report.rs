//! The answer to `net`: Smoothieware's four lines, then what it does not say.

use core::net::Ipv4Addr;

use base::ports::{NetworkAddress, NetworkReport, NetworkTraffic};
use base::sessions::Reply;

/// Says the state of the network; `is_wanted`: the configuration asks for it.
pub(super) fn tell(report: Option<NetworkReport>, is_wanted: bool, reply: &mut Reply<'_>) {
    let Some(report) = report else {
        let why = if is_wanted { "it does not work, see the messages of the start" } else { "[network] enable is off" };
        return reply.say(format_args!("No network: {why}\n"));
    };
    let NetworkReport { mac, link, address, name, traffic, services, has_password, clock_set_ago } = report;
    match link {
        Some(link) => {
            let duplex = if link.is_full_duplex { "full" } else { "half" };
            reply.say(format_args!("Link: {} Mbit/s, {duplex} duplex\n", link.mbit));
        }
        None => reply.say(format_args!("Link DOWN\n")),
    }
    match address {
        Some(address) => tell_address(&address, reply),
        None if link.is_some() => reply.say(format_args!("IP Address: looking for one\n")),
        None => {}
    }
    let [a, b, c, d, e, f] = mac;
    reply.say(format_args!("MAC Address: {a:02X}:{b:02X}:{c:02X}:{d:02X}:{e:02X}:{f:02X}\n"));
    if !name.is_empty() {
        reply.say(format_args!("Name: {name}.local\n"));
    }
    for service in &services {
        reply.say(format_args!("{}: port {}, {} connected\n", service.name, service.port, service.peers));
    }
    if !services.is_empty() {
        reply.say(format_args!("Password: {}\n", if has_password { "set" } else { "none; password WORD sets one" }));
    }
    if let Some(ago) = clock_set_ago {
        reply.say(format_args!("Clock: set from the network {ago} s ago\n"));
    }
    tell_traffic(&traffic, reply);
}

fn tell_address(address: &NetworkAddress, reply: &mut Reply<'_>) {
    let mask = Ipv4Addr::from(u32::MAX.checked_shl(32 - u32::from(address.mask_bits)).unwrap_or(0));
    reply.say(format_args!("IP Address: {} ({})\n", address.address, address.origin.words()));
    reply.say(format_args!("Subnet Mask: {}\n", mask));
    if let Some(gateway) = address.gateway {
        reply.say(format_args!("Gateway Address: {}\n", gateway));
    }
    if let Some(dns) = address.dns {
        reply.say(format_args!("DNS Server Address: {}\n", dns));
    }
}

fn tell_traffic(traffic: &NetworkTraffic, reply: &mut Reply<'_>) {
    let ((frames_in, bytes_in), (frames_out, bytes_out)) = (traffic.received, traffic.sent);
    reply.say(format_args!(
        "Received: {frames_in} frames, {bytes_in} bytes. Sent: {frames_out} frames, {bytes_out} bytes\n"
    ));
    let NetworkTraffic { damaged, lost, broadcasts_left_out, links, .. } = *traffic;
    if damaged > 0 {
        reply.say(format_args!("Damaged frames: {damaged}; look at the cable, or try [network] link = 10\n"));
    }
    if lost > 0 {
        reply.say(format_args!("Frames lost for want of room: {lost}\n"));
    }
    if broadcasts_left_out > 0 {
        reply.say(format_args!("Broadcasts left out, too many came at once: {broadcasts_left_out}\n"));
    }
    if links > 1 {
        reply.say(format_args!("The cable, or the other end, was away {} times\n", links - 1));
    }
}

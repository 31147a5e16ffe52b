//! The board's Ethernet socket for this computer: `console --net`, `console --tap`.

use std::net::IpAddr;

use clap::Args;
use virtual_prime::net_desk;
use virtual_prime::net_desk::forward::Forward;
use virtual_prime::net_desk::peer::Peer;
use virtual_prime::net_desk::tap::Tap;
use virtual_prime::peripherals::ethernet::Partner;
use virtual_prime::vm::Vm;

/// Where the socket leads to.
#[derive(Args)]
pub struct NetOptions {
    /// Plug in a network with a DHCP server, and lead ports of this computer to ports of the board.
    #[arg(long, conflicts_with = "tap")]
    net: bool,
    /// Port of the board that is led to, or PORT:BOARD with the port of this computer; any number of times.
    #[arg(long = "telnet-port", value_name = "[PORT:]BOARD", default_value = "23", value_parser = ports)]
    telnet_ports: Vec<(u16, u16)>,
    /// The same for a port of the board that serves web pages.
    #[arg(long = "web-port", value_name = "[PORT:]BOARD", value_parser = ports)]
    web_ports: Vec<(u16, u16)>,
    /// Plug in a TAP device of Linux, made with `ip tuntap add dev NAME mode tap user $USER`.
    #[arg(long, value_name = "NAME")]
    tap: Option<String>,
}

/// Reads a pair of ports: of this computer, which is zero when it is not said, and of the board.
fn ports(text: &str) -> Result<(u16, u16), String> {
    let number = |text: &str| text.parse::<u16>().map_err(|error| error.to_string());
    match text.split_once(':') {
        Some((own, board)) => Ok((number(own)?, number(board)?)),
        None => Ok((0, number(text)?)),
    }
}

/// What the cable leads to.
enum End {
    Ports(Box<Peer>, Vec<Forward>),
    Tap(Tap),
}

/// The cable.
pub struct NetSocket {
    end: End,
    is_plugged: bool,
}

impl NetSocket {
    /// Opens ports or the device, if that is asked for, and prints how to use them.
    ///
    /// # Errors
    /// Which port or device cannot be had.
    pub fn open(options: &NetOptions) -> Result<Option<Self>, String> {
        let end = if let Some(name) = &options.tap {
            eprintln!("the network is on {name}");
            End::Tap(Tap::open(name).map_err(|error| format!("{name}: {error}"))?)
        } else if options.net {
            let mut list = forwards(&options.telnet_ports, |ip, port| format!("telnet {ip} {port}"))?;
            list.extend(forwards(&options.web_ports, |ip, port| format!("http://{ip}:{port}/"))?);
            End::Ports(Box::new(Peer::new(1)), list)
        } else {
            return Ok(None);
        };
        Ok(Some(Self { end, is_plugged: false }))
    }

    /// Carries frames and bytes both ways; the cable is plugged in with the first call.
    pub fn serve(&mut self, vm: &mut Vm) {
        if !std::mem::replace(&mut self.is_plugged, true) {
            net_desk::wire(vm, |wire| wire.plug(Partner::default()));
        }
        match &mut self.end {
            End::Ports(peer, forwards) => {
                forwards.iter_mut().for_each(|forward| forward.serve(peer));
                peer.serve(vm);
            }
            End::Tap(tap) => tap.serve(vm),
        }
    }
}

/// Leads ports of this computer to ports of the board, and prints how each is used.
fn forwards(ports: &[(u16, u16)], use_of: impl Fn(IpAddr, u16) -> String) -> Result<Vec<Forward>, String> {
    let mut list = Vec::new();
    for &(own, board) in ports {
        let fail = |error: std::io::Error| format!("port {own}: {error}");
        let forward = Forward::listen(own, board).map_err(fail)?;
        let address = forward.address().map_err(fail)?;
        eprintln!("the board's port {board}: {}", use_of(address.ip(), address.port()));
        list.push(forward);
    }
    Ok(list)
}

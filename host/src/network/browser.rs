//! Browser of mDNS: which machines of the local network offer telnet, and which of them are boards of Velvet.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::net::{IpAddr, Ipv4Addr};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;
use mdns_sd::{
    HostnameResolutionEvent, MDNS_PORT, Receiver, RecvTimeoutError, ResolvedService, ServiceDaemon, ServiceEvent,
};
use serde::Serialize;

/// Service that a board announces while its telnet console is open.
const SERVICE: &str = "_telnet._tcp.local.";
/// Time that a machine may take to answer to its name.
const NAMING: Duration = Duration::from_secs(3);

/// Things to look at when no board answers.
pub const ADVICE: &str = "Look at these:\n\
    - The board is on, its cable is in, and this computer is in the same network.\n\
    - Its config.ini has [network] enable = true and shell_enable = true.\n\
    - A firewall on this computer lets UDP from port 5353 in.\n\
    - `net` on a USB or serial console says the board's link, address and name;\n  \
    `velvet console ADDRESS` needs no mDNS.";

/// Options of every command that asks by mDNS.
#[derive(Args)]
pub struct Mdns {
    /// For tests: the port of mDNS
    #[arg(long, hide = true, default_value_t = MDNS_PORT)]
    mdns_port: u16,
}

/// Machine that offers telnet.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Machine {
    /// Name of the host, as `velvet.local`.
    pub name: String,
    pub address: Ipv4Addr,
    /// Port of the console.
    pub telnet: u16,
    /// Port of the console in GRBL's dialect, if there is one.
    pub grbl: Option<u16>,
    /// Firmware, as it says it is called.
    pub firmware: Option<String>,
    pub version: Option<String>,
}

impl Machine {
    /// Returns whether the machine is a board of Velvet.
    pub fn is_board(&self) -> bool {
        self.firmware.as_deref() == Some("velvet")
    }

    fn new(service: &ResolvedService) -> Option<Self> {
        let text = |key| service.get_property_val_str(key).map(ToOwned::to_owned);
        Some(Self {
            name: service.host.trim_end_matches('.').to_owned(),
            // A board has one; of several any leads there.
            address: service.get_addresses_v4().into_iter().min()?,
            telnet: service.port,
            grbl: text("grbl").and_then(|port| port.parse().ok()),
            firmware: text("firmware"),
            version: text("version"),
        })
    }
}

/// The browser. Asking ends when it is dropped.
pub struct Browser(ServiceDaemon);

impl Browser {
    /// Opens mDNS on all interfaces.
    pub fn new(options: &Mdns) -> Result<Self> {
        ServiceDaemon::new_with_port(options.mdns_port).map(Self).context("mDNS does not work on this computer")
    }

    /// Returns the machines that offer telnet, as far as they answer within this time.
    pub fn machines(&self, wait: Duration) -> Result<Vec<Machine>> {
        let mut found = BTreeMap::new();
        listen(&self.0.browse(SERVICE)?, wait, |event| {
            match event {
                ServiceEvent::ServiceResolved(service) => {
                    found.extend(Machine::new(&service).map(|machine| (service.fullname, machine)));
                }
                ServiceEvent::ServiceRemoved(_, fullname) => drop(found.remove(&fullname)),
                _ => {}
            }
            ControlFlow::<()>::Continue(())
        })?;
        let mut machines: Vec<Machine> = found.into_values().collect();
        machines.sort();
        Ok(machines)
    }

    /// Returns the machine of a name that offers telnet.
    pub fn machine(&self, name: &str) -> Result<Option<Machine>> {
        listen(&self.0.browse(SERVICE)?, NAMING, |event| match event {
            ServiceEvent::ServiceResolved(service) => match Machine::new(&service) {
                Some(machine) if machine.name.eq_ignore_ascii_case(name) => ControlFlow::Break(machine),
                _ => ControlFlow::Continue(()),
            },
            _ => ControlFlow::Continue(()),
        })
    }

    /// Returns the address of a name, whatever the machine offers.
    pub fn address(&self, name: &str) -> Result<Option<Ipv4Addr>> {
        listen(&self.0.resolve_hostname(&format!("{name}."), None)?, NAMING, |event| match event {
            HostnameResolutionEvent::AddressesFound(_, addresses) => {
                let mut addresses = addresses.into_iter().map(|address| address.to_ip_addr());
                let found = addresses.find_map(|address| if let IpAddr::V4(v4) = address { Some(v4) } else { None });
                found.map_or(ControlFlow::Continue(()), ControlFlow::Break)
            }
            _ => ControlFlow::Continue(()),
        })
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _has_ended = self.0.shutdown();
    }
}

/// Hands over events until one is what was looked for, or the time is up.
fn listen<Event, Found>(
    events: &Receiver<Event>,
    wait: Duration,
    mut hear: impl FnMut(Event) -> ControlFlow<Found>,
) -> Result<Option<Found>> {
    let end = Instant::now() + wait;
    loop {
        match events.recv_deadline(end) {
            Ok(event) => {
                if let ControlFlow::Break(found) = hear(event) {
                    return Ok(Some(found));
                }
            }
            Err(RecvTimeoutError::Timeout) => return Ok(None),
            Err(RecvTimeoutError::Disconnected) => bail!("mDNS has stopped working on this computer"),
        }
    }
}

/// Returns a line a board, in columns.
pub fn table(boards: &[Machine]) -> String {
    let width = boards.iter().map(|board| board.name.chars().count()).max().unwrap_or(0);
    let mut table = String::new();
    for Machine { name, address, telnet, grbl, version, .. } in boards {
        let grbl = grbl.map(|port| format!(", GRBL's dialect {port}")).unwrap_or_default();
        let version = version.as_ref().map(|version| format!(", version {version}")).unwrap_or_default();
        let _written = writeln!(table, "{name:width$}  {:15}  telnet {telnet}{grbl}{version}", address.to_string());
    }
    table
}

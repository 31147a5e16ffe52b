//! Settings of `[network]`.

use base::ports::NetworkNews;
use scenarios::Bench;

use super::See::{Board, Look, Say};
use super::{Row, row};

const ON: &[&str] = &["[network] enable = true"];
const CONSOLES: &[&str] = &["[network] enable = true", "[network] shell_enable = true", "[network] grbl_enable = true"];
const PAGE: &[&str] = &["[network] enable = true", "[network] webserver_enable = true"];
const FIXED: &[&str] = &["[network] enable = true", "[network] ip_address = 10.0.0.5"];

pub const ROWS: &[Row] = &[
    row("[network] enable", "false", "true", Say(&["net"])),
    row("[network] ip_address", "10.0.0.5", "10.0.0.6", Say(&["net"])).with(ON),
    row("[network] ip_mask", "255.0.0.0", "255.255.0.0", Say(&["net"])).with(FIXED),
    row("[network] ip_gateway", "10.0.0.1", "10.0.0.2", Say(&["net"])).with(FIXED),
    row("[network] dns_server", "10.0.0.1", "10.0.0.2", Say(&["net"])).with(FIXED),
    row("[network] hostname", "velvet", "mill", Say(&["net"])).with(ON),
    row("[network] mdns", "true", "false", Say(&["net"])).with(ON),
    row("[network] shell_enable", "false", "true", Say(&["net"])).with(ON),
    row("[network] shell_port", "23", "2300", Say(&["net"])).with(CONSOLES),
    row("[network] grbl_enable", "false", "true", Say(&["net"])).with(ON),
    row("[network] grbl_port", "2323", "8080", Say(&["net"])).with(CONSOLES),
    row("[network] webserver_enable", "false", "true", Say(&["net"])).with(ON),
    row("[network] webserver_port", "80", "8080", Say(&["net"])).with(PAGE),
    row("[network] timezone", "0", "5.75", Look(dated)).with(ON),
    row("[network] link", "auto", "10", Board("network/addresses.rs")).with(ON),
    row("[network] password_required", "true", "false", Board("network/consoles.rs")).with(CONSOLES),
    row("[network] watch_without_password", "true", "false", Board("network/access.rs")).with(CONSOLES),
    row("[network] ntp_enable", "true", "false", Board("network/addresses.rs")).with(ON),
    row("[network] ntp_server", "pool.ntp.org", "10.0.0.9", Board("network/addresses.rs")).with(ON),
];

/// The date once the network has told the time.
fn dated(bench: &mut Bench) -> String {
    bench.network(|network| network.news.push_back(NetworkNews::Time(1_795_953_600)));
    bench.hear(0.1);
    bench.say("date")
}

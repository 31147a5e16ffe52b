//! Whether a request is meant for this server, by somebody who sees its own page.
//!
//! A browser sends requests for any page that it shows. A name that an attacker's DNS leads here ("DNS
//! rebinding") shows in `Host`; a foreign page shows in `Origin` and in `Sec-Fetch-Site`. Programs that are
//! no browsers send neither of the two.

use crate::method::Method;
use crate::request::Request;
use crate::status::Status;

/// Names that this server answers to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known<'k> {
    /// Host names, in letters of any case.
    pub names: &'k [&'k str],
    /// Addresses of this server.
    pub addresses: &'k [[u8; 4]],
    /// Other pages that may ask: scheme, host, and port unless it is the scheme's own.
    pub origins: &'k [&'k str],
}

impl Known<'_> {
    /// Returns the status that the request is to be refused with.
    ///
    /// # Errors
    /// 421 where it is not meant for this server, 403 where a foreign page asks.
    pub fn check(&self, request: &Request<'_>) -> Result<(), Status> {
        // Only a peer of HTTP/1.0 has none, and no browser is one.
        let host = request.header("Host").unwrap_or_default();
        let may_miss = host.is_empty() && request.head.is_old;
        if !may_miss && !self.has(host) {
            return Err(Status::MisdirectedRequest);
        }
        if let Some(origin) = request.header("Origin") {
            let own = origin.strip_prefix("http://").is_some_and(|page| is_same_place(page, host));
            if !own && !self.origins.contains(&origin) {
                return Err(Status::Forbidden);
            }
            return Ok(());
        }
        let is_foreign = matches!(request.header("Sec-Fetch-Site"), Some("cross-site" | "same-site"));
        // A link on a foreign page may lead here.
        let is_link = matches!(request.head.method, Method::Get | Method::Head)
            && request.header("Sec-Fetch-Mode") == Some("navigate");
        if is_foreign && !is_link { Err(Status::Forbidden) } else { Ok(()) }
    }

    /// Returns whether a `Host` line names this server. The port does not count: slicers leave it out.
    fn has(&self, host: &str) -> bool {
        let Some((name, _)) = split(host) else { return false };
        let name = name.strip_suffix('.').unwrap_or(name);
        match address(name) {
            Some(address) => self.addresses.contains(&address),
            None => !name.is_empty() && self.names.iter().any(|known| known.eq_ignore_ascii_case(name)),
        }
    }
}

/// Returns whether two hosts with ports are the same.
fn is_same_place(one: &str, other: &str) -> bool {
    match (split(one), split(other)) {
        (Some((one, port)), Some((other, same))) => one.eq_ignore_ascii_case(other) && port == same,
        _ => false,
    }
}

/// Splits a host from its port.
fn split(host: &str) -> Option<(&str, u16)> {
    match host.split_once(':') {
        None => Some((host, 80)),
        Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) => Some((name, port.parse().ok()?)),
        Some(_) => None,
    }
}

/// Reads an address in the one way that it is written.
fn address(text: &str) -> Option<[u8; 4]> {
    let mut parts = text.split('.');
    let mut address = [0; 4];
    for place in &mut address {
        let digits = parts.next()?;
        let is_plain =
            digits.bytes().all(|digit| digit.is_ascii_digit()) && (digits.len() == 1 || !digits.starts_with('0'));
        *place = digits.parse().ok().filter(|_| is_plain)?;
    }
    parts.next().is_none().then_some(address)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: Known<'_> = Known {
        names: &["velvet.local", "velvet"],
        addresses: &[[192, 168, 1, 37]],
        origins: &["https://farm.example"],
    };

    fn check(method: &str, lines: &str) -> u16 {
        let mut head = format!("{method} / HTTP/1.1\r\n{lines}\r\n").into_bytes();
        let request = Request::read(&mut head).expect("a head");
        KNOWN.check(&request).map_or_else(Status::code, |()| 200)
    }

    #[test]
    fn a_host_is_one_that_the_server_has() {
        for host in
            ["velvet.local", "VELVET.local:80", "velvet:8080", "velvet.local.", "192.168.1.37", "192.168.1.37:81"]
        {
            assert_eq!(check("GET", &format!("Host: {host}\r\n")), 200, "{host}");
        }
        for host in [
            "evil.example",
            "velvet.local.evil.example",
            "192.168.1.38",
            "192.168.1.037",
            "192.168.1",
            "192.168.1.37.1",
            "192.168.1.293",
            "3232235813",
            "[::1]",
            "velvet:x",
            "velvet:99999",
            "velvet:+80",
            "",
            ".",
            ":80",
            "velvet..",
            "velvet@evil",
        ] {
            assert_eq!(check("GET", &format!("Host: {host}\r\n")), 421, "{host}");
        }
    }

    #[test]
    fn a_page_is_the_servers_own_or_listed() {
        for (host, origin, status) in [
            ("velvet.local", "http://velvet.local", 200),
            ("velvet.local", "http://VELVET.local:80", 200),
            ("velvet:8080", "http://velvet:8080", 200),
            ("velvet", "https://farm.example", 200),
            ("velvet.local", "http://velvet", 403),
            ("velvet:8080", "http://velvet", 403),
            ("velvet", "https://velvet", 403),
            ("velvet", "null", 403),
            ("velvet", "", 403),
            ("velvet", "http://evil.example", 403),
            ("velvet", "https://farm.example.evil", 403),
        ] {
            let lines = format!("Host: {host}\r\nOrigin: {origin}\r\n");
            assert_eq!(check("POST", &lines), status, "{lines}");
            let rebound = lines.replace(&format!("Host: {host}"), "Host: evil.example");
            assert_eq!(check("GET", &rebound), 421, "{rebound}");
        }
    }

    #[test]
    fn a_foreign_page_may_lead_here_and_nothing_else() {
        for (method, site, mode, status) in [
            ("GET", "same-origin", "cors", 200),
            ("POST", "same-origin", "cors", 200),
            ("GET", "none", "navigate", 200),
            ("GET", "cross-site", "navigate", 200),
            ("HEAD", "same-site", "navigate", 200),
            ("GET", "cross-site", "no-cors", 403),
            ("GET", "same-site", "no-cors", 403),
            ("POST", "cross-site", "navigate", 403),
        ] {
            let lines = format!("Host: velvet\r\nSec-Fetch-Site: {site}\r\nSec-Fetch-Mode: {mode}\r\n");
            assert_eq!(check(method, &lines), status, "{method} {site} {mode}");
        }
    }

    #[test]
    fn a_peer_of_old_need_not_name_the_server() {
        let mut head = *b"GET / HTTP/1.0\r\n\r\n";
        assert_eq!(KNOWN.check(&Request::read(&mut head).expect("a head")), Ok(()));
        let mut head = *b"GET / HTTP/1.0\r\nHost: evil\r\n\r\n";
        assert_eq!(KNOWN.check(&Request::read(&mut head).expect("a head")), Err(Status::MisdirectedRequest));
    }
}

//! Where the board's address comes from, and where it goes.

use std::net::Ipv4Addr;

use crate::testing::{BOARD, Bench, SECOND};
use crate::{News, Origin};

#[test]
fn a_server_gives_the_address_and_is_told_the_name() {
    let mut bench = Bench::with_address();
    let address = bench.network.report().address.unwrap();
    assert_eq!((address.address, address.prefix, address.origin), (BOARD, 24, Origin::Dhcp));
    assert_eq!(address.gateway, Some(Ipv4Addr::new(10, 0, 0, 1)));
    assert_eq!(bench.desk.dhcp.host.as_deref(), Some("velvet"));
    assert!(bench.now < 4 * SECOND, "{}", bench.now);
    bench.run(3_600 * SECOND);
    let addresses = bench.news.iter().filter(|news| !matches!(news, News::Named(_)));
    assert_eq!(addresses.count(), 1, "the lease is renewed: {:?}", bench.news);
}

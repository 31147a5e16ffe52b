//! The time from a server.

use crate::names::message::Message;
use crate::testing::{Bench, DESK, SECOND, time_server};
use crate::{News, Settings};

/// 2026-11-29 02:00:00 UTC.
const UNIX: u64 = 1_795_917_600;

fn bench(server: &str) -> Bench {
    let settings = Settings { time_server: time_server(server), ..Bench::settings() };
    let mut bench = Bench::new(settings);
    bench.get_address();
    bench
}

/// Answers questions for names and time for so long. Returns how many of each there were.
fn serve(bench: &mut Bench, duration: u64, knows: bool, stratum: u8) -> (u32, u32) {
    let (dns, ntp) = (bench.desk.bind(53), bench.desk.bind(123));
    let (mut names, mut times) = (0, 0);
    let end = bench.now + duration;
    while bench.now < end {
        bench.step();
        while let Some((mut bytes, from)) = bench.desk.datagram(dns) {
            names += 1;
            let message = Message::new(&bytes).unwrap();
            assert_eq!(message.questions().count(), 1);
            bytes[2] |= 0x80;
            if knows {
                bytes[7] = 1;
                bytes.extend([0xC0, 12, 0, 1, 0, 1, 0, 0, 0, 60, 0, 4]);
                bytes.extend(DESK.octets());
            }
            let std::net::IpAddr::V4(to) = std::net::IpAddr::from(from.addr) else { panic!() };
            bench.desk.tell(dns, (to, from.port), &bytes);
        }
        while let Some((bytes, from)) = bench.desk.datagram(ntp) {
            times += 1;
            let mut reply = [0; 48];
            (reply[0], reply[1]) = (0x24, stratum);
            reply[24..32].copy_from_slice(&bytes[40..48]);
            let now = (UNIX + bench.now / SECOND + 2_208_988_800) << 32;
            reply[40..].copy_from_slice(&now.to_be_bytes());
            let std::net::IpAddr::V4(to) = std::net::IpAddr::from(from.addr) else { panic!() };
            bench.desk.tell(ntp, (to, from.port), &reply);
        }
    }
    (names, times)
}

fn times(bench: &Bench) -> Vec<u64> {
    let time = |news: &News| if let News::Time { unix_ms } = news { Some(*unix_ms / 1_000) } else { None };
    bench.news.iter().filter_map(time).collect()
}

#[test]
fn the_time_comes_at_once_and_each_hour() {
    let mut bench = bench("10.0.0.1");
    let asked = serve(&mut bench, 2 * 3_600 * SECOND + 60 * SECOND, true, 2);
    assert_eq!(asked, (0, 3));
    let told = times(&bench);
    assert!(told.len() == 3 && told[0] - UNIX < 10 && told[2] - told[0] >= 7_200, "{told:?}");
    let report = bench.network.report();
    assert!(report.time_server == Some(DESK) && report.time_at.is_some());
}

#[test]
fn a_servers_name_is_looked_up() {
    let mut bench = bench("pool.ntp.org");
    assert_eq!(serve(&mut bench, 30 * SECOND, true, 2), (1, 1));
    assert_eq!(times(&bench).len(), 1);
}

#[test]
fn servers_that_do_not_answer_are_asked_less_and_less() {
    let mut bench = bench("10.0.0.77");
    bench.run(3_600 * SECOND);
    assert_eq!(bench.news.iter().filter(|news| **news == News::NoTime).count(), 1, "{:?}", bench.news);
    let mut bench = self::bench("pool.ntp.org");
    let (names, asked) = serve(&mut bench, 3_600 * SECOND, false, 2);
    assert!((8..60).contains(&names) && asked == 0, "{names}");
}

#[test]
fn a_server_that_wants_to_be_left_alone_is() {
    let mut bench = bench("10.0.0.1");
    assert_eq!(serve(&mut bench, 3_600 * SECOND, true, 0).1, 1);
    assert!(times(&bench).is_empty());
}

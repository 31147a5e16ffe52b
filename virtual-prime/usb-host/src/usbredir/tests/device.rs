use super::super::message::{DeviceInfo, NO_ENDPOINT};
use super::*;
use crate::mock::CONFIGURATION;

#[test]
fn nothing_is_said_before_the_peers_hello() {
    let mut bench = Bench::new(Mock::connected());
    bench.peer.output().clear();
    bench.root().plug();
    bench.pass_ms(200);
    assert!(bench.hub.is_ready() && bench.told.is_empty() && !bench.session.wants_device());
}

#[test]
fn a_device_is_announced_with_what_it_is() {
    let mut bench = Bench::new(Mock::connected());
    bench.root().plug();
    bench.pass_ms(200);
    assert!(bench.session.wants_device());
    let told: Vec<_> = bench.told.drain(..).map(|(_, message)| message).collect();
    let device = DeviceInfo { speed: 1, class: [0xEF, 2, 1], vendor: 0x1D50, product: 0x6015, release: 0x0102 };
    assert_eq!(told[2], Message::DeviceConnect(device));
    let Message::InterfaceInfo(interfaces) = &told[0] else { panic!("{told:?}") };
    assert_eq!(
        interfaces.iter().map(|one| (one.number, one.class)).collect::<Vec<_>>(),
        [(0, [2, 2, 1]), (1, [10, 0, 0])]
    );
    let Message::EpInfo(endpoints) = &told[1] else { panic!("{told:?}") };
    let there: Vec<_> = (0..32).filter(|&at| endpoints[at].kind != NO_ENDPOINT).collect();
    assert_eq!(there, [0, 16], "nothing is configured");
    assert_eq!(endpoints[0].max_packet, 64);
}

#[test]
fn endpoints_come_with_the_configuration_and_before_its_status() {
    let mut bench = Bench::announced();
    bench.say(77, &Message::SetConfiguration { configuration: 1 });
    bench.pass_ms(3);
    assert_eq!(bench.device.configuration, 1);
    let told = std::mem::take(&mut bench.told);
    let Message::EpInfo(endpoints) = &told[1].1 else { panic!("{told:?}") };
    let row =
        |at: usize| (endpoints[at].kind, endpoints[at].interval, endpoints[at].interface, endpoints[at].max_packet);
    assert_eq!([row(1), row(17), row(18)], [(2, 0, 1, 64), (2, 0, 1, 64), (3, 16, 0, 16)]);
    assert_eq!(told[2], (77, Message::ConfigurationStatus { status: 0, configuration: 1 }));
    bench.say(78, &Message::GetConfiguration);
    bench.say(79, &Message::SetConfiguration { configuration: 7 });
    bench.say(80, &Message::SetAltSetting { interface: 1, alt: 0 });
    bench.say(81, &Message::GetAltSetting { interface: 1 });
    bench.pass_ms(3);
    bench.told.retain(|(id, _)| *id != 0);
    let stall = 4;
    assert_eq!(bench.answers(), [(78, 0, vec![1]), (79, stall, vec![7]), (80, 0, vec![1, 0]), (81, 0, vec![1, 0])]);
}

#[test]
fn a_device_that_goes_ends_everything_and_waits_for_the_acknowledgement() {
    let mut bench = Bench::configured();
    bench.read(5, 64);
    bench.read(6, 64);
    bench.pass_ms(2);
    bench.device.connected = false;
    bench.pass_ms(2);
    assert_eq!(bench.told.pop().unwrap().1, Message::DeviceDisconnect);
    let cancelled = 1;
    assert_eq!(bench.answers(), [(5, cancelled, vec![]), (6, cancelled, vec![])]);
    bench.device.connected = true;
    // Sent before the peer knew.
    bench.read(7, 64);
    bench.say(6, &Message::CancelDataPacket);
    bench.pass_ms(200);
    assert!(bench.hub.is_ready() && bench.told.is_empty(), "{:?}", bench.told);
    bench.say(0, &Message::DeviceDisconnectAck);
    bench.pass_ms(1);
    assert_eq!(bench.kinds(), [4, 5, 1]);
    bench.control(7, descriptor(2, 255), &[]);
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [(7, 0, CONFIGURATION.to_vec())]);
}

#[test]
fn a_peer_that_cannot_acknowledge_is_told_at_once() {
    let mut bench = Bench::of(Mock::connected(), Capabilities(QEMU.0 & !Capabilities::DISCONNECT_ACK.0));
    bench.root().plug();
    bench.pass_ms(200);
    bench.kinds();
    bench.device.connected = false;
    bench.pass_ms(2);
    bench.device.connected = true;
    bench.pass_ms(200);
    assert_eq!(bench.kinds(), [2, 4, 5, 1]);
}

#[test]
fn a_reset_has_no_answer_and_what_follows_waits_for_it() {
    let mut bench = Bench::configured();
    bench.read(5, 64);
    bench.pass_ms(1);
    bench.say(0, &Message::Reset);
    bench.control(9, descriptor(1, 18), &[]);
    bench.control(10, descriptor(2, 9), &[]);
    bench.say(10, &Message::CancelDataPacket);
    bench.pass_ms(5);
    assert_eq!(bench.answers(), [(10, 1, vec![]), (5, 1, vec![])], "what was pending, and what was given up");
    assert_eq!(bench.device.resets, 2);
    bench.pass_ms(30);
    let answers = bench.answers();
    assert_eq!((answers.len(), answers[0].0, answers[0].1, answers[0].2.len()), (1, 9, 0, 18));
    bench.read(11, 64);
    bench.pass_ms(1);
    assert_eq!(bench.answers(), [(11, 2, vec![])], "no configuration is selected");
}

#[test]
fn a_second_reset_drops_what_waits_for_the_first() {
    let mut bench = Bench::configured();
    bench.say(0, &Message::Reset);
    bench.control(9, descriptor(1, 18), &[]);
    bench.pass_ms(1);
    bench.say(0, &Message::Reset);
    bench.control(12, descriptor(1, 8), &[]);
    bench.pass_ms(40);
    let answers = bench.answers();
    assert_eq!(answers.iter().map(|(id, status, _)| (*id, *status)).collect::<Vec<_>>(), [(9, 1), (12, 0)]);
}

#[test]
fn a_peer_may_refuse_the_device() {
    let mut bench = Bench::announced();
    bench.say(0, &Message::FilterFilter("0x03,-1,-1,-1,1".into()));
    bench.say(0, &Message::FilterReject);
    bench.pass_ms(1);
    assert!(bench.session.is_rejected() && !bench.session.wants_device());
    bench.root().unplug();
    bench.root().plug();
    bench.pass_ms(200);
    assert!(!bench.kinds().contains(&1), "it is not announced again");
}

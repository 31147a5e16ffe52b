use super::*;
use crate::mock::{Mock, pass};
use crate::request;

struct Bench {
    hub: Hub,
    controller: Controller,
    device: Mock,
    now_ns: u64,
    news: Vec<HubEvent>,
    completions: Vec<Completion>,
}

impl Bench {
    fn new(device: Mock) -> Self {
        let (hub, controller) = (Hub::default(), Controller::default());
        Self { hub, controller, device, now_ns: 0, news: Vec::new(), completions: Vec::new() }
    }

    fn root(&mut self) -> Root<'_, Mock> {
        let Self { hub, controller, device, now_ns, .. } = self;
        Root { hub, controller, device, now_ns: *now_ns }
    }

    fn pass_ms(&mut self, ms: u64) {
        for _ in 0..ms {
            pass(&mut self.controller, &mut self.device, &mut self.now_ns, MS);
            let (news, completions) = self.root().run();
            self.news.extend(news);
            self.completions.extend(completions);
        }
    }

    fn control(&mut self, setup: Setup) -> Outcome {
        let endpoint = self.hub.endpoint(0).unwrap();
        let id = self.root().submit(endpoint, Request::Control { setup: setup.bytes(), data: Vec::new() });
        self.pass_ms(3);
        let outcome = self.completions.iter().find(|one| one.id == id).expect("an end").outcome;
        if outcome == Outcome::Done {
            self.root().follow(setup);
        }
        outcome
    }
}

const SELECT: Setup =
    Setup { kind: request::DEVICE_OUT, request: request::SET_CONFIGURATION, value: 1, index: 0, length: 0 };

#[test]
fn a_device_is_found_and_its_endpoints_come_with_the_configuration() {
    let mut bench = Bench::new(Mock::connected());
    bench.root().plug();
    bench.pass_ms(200);
    assert_eq!(bench.news, [HubEvent::Found]);
    let found = bench.hub.found().unwrap();
    assert_eq!((found.device.vendor, found.device.product, found.configurations.len()), (0x1D50, 0x6015, 1));
    assert_eq!(bench.hub.endpoint(0x81), None, "nothing is selected yet");
    assert_eq!(bench.control(SELECT), Outcome::Done);
    let input = bench.hub.endpoint(0x81).unwrap();
    assert_eq!((input.device, input.number, input.direction), (1, 1, Direction::In));
    assert_eq!(bench.hub.endpoint(0x82).unwrap().kind, Kind::Interrupt { frames: 16 });
    assert_eq!(bench.hub.endpoints().map(|(interface, _)| interface).collect::<Vec<_>>(), [0, 1, 1]);
    assert_eq!(bench.hub.endpoint(0x03), None);
}

#[test]
fn a_reset_ends_transfers_and_the_address_comes_back() {
    let mut bench = Bench::new(Mock::connected());
    bench.root().plug();
    bench.pass_ms(200);
    bench.control(SELECT);
    let input = bench.hub.endpoint(0x81).unwrap();
    let waits = bench.root().submit(input, Request::In(64));
    bench.root().reset();
    assert!(!bench.hub.is_ready());
    bench.pass_ms(40);
    assert!(bench.hub.is_ready());
    assert!(bench.completions.iter().any(|one| one.id == waits && one.outcome == Outcome::Gone));
    assert_eq!((bench.device.resets, bench.hub.endpoint(0x81)), (2, None));
    assert_eq!(bench.control(SELECT), Outcome::Done, "it has its address again");
    assert_eq!(bench.news, [HubEvent::Found], "it is the same device");
}

#[test]
fn toggles_start_over_with_a_cleared_halt() {
    let mut bench = Bench::new(Mock::connected());
    bench.root().plug();
    bench.pass_ms(200);
    bench.control(SELECT);
    let output = bench.hub.endpoint(0x01).unwrap();
    let send = |bench: &mut Bench, text: &[u8]| {
        bench.root().submit(output, Request::Out { data: text.to_vec(), zero: false });
        bench.pass_ms(2);
    };
    send(&mut bench, b"one");
    bench.device.halted = true;
    send(&mut bench, b"refused");
    let clear = Setup { kind: request::ENDPOINT_OUT, request: request::CLEAR_FEATURE, value: 0, index: 1, length: 0 };
    assert_eq!(bench.control(clear), Outcome::Done);
    send(&mut bench, b"two");
    assert_eq!(bench.device.heard, b"onetwo");
}

#[test]
fn a_device_that_answers_nothing_is_asked_three_times() {
    let mut bench = Bench::new(Mock::connected());
    bench.device.dead = true;
    bench.root().plug();
    bench.pass_ms(400);
    assert_eq!(bench.news, [HubEvent::Unusable("Begin ended Failed".into())]);
    assert_eq!(bench.device.resets, 3);
    bench.device.dead = false;
    bench.device.connected = false;
    bench.pass_ms(2);
    bench.device.connected = true;
    bench.pass_ms(200);
    assert_eq!(bench.news.last(), Some(&HubEvent::Found), "another chance when it comes back");
}

#[test]
fn a_device_that_goes_is_gone_and_read_again_when_it_comes_back() {
    let mut bench = Bench::new(Mock::connected());
    bench.root().plug();
    bench.pass_ms(200);
    bench.device.connected = false;
    bench.pass_ms(2);
    assert!(bench.hub.found().is_none() && bench.hub.is_plugged());
    bench.device.connected = true;
    bench.pass_ms(200);
    assert_eq!(bench.news, [HubEvent::Found, HubEvent::Gone, HubEvent::Found]);
    bench.root().unplug();
    assert!(!bench.hub.is_plugged());
    bench.pass_ms(10);
    assert_eq!(bench.news.len(), 3);
}

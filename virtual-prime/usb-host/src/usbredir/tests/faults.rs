use super::*;

#[test]
fn a_message_of_the_other_side_ends_the_conversation() {
    let mut bench = Bench::announced();
    bench.say(0, &Message::DeviceDisconnect);
    assert!(bench.try_pass(1).is_err());
}

#[test]
fn kinds_that_were_not_agreed_on_are_passed_over() {
    let mut bench = Bench::configured();
    bench.say(3, &Message::Other(25));
    bench.read(4, 64);
    bench.device.to_say.push_back(b"here".to_vec());
    bench.pass_ms(3);
    assert_eq!(bench.answers(), [(4, 0, b"here".to_vec())]);
}

#[test]
fn a_device_that_answers_no_more_is_an_error_and_its_notifications_stop() {
    let mut bench = Bench::configured();
    bench.say(1, &Message::StartInterruptReceiving { endpoint: 0x82 });
    bench.pass_ms(2);
    bench.answers();
    bench.device.dead = true;
    bench.write(2, b"lost");
    bench.control(3, descriptor(1, 8), &[]);
    bench.pass_ms(60);
    let mut answers = bench.answers();
    answers.sort();
    // The interrupt endpoint's error is told as a stall, the only error after which a peer polls again.
    assert_eq!(answers, [(0, 4, vec![0x82]), (2, 3, vec![]), (3, 3, vec![])]);
}

/// Messages in any order: every identifier that was used once is answered at most once.
#[test]
fn no_order_of_messages_breaks_it() {
    let mut seed = 1_u64;
    let mut draw = move |below: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % below
    };
    let mut bench = Bench::configured();
    let (mut next, mut cancelled) = (100, Vec::new());
    let mut asked = Vec::new();
    for _ in 0..3_000 {
        match draw(14) {
            0..4 => {
                bench.read(next, 1 + draw(200) as u32);
                asked.push(next);
                next += 1;
            }
            4..7 => {
                bench.write(next, &vec![b'w'; draw(300) as usize]);
                asked.push(next);
                next += 1;
            }
            7 => bench.device.to_say.push_back(vec![b's'; draw(65) as usize]),
            8 => {
                let id = 100 + draw(next - 99);
                bench.say(id, &Message::CancelDataPacket);
                cancelled.push(id);
            }
            9 => {
                bench.control(next, descriptor(1 + draw(3) as u8, draw(300) as u16), &[]);
                asked.push(next);
                next += 1;
            }
            10 if draw(10) == 0 => bench.say(0, &Message::Reset),
            11 => {
                bench.say(next, &Message::SetConfiguration { configuration: 1 });
                asked.push(next);
                next += 1;
            }
            12 if draw(10) == 0 => bench.device.halted = true,
            _ => bench.pass_ms(draw(4)),
        }
    }
    bench.pass_ms(50);
    bench.say(0, &Message::Reset);
    bench.pass_ms(50);
    let mut answered: Vec<u64> = bench.told.iter().map(|(id, _)| *id).filter(|id| *id != 0).collect();
    answered.sort_unstable();
    assert_eq!(answered, asked, "each once, and nothing else");
    assert!(!cancelled.is_empty());
}

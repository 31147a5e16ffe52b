use crate::args::Args;
use crate::desk::Bench;
use crate::{Command, DICTIONARY, Reason, Response};

fn fetched() -> Vec<u8> {
    let mut bench = Bench::new(0);
    let mut all = Vec::new();
    loop {
        let said = bench.tell(Command::Identify, &[all.len() as u32, 40]);
        let (_, _, part) = said.into_iter().find(|(kind, ..)| *kind == Response::Identified).expect("an answer");
        if part.is_empty() {
            return all;
        }
        all.extend(part);
    }
}

#[test]
fn a_host_fetches_all_of_it() {
    let packed = fetched();
    assert_eq!(packed, DICTIONARY);
    let json = miniz_oxide::inflate::decompress_to_vec_zlib(&packed).expect("a zlib stream");
    let json = String::from_utf8(json).expect("text");
    for command in Command::ALL {
        assert!(json.contains(&format!("\"{}\":{}", command.format(), command.number())), "{command:?}");
    }
    for response in Response::ALL {
        assert!(json.contains(&format!("\"{}\":{}", response.format(), response.number())), "{response:?}");
    }
    for reason in Reason::ALL {
        assert!(json.contains(&format!("\"{}\":{}", reason.text(), reason.number())), "{reason:?}");
    }
    assert!(json.contains("\"CLOCK_FREQ\":200000000") && !json.contains("SERIAL_BAUD"));
}

#[test]
fn every_command_reads_what_its_format_says() {
    for command in Command::ALL {
        let parameters: Vec<_> = command.format().split(' ').skip(1).collect();
        let mut content = Bench::message(*command, &[], None);
        let mut expected = Vec::new();
        for (place, parameter) in parameters.iter().enumerate() {
            if parameter.contains('*') {
                content.extend([2, 0xAA, 0xBB]);
                expected.push(0);
            } else {
                content.push(place as u8 + 1);
                expected.push(place as u32 + 1);
            }
        }
        content.push(0x55);
        let (read, args, behind) = Args::read(&content).expect("a message");
        assert_eq!((read, behind), (*command, &[0x55][..]));
        let integers: Vec<_> = (0..parameters.len()).map(|place| args.at(place)).collect();
        assert_eq!(integers, expected, "{command:?}");
        let has_buffer = parameters.iter().any(|parameter| parameter.contains('*'));
        assert_eq!(args.bytes, if has_buffer { &[0xAA, 0xBB][..] } else { &[] });
        // Cut anywhere, it is no message.
        for length in 0..content.len() - 1 {
            let cut = Args::read(&content[..length]);
            assert!(cut.is_none() || parameters.is_empty(), "{command:?} of {length} bytes");
        }
    }
}

//! Objects against machines whose every field counts.

use super::*;
use base::bed::MeshName;
use base::snapshot::{LaserShown, LimitShown, MeshShown, ProbeShown, SpindleShown};
use units::{Celsius, MmPerSecond, PerAxis};

/// A machine whose every text and number is as long as can be.
fn longest() -> Snapshot {
    let far = PerAxis([-12_345.678; units::MAX_AXES]);
    let mut of = Snapshot {
        state: State::Invalid,
        position: far,
        work: far,
        ends: [far; 2],
        systems: [[-12_345.678; 3]; base::snapshot::SHOWN_SYSTEMS],
        shift: [-12_345.678; 3],
        speed: MmPerSecond(12_345.678),
        feed_factor: 12.345,
        rapid_factor: 12.345,
        most: (Some(12_345.67), 123_456.0),
        probe: Some(ProbeShown { touches: false, last: Some([-12_345.678; 3]) }),
        tool: Some((u32::MAX, -12_345.678)),
        spindle: Some(SpindleShown {
            direction: program::Spindle::CounterClockwise,
            asked: 123_456.7,
            set: 123_456.7,
            most: 123_456.7,
            factor: 12.345,
        }),
        laser: Some(LaserShown {
            power: 0.123,
            mode: program::Spindle::Clockwise,
            open: "n,".repeat(48).as_str().try_into().unwrap(),
            ..LaserShown::default()
        }),
        coolant: Some([false; 2]),
        mesh: Some(MeshShown {
            name: MeshName::read(&"n".repeat(24)).unwrap(),
            ends: [[-12_345.678; 2]; 2],
            count: [units::MOST_SIDE as u8; 2],
            number: 1,
        }),
        flow_factor: 12.345,
        job: Some(JobShown {
            path: "x".repeat(base::ports::PATH_BYTES).as_str().try_into().unwrap(),
            size: u32::MAX,
            done: u32::MAX - 1,
            line: u32::MAX,
            elapsed_s: u32::MAX,
            left_s: Some(1e9),
            layer: u32::MAX,
            layers: Some(u32::MAX),
            ..JobShown::default()
        }),
        ..Snapshot::default()
    };
    let name = "n".repeat(24);
    while of
        .heaters
        .push(HeaterShown {
            name: name.as_str().try_into().unwrap(),
            reading: Some(Celsius(-123.456)),
            target: Celsius(-123.456),
            power: 0.123,
            max: Celsius(-123.0),
            heats: true,
            ..HeaterShown::default()
        })
        .is_ok()
    {}
    let limit = LimitShown { axis: Axis::X, end: Some(false), is_pressed: false };
    while of.limits.push(limit).is_ok() {}
    of
}

fn of_halted() -> Snapshot {
    Snapshot { state: State::Alarm, ..Snapshot::default() }
}

#[test]
fn every_object_fits_into_a_part() {
    let of = longest();
    let fault = "\"".repeat(crate::messages::TEXT_BYTES);
    let mut heights = Heights::new();
    (0..units::MOST_SIDE).for_each(|row| heights.set(1, row, &[-12.345; units::MOST_SIDE]));
    let mut messages = Messages::new();
    (0..MESSAGES).for_each(|_| messages.take(&format!("ALARM: robe {}", "\"".repeat(200)), u32::MAX));
    let told = Told { of: &of, fault: Some(&fault), heights: &heights, messages: &messages };
    for part in 0..PARTS {
        let mut room = [0; 4_096];
        let mut parts = Parts::new();
        let made = parts.make(&mut room, |_, json| {
            write_part(part, Objects::MAX, &told, json);
            Next::End
        });
        let Made::Last(length) = made else { panic!("{made:?}") };
        assert!(length <= OBJECT_BYTES, "{length} bytes: {}", String::from_utf8_lossy(&room[..length]));
    }
}

fn hash(place: usize, of: &Snapshot, fault: Option<&str>) -> u32 {
    super::hash(place, &Told { of, fault, heights: &Heights::new(), messages: &Messages::new() })
}

#[test]
fn a_hash_changes_with_each_field() {
    let of = Snapshot::default();
    let before: Vec<u32> = (0..MAX_OBJECTS).map(|place| hash(place, &of, None)).collect();
    let changed = Snapshot { flow_factor: 0.9, ..of };
    let after: Vec<u32> = (0..MAX_OBJECTS).map(|place| hash(place, &changed, None)).collect();
    let differ: Vec<usize> = (0..MAX_OBJECTS).filter(|place| before[*place] != after[*place]).collect();
    assert_eq!(differ, [2], "gcode_move alone");
    let mesh = Some(MeshShown { number: 7, ..MeshShown::default() });
    let with_mesh = Snapshot { mesh, ..Snapshot::default() };
    assert_ne!(hash(MESH_PLACE, &with_mesh, None), before[MESH_PLACE]);
    // The rest of `velvet` counts, and what the machine said.
    let changed = Snapshot { coolant: Some([true, false]), ..Snapshot::default() };
    let velvet = REST - 1;
    let open = "lid,door,".try_into().unwrap();
    let laser =
        Some(LaserShown { power: 0.25, mode: program::Spindle::CounterClockwise, open, ..LaserShown::default() });
    let changed_laser = Snapshot { laser, ..Snapshot::default() };
    assert_ne!(hash(velvet, &changed_laser, None), before[velvet]);
    assert_ne!(hash(velvet, &changed, None), before[velvet]);
    assert_ne!(hash(velvet, &of_halted(), Some("one")), hash(velvet, &of_halted(), Some("other")));
}

#[test]
fn a_laser_is_told_with_its_open_interlocks() {
    let told = |laser: Option<LaserShown>, spindle| {
        let of = Snapshot { laser, spindle, ..Snapshot::default() };
        let (messages, heights) = (Messages::new(), Heights::new());
        let told = Told { of: &of, fault: None, heights: &heights, messages: &messages };
        let mut text = [0; 4_096];
        let made = Parts::new().make(&mut text, |part, json| {
            write_part(part as usize, 1 << (REST - 1), &told, json);
            if part as usize + 1 == PARTS { Next::End } else { Next::Part }
        });
        let Made::Last(length) = made else { panic!("{made:?}") };
        String::from_utf8_lossy(&text[..length]).into_owned()
    };
    let open = "lid,door,".try_into().unwrap();
    let laser =
        LaserShown { power: 0.25, mode: program::Spindle::CounterClockwise, is_test: true, is_framing: false, open };
    let json = told(Some(laser.clone()), None);
    let fields = r#""laser":{"power":0.25,"mode":"M4","on":true,"test":true,"framing":false,"open":["lid","door"]}"#;
    assert!(json.contains(fields) && json.contains(r#""machine":"laser""#), "{json}");
    let json = told(Some(LaserShown::default()), Some(SpindleShown::default()));
    assert!(json.contains(r#""power":0,"mode":"off","on":false,"test":false,"framing":false,"open":[]}"#), "{json}");
    assert!(json.contains(r#""machine":"mill""#), "with a spindle too: {json}");
    assert!(told(None, None).contains(r#""laser":null"#));
}

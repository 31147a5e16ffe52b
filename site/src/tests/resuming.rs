//! Uploads that break off and go on.

use super::files::{content, form, request_of};
use super::*;

/// SHA-256 of a content, as a header has it.
fn digest(content: &[u8]) -> String {
    use sha2::Digest as _;
    sha2::Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn headers(digest: &str, offset: usize) -> String {
    format!("Upload-Checksum: {digest}\r\nUpload-Offset: {offset}\r\n")
}

impl Desk {
    /// Asks how much is there of a file, over a connection of its own.
    fn part(&mut self, digest: &str) -> usize {
        self.open(3);
        let request =
            format!("GET /server/files/upload HTTP/1.1\r\nHost: velvet.local\r\nUpload-Checksum: {digest}\r\n\r\n");
        let answer = String::from_utf8(self.send(3, request.as_bytes())).unwrap();
        self.site.close(3, &mut self.card);
        let offset = answer.split(r#"{"result":{"offset":"#).nth(1).expect(&answer);
        offset.split('}').next().unwrap().parse().expect(&answer)
    }

    /// Sends the rest of a file from there. Returns the answer.
    fn send_rest(&mut self, name: &str, content: &[u8], digest: &str, offset: usize) -> String {
        self.open(1);
        let answer =
            self.send(1, &request_of(&headers(digest, offset), &form(&[("path", "p")], name, &content[offset..])));
        self.run();
        let answer = [answer, self.hear(1)].concat();
        self.site.close(1, &mut self.card);
        self.run();
        String::from_utf8(answer).unwrap()
    }
}

#[test]
fn an_upload_goes_on_where_it_broke_off_wherever_that_is() {
    let bytes = content(4_000);
    let digest = digest(&bytes);
    let request = request_of(&headers(&digest, 0), &form(&[("path", "p")], "a.gcode", &bytes));
    let mut offsets = std::collections::BTreeSet::new();
    for end in (0..request.len()).step_by(61).chain([request.len() - 1]) {
        let mut desk = Desk::new(Role::Operate);
        desk.card.directories.insert("/sd/p".into());
        desk.card.put("/sd/p/a.gcode", b"old");
        desk.open(0);
        desk.send(0, &request[..end]);
        desk.site.close(0, &mut desk.card);
        desk.run();
        assert_eq!((desk.card.text("/sd/p/a.gcode"), desk.card.open_files()), ("old", 0), "cut off at byte {end}");
        let offset = desk.part(&digest);
        assert!(offset <= bytes.len() && offset + request.len() > bytes.len() + end - 512, "{offset} of {end}");
        // Once more, in the rest.
        desk.open(0);
        let rest = request_of(&headers(&digest, offset), &form(&[("path", "p")], "a.gcode", &bytes[offset..]));
        desk.send(0, &rest[..rest.len() / 2]);
        desk.site.close(0, &mut desk.card);
        desk.run();
        let further = desk.part(&digest);
        assert!(further >= offset, "{further} after {offset}");
        let answer = desk.send_rest("a.gcode", &bytes, &digest, further);
        assert!(answer.starts_with("HTTP/1.1 201 ") && answer.contains(&digest), "cut off at byte {end}: {answer}");
        assert_eq!(desk.card.files["/sd/p/a.gcode"], bytes, "cut off at byte {end}");
        assert_eq!((desk.card.files.len(), desk.card.open_files(), desk.part(&digest)), (1, 0, 0), "nothing is left");
        offsets.insert(offset);
    }
    assert!(offsets.len() > 5 && offsets.contains(&0), "{offsets:?}");
}

#[test]
fn a_power_cut_leaves_a_part_that_can_be_gone_on_with_or_nothing() {
    let (old, new) = (b"old".to_vec(), content(2_000));
    let digest = digest(&new);
    let request = request_of(&headers(&digest, 0), &form(&[("path", "p")], "a.gcode", &new));
    let mut offsets = std::collections::BTreeSet::new();
    for writes in 0.. {
        let mut desk = Desk::new(Role::Operate);
        desk.card.directories.insert("/sd/p".into());
        desk.card.put("/sd/p/a.gcode", &old);
        desk.card.writes_left = Some(writes);
        desk.open(0);
        desk.send(0, &request);
        desk.run();
        let is_done = desk.card.writes_left != Some(0);
        let mut after = Desk::new(Role::Operate);
        after.card = desk.card.rebooted();
        let offset = after.part(&digest);
        let is_new = after.card.files["/sd/p/a.gcode"] == new;
        assert!(is_new || after.card.files["/sd/p/a.gcode"] == old, "after {writes} writes");
        let answer = after.send_rest("a.gcode", &new, &digest, offset);
        assert!(answer.starts_with("HTTP/1.1 201 "), "after {writes} writes, from {offset}: {answer}");
        assert_eq!(after.card.files["/sd/p/a.gcode"], new);
        assert_eq!(after.card.files.len(), 1, "{:?}", after.card.files.keys());
        offsets.insert(offset);
        if is_done {
            break;
        }
    }
    assert!(offsets.len() > 3, "{offsets:?}");
}

#[test]
fn a_connection_that_died_without_a_word_is_not_waited_for() {
    let bytes = content(3_000);
    let digest = digest(&bytes);
    let mut desk = Desk::new(Role::Operate);
    desk.open(0);
    let request = request_of(&headers(&digest, 0), &form(&[("path", "p")], "a.gcode", &bytes));
    desk.send(0, &request[..2_000]);
    let offset = desk.part(&digest);
    assert!(offset > 1_000);
    let answer = desk.send_rest("a.gcode", &bytes, &digest, offset);
    assert!(answer.starts_with("HTTP/1.1 201 "), "{answer}");
    // What comes late over the first connection goes nowhere.
    desk.send(0, &request[2_000..]);
    desk.run();
    assert_eq!((&desk.card.files["/sd/p/a.gcode"], desk.card.files.len()), (&bytes, 1));
}

#[test]
fn a_file_that_is_another_than_was_said_is_refused_and_nothing_of_it_stays() {
    let (bytes, other) = (content(3_000), content(3_001));
    let (digest, others) = (digest(&bytes), digest(&other));
    let begun = |role| {
        let mut desk = Desk::new(role);
        desk.open(0);
        let request = request_of(&headers(&digest, 0), &form(&[("path", "p")], "a.gcode", &bytes));
        desk.send(0, &request[..2_000]);
        desk.site.close(0, &mut desk.card);
        desk.run();
        desk
    };
    let mut desk = begun(Role::Operate);
    let offset = desk.part(&digest);
    assert_eq!(desk.part(&others), 0, "another file has no part");
    for (said, offset) in [(&digest, offset + 1), (&digest, 1), (&others, offset)] {
        let answer = desk.send_rest("a.gcode", &other, said, offset);
        assert!(answer.starts_with("HTTP/1.1 409 ") && answer.contains("ask where it does"), "{answer}");
    }
    assert_eq!(desk.part(&digest), offset, "it is there all the same");
    // The rest is that of another file.
    let answer = desk.send_rest("a.gcode", &other.iter().map(|byte| byte ^ 1).collect::<Vec<_>>(), &digest, offset);
    assert!(answer.starts_with("HTTP/1.1 422 "), "{answer}");
    assert!(desk.card.files.is_empty() && desk.part(&digest) == 0, "{:?}", desk.card.files.keys());
    // A name that is refused.
    let mut desk = begun(Role::Operate);
    let offset = desk.part(&digest);
    assert!(desk.send_rest("a?.gcode", &bytes, &digest, offset).starts_with("HTTP/1.1 400 "));
    assert!(desk.card.files.is_empty() && desk.part(&digest) == 0);
    // Two checksums, and one that is none.
    let form = form(&[("checksum", &others)], "a.gcode", &bytes);
    desk.open(0);
    assert!(desk.send(0, &request_of(&headers(&digest, 0), &form)).starts_with(b"HTTP/1.1 400 "));
    desk.open(0);
    assert!(desk.send(0, &request_of("Upload-Checksum: abc\r\n", &form)).starts_with(b"HTTP/1.1 400 "));
}

#[test]
fn a_part_is_kept_for_an_hour_and_makes_room_for_a_third_file() {
    let bytes = content(3_000);
    let digest = digest(&bytes);
    let break_off = |desk: &mut Desk, content: &[u8]| {
        desk.open(0);
        let request = request_of(&headers(&self::digest(content), 0), &form(&[("path", "p")], "a.gcode", content));
        desk.send(0, &request[..2_000]);
        desk.site.close(0, &mut desk.card);
        desk.run();
    };
    let mut desk = Desk::new(Role::Operate);
    break_off(&mut desk, &bytes);
    desk.open(4);
    desk.now += 3_590_000;
    desk.run();
    assert!(desk.card.files.len() == 2, "the part and its mark: {:?}", desk.card.files.keys());
    desk.now += 10_000;
    desk.run();
    assert!(desk.card.files.is_empty() && desk.part(&digest) == 0, "{:?}", desk.card.files.keys());
    // Other uploads leave a part alone while there is another place, also those of whoever cannot go on.
    break_off(&mut desk, &bytes);
    assert!(desk.put(&[], "b.g", b"x").starts_with("HTTP/1.1 201 "));
    assert!(desk.part(&digest) > 0);
    break_off(&mut desk, &content(3_001));
    assert!(desk.part(&digest) > 0);
    break_off(&mut desk, &content(3_002));
    assert!(desk.part(&digest) == 0 || desk.part(&self::digest(&content(3_001))) == 0);
    assert!(desk.part(&self::digest(&content(3_002))) > 0);
}

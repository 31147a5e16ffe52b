//! Sessions of browsers that have given the password: a token in a cookie, of which only the digest is kept.

use super::digest::Digest;

/// Sessions at a time; the oldest one makes room for a new one.
const SESSIONS: usize = 8;
/// Longest life of a session, seconds: 30 days. A restart ends all of them.
pub const SESSION_S: u32 = 30 * 24 * 3_600;

/// A session that a login has begun.
#[derive(Clone, Copy, Debug)]
struct Session {
    number: u32,
    digest: Digest,
    since_ms: u64,
}

/// Sessions of all who have logged in.
#[derive(Debug)]
pub struct Sessions {
    places: [Option<Session>; SESSIONS],
    /// Number of the session that was begun last.
    last: u32,
}

impl Sessions {
    /// Begins without any session.
    #[must_use]
    pub const fn new() -> Self {
        Self { places: [None; SESSIONS], last: 0 }
    }

    /// Begins the session of a token.
    pub fn begin(&mut self, token: &str, now_ms: u64) {
        self.last = self.last.wrapping_add(1);
        let session = Session { number: self.last, digest: Digest::of(token), since_ms: now_ms };
        // An empty place comes before the oldest session.
        let place = self.places.iter_mut().min_by_key(|place| place.map_or(0, |session| session.since_ms + 1));
        if let Some(place) = place {
            *place = Some(session);
        }
    }

    /// Returns the number of a token's session.
    #[must_use]
    pub fn find(&self, token: &str) -> Option<u32> {
        let digest = Digest::of(token);
        self.places.iter().flatten().find(|session| session.digest.is(&digest)).map(|session| session.number)
    }

    /// Returns whether a session goes on.
    #[must_use]
    pub fn has(&self, number: u32) -> bool {
        self.places.iter().flatten().any(|session| session.number == number)
    }

    /// Ends a session: its cookie proves nothing any more.
    pub fn end(&mut self, number: u32) {
        self.retain(|session| session.number != number);
    }

    /// Ends the sessions of everybody.
    pub fn end_all(&mut self) {
        self.places = [None; SESSIONS];
    }

    /// Ends sessions that have lived for their time.
    pub fn expire(&mut self, now_ms: u64) {
        self.retain(|session| now_ms.saturating_sub(session.since_ms) < u64::from(SESSION_S) * 1_000);
    }

    fn retain(&mut self, stays: impl Fn(&Session) -> bool) {
        for place in &mut self.places {
            *place = place.filter(&stays);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_is_found_by_its_token_until_it_ends() {
        let mut sessions = Sessions::new();
        assert_eq!(sessions.find(""), None);
        sessions.begin("one", 5);
        sessions.begin("two", 6);
        let (one, two) = (sessions.find("one").unwrap(), sessions.find("two").unwrap());
        assert!(one != two && sessions.has(one) && sessions.find("three").is_none());
        sessions.end(one);
        assert!(!sessions.has(one) && sessions.find("one").is_none() && sessions.has(two));
        sessions.end_all();
        assert!(!sessions.has(two));
    }

    #[test]
    fn a_session_ends_after_thirty_days() {
        let mut sessions = Sessions::new();
        sessions.begin("one", 1_000);
        sessions.expire(1_000 + 30 * 86_400_000 - 1);
        assert!(sessions.find("one").is_some());
        sessions.expire(1_000 + 30 * 86_400_000);
        assert!(sessions.find("one").is_none());
    }

    #[test]
    fn the_oldest_session_makes_room() {
        let mut sessions = Sessions::new();
        for number in 0..SESSIONS + 2 {
            sessions.begin(&number.to_string(), number as u64);
        }
        let there: Vec<bool> = (0..SESSIONS + 2).map(|number| sessions.find(&number.to_string()).is_some()).collect();
        assert_eq!(there.iter().filter(|there| **there).count(), SESSIONS);
        assert!(!there[0] && !there[1]);
    }
}

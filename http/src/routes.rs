//! The table of routes: what may be asked, how, and by whom.

use crate::method::{Method, Methods};
use crate::status::Status;

/// Rights of a visitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Nobody is known: log in, see that it is there.
    Nobody,
    /// Sees all, and may stop the machine.
    Watch,
    /// Has the machine move, heat and play files.
    Operate,
    /// Changes what stays: settings, users, firmware.
    Own,
}

impl Role {
    /// All roles, each of which may what the one before it may.
    pub const ALL: [Self; 4] = [Self::Nobody, Self::Watch, Self::Operate, Self::Own];
}

/// Content that a request may have. Foreign pages can have a browser send forms and plain text, but not JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// No content at all.
    Nothing,
    /// Arguments of a call, in JSON.
    Json,
    /// Form with files in it.
    Form,
    /// Bytes of a file.
    Bytes,
}

impl Content {
    /// Returns whether a body of this type is taken. Without a type there is no body.
    #[must_use]
    pub fn takes(self, content_type: Option<&str>) -> bool {
        let Some(content_type) = content_type else { return true };
        let media = content_type.split(';').next().unwrap_or_default().trim_ascii();
        let is = |known: &str| media.eq_ignore_ascii_case(known);
        match self {
            Self::Nothing => false,
            Self::Json => is("application/json"),
            Self::Form => is("multipart/form-data"),
            Self::Bytes => is("application/octet-stream"),
        }
    }
}

/// Row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Route<H: 'static> {
    /// Method of the request; HEAD goes where GET goes.
    pub method: Method,
    /// Path: `{}` stands for one segment of any name, `*` at the end for all that follows.
    pub path: &'static str,
    /// Least role that may ask.
    pub role: Role,
    /// Content that is taken.
    pub content: Content,
    /// Longest body that is taken, bytes.
    pub body_bytes: u64,
    /// Sentence that says what the request does.
    pub help: &'static str,
    /// Function, or number of one, that carries the request out.
    pub handler: H,
}

impl<H> Route<H> {
    /// Returns the status that a visitor of this role is refused with.
    ///
    /// # Errors
    /// 401 for nobody, 403 for who is known and may not.
    pub fn admit(&self, role: Role) -> Result<(), Status> {
        match role {
            role if role >= self.role => Ok(()),
            Role::Nobody => Err(Status::Unauthorized),
            Role::Watch | Role::Operate | Role::Own => Err(Status::Forbidden),
        }
    }

    fn answers(&self, method: Method) -> bool {
        self.method == method || self.method == Method::Get && method == Method::Head
    }
}

/// Answer of a table to a method and a path.
#[derive(Clone, Copy, Debug)]
pub enum Found<'p, H: 'static> {
    /// Row, and what `{}` or `*` stands for.
    Route(&'static Route<H>, &'p str),
    /// The path is known, with these methods.
    WrongMethod(Methods),
    /// The path is not known.
    Nothing,
}

/// The table. The first row that fits is taken.
#[derive(Clone, Copy, Debug)]
pub struct Routes<H: 'static>(pub &'static [Route<H>]);

impl<H> Routes<H> {
    /// Returns what the table has for a request.
    #[must_use]
    pub fn find<'p>(&self, method: Method, path: &'p str) -> Found<'p, H> {
        let mut methods = Methods::NONE;
        for route in self.0 {
            let Some(rest) = fit(route.path, path) else { continue };
            if route.answers(method) {
                return Found::Route(route, rest);
            }
            methods = methods.with(route.method);
            if route.method == Method::Get {
                methods = methods.with(Method::Head);
            }
        }
        if methods.is_empty() { Found::Nothing } else { Found::WrongMethod(methods) }
    }

    /// Returns the number of a row that is never reached, as an earlier one takes all its requests.
    #[must_use]
    pub fn hidden(&self) -> Option<usize> {
        (0..self.0.len()).find(|at| {
            let Some(route) = self.0.get(*at) else { return false };
            self.0
                .iter()
                .take(*at)
                .any(|earlier| earlier.answers(route.method) && fit(earlier.path, route.path).is_some())
        })
    }

    /// Goes through every row with every role, and whether it is admitted.
    pub fn matrix(&self) -> impl Iterator<Item = (&'static Route<H>, Role, Result<(), Status>)> {
        self.0.iter().flat_map(|route| Role::ALL.into_iter().map(move |role| (route, role, route.admit(role))))
    }
}

/// Returns what the open part of a pattern stands for, where the path fits.
fn fit<'p>(pattern: &str, path: &'p str) -> Option<&'p str> {
    if let Some(folder) = pattern.strip_suffix('*') {
        return path.strip_prefix(folder);
    }
    let Some((before, behind)) = pattern.split_once('{') else { return (pattern == path).then_some("") };
    let segment = path.strip_prefix(before)?.strip_suffix(behind.strip_prefix('}')?)?;
    (!segment.is_empty() && !segment.contains('/')).then_some(segment)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn row(method: Method, path: &'static str, role: Role, handler: u8) -> Route<u8> {
        Route { method, path, role, content: Content::Nothing, body_bytes: 0, help: "", handler }
    }

    const TABLE: Routes<u8> = Routes(&[
        row(Method::Get, "/", Role::Nobody, 0),
        row(Method::Get, "/api/job", Role::Watch, 1),
        row(Method::Post, "/api/job", Role::Operate, 2),
        row(Method::Post, "/api/job/{}/start", Role::Operate, 3),
        row(Method::Put, "/api/files/*", Role::Operate, 4),
        row(Method::Delete, "/api/files/*", Role::Own, 5),
        row(Method::Get, "/api/files/{}", Role::Watch, 6),
    ]);

    fn found(method: Method, path: &str) -> Option<(u8, String)> {
        match TABLE.find(method, path) {
            Found::Route(route, rest) => Some((route.handler, rest.to_owned())),
            _ => None,
        }
    }

    #[test]
    fn requests_find_their_rows() {
        for (method, path, handler, rest) in [
            (Method::Get, "/", 0, ""),
            (Method::Head, "/api/job", 1, ""),
            (Method::Post, "/api/job", 2, ""),
            (Method::Post, "/api/job/a b/start", 3, "a b"),
            (Method::Put, "/api/files/a/b.g", 4, "a/b.g"),
            (Method::Delete, "/api/files/", 5, ""),
            (Method::Get, "/api/files/x", 6, "x"),
        ] {
            assert_eq!(found(method, path), Some((handler, rest.to_owned())), "{path}");
        }
        for path in
            ["/api", "/api/job/", "/api/job//start", "/api/job/a/b/start", "/api/job/start", "/api/jobs", "/api/filesx"]
        {
            assert!(matches!(TABLE.find(Method::Get, path), Found::Nothing | Found::WrongMethod(_)), "{path}");
        }
        assert!(matches!(TABLE.find(Method::Get, "/api"), Found::Nothing));
    }

    #[test]
    fn a_known_path_says_its_methods() {
        let Found::WrongMethod(methods) = TABLE.find(Method::Post, "/api/files/x") else { panic!("no 405") };
        assert_eq!(methods.iter().collect::<Vec<_>>(), [Method::Get, Method::Head, Method::Put, Method::Delete]);
        let Found::WrongMethod(methods) = TABLE.find(Method::Get, "/api/files/a/b") else { panic!("no 405") };
        assert_eq!(methods.iter().collect::<Vec<_>>(), [Method::Put, Method::Delete]);
    }

    #[test]
    fn every_row_admits_the_roles_from_its_own_on() {
        let admitted = |handler: u8| -> Vec<u16> {
            let rows = TABLE.matrix().filter(|(route, ..)| route.handler == handler);
            rows.map(|(_, _, admitted)| admitted.map_or_else(Status::code, |()| 200)).collect()
        };
        assert_eq!(admitted(0), [200, 200, 200, 200]);
        assert_eq!(admitted(1), [401, 200, 200, 200]);
        assert_eq!(admitted(2), [401, 403, 200, 200]);
        assert_eq!(admitted(5), [401, 403, 403, 200]);
        assert_eq!(TABLE.matrix().count(), 4 * 7);
    }

    #[test]
    fn a_row_behind_one_that_takes_all_is_found() {
        const HIDDEN: Routes<u8> =
            Routes(&[row(Method::Get, "/a/*", Role::Own, 0), row(Method::Get, "/a/b", Role::Nobody, 1)]);
        assert_eq!((TABLE.hidden(), HIDDEN.hidden()), (None, Some(1)));
    }

    #[test]
    fn content_is_of_the_type_that_a_row_takes() {
        assert!(Content::Json.takes(Some("application/JSON ; charset=utf-8")) && Content::Nothing.takes(None));
        assert!(Content::Form.takes(Some("multipart/form-data; boundary=x")));
        assert!(Content::Bytes.takes(Some("application/octet-stream")));
        for (content, media) in [
            (Content::Json, "text/plain"),
            (Content::Json, "text/plain; application/json"),
            (Content::Json, ""),
            (Content::Form, "application/x-www-form-urlencoded"),
            (Content::Bytes, "multipart/form-data"),
            (Content::Nothing, "application/json"),
        ] {
            assert!(!content.takes(Some(media)), "{media}");
        }
    }
}

//! Parameters of a query, or of a form's body.

use crate::percent;

/// Parameters of a query, as they were sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Query<'b>(&'b str);

impl<'b> Query<'b> {
    /// Takes the text behind the question mark.
    #[must_use]
    pub const fn new(text: &'b str) -> Self {
        Self(text)
    }

    /// Returns the query as it was sent.
    #[must_use]
    pub const fn as_str(self) -> &'b str {
        self.0
    }

    /// Goes through the parameters: name and value, still encoded. A name without "=" has an empty value.
    pub fn iter(self) -> impl Iterator<Item = (&'b str, &'b str)> {
        let parts = self.0.split('&').filter(|part| !part.is_empty());
        parts.map(|part| part.split_once('=').unwrap_or((part, "")))
    }

    /// Decodes the value of the first parameter of this name into `out`. None if there is none, or if it
    /// cannot be decoded.
    pub fn value<'o>(self, name: &str, out: &'o mut [u8]) -> Option<&'o str> {
        let (_, value) = self.iter().find(|(known, _)| *known == name)?;
        percent::decode(value, true, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_found_and_decoded() {
        let query = Query::new("path=a%2Fb+c&print&&n=1&n=2&x==");
        let all: Vec<_> = query.iter().collect();
        assert_eq!(all, [("path", "a%2Fb+c"), ("print", ""), ("n", "1"), ("n", "2"), ("x", "=")]);
        let mut room = [0; 8];
        assert_eq!(query.value("path", &mut room), Some("a/b c"));
        assert_eq!(query.value("print", &mut room), Some(""));
        assert_eq!(query.value("n", &mut room), Some("1"));
        assert_eq!(query.value("none", &mut room), None);
        assert_eq!(query.value("path", &mut [0; 3]), None);
    }
}

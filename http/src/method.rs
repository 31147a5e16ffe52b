//! Methods of requests (RFC 9110, section 9).

/// Method of a request. Others are not implemented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Method {
    /// Asks for a representation.
    Get,
    /// Asks for the head of the answer that GET would have.
    Head,
    /// Has something done, once a request.
    Post,
    /// Puts something into its place.
    Put,
    /// Removes what is there.
    Delete,
    /// Asks what may be done.
    Options,
}

impl Method {
    /// All methods, in the order in which they are listed.
    pub const ALL: [Self; 6] = [Self::Get, Self::Head, Self::Post, Self::Put, Self::Delete, Self::Options];

    /// Returns the method of this name; names are in capitals.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// Returns the method's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Get => "GET",
            Self::Head => "HEAD",
            Self::Post => "POST",
            Self::Put => "PUT",
            Self::Delete => "DELETE",
            Self::Options => "OPTIONS",
        }
    }
}

/// Set of methods, as `Allow` lists them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Methods(u8);

impl Methods {
    /// Set without a method.
    pub const NONE: Self = Self(0);

    /// Returns the set with a method more.
    #[must_use]
    pub const fn with(self, method: Method) -> Self {
        Self(self.0 | 1 << method as u8)
    }

    /// Returns whether the method is in the set.
    #[must_use]
    pub const fn has(self, method: Method) -> bool {
        self.0 & (1 << method as u8) != 0
    }

    /// Returns whether no method is in the set.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Goes through the methods of the set.
    pub fn iter(self) -> impl Iterator<Item = Method> {
        Method::ALL.into_iter().filter(move |method| self.has(*method))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_found_by_its_name_and_no_other() {
        for method in Method::ALL {
            assert_eq!(Method::named(method.name()), Some(method));
        }
        for name in ["", "get", "GETS", "CONNECT", "TRACE", "PATCH"] {
            assert_eq!(Method::named(name), None, "{name}");
        }
    }

    #[test]
    fn a_set_holds_what_was_put_in() {
        let set = Methods::NONE.with(Method::Post).with(Method::Get).with(Method::Get);
        assert_eq!(set.iter().collect::<Vec<_>>(), [Method::Get, Method::Post]);
        assert!(!set.is_empty() && Methods::NONE.is_empty() && !set.has(Method::Options));
    }
}

//! Status codes of answers (RFC 9110, section 15).

/// Status of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
#[allow(missing_docs, reason = "the names are the words of RFC 9110")]
pub enum Status {
    SwitchingProtocols = 101,
    Ok = 200,
    Created = 201,
    Accepted = 202,
    NoContent = 204,
    PartialContent = 206,
    SeeOther = 303,
    NotModified = 304,
    BadRequest = 400,
    Unauthorized = 401,
    Forbidden = 403,
    NotFound = 404,
    MethodNotAllowed = 405,
    RequestTimeout = 408,
    Conflict = 409,
    LengthRequired = 411,
    PreconditionFailed = 412,
    ContentTooLarge = 413,
    UriTooLong = 414,
    UnsupportedMediaType = 415,
    RangeNotSatisfiable = 416,
    ExpectationFailed = 417,
    MisdirectedRequest = 421,
    UnprocessableContent = 422,
    UpgradeRequired = 426,
    TooManyRequests = 429,
    RequestHeaderFieldsTooLarge = 431,
    InternalServerError = 500,
    NotImplemented = 501,
    ServiceUnavailable = 503,
    HttpVersionNotSupported = 505,
    InsufficientStorage = 507,
}

impl Status {
    /// Returns the number of the status.
    #[must_use]
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// Returns whether answers of the status have no body, and say nothing of its length.
    #[must_use]
    pub const fn is_bare(self) -> bool {
        matches!(self, Self::SwitchingProtocols | Self::NoContent | Self::NotModified)
    }

    /// Returns the words of RFC 9110.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::SwitchingProtocols => "Switching Protocols",
            Self::Ok => "OK",
            Self::Created => "Created",
            Self::Accepted => "Accepted",
            Self::NoContent => "No Content",
            Self::PartialContent => "Partial Content",
            Self::SeeOther => "See Other",
            Self::NotModified => "Not Modified",
            Self::BadRequest => "Bad Request",
            Self::Unauthorized => "Unauthorized",
            Self::Forbidden => "Forbidden",
            Self::NotFound => "Not Found",
            Self::MethodNotAllowed => "Method Not Allowed",
            Self::RequestTimeout => "Request Timeout",
            Self::Conflict => "Conflict",
            Self::LengthRequired => "Length Required",
            Self::PreconditionFailed => "Precondition Failed",
            Self::ContentTooLarge => "Content Too Large",
            Self::UriTooLong => "URI Too Long",
            Self::UnsupportedMediaType => "Unsupported Media Type",
            Self::RangeNotSatisfiable => "Range Not Satisfiable",
            Self::ExpectationFailed => "Expectation Failed",
            Self::MisdirectedRequest => "Misdirected Request",
            Self::UnprocessableContent => "Unprocessable Content",
            Self::UpgradeRequired => "Upgrade Required",
            Self::TooManyRequests => "Too Many Requests",
            Self::RequestHeaderFieldsTooLarge => "Request Header Fields Too Large",
            Self::InternalServerError => "Internal Server Error",
            Self::NotImplemented => "Not Implemented",
            Self::ServiceUnavailable => "Service Unavailable",
            Self::HttpVersionNotSupported => "HTTP Version Not Supported",
            Self::InsufficientStorage => "Insufficient Storage",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_words_are_those_of_the_rfc() {
        for (status, code, reason) in [
            (Status::Ok, 200, "OK"),
            (Status::PartialContent, 206, "Partial Content"),
            (Status::MethodNotAllowed, 405, "Method Not Allowed"),
            (Status::RangeNotSatisfiable, 416, "Range Not Satisfiable"),
            (Status::UpgradeRequired, 426, "Upgrade Required"),
            (Status::TooManyRequests, 429, "Too Many Requests"),
            (Status::ServiceUnavailable, 503, "Service Unavailable"),
            (Status::InsufficientStorage, 507, "Insufficient Storage"),
        ] {
            assert_eq!((status.code(), status.reason()), (code, reason));
        }
        let bare = [Status::SwitchingProtocols, Status::NoContent, Status::NotModified];
        assert!(bare.iter().all(|status| status.is_bare()) && !Status::Ok.is_bare() && !Status::BadRequest.is_bare());
    }
}

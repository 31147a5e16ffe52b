//! Table of what may be asked over HTTP.

use http::{Content, Method, Role, Route, Routes};

/// Work of a route.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handler {
    /// WebSocket of the API.
    Socket,
    ServerInfo,
    PrinterInfo,
    ListObjects,
    QueryObjects,
    /// Stop at once, for pages whose socket is gone.
    EmergencyStop,
    /// Upload of a file, file of the card, removal of one.
    Upload,
    File,
    RemoveFile,
    /// A file of the page.
    Page,
}

/// Longest upload: what a file of the card can have, with what a form has beside it.
pub const UPLOAD_BYTES: u64 = 0xFFFF_FFFF;

const fn get(path: &'static str, role: Role, help: &'static str, handler: Handler) -> Route<Handler> {
    Route { method: Method::Get, path, role, content: Content::Nothing, body_bytes: 0, help, handler }
}

/// All routes: the first row that fits is taken.
pub const ROUTES: Routes<Handler> = Routes(&[
    get("/websocket", Role::Watch, "the API, as JSON-RPC 2.0 over a WebSocket", Handler::Socket),
    get("/server/info", Role::Watch, "state of the server", Handler::ServerInfo),
    get("/printer/info", Role::Watch, "state of the machine, in short", Handler::PrinterInfo),
    get("/printer/objects/list", Role::Watch, "names of all objects of the machine's state", Handler::ListObjects),
    get("/printer/objects/query", Role::Watch, "objects of the machine's state", Handler::QueryObjects),
    Route {
        method: Method::Post,
        path: "/printer/emergency_stop",
        role: Role::Watch,
        content: Content::Json,
        body_bytes: 256,
        help: "stop the machine at once",
        handler: Handler::EmergencyStop,
    },
    Route {
        method: Method::Post,
        path: "/server/files/upload",
        role: Role::Operate,
        content: Content::Form,
        body_bytes: UPLOAD_BYTES,
        help: "put a file on the card",
        handler: Handler::Upload,
    },
    get("/server/files/gcodes/*", Role::Watch, "a file of the card, or a picture out of one", Handler::File),
    Route {
        method: Method::Delete,
        path: "/server/files/gcodes/*",
        role: Role::Own,
        content: Content::Nothing,
        body_bytes: 0,
        help: "remove a file",
        handler: Handler::RemoveFile,
    },
    get("/*", Role::Nobody, "the page", Handler::Page),
]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_route_hides_another() {
        assert_eq!(ROUTES.hidden(), None);
    }

    #[test]
    fn nobody_gets_the_page_and_nothing_else() {
        for (route, _, admitted) in ROUTES.matrix().filter(|(_, role, _)| *role == Role::Nobody) {
            assert_eq!(admitted.is_ok(), route.handler == Handler::Page, "{}", route.path);
        }
    }
}

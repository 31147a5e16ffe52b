//! Table of what may be asked over HTTP.

use http::{Content, Method, Role, Route, Routes};

use crate::calls;
use crate::files::Ask;

/// Work of a route.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handler {
    /// WebSocket of the API.
    Socket,
    ServerInfo,
    PrinterInfo,
    ListObjects,
    QueryObjects,
    /// Lines of the console from before, as many as the query says.
    Lines,
    /// Temperatures of the last minutes.
    Temperatures,
    /// One call or several, as over the WebSocket, which are the body.
    Calls,
    /// Call whose parameters are the body, if there is one.
    Call(calls::Method),
    /// Stop at once, for pages whose socket is gone.
    EmergencyStop,
    /// Upload of a file, file of the card, removal of one.
    Upload,
    /// How much is there of an upload that broke off.
    UploadPart,
    File,
    RemoveFile,
    /// Question about files, whose paths stand in the query.
    Ask(Ask),
    /// A file of the page.
    Page,
}

/// Longest upload: what a file of the card can have, with what a form has beside it.
pub const UPLOAD_BYTES: u64 = 0xFFFF_FFFF;

const fn get(path: &'static str, role: Role, help: &'static str, handler: Handler) -> Route<Handler> {
    Route { method: Method::Get, path, role, content: Content::Nothing, body_bytes: 0, help, handler }
}

/// Longest body of a call, bytes: parameters of access are short.
const CALL_BYTES: u64 = 512;

/// Longest body of calls, bytes.
const CALLS_BYTES: u64 = 4_096;

const fn call(path: &'static str, method: calls::Method, help: &'static str) -> Route<Handler> {
    let (role, handler) = (method.least_role(), Handler::Call(method));
    Route { method: Method::Post, path, role, content: Content::Json, body_bytes: CALL_BYTES, help, handler }
}

/// All routes: the first row that fits is taken.
pub const ROUTES: Routes<Handler> = Routes(&[
    get("/websocket", Role::Nobody, "the API, as JSON-RPC 2.0 over a WebSocket", Handler::Socket),
    get("/server/info", Role::Watch, "state of the server", Handler::ServerInfo),
    get("/printer/info", Role::Watch, "state of the machine, in short", Handler::PrinterInfo),
    get("/printer/objects/list", Role::Watch, "names of all objects of the machine's state", Handler::ListObjects),
    get("/printer/objects/query", Role::Watch, "objects of the machine's state", Handler::QueryObjects),
    get("/server/gcode_store", Role::Watch, "lines of the console from before", Handler::Lines),
    get("/server/temperature_store", Role::Watch, "temperatures of the last minutes", Handler::Temperatures),
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
    get("/server/files/upload", Role::Operate, "how much is there of an upload that broke off", Handler::UploadPart),
    get("/server/files/list", Role::Watch, "files of a folder", Handler::Ask(Ask::List)),
    get("/server/files/directory", Role::Watch, "folder with its entries", Handler::Ask(Ask::Directory)),
    get("/server/files/metadata", Role::Watch, "what a slicer has written into a file", Handler::Ask(Ask::Metadata)),
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
    Route {
        method: Method::Post,
        path: "/server/jsonrpc",
        role: Role::Nobody,
        content: Content::Json,
        body_bytes: CALLS_BYTES,
        help: "calls of the API, one or an array of them",
        handler: Handler::Calls,
    },
    call("/access/login", calls::Method::Login, "log in with the password: the answer has a session's cookie"),
    call("/access/logout", calls::Method::Logout, "end the session"),
    call("/access/api_key", calls::Method::MakeKey, "make a key for a program, which is shown this once"),
    get("/access/info", Role::Nobody, "how to be let in", Handler::Call(calls::Method::AccessInfo)),
    get("/access/user", Role::Nobody, "who the visitor is", Handler::Call(calls::Method::GetUser)),
    get("/*", Role::Nobody, "the page", Handler::Page),
]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_route_hides_another() {
        assert_eq!(ROUTES.hidden(), None);
    }

    /// What each role may ask, written once more: a row that is changed or added has to be decided on here.
    #[test]
    fn each_role_may_ask_for_what_is_written_here() {
        const LEAST: [(Method, &str, Role); 22] = [
            (Method::Get, "/websocket", Role::Nobody),
            (Method::Get, "/server/info", Role::Watch),
            (Method::Get, "/printer/info", Role::Watch),
            (Method::Get, "/printer/objects/list", Role::Watch),
            (Method::Get, "/printer/objects/query", Role::Watch),
            (Method::Get, "/server/gcode_store", Role::Watch),
            (Method::Get, "/server/temperature_store", Role::Watch),
            (Method::Post, "/printer/emergency_stop", Role::Watch),
            (Method::Get, "/server/files/list", Role::Watch),
            (Method::Get, "/server/files/directory", Role::Watch),
            (Method::Get, "/server/files/metadata", Role::Watch),
            (Method::Post, "/server/files/upload", Role::Operate),
            (Method::Get, "/server/files/upload", Role::Operate),
            (Method::Get, "/server/files/gcodes/*", Role::Watch),
            (Method::Delete, "/server/files/gcodes/*", Role::Own),
            (Method::Post, "/server/jsonrpc", Role::Nobody),
            (Method::Post, "/access/login", Role::Nobody),
            (Method::Post, "/access/logout", Role::Nobody),
            (Method::Post, "/access/api_key", Role::Own),
            (Method::Get, "/access/info", Role::Nobody),
            (Method::Get, "/access/user", Role::Nobody),
            (Method::Get, "/*", Role::Nobody),
        ];
        assert_eq!(ROUTES.0.len(), LEAST.len());
        for (route, role, admitted) in ROUTES.matrix() {
            let row = LEAST.iter().find(|(method, path, _)| *path == route.path && *method == route.method);
            let (.., least) = row.expect(route.path);
            assert_eq!(admitted.is_ok(), role >= *least, "{} {role:?}", route.path);
        }
    }
}

//! The page's files, and the responses to HTTP requests.
//!
//! In: the head of a request. Out: a file of the page, a refusal, or the key of a WebSocket's
//! handshake. Promise: a WebSocket is opened for pages of this server alone, whose `Origin` has the
//! same authority as `Host`; a request without an origin comes from no browser and is refused.

use crate::http::{Head, Refused};
use tungstenite::handshake::derive_accept_key;

/// The files: path, media type and contents.
const FILES: &[(&str, &str, &str)] = &[
    ("/", "text/html; charset=utf-8", include_str!("assets/index.html")),
    ("/page.css", "text/css; charset=utf-8", include_str!("assets/page.css")),
    ("/page.js", "text/javascript; charset=utf-8", include_str!("assets/page.js")),
    ("/frame.js", "text/javascript; charset=utf-8", include_str!("assets/frame.js")),
    ("/view.js", "text/javascript; charset=utf-8", include_str!("assets/view.js")),
    ("/input.js", "text/javascript; charset=utf-8", include_str!("assets/input.js")),
    ("/console.js", "text/javascript; charset=utf-8", include_str!("assets/console.js")),
    ("/png.js", "text/javascript; charset=utf-8", include_str!("assets/png.js")),
    ("/icon.svg", "image/svg+xml", include_str!("assets/icon.svg")),
];

/// Path of the WebSocket.
const SOCKET_PATH: &str = "/socket";

/// Headers of all responses: no code but the page's own files, no other site, no frame around it.
const SAFETY: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
                      img-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; \
                      frame-ancestors 'none'\r\n\
                      X-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\nReferrer-Policy: no-referrer\r\n\
                      Cross-Origin-Opener-Policy: same-origin\r\nCross-Origin-Resource-Policy: same-origin\r\n\
                      Cache-Control: no-store\r\n";

/// The response to a request.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Response {
    /// Bytes to send before the connection is closed.
    Bytes(Vec<u8>),
    /// The head of the response with which the WebSocket begins.
    Switch(Vec<u8>),
}

/// Returns the response to a request's head.
pub(super) fn respond(head: &[u8], own_name: Option<&str>) -> Response {
    let parsed = Head::parse(head, own_name);
    match parsed.and_then(|head| if head.path == SOCKET_PATH { switch(&head) } else { Ok(file(&head)) }) {
        Ok(response) => response,
        Err(refused) => Response::Bytes(refusal(&refused)),
    }
}

/// Returns the response of a refusal.
pub(super) fn refusal(refused: &Refused) -> Vec<u8> {
    let body = format!("{}\n", refused.reason);
    response(refused.status, "text/plain; charset=utf-8", &body, true)
}

fn response(status: &str, media_type: &str, body: &str, wants_body: bool) -> Vec<u8> {
    let allow = if status.starts_with("405") { "Allow: GET, HEAD\r\n" } else { "" };
    let body_sent = if wants_body { body } else { "" };
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: {media_type}\r\nContent-Length: {}\r\n{allow}{SAFETY}\
         Connection: close\r\n\r\n{body_sent}",
        body.len()
    )
    .into_bytes()
}

fn file(head: &Head<'_>) -> Response {
    Response::Bytes(match FILES.iter().find(|(path, ..)| *path == head.path) {
        Some((_, media_type, body)) => response("200 OK", media_type, body, head.is_get),
        None => refusal(&Refused { status: "404 Not Found", reason: "the page is at /" }),
    })
}

/// Returns the head of the response with which the WebSocket begins (RFC 6455, section 4.2).
fn switch(head: &Head<'_>) -> Result<Response, Refused> {
    let refused = |status, reason| Err(Refused { status, reason });
    let has = |name, word: &str| {
        head.values(name).flat_map(|value| value.split(',')).any(|v| v.trim().eq_ignore_ascii_case(word))
    };
    if !head.is_get || !has("upgrade", "websocket") || !has("connection", "upgrade") {
        return refused("426 Upgrade Required", "a WebSocket is opened here");
    }
    if head.value("sec-websocket-version") != Some("13") {
        return refused("426 Upgrade Required", "version 13 of the WebSocket protocol is spoken here");
    }
    // 16 bytes in base64.
    let Some(key) = head.value("sec-websocket-key").filter(|key| key.len() == 24 && key.ends_with("=="))
    else {
        return refused("400 Bad Request", "Sec-WebSocket-Key is expected");
    };
    let origin = head
        .value("origin")
        .and_then(|origin| origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://")));
    if origin.is_none_or(|origin| !head.value("host").is_some_and(|host| host.eq_ignore_ascii_case(origin))) {
        return refused("403 Forbidden", "the WebSocket is for this server's own page");
    }
    let accept = derive_accept_key(key.as_bytes());
    let text = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\n\r\n"
    );
    Ok(Response::Switch(text.into_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

    fn status(request: &str) -> String {
        let head = format!("{request}\r\n");
        let bytes = match respond(head.as_bytes(), Some("wall.example")) {
            Response::Bytes(bytes) | Response::Switch(bytes) => String::from_utf8(bytes).unwrap(),
        };
        bytes.split(' ').nth(1).unwrap().to_owned()
    }

    fn socket(host: &str, more: &str) -> String {
        status(&format!(
            "GET /socket HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: keep-alive, Upgrade\r\n{KEY}{more}"
        ))
    }

    #[test]
    fn a_socket_is_for_the_own_page_alone() {
        for (host, origin) in [
            ("127.0.0.1:8080", "http://127.0.0.1:8080"),
            ("localhost:8080", "http://LOCALHOST:8080"),
            ("[::1]:8080", "http://[::1]:8080"),
            ("wall.example", "https://wall.example"),
        ] {
            assert_eq!(socket(host, &format!("Origin: {origin}\r\n")), "101", "{origin}");
        }
        for origin in [
            "http://evil.example",
            "http://localhost:8080",
            "http://127.0.0.1",
            "http://127.0.0.1:8081",
            "http://127.0.0.1:8080.evil.example",
            "null",
            "file://",
            "127.0.0.1:8080",
            "",
        ] {
            assert_eq!(socket("127.0.0.1:8080", &format!("Origin: {origin}\r\n")), "403", "{origin}");
        }
        assert_eq!(socket("127.0.0.1:8080", ""), "403", "no origin is no browser");
        let own = "Origin: http://127.0.0.1:8080\r\n";
        assert_eq!(socket("127.0.0.1:8080", &format!("{own}Origin: http://evil.example\r\n")), "403");
        assert_eq!(socket("evil.example", "Origin: http://evil.example\r\n"), "403", "a rebound name");
    }

    #[test]
    fn what_is_no_handshake_is_refused() {
        let request = |head: &str| status(&format!("GET /socket HTTP/1.1\r\nHost: localhost\r\n{head}"));
        assert_eq!(request(""), "426");
        let upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nOrigin: http://localhost\r\n";
        assert_eq!(request(&format!("{upgrade}{KEY}")), "101");
        assert_eq!(request(&format!("{upgrade}{}", KEY.replace("13", "8"))), "426");
        assert_eq!(request(&format!("{upgrade}{}", KEY.replace("==", ""))), "400");
        assert_eq!(status("POST /socket HTTP/1.1\r\nHost: localhost\r\n"), "405");
    }

    #[test]
    fn the_page_has_no_inline_code_and_no_other_site() {
        for (path, _, text) in FILES {
            for word in ["http://", "https://", "eval(", "innerHTML", "style=", " onclick", "javascript:"] {
                let is_namespace = *path == "/icon.svg" && word == "http://";
                assert!(is_namespace || !text.contains(word), "{path} has {word}");
            }
            assert_eq!(status(&format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n")), "200");
        }
        assert_eq!(status("GET /../Cargo.toml HTTP/1.1\r\nHost: localhost\r\n"), "404");
        assert_eq!(status("GET / HTTP/1.1\r\nHost: evil.example\r\n"), "403");
        let html = FILES[0].2;
        assert!(
            !html.contains("<style")
                && html.matches("<script").count()
                    == html.matches("<script src").count()
                        + html.matches("<script type=\"module\" src").count()
        );
    }
}

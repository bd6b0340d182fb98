//! Who may connect: the head of a request, and the checks of its host, origin and token.
//!
//! A page of another site can make a browser connect to this server, but it has no token, its
//! origin is another one, and a name that it has pointed at this computer (DNS rebinding) is not a
//! host of this server.

use std::net::{IpAddr, SocketAddr};

use crate::token::Token;

/// Bytes of the head of a request.
pub const HEAD_BYTES: usize = 8192;

/// Fields of a head.
const FIELDS: usize = 64;

/// Route of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Route {
    /// A file of the page.
    File(String),
    /// The page itself, with a valid token.
    Page,
    /// A file for the user, with a valid token.
    Download(String),
    /// A WebSocket, with a valid token: the key of its handshake.
    Socket(String),
    /// Nothing that it gets: status and reason.
    Refused(u16, &'static str),
}

/// A request: its route, and the length of its head.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Its route.
    pub route: Route,
    /// Bytes of the head.
    pub length: usize,
}

/// The checks.
pub struct Guard {
    address: SocketAddr,
    token: Token,
}

impl Guard {
    /// Of a server at this address.
    pub fn new(address: SocketAddr, token: Token) -> Self {
        Self { address, token }
    }

    /// The request that starts with these bytes; `None` while its head is incomplete.
    pub fn request(&self, bytes: &[u8]) -> Option<Request> {
        let refused = |status, why| Request {
            route: Route::Refused(status, why),
            length: bytes.len(),
        };
        let mut fields = [httparse::EMPTY_HEADER; FIELDS];
        let mut head = httparse::Request::new(&mut fields);
        match head.parse(bytes) {
            Ok(httparse::Status::Complete(length)) => Some(Request {
                route: self.route(&head),
                length,
            }),
            Ok(httparse::Status::Partial) if bytes.len() < HEAD_BYTES => None,
            Ok(httparse::Status::Partial) => Some(refused(431, "the request is too long")),
            Err(_) => Some(refused(400, "the request is malformed")),
        }
    }

    fn route(&self, head: &httparse::Request<'_, '_>) -> Route {
        let field = |name: &str| {
            let mut found = head
                .headers
                .iter()
                .filter(|field| field.name.eq_ignore_ascii_case(name));
            let first = found.next();
            // Two fields of one name could be read as either.
            first
                .filter(|_| found.next().is_none())
                .and_then(|field| std::str::from_utf8(field.value).ok())
                .map(str::trim)
        };
        if head.method != Some("GET") {
            return Route::Refused(405, "the method is not GET");
        }
        let Some(host) = field("Host").filter(|host| self.is_host(host)) else {
            return Route::Refused(421, "the host is not this server");
        };
        let target = head.path.unwrap_or_default();
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        if super::assets::find(path).is_some() {
            return Route::File(path.to_owned());
        }
        let given = query
            .split('&')
            .find_map(|pair| pair.strip_prefix("token="));
        if !given.is_some_and(|given| self.token.is(given)) {
            return Route::Refused(403, "the token is missing or wrong");
        }
        match path {
            "/" => Route::Page,
            "/socket" => {
                if field("Origin") != Some(&format!("http://{host}")) {
                    return Route::Refused(403, "the origin is not this server");
                }
                let is_upgrade =
                    field("Upgrade").is_some_and(|value| value.eq_ignore_ascii_case("websocket"));
                match field("Sec-WebSocket-Key") {
                    Some(key) if is_upgrade && field("Sec-WebSocket-Version") == Some("13") => {
                        Route::Socket(key.to_owned())
                    }
                    _ => Route::Refused(400, "the handshake of the WebSocket is malformed"),
                }
            }
            _ => match path.strip_prefix("/files/") {
                Some(name) => Route::Download(name.to_owned()),
                None => Route::Refused(404, "there is no such file"),
            },
        }
    }

    /// Whether this host can be this server: a name cannot be resolved to
    /// it by others, and an address is its own.
    fn is_host(&self, host: &str) -> bool {
        let Some((name, port)) = host.rsplit_once(':') else {
            return false;
        };
        if port.parse() != Ok(self.address.port()) {
            return false;
        }
        let bare = name
            .strip_prefix('[')
            .and_then(|name| name.strip_suffix(']'));
        match bare.unwrap_or(name).parse::<IpAddr>() {
            Ok(address) if address.is_loopback() => true,
            // An address cannot be rebound.
            Ok(_) => !self.address.ip().is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: &str) -> (Guard, String) {
        let token = Token::random().unwrap();
        let text = token.text().to_owned();
        (Guard::new(address.parse().unwrap(), token), text)
    }

    fn route(guard: &Guard, target: &str, host: &str, more: &str) -> Route {
        let text = format!("GET {target} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n");
        guard
            .request(text.as_bytes())
            .expect("it is complete")
            .route
    }

    fn status(route: &Route) -> u16 {
        match route {
            Route::Refused(status, _) => *status,
            _ => 200,
        }
    }

    const SOCKET: &str =
        "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: x\r\n";

    #[test]
    fn only_a_host_of_this_server_is_served() {
        let (local, _) = guard("127.0.0.1:29500");
        for (host, expected) in [
            ("127.0.0.1:29500", 200),
            ("localhost:29500", 200),
            ("[::1]:29500", 200),
            ("127.0.0.1:29501", 421),
            ("127.0.0.1", 421),
            ("attacker.example:29500", 421),
            ("localhost.attacker.example:29500", 421),
            ("192.168.1.5:29500", 421),
        ] {
            assert_eq!(
                status(&route(&local, "/main.js", host, "")),
                expected,
                "{host}"
            );
        }
        let (open, _) = guard("0.0.0.0:29500");
        assert_eq!(
            status(&route(&open, "/main.js", "192.168.1.5:29500", "")),
            200
        );
        assert_eq!(
            status(&route(&open, "/main.js", "attacker.example:29500", "")),
            421
        );
        let two = "Host: attacker.example\r\n";
        assert_eq!(
            status(&route(&local, "/main.js", "127.0.0.1:29500", two)),
            421
        );
    }

    #[test]
    fn the_page_the_socket_and_files_need_the_token() {
        let (guard, token) = guard("127.0.0.1:29500");
        let host = "127.0.0.1:29500";
        for path in ["/", "/socket", "/files/a.csv", "/unknown"] {
            for wrong in [
                "",
                "?token=",
                "?token=00",
                "?other=1",
                &format!("?token={token}0"),
            ] {
                let target = format!("{path}{wrong}");
                assert_eq!(
                    status(&route(&guard, &target, host, SOCKET)),
                    403,
                    "{target}"
                );
            }
        }
        assert_eq!(
            route(&guard, &format!("/?token={token}"), host, ""),
            Route::Page
        );
    }

    #[test]
    fn a_socket_of_another_origin_is_refused() {
        let (guard, token) = guard("127.0.0.1:29500");
        let target = format!("/socket?token={token}");
        let of = |origin: &str| {
            let more = format!("{SOCKET}Origin: {origin}\r\n");
            route(&guard, &target, "127.0.0.1:29500", &more)
        };
        assert_eq!(of("http://127.0.0.1:29500"), Route::Socket("x".into()));
        for origin in [
            "http://attacker.example",
            "http://127.0.0.1:8000",
            "null",
            "http://localhost:29500",
        ] {
            assert_eq!(status(&of(origin)), 403, "{origin}");
        }
        assert_eq!(
            status(&route(&guard, &target, "127.0.0.1:29500", SOCKET)),
            403,
            "none"
        );
    }

    #[test]
    fn heads_are_bounded_and_malformed_ones_refused() {
        let (guard, _) = guard("127.0.0.1:29500");
        assert_eq!(guard.request(b"GET / HT"), None);
        let long = vec![b'a'; HEAD_BYTES];
        let long = [b"GET /".as_slice(), &long].concat();
        assert_eq!(status(&guard.request(&long).unwrap().route), 431);
        let binary = guard.request(b"\x16\x03\x01\x02\x00\x01\r\n\r\n").unwrap();
        assert_eq!(status(&binary.route), 400);
        let post = guard.request(b"POST / HTTP/1.1\r\nHost: 127.0.0.1:29500\r\n\r\n");
        assert_eq!(status(&post.unwrap().route), 405);
    }
}

//! Addresses as arguments: `HOST:PORT`, `:PORT` for loopback, a path for a Unix socket.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;

/// Default port, that of Pixelflut servers.
pub(in crate::cli) const DEFAULT_PORT: u16 = 1234;

/// Returns the address that a server listens on by default.
pub(in crate::cli) fn default_address() -> SocketAddr {
    (Ipv4Addr::LOCALHOST, DEFAULT_PORT).into()
}

/// Parses `HOST:PORT`, `:PORT`, `PORT` or `HOST`; without a host it is loopback.
pub(in crate::cli) fn tcp(text: &str) -> Result<SocketAddr, String> {
    let expected =
        || format!("an address is HOST:PORT, :PORT or PORT, as in 127.0.0.1:{DEFAULT_PORT}, not {text:?}");
    if let Ok(host) = text.parse::<IpAddr>() {
        return Ok((host, DEFAULT_PORT).into());
    }
    // A number alone is a port: the system would parse it as an address, 4567 as 0.0.17.215.
    let port = text.strip_prefix(':').or_else(|| text.bytes().all(|b| b.is_ascii_digit()).then_some(text));
    if let Some(port) = port {
        let port: u16 = port.parse().map_err(|_| expected())?;
        return Ok((Ipv4Addr::LOCALHOST, port).into());
    }
    if let Ok(address) = text.parse() {
        return Ok(address);
    }
    // The system would read 0x1234 and 1.2 as addresses, too.
    let host = text.rsplit_once(':').map_or(text, |(host, _)| host);
    let is_decimal = host.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let is_hex = |digits: &str| digits.bytes().all(|b| b.is_ascii_hexdigit() || b == b'.');
    if is_decimal || host.strip_prefix("0x").is_some_and(is_hex) {
        host.parse::<IpAddr>().map_err(|_| expected())?;
    }
    let with_port = match text.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => text.to_owned(),
        None if !text.is_empty() => format!("{text}:{DEFAULT_PORT}"),
        _ => return Err(expected()),
    };
    let mut found =
        with_port.to_socket_addrs().map_err(|e| format!("no host has this name ({e}); {}", expected()))?;
    found.next().ok_or_else(|| format!("no host has this name; {}", expected()))
}

/// Parses an address to listen on, and refuses one that other machines reach unless that is allowed.
pub(in crate::cli) fn checked(text: &str, allow_remote: bool) -> Result<SocketAddr, String> {
    let address = tcp(text)?;
    match is_loopback(&address) || allow_remote {
        true => Ok(address),
        false => Err(format!("{address} can be reached from other machines: that needs --allow-remote")),
    }
}

/// Returns whether an address is reachable from this machine only; IPv4 addresses mapped to IPv6
/// are recognised.
pub(in crate::cli) fn is_loopback(address: &SocketAddr) -> bool {
    address.ip().to_canonical().is_loopback()
}

/// Returns the host of an address if it is a name, not an IP address.
pub(in crate::cli) fn host_name(text: &str) -> Option<&str> {
    let host = text.rsplit_once(':').map_or(text, |(host, _)| host);
    let is_name =
        !host.is_empty() && !host.starts_with('[') && !host.contains(':') && host.parse::<IpAddr>().is_err();
    (is_name && host.parse::<u16>().is_err()).then_some(host)
}

/// Address of a server: a Unix socket for text with `/`, the prefix `unix:` or the name of a socket
/// in the current folder, otherwise TCP.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) enum ServerAddress {
    Tcp(SocketAddr),
    Unix(PathBuf),
}

/// Parses the address of a server.
pub(in crate::cli) fn target(text: &str) -> Result<ServerAddress, String> {
    match text.strip_prefix("unix:") {
        Some(path) => Ok(ServerAddress::Unix(path.into())),
        None if text.contains('/') || is_socket(text) => Ok(ServerAddress::Unix(text.into())),
        None => tcp(text).map(ServerAddress::Tcp),
    }
}

/// Returns whether a path is that of a Unix socket.
#[cfg(unix)]
fn is_socket(path: &str) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|meta| meta.file_type().is_socket())
}

#[cfg(not(unix))]
fn is_socket(_: &str) -> bool {
    false
}

/// Returns the message for a server that cannot be reached, with a hint.
pub(in crate::cli) fn no_server(address: &str, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::ConnectionRefused | io::ErrorKind::NotFound => {
            format!(
                "{address}: no server there ({error}); `fbptr serve` starts one, and says where it listens"
            )
        }
        _ => format!("{address}: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_without_a_host_are_loopback() {
        assert_eq!(tcp(":99").unwrap(), "127.0.0.1:99".parse().unwrap());
        assert_eq!(tcp("0.0.0.0:99").unwrap(), "0.0.0.0:99".parse().unwrap());
        assert_eq!(tcp("[::1]:99").unwrap(), "[::1]:99".parse().unwrap());
        assert_eq!(tcp("127.0.0.1").unwrap(), "127.0.0.1:1234".parse().unwrap());
        assert_eq!(tcp("4567").unwrap(), "127.0.0.1:4567".parse().unwrap());
        for (text, name) in [
            ("wall.local:9100", Some("wall.local")),
            ("wall", Some("wall")),
            ("4567", None),
            (":99", None),
            ("127.0.0.1:99", None),
            ("[::1]:99", None),
            ("::1", None),
        ] {
            assert_eq!(host_name(text), name, "{text}");
        }
        assert_eq!(tcp("::1").unwrap(), "[::1]:1234".parse().unwrap());
        for bad in ["0x1234", "0x7f000001:99", "1.2", "1.2:99", "1.2.3.4.5:9"] {
            assert!(tcp(bad).unwrap_err().starts_with("an address is HOST:PORT"), "{bad}");
        }
        for bad in ["", ":", ":x", "99999", ":99999", "127.0.0.1:", "127.0.0.1:x", "a b:1"] {
            assert!(tcp(bad).is_err(), "{bad}");
        }
        let unknown = tcp("a b:1").unwrap_err();
        assert!(unknown.contains("no host has this name") && unknown.contains("HOST:PORT"), "{unknown}");
        assert_eq!(target("/a/b").unwrap(), ServerAddress::Unix("/a/b".into()));
        assert_eq!(target("unix:b").unwrap(), ServerAddress::Unix("b".into()));
    }
}

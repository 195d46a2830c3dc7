//! Status lines of a server: its addresses, number of clients, and rates.
//!
//! In: readings of the server's [`MetricsBoard`], once a second. Out: lines of text.

use fbptr_server::{MetricsBoard, Stats};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Period over which rates are measured.
const PERIOD: Duration = Duration::from_secs(1);

/// Addresses and rates of a server, as shown in its window.
#[derive(Clone, Debug)]
pub struct ServerStatus {
    addresses: Vec<String>,
    board: Arc<MetricsBoard>,
    last: Option<(Instant, Stats)>,
    rates: [String; 2],
}

impl ServerStatus {
    /// Creates the status of a server with these addresses, whose counters are read from `board`.
    pub fn new(addresses: Vec<String>, board: Arc<MetricsBoard>) -> Self {
        ServerStatus { addresses, board, last: None, rates: Default::default() }
    }

    /// Returns what a window shows while nothing was drawn: the addresses, and a line to copy.
    pub fn welcome(&self) -> Vec<String> {
        let mut lines = vec!["nothing was drawn yet".to_owned(), String::new()];
        lines.extend(self.addresses.iter().map(|address| format!("listening on {address}")));
        let targets = self.addresses.iter().filter_map(|address| target(address));
        if let Some(target) = targets.into_iter().next() {
            lines.extend([String::new(), "in a shell:".to_owned(), String::new()]);
            lines.push(format!("printf 'LINE 0 0 99 99 red\\n' | nc {target}"));
        }
        lines
    }

    /// Returns the current lines, measuring the rates if a period has passed.
    pub fn lines(&mut self) -> Vec<String> {
        let now = Instant::now();
        if self.last.is_none_or(|(at, _)| now >= at + PERIOD) {
            let metrics = self.board.read().metrics;
            let (elapsed, done) = match self.last {
                Some((at, before)) => ((now - at).as_secs_f64(), metrics.engine.totals - before),
                None => (f64::INFINITY, Stats::default()),
            };
            let rate = |count: u64| count as f64 / elapsed;
            let clients = match metrics.engine.connections {
                1 => "1 client".to_owned(),
                n => format!("{n} clients"),
            };
            let bytes = short(rate(done.bytes));
            let number = bytes.trim_end_matches(char::is_alphabetic);
            self.rates = [
                format!("{clients}  {} commands/s", short(rate(done.commands))),
                format!("{} pixels/s  {number} {}B/s", short(rate(done.pixels)), &bytes[number.len()..]),
            ];
            self.last = Some((now, metrics.engine.totals));
        }
        self.addresses.iter().chain(&self.rates).cloned().collect()
    }
}

/// Returns the arguments of nc for an address, if it can reach it from this machine.
fn target(address: &str) -> Option<String> {
    let (kind, place) = address.split_once(' ').unwrap_or(("", address));
    if kind == "unix" {
        return Some(format!("-U {place}"));
    }
    let address: std::net::SocketAddr = place.parse().ok()?;
    let is_here = address.ip().is_loopback() || address.ip().is_unspecified();
    let host = if is_here { "localhost".to_owned() } else { address.ip().to_string() };
    Some(format!("{host} {}", address.port()))
}

/// Formats a number in at most five characters, with k, M or G.
fn short(number: f64) -> String {
    let (scaled, unit) = match number {
        n if n < 1e3 => return format!("{n:.0}"),
        n if n < 1e6 => (n / 1e3, "k"),
        n if n < 1e9 => (n / 1e6, "M"),
        n => (n / 1e9, "G"),
    };
    match scaled < 100.0 {
        true => format!("{scaled:.1}{unit}"),
        false => format!("{scaled:.0}{unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_server::Metrics;

    #[test]
    fn the_line_to_copy_reaches_the_server_from_this_machine() {
        for (address, expected) in [
            ("tcp 127.0.0.1:1234", Some("localhost 1234")),
            ("tcp 0.0.0.0:80", Some("localhost 80")),
            ("tcp [::]:80", Some("localhost 80")),
            ("tcp 192.168.1.7:99", Some("192.168.1.7 99")),
            ("unix /tmp/fb", Some("-U /tmp/fb")),
            ("tcp nonsense", None),
        ] {
            assert_eq!(target(address).as_deref(), expected, "{address}");
        }
        let status = ServerStatus::new(vec!["tcp 127.0.0.1:1337".into()], MetricsBoard::new());
        let line = "printf 'LINE 0 0 99 99 red\\n' | nc localhost 1337";
        assert!(status.welcome().iter().any(|l| l == line), "{:?}", status.welcome());
    }

    #[test]
    fn numbers_are_short() {
        for (number, text) in [
            (0.0, "0"),
            (999.4, "999"),
            (1000.0, "1.0k"),
            (12_345.0, "12.3k"),
            (129e6, "129M"),
            (2.5e9, "2.5G"),
        ] {
            assert_eq!(short(number), text);
        }
    }

    #[test]
    fn addresses_clients_and_rates_are_told() {
        let board = MetricsBoard::new();
        let mut status = ServerStatus::new(vec!["tcp 127.0.0.1:1234".into()], board.clone());
        assert_eq!(status.lines(), ["tcp 127.0.0.1:1234", "0 clients  0 commands/s", "0 pixels/s  0 B/s"]);
        let fill = |m: &mut Metrics| {
            m.engine.connections = 1;
            m.engine.totals.pixels = 10_000;
            m.engine.totals.bytes = 50_000;
        };
        assert!(board.update(Instant::now(), fill));
        let before = Instant::now().checked_sub(PERIOD).expect("the clock has run for a second");
        status.last = Some((before, Stats::default()));
        let lines = status.lines();
        assert_eq!(lines[1], "1 client  0 commands/s");
        assert!(lines[2].contains("k pixels/s  ") && lines[2].ends_with(" kB/s"), "{lines:?}");
    }
}

//! `--web`: the page in the browser, as arguments, and the links that lead to it.

use super::{args::address, say_as_program};
use crate::server::{
    Engine, MetricsBoard, RenderThread, Server, VerbCounts, WebFeed, WebObserver, WebOptions, WebServer,
    WebTokens,
};
use clap::Args;
use std::io;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::sync::Arc;

/// The page in the browser.
#[derive(Debug, Args)]
pub(super) struct WebArgs {
    /// Show the frame in browsers, on a page at this address; :PORT is loopback
    #[arg(long, value_name = "ADDR")]
    web: Option<String>,
    /// Let those who have the second link of --web run commands, and send keys and mouse
    #[arg(long, requires = "web")]
    web_write: bool,
}

/// The running page.
pub(super) type WebPage = WebServer;

/// The page's settings, checked.
#[derive(Debug)]
pub(super) struct PreparedWeb {
    address: SocketAddr,
    name: Option<String>,
    tokens: WebTokens,
    feed: Option<Arc<WebFeed>>,
    board: Option<Arc<MetricsBoard>>,
}

impl WebArgs {
    /// Returns whether the page is asked for.
    pub fn is_wanted(&self) -> bool {
        self.web.is_some()
    }

    /// Returns the descriptors that the page needs.
    pub fn descriptors(&self) -> usize {
        if self.is_wanted() { WebServer::MAX_FILES } else { 0 }
    }

    /// Checks the address and draws the tokens.
    pub fn prepare(&self, allow_remote: bool) -> Result<Option<PreparedWeb>, String> {
        let Some(text) = &self.web else { return Ok(None) };
        let address = address::checked(text, allow_remote)?;
        let is_remote = !address::is_loopback(&address);
        let tokens = WebTokens::new(is_remote, self.web_write)
            .map_err(|e| format!("--web: no random numbers for the links: {e}"))?;
        let name = address::host_name(text).map(str::to_owned);
        Ok(Some(PreparedWeb { address, name, tokens, feed: None, board: None }))
    }
}

impl PreparedWeb {
    /// Lets the page follow an engine: its frames, and its counters.
    pub fn attach(&mut self, engine: &mut Engine) {
        let feed = self.feed(engine.memory().width(), engine.memory().height());
        engine.attach(WebObserver::new(feed));
        if engine.observer::<VerbCounts>().is_none() {
            engine.attach(VerbCounts::new(MetricsBoard::new()));
        }
        self.board = engine.observer::<VerbCounts>().map(|counts| counts.board().clone());
    }

    /// Returns the feed of the page, for frames of this size.
    pub fn feed(&mut self, width: u32, height: u32) -> Arc<WebFeed> {
        self.feed.get_or_insert_with(|| WebFeed::new(width, height)).clone()
    }

    /// Serves the page of a server.
    pub fn serve(self, server: &Server) -> Result<WebPage, String> {
        self.start(|feed, options| server.serve_web(feed, options))
    }

    /// Serves the page of a render thread.
    pub fn serve_thread(self, thread: &RenderThread) -> Result<WebPage, String> {
        self.start(|feed, options| thread.serve_web(feed, options))
    }

    /// Serves the page of a program that is no server.
    pub fn serve_program(self) -> Result<WebPage, String> {
        self.start(WebServer::of_program)
    }

    fn start(
        self,
        serve: impl FnOnce(Arc<WebFeed>, WebOptions) -> io::Result<WebServer>,
    ) -> Result<WebPage, String> {
        let PreparedWeb { address, name, tokens, feed, board } = self;
        let feed = feed.ok_or("--web: there is no frame to show")?;
        let options = WebOptions { address, name: name.clone(), tokens: tokens.clone(), board };
        let page = serve(feed, options).map_err(|e| format!("cannot serve the page on {address}: {e}"))?;
        let base = format!("http://{}/", authority(page.address(), name.as_deref()));
        let link = |word: Option<&str>| word.map_or(base.clone(), |word| format!("{base}#{word}"));
        say_as_program(format_args!("watch in the browser: {}", link(tokens.watch())));
        if tokens.drive().is_some() {
            say_as_program(format_args!("watch and drive: {}", link(tokens.drive())));
        }
        if tokens.watch().is_some() {
            say_as_program(
                "warning: the page is not encrypted: whoever reads the network sees the links' tokens",
            );
        }
        Ok(page)
    }
}

/// Returns the authority of the links: the name that was given, or an address of this machine.
fn authority(mut address: SocketAddr, name: Option<&str>) -> String {
    if let Some(name) = name {
        return format!("{name}:{}", address.port());
    }
    if address.ip().is_unspecified() {
        address.set_ip(own_address(address.ip()));
    }
    address.to_string()
}

/// Returns the address from which this machine would reach others, or loopback. Nothing is sent.
fn own_address(unspecified: IpAddr) -> IpAddr {
    let probe = |own: &str, other: &str| {
        let socket = UdpSocket::bind((own, 0))?;
        // Addresses of documentation (RFC 5737, RFC 3849).
        socket.connect((other, 9))?;
        io::Result::Ok(socket.local_addr()?.ip())
    };
    match unspecified {
        IpAddr::V4(_) => probe("0.0.0.0", "192.0.2.1").unwrap_or(std::net::Ipv4Addr::LOCALHOST.into()),
        IpAddr::V6(_) => probe("::", "2001:db8::1").unwrap_or(std::net::Ipv6Addr::LOCALHOST.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(web: &str, web_write: bool) -> WebArgs {
        WebArgs { web: Some(web.into()), web_write }
    }

    #[test]
    fn a_page_that_others_reach_is_allowed_and_has_tokens() {
        assert!(args("0.0.0.0:0", false).prepare(false).unwrap_err().contains("--allow-remote"));
        let remote = args("0.0.0.0:0", false).prepare(true).unwrap().unwrap();
        assert!(remote.tokens.watch().is_some() && remote.tokens.drive().is_none());
        let local = args(":0", true).prepare(false).unwrap().unwrap();
        assert!(local.tokens.watch().is_none() && local.tokens.drive().is_some());
        let loopback = "127.0.0.1:80".parse().unwrap();
        assert_eq!(authority(loopback, None), "127.0.0.1:80");
        assert_eq!(authority(loopback, Some("wall.local")), "wall.local:80");
        assert!(!authority("0.0.0.0:80".parse().unwrap(), None).starts_with("0.0.0.0"));
    }
}

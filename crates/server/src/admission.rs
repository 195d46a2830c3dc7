//! Admission control: decides which clients may connect, and counts the refused ones.
//!
//! In: the address of a client that a listener has just accepted. Out: a [`Slot`] that counts the
//! connection until it is dropped, or a [`Refusal`] with the reason. All listeners of a server
//! share one [`Admission`]; any thread may call it. Promises: the counts return to zero when all
//! slots are dropped, and the table of networks contains connected ones only.

use std::collections::HashMap;
use std::fmt;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Bits of an IPv6 address that identify its network: a host usually owns all addresses of one.
const IPV6_NETWORK_BITS: u32 = 64;

/// The unit that `connections_per_address` counts: an IPv4 address, or the /64 network of an IPv6
/// address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Network(IpAddr);

impl Network {
    /// Returns the network of `address`. An IPv4-mapped IPv6 address counts as the IPv4 address.
    pub fn of(address: IpAddr) -> Network {
        Network(match address.to_canonical() {
            IpAddr::V6(v6) => {
                let mask = u128::MAX << (128 - IPV6_NETWORK_BITS);
                IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() & mask))
            }
            v4 => v4,
        })
    }
}

impl fmt::Display for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            IpAddr::V4(address) => write!(f, "{address}"),
            IpAddr::V6(address) => write!(f, "{address}/{IPV6_NETWORK_BITS}"),
        }
    }
}

/// Reason for which a connection was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// The server has this many connections, its limit.
    Full { limit: usize },
    /// The peer's network has this many connections, its limit.
    AddressFull { network: Network, limit: usize },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Full { limit } => write!(f, "no more than {limit} connections at one time"),
            Refusal::AddressFull { network, limit } => {
                write!(f, "no more than {limit} connections at one time from {network}")
            }
        }
    }
}

/// Numbers of connections refused since the start, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RefusedConnections {
    /// Refused because the server was full.
    pub server_full: u64,
    /// Refused because the client's address had as many connections as are allowed.
    pub address_full: u64,
    /// Refused because the system had no descriptor or no thread left.
    pub no_resources: u64,
}

/// Connection counts of all listeners, and their limits.
#[derive(Debug)]
pub(crate) struct Admission {
    limit: AtomicUsize,
    limit_per_address: usize,
    open: Mutex<Open>,
    server_full: AtomicU64,
    address_full: AtomicU64,
    no_resources: AtomicU64,
}

#[derive(Debug, Default)]
struct Open {
    connections: usize,
    by_network: HashMap<Network, usize>,
}

impl Admission {
    /// Allows at most `limit` connections, and `limit_per_address` from one network.
    pub fn new(limit: usize, limit_per_address: usize) -> Arc<Admission> {
        Arc::new(Admission {
            limit: AtomicUsize::new(limit),
            limit_per_address,
            open: Mutex::default(),
            server_full: AtomicU64::new(0),
            address_full: AtomicU64::new(0),
            no_resources: AtomicU64::new(0),
        })
    }

    /// Returns the number of connections that are allowed.
    pub fn limit(&self) -> usize {
        self.limit.load(Ordering::Relaxed)
    }

    /// Sets the number of connections that are allowed; open ones stay.
    pub fn set_limit(&self, limit: usize) {
        self.limit.store(limit, Ordering::Relaxed);
    }

    /// Counts a connection that was refused for lack of a descriptor or a thread.
    pub fn note_no_resources(&self) {
        self.no_resources.fetch_add(1, Ordering::Relaxed);
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        // The counts are valid even if a thread panicked while it held the lock.
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a connection from `peer`, or refuses it. The client of a Unix socket has no address
    /// and is only subject to the limit of the server: whoever may open the file is trusted.
    pub fn admit(self: &Arc<Self>, peer: Option<IpAddr>) -> Result<Slot, Refusal> {
        let network = peer.map(Network::of);
        let limit = self.limit();
        let mut open = self.lock();
        if open.connections >= limit {
            self.server_full.fetch_add(1, Ordering::Relaxed);
            return Err(Refusal::Full { limit });
        }
        if let Some(network) = network {
            let used = open.by_network.get(&network).copied().unwrap_or(0);
            if used >= self.limit_per_address {
                self.address_full.fetch_add(1, Ordering::Relaxed);
                return Err(Refusal::AddressFull { network, limit: self.limit_per_address });
            }
            open.by_network.insert(network, used + 1);
        }
        open.connections += 1;
        Ok(Slot { admission: self.clone(), network })
    }

    /// Returns the numbers of refused connections so far.
    pub fn refused(&self) -> RefusedConnections {
        RefusedConnections {
            server_full: self.server_full.load(Ordering::Relaxed),
            address_full: self.address_full.load(Ordering::Relaxed),
            no_resources: self.no_resources.load(Ordering::Relaxed),
        }
    }

    fn release(&self, network: Option<Network>) {
        let mut open = self.lock();
        open.connections -= 1;
        if let Some(network) = network
            && let Some(used) = open.by_network.get_mut(&network)
        {
            *used -= 1;
            if *used == 0 {
                open.by_network.remove(&network);
            }
        }
    }
}

/// A place among the allowed connections, which is freed when this is dropped.
#[derive(Debug)]
pub(crate) struct Slot {
    admission: Arc<Admission>,
    network: Option<Network>,
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.admission.release(self.network);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ip(text: &str) -> Option<IpAddr> {
        Some(text.parse().unwrap())
    }

    #[test]
    fn each_network_has_its_share_and_gets_it_back() {
        let admission = Admission::new(100, 2);
        let first = admission.admit(ip("10.0.0.1")).unwrap();
        let _mapped = admission.admit(ip("::ffff:10.0.0.1")).unwrap();
        let refusal = admission.admit(ip("10.0.0.1")).unwrap_err();
        assert_eq!(refusal.to_string(), "no more than 2 connections at one time from 10.0.0.1");
        let _other = admission.admit(ip("10.0.0.2")).unwrap();
        drop(first);
        let _again = admission.admit(ip("10.0.0.1")).unwrap();
        assert_eq!(
            admission.refused(),
            RefusedConnections { address_full: 1, ..RefusedConnections::default() }
        );
    }

    #[test]
    fn an_ipv6_host_cannot_dodge_its_share_inside_its_network() {
        let admission = Admission::new(100, 1);
        let _one = admission.admit(ip("2001:db8::1")).unwrap();
        let refusal = admission.admit(ip("2001:db8::2:1")).unwrap_err();
        assert!(refusal.to_string().ends_with(" from 2001:db8::/64"), "{refusal}");
        let _other = admission.admit(ip("2001:db8:0:1::1")).unwrap();
    }

    #[test]
    fn peers_without_an_address_count_for_the_server_alone() {
        let admission = Admission::new(3, 1);
        let slots: Vec<Slot> = (0..3).map(|_| admission.admit(None).unwrap()).collect();
        assert_eq!(admission.admit(None).unwrap_err(), Refusal::Full { limit: 3 });
        assert_eq!(admission.admit(ip("10.0.0.1")).unwrap_err(), Refusal::Full { limit: 3 });
        assert_eq!(
            admission.refused(),
            RefusedConnections { server_full: 2, ..RefusedConnections::default() }
        );
        drop(slots);
        let counts = |open: &Open| (open.connections, open.by_network.len());
        assert_eq!(counts(&admission.lock()), (0, 0));
        admission.set_limit(1);
        let slot = admission.admit(ip("10.0.0.1")).unwrap();
        assert_eq!(admission.admit(None).unwrap_err(), Refusal::Full { limit: 1 });
        assert_eq!(admission.lock().by_network.len(), 1);
        drop(slot);
        assert!(admission.lock().by_network.is_empty(), "networks without connections are forgotten");
    }
}

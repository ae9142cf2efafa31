//! Which requests are those of the page that this server serves.
//!
//! A name of another site may be made to lead to this address (DNS rebinding); the browser then sends that name as `Host`. A page of
//! another site may open a WebSocket here; the browser then sends that site as `Origin`.

use std::net::SocketAddr;

/// The names that lead to a server on a loopback address.
#[derive(Clone, Debug)]
pub struct OwnNames(Vec<String>);

/// Why a request is refused.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestRefusal {
    /// `Host` is missing, is there twice, or names something else.
    #[error("refused: Host does not name this console; open it by the address that `linewright console` has printed")]
    Host,
    /// `Origin` is another page.
    #[error("refused: the request comes from a page of another site")]
    Origin,
    /// `Origin` is missing where it has to be sent.
    #[error("refused: a feed is opened by the console's page, with its Origin")]
    NoOrigin,
}

impl OwnNames {
    /// Those of a server that listens here.
    pub fn of(address: SocketAddr) -> Self {
        let port = address.port();
        let mut names: Vec<String> = ["127.0.0.1", "localhost", "[::1]"].map(|host| format!("{host}:{port}")).into();
        names.push(address.to_string());
        // Browsers leave out the port of HTTP.
        let without: Vec<String> =
            names.iter().filter_map(|name| name.strip_suffix(":80")).map(str::to_owned).collect();
        names.extend(without);
        OwnNames(names)
    }

    /// Checks a request by all its `Host` and `Origin` headers.
    ///
    /// # Errors
    /// When it is none of the page of this server.
    pub fn check(&self, hosts: &[&[u8]], origins: &[&[u8]], needs_origin: bool) -> Result<(), RequestRefusal> {
        let [host] = hosts else { return Err(RequestRefusal::Host) };
        if !self.0.iter().any(|own| own.as_bytes().eq_ignore_ascii_case(host)) {
            return Err(RequestRefusal::Host);
        }
        match origins {
            [] if needs_origin => Err(RequestRefusal::NoOrigin),
            [] => Ok(()),
            [origin] => {
                let of = origin.strip_prefix(b"http://").filter(|of| of.eq_ignore_ascii_case(host));
                of.map(drop).ok_or(RequestRefusal::Origin)
            }
            _ => Err(RequestRefusal::Origin),
        }
    }
}

//! Access to the page: a one-time token, then a cookie of the session.
//!
//! The page lies under a folder with a random name, and the cookie is sent for that folder alone. Browsers send cookies to every
//! port of a host: without the folder, another server on this machine could receive it.

use hyper::header::{COOKIE, HOST, HeaderMap, ORIGIN};
use shatter_proto::{Error, ErrorKind};
use std::fs::File;
use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};

/// Random bytes of a secret.
const SECRET_BYTES: usize = 16;

/// Name of the cookie.
const COOKIE_NAME: &str = "shatter-view";

/// Secrets of one run of the server.
pub(crate) struct Access {
    token: String,
    cookie: String,
    folder: String,
    hosts: [String; 2],
    is_used: AtomicBool,
}

impl Access {
    /// Draws the secrets for a server on `port`.
    ///
    /// # Errors
    /// `failed` if the system has no random numbers.
    pub fn new(port: u16) -> Result<Self, Error> {
        Ok(Self {
            token: secret()?,
            cookie: secret()?,
            folder: secret()?,
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            is_used: AtomicBool::new(false),
        })
    }

    /// Address of the page, with the token.
    pub fn address(&self) -> String {
        format!("http://{}/?token={}", self.hosts[0], self.token)
    }

    /// Path of the folder of the page, with a slash at its end.
    pub fn folder(&self) -> String {
        format!("/{}/", self.folder)
    }

    /// Whether `given` is the token, which only counts once.
    pub fn redeem(&self, given: &str) -> bool {
        is_equal(given, &self.token) && !self.is_used.swap(true, Ordering::Relaxed)
    }

    /// Header that sets the cookie.
    pub fn set_cookie(&self) -> String {
        format!("{COOKIE_NAME}={}; Path={}; HttpOnly; SameSite=Strict", self.cookie, self.folder())
    }

    /// Whether the request has the cookie.
    pub fn has_cookie(&self, headers: &HeaderMap) -> bool {
        let lines = headers.get_all(COOKIE).into_iter().filter_map(|value| value.to_str().ok());
        let pairs = lines.flat_map(|line| line.split(';')).filter_map(|pair| pair.trim().split_once('='));
        pairs.into_iter().any(|(name, value)| name == COOKIE_NAME && is_equal(value, &self.cookie))
    }

    /// Whether the request names this server as its host: a name that an attacker points at 127.0.0.1 does not.
    pub fn is_host(&self, headers: &HeaderMap) -> bool {
        let mut given = headers.get_all(HOST).iter();
        let first = given.next().and_then(|value| value.to_str().ok());
        given.next().is_none() && first.is_some_and(|host| self.hosts.iter().any(|own| own == host))
    }

    /// Whether the request comes from the page. Browsers leave the origin out of plain requests for pages; for a WebSocket they
    /// always send it.
    pub fn is_origin(&self, headers: &HeaderMap, is_required: bool) -> bool {
        let mut given = headers.get_all(ORIGIN).iter();
        let Some(first) = given.next() else { return !is_required };
        let host = first.to_str().ok().and_then(|origin| origin.strip_prefix("http://"));
        given.next().is_none() && host.is_some_and(|host| self.hosts.iter().any(|own| own == host))
    }
}

/// Compares secrets in a time that does not depend on where they differ.
fn is_equal(given: &str, own: &str) -> bool {
    given.len() == own.len() && given.bytes().zip(own.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

fn secret() -> Result<String, Error> {
    let mut bytes = [0; SECRET_BYTES];
    let read = File::open("/dev/urandom").and_then(|mut source| source.read_exact(&mut bytes));
    read.map_err(|error| {
        Error::new(ErrorKind::Failed, "/dev/urandom", format!("cannot read random numbers from /dev/urandom: {error}"))
    })?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hyper::header::HeaderValue;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let mut map = HeaderMap::new();
        for (name, value) in pairs {
            map.append(*name, HeaderValue::from_str(value).unwrap());
        }
        map
    }

    #[test]
    fn the_token_counts_once() {
        let access = Access::new(4000).unwrap();
        let token = access.token.clone();
        assert!(!access.redeem("") && !access.redeem(&token[1..]));
        assert!(access.redeem(&token) && !access.redeem(&token));
        assert_ne!(access.token, access.cookie);
        assert_ne!(access.cookie, Access::new(4000).unwrap().cookie);
    }

    #[test]
    fn only_the_own_host_and_origin_are_accepted() {
        let access = Access::new(4000).unwrap();
        for host in ["127.0.0.1:4000", "localhost:4000"] {
            assert!(access.is_host(&headers(&[("host", host)])), "{host}");
            assert!(access.is_origin(&headers(&[("origin", &format!("http://{host}"))]), true), "{host}");
        }
        for host in ["127.0.0.1", "127.0.0.1:4001", "evil.example:4000", "localhost:4000.evil.example"] {
            assert!(!access.is_host(&headers(&[("host", host)])), "{host}");
            assert!(!access.is_origin(&headers(&[("origin", &format!("http://{host}"))]), false), "{host}");
        }
        assert!(!access.is_host(&headers(&[])));
        assert!(!access.is_host(&headers(&[("host", "127.0.0.1:4000"), ("host", "evil.example")])));
        assert!(access.is_origin(&headers(&[]), false) && !access.is_origin(&headers(&[]), true));
        assert!(!access.is_origin(&headers(&[("origin", "https://127.0.0.1:4000")]), false));
        assert!(!access.is_origin(&headers(&[("origin", "null")]), false));
    }

    #[test]
    fn the_cookie_is_found_among_others() {
        let access = Access::new(4000).unwrap();
        let own = format!("a=b; shatter-view={}", access.cookie);
        assert!(access.has_cookie(&headers(&[("cookie", &own)])));
        assert!(!access.has_cookie(&headers(&[("cookie", "shatter-view=0")])) && !access.has_cookie(&headers(&[])));
        let set = access.set_cookie();
        assert!(set.contains("HttpOnly") && set.contains("SameSite=Strict") && set.contains(&access.folder()), "{set}");
    }
}

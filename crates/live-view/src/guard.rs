//! Who is let in. The server listens on loopback, and still any page that the user has open could reach it: by a
//! request across sites, or by a name that is made to point here (DNS rebinding). Both are refused by their headers.
//! Commands need the token of the printed address besides.

use axum::http::{HeaderMap, header};
use serde::Serialize;
use std::net::IpAddr;

/// The secret of one server, in hexadecimal digits.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// A new one of 128 bits.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn new() -> Result<Self, getrandom::Error> {
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Its digits.
    pub fn digits(&self) -> &str {
        &self.0
    }

    /// Whether a text is the token; takes the same time wherever they differ.
    pub fn is(&self, text: &str) -> bool {
        let (own, other) = (self.0.as_bytes(), text.as_bytes());
        own.len() == other.len() && own.iter().zip(other).fold(0, |differing, (a, b)| differing | (a ^ b)) == 0
    }
}

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(secret)")
    }
}

/// How many requests were refused, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Refused {
    /// The name of the host is none of this server.
    pub host: u64,
    /// Asked by a page of another origin.
    pub origin: u64,
    /// A word without the token, or with another.
    pub token: u64,
    /// Too many pages at once.
    pub full: u64,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The name of the host is none of this server.
    Host,
    /// Asked by a page of another origin.
    Origin,
}

/// Whether a request may be answered. `Host` must be an address in numbers, or `localhost`, with the server's own port:
/// a name that is made to point here is neither. `Origin`, where there is one, must be that host.
///
/// # Errors
/// Which of the two is wrong.
pub fn admit(headers: &HeaderMap, port: u16) -> Result<(), Refusal> {
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or(""));
    let mut hosts = headers.get_all(header::HOST).iter();
    let host = hosts.next().and_then(|host| host.to_str().ok()).filter(|host| is_own(host, port));
    let Some(host) = host.filter(|_| hosts.next().is_none()) else { return Err(Refusal::Host) };
    match text(header::ORIGIN) {
        Some(origin) if !origin.strip_prefix("http://").is_some_and(|origin| origin.eq_ignore_ascii_case(host)) => {
            Err(Refusal::Origin)
        }
        _ => Ok(()),
    }
}

fn is_own(host: &str, port: u16) -> bool {
    let (name, own_port) = match host.rsplit_once(':') {
        Some((name, digits)) if !digits.ends_with(']') => (name, digits.parse() == Ok(port)),
        _ => (host, port == 80),
    };
    let number = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    own_port && (name.eq_ignore_ascii_case("localhost") || number.parse::<IpAddr>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(host: &str, origin: Option<&str>) -> Result<(), Refusal> {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        admit(&headers, 8123)
    }

    #[test]
    fn only_own_names_and_own_pages() {
        for host in ["127.0.0.1:8123", "localhost:8123", "[::1]:8123", "192.168.1.5:8123"] {
            assert_eq!(asked(host, None), Ok(()));
            assert_eq!(asked(host, Some(&format!("http://{host}"))), Ok(()));
            for foreign in ["http://evil.example", "null", "http://127.0.0.1:8124", "https://127.0.0.1:8123", ""] {
                assert_eq!(asked(host, Some(foreign)), Err(Refusal::Origin), "{foreign}");
            }
        }
        for host in ["evil.example:8123", "localhost.evil.example:8123", "127.0.0.1", "127.0.0.1:80", "", ":8123"] {
            assert_eq!(asked(host, Some(&format!("http://{host}"))), Err(Refusal::Host), "{host}");
        }
        assert_eq!(admit(&HeaderMap::new(), 8123), Err(Refusal::Host));
    }

    #[test]
    fn a_token_is_itself_and_nothing_else() {
        let token = Token::new().unwrap();
        assert_eq!(token.digits().len(), 32);
        assert!(token.is(token.digits()) && !token.is("") && !token.is(&token.digits()[1..]));
        assert!(!token.is(Token::new().unwrap().digits()));
        assert!(!format!("{token:?}").contains(token.digits()));
    }
}

//! Connection strings: one text that says how to reach autopilots, in the spellings that users know from other tools.

use std::fmt;
use std::str::FromStr;

/// Baud rate of a serial link that names none: what telemetry radios are set to when they are new.
pub const DEFAULT_BAUD: u32 = 57_600;

/// How autopilots are reached.
///
/// ```
/// use mavlink_bridge::link::Connection;
///
/// let connection: Connection = "tcp://127.0.0.1:5760".parse()?;
/// assert_eq!(connection.to_string(), "tcp:127.0.0.1:5760");
/// # Ok::<(), mavlink_bridge::link::ConnectionError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Connection {
    /// UDP: waits at an address for whoever speaks first (`udpin:`, `udp:`, or an address alone).
    UdpIn(HostPort),
    /// UDP: speaks first to an address (`udpout:`).
    UdpOut(HostPort),
    /// TCP: connects to an address (`tcp:`, `tcpout:`).
    TcpOut(HostPort),
    /// TCP: waits at an address for connections (`tcpin:`).
    TcpIn(HostPort),
    /// A serial port (`serial:PORT:BAUD`, `/dev/ttyUSB0,57600`).
    Serial {
        /// The device, as the system names it.
        device: String,
        /// Bits per second.
        baud: u32,
    },
}

/// A host, by name or by number, and a port.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct HostPort {
    /// A name, an IPv4 address, or an IPv6 address without brackets.
    pub host: String,
    /// The port.
    pub port: u16,
}

/// What is wrong with a connection string. Its text shows the right spelling.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConnectionError {
    /// It is empty.
    #[error("a link must be named, for example udpin:127.0.0.1:14550, tcp:127.0.0.1:5760 or /dev/ttyUSB0,57600")]
    Empty,
    /// There is no such kind of link.
    #[error("{given}: there is no link of kind \"{kind}\": must be {suggestion}")]
    UnknownKind {
        /// The whole text.
        given: String,
        /// The part before the first colon.
        kind: String,
        /// The nearest right spelling.
        suggestion: String,
    },
    /// The port is missing or is no port.
    #[error("{given}: must name a port from 1 to 65535, for example {example}")]
    Port {
        /// The whole text.
        given: String,
        /// A right spelling.
        example: String,
    },
    /// The host is missing where there must be one.
    #[error("{given}: must name the host to speak to, for example {example}")]
    Host {
        /// The whole text.
        given: String,
        /// A right spelling.
        example: String,
    },
    /// The baud rate is no number, or out of range.
    #[error("{given}: must name a baud rate from 300 to 12000000, for example {example}")]
    Baud {
        /// The whole text.
        given: String,
        /// A right spelling.
        example: String,
    },
    /// The serial device is missing.
    #[error("{given}: must name a serial port, for example serial:/dev/ttyUSB0:57600")]
    Device {
        /// The whole text.
        given: String,
    },
}

/// The kinds of links and what stands behind each.
const KINDS: [(&str, &str); 7] = [
    ("udpin", "127.0.0.1:14550"),
    ("udpout", "127.0.0.1:14550"),
    ("udp", "127.0.0.1:14550"),
    ("tcp", "127.0.0.1:5760"),
    ("tcpin", "127.0.0.1:5760"),
    ("tcpout", "127.0.0.1:5760"),
    ("serial", "/dev/ttyUSB0:57600"),
];

impl FromStr for Connection {
    type Err = ConnectionError;

    fn from_str(text: &str) -> Result<Self, ConnectionError> {
        let text = text.trim();
        if text.is_empty() {
            return Err(ConnectionError::Empty);
        }
        if is_device(text) {
            return serial(text, text);
        }
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let kind = kind.to_ascii_lowercase();
        let rest = rest.strip_prefix("//").unwrap_or(rest);
        match kind.as_str() {
            "udpin" | "udp" => Ok(Self::UdpIn(address(text, &kind, rest, Some("0.0.0.0"))?)),
            "udpout" => Ok(Self::UdpOut(address(text, &kind, rest, None)?)),
            "tcp" | "tcpout" => Ok(Self::TcpOut(address(text, &kind, rest, None)?)),
            "tcpin" => Ok(Self::TcpIn(address(text, &kind, rest, Some("0.0.0.0"))?)),
            "serial" => serial(text, rest),
            // An address alone: as pymavlink takes it.
            _ if is_address(text) => Ok(Self::UdpIn(address(text, "udpin", text, None)?)),
            _ => Err(unknown_kind(text, &kind, rest)),
        }
    }
}

impl fmt::Display for Connection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpIn(address) => write!(f, "udpin:{address}"),
            Self::UdpOut(address) => write!(f, "udpout:{address}"),
            Self::TcpOut(address) => write!(f, "tcp:{address}"),
            Self::TcpIn(address) => write!(f, "tcpin:{address}"),
            Self::Serial { device, baud } => write!(f, "serial:{device}:{baud}"),
        }
    }
}

impl fmt::Display for HostPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

impl Connection {
    /// Whether everything that passes stays on this machine: a loopback address.
    pub fn is_loopback(&self) -> bool {
        match self {
            Self::UdpIn(address) | Self::UdpOut(address) | Self::TcpOut(address) | Self::TcpIn(address) => {
                address.host == "localhost"
                    || address.host.parse().is_ok_and(|host: std::net::IpAddr| host.is_loopback())
            }
            Self::Serial { .. } => false,
        }
    }

    /// Bytes per second that the link carries, where that is a limit: a serial line sends ten bits for a byte.
    pub fn capacity_bytes_per_s(&self) -> Option<f64> {
        match self {
            Self::Serial { baud, .. } => Some(f64::from(*baud) / 10.0),
            _ => None,
        }
    }
}

/// `/dev/ttyUSB0`, `COM3`.
fn is_device(text: &str) -> bool {
    let is_com = text.get(..3).is_some_and(|start| start.eq_ignore_ascii_case("com"))
        && text[3..].starts_with(|c: char| c.is_ascii_digit());
    text.starts_with('/') || is_com
}

/// Whether a text without a kind is `HOST:PORT`.
fn is_address(text: &str) -> bool {
    match text.rsplit_once(':') {
        Some((host, port)) => {
            !host.is_empty() && port.parse::<u16>().is_ok() && (!host.contains(':') || host.starts_with('['))
        }
        None => false,
    }
}

fn address(given: &str, kind: &str, rest: &str, any_host: Option<&str>) -> Result<HostPort, ConnectionError> {
    let rest = rest.trim_end_matches('/');
    let example = |host: &str| {
        let host = if host.is_empty() { "127.0.0.1" } else { host };
        let port = if kind.starts_with("tcp") { 5760 } else { 14550 };
        format!("{kind}:{host}:{port}")
    };
    let (host, port) = match rest.rsplit_once(':') {
        // `udpin::14550` and `udp://:14540`.
        Some((host, port)) => (host, port),
        None => {
            let host = if rest.bytes().all(|byte| byte.is_ascii_digit()) { "" } else { rest };
            return Err(ConnectionError::Port { given: given.to_owned(), example: example(host) });
        }
    };
    let host = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
    let port = port.parse().ok().filter(|&port: &u16| port > 0);
    let port = port.ok_or_else(|| ConnectionError::Port { given: given.to_owned(), example: example(host) })?;
    let host = match (host, any_host) {
        ("", Some(any_host)) => any_host,
        ("", None) => {
            return Err(ConnectionError::Host { given: given.to_owned(), example: format!("{kind}:127.0.0.1:{port}") });
        }
        (host, _) => host,
    };
    Ok(HostPort { host: host.to_owned(), port })
}

/// `DEVICE`, `DEVICE,BAUD` or `DEVICE:BAUD`.
fn serial(given: &str, rest: &str) -> Result<Connection, ConnectionError> {
    let (device, baud) = match rest.rsplit_once([',', ':']) {
        Some((device, baud)) => (device, Some(baud)),
        None => (rest, None),
    };
    if device.is_empty() {
        return Err(ConnectionError::Device { given: given.to_owned() });
    }
    let baud = match baud {
        None => DEFAULT_BAUD,
        Some(baud) => baud.trim().parse().ok().filter(|baud| (300..=12_000_000).contains(baud)).ok_or_else(|| {
            ConnectionError::Baud { given: given.to_owned(), example: format!("serial:{device}:{DEFAULT_BAUD}") }
        })?,
    };
    Ok(Connection::Serial { device: device.to_owned(), baud })
}

fn unknown_kind(given: &str, kind: &str, rest: &str) -> ConnectionError {
    let distance = |known: &str| strsim::damerau_levenshtein(known, kind);
    let nearest = KINDS.iter().min_by_key(|(known, _)| distance(known));
    let suggestion = match nearest {
        Some((known, example)) if distance(known) <= 2 => {
            let behind = if rest.is_empty() { example } else { rest };
            format!("{known}:{behind}")
        }
        _ => "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or serial:PORT:BAUD".to_owned(),
    };
    ConnectionError::UnknownKind { given: given.to_owned(), kind: kind.to_owned(), suggestion }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spelled(text: &str) -> String {
        text.parse::<Connection>().map_or_else(|error| format!("error: {error}"), |connection| connection.to_string())
    }

    #[test]
    fn the_spellings_of_other_tools_are_read() {
        for (text, meaning) in [
            // pymavlink, MAVProxy, DroneKit
            ("udpin:127.0.0.1:14550", "udpin:127.0.0.1:14550"),
            ("udpout:127.0.0.1:14550", "udpout:127.0.0.1:14550"),
            ("udp:127.0.0.1:14550", "udpin:127.0.0.1:14550"),
            ("127.0.0.1:14550", "udpin:127.0.0.1:14550"),
            ("tcp:localhost:5760", "tcp:localhost:5760"),
            ("tcpin:0.0.0.0:5760", "tcpin:0.0.0.0:5760"),
            ("/dev/ttyACM0", "serial:/dev/ttyACM0:57600"),
            ("/dev/ttyUSB0,115200", "serial:/dev/ttyUSB0:115200"),
            ("COM3,57600", "serial:COM3:57600"),
            // rust-mavlink
            ("tcpout:127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("serial:/dev/ttyUSB0:57600", "serial:/dev/ttyUSB0:57600"),
            // MAVSDK
            ("udpin://0.0.0.0:14540", "udpin:0.0.0.0:14540"),
            ("udp://:14540", "udpin:0.0.0.0:14540"),
            ("tcpout://127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("serial:///dev/ttyUSB0:57600", "serial:/dev/ttyUSB0:57600"),
            // mavlink-router
            ("/dev/ttyS1:921600", "serial:/dev/ttyS1:921600"),
            ("UDPIN:127.0.0.1:14550", "udpin:127.0.0.1:14550"),
            ("udpin:[::1]:14550", "udpin:[::1]:14550"),
        ] {
            assert_eq!(spelled(text), meaning, "{text}");
        }
    }

    #[test]
    fn a_wrong_spelling_is_told_with_the_right_one() {
        for (text, right) in [
            ("", "udpin:127.0.0.1:14550"),
            ("udpn:127.0.0.1:14550", "must be udpin:127.0.0.1:14550"),
            ("tpc:10.0.0.1:5760", "must be tcp:10.0.0.1:5760"),
            ("bluetooth:thing", "udpin:HOST:PORT"),
            ("udpin:14550", "for example udpin:127.0.0.1:14550"),
            ("udpin:127.0.0.1", "for example udpin:127.0.0.1:14550"),
            ("udpin:127.0.0.1:99999", "port from 1 to 65535"),
            ("udpin:127.0.0.1:0", "port from 1 to 65535"),
            ("udpout::14550", "for example udpout:127.0.0.1:14550"),
            ("tcp:127.0.0.1:", "for example tcp:127.0.0.1:5760"),
            ("serial:", "serial:/dev/ttyUSB0:57600"),
            ("/dev/ttyUSB0,fast", "serial:/dev/ttyUSB0:57600"),
            ("14550", "udpin:HOST:PORT"),
        ] {
            let told = spelled(text);
            assert!(told.starts_with("error: ") && told.contains(right), "{text}: {told}");
        }
    }

    #[test]
    fn loopback_is_known() {
        assert!("udpin:127.0.0.1:14550".parse::<Connection>().unwrap().is_loopback());
        assert!("tcp:[::1]:5760".parse::<Connection>().unwrap().is_loopback());
        assert!(!"udpin:0.0.0.0:14550".parse::<Connection>().unwrap().is_loopback());
        assert!(!"/dev/ttyUSB0".parse::<Connection>().unwrap().is_loopback());
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in ".{0,40}") {
            let _ = text.parse::<Connection>();
        }

        #[test]
        fn what_is_shown_is_read_again(host in "[a-z][a-z0-9.]{0,12}", port in 1..=u16::MAX, kind in 0..4usize) {
            let text = format!("{}:{host}:{port}", ["udpin", "udpout", "tcp", "tcpin"][kind]);
            let connection: Connection = text.parse().unwrap();
            prop_assert_eq!(connection.to_string(), text);
        }
    }
}

//! The page's server from outside, by a client of a few lines that need not behave.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use live_view::choice::{Choice, Member};
use live_view::{Answer, Event, Frame, LiveView, Scene, Settings, VehicleNow, Weight};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(30);

fn view() -> LiveView {
    LiveView::start(&Settings::default()).unwrap()
}

fn port(view: &LiveView) -> u16 {
    view.url_to_watch().trim_end_matches('/').rsplit(':').next().unwrap().parse().unwrap()
}

fn token(view: &LiveView) -> String {
    view.url().split('#').nth(1).unwrap().to_owned()
}

fn flock(vehicles: usize) -> impl Fn(&mut Frame) {
    move |frame| {
        frame.time_s += 0.1;
        let one = |index: usize| VehicleNow {
            number: index as u32 + 1,
            x_m: 10.0 * index as f32,
            y_m: 0.0,
            ..VehicleNow::default()
        };
        frame.vehicles = (0..vehicles).map(one).collect();
    }
}

/// A browser without a screen.
struct Client {
    stream: TcpStream,
}

impl Client {
    /// Asks for a path with these lines in the head; gives the status and the connection.
    fn ask(port: u16, path: &str, lines: &str) -> (u16, Self) {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\n{lines}\r\n").unwrap();
        let mut head = Vec::new();
        let mut byte = [0];
        while !head.ends_with(b"\r\n\r\n") && stream.read(&mut byte).is_ok_and(|read| read > 0) {
            head.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        let status = head.split_whitespace().nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, Self { stream })
    }

    fn upgrade(port: u16, host: &str, origin: Option<&str>) -> (u16, Self) {
        let origin = origin.map_or(String::new(), |origin| format!("Origin: {origin}\r\n"));
        let lines = format!(
            "Host: {host}\r\n{origin}Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        );
        Self::ask(port, "/live", &lines)
    }

    fn open(view: &LiveView) -> Self {
        let port = port(view);
        let host = format!("127.0.0.1:{port}");
        let (status, client) = Self::upgrade(port, &host, Some(&format!("http://{host}")));
        assert_eq!(status, 101);
        client
    }

    /// The next message; none when the server has hung up.
    fn next(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut take = |count: usize| {
            let mut bytes = vec![0; count];
            self.stream.read_exact(&mut bytes).ok().map(|()| bytes)
        };
        let head = take(2)?;
        let length = match head[1] {
            126 => take(2)?.iter().fold(0, |all, byte| all << 8 | usize::from(*byte)),
            127 => take(8)?.iter().fold(0, |all, byte| all << 8 | usize::from(*byte)),
            short => usize::from(short),
        };
        Some((head[0] & 15, take(length)?))
    }

    /// The next text that has a word in it.
    fn text_with(&mut self, word: &str) -> String {
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            let (kind, bytes) = self.next().expect("the server has hung up");
            let text = String::from_utf8_lossy(&bytes).into_owned();
            if kind == 1 && text.contains(word) {
                return text;
            }
        }
        panic!("no text with {word}");
    }

    fn frame(&mut self) -> Vec<u8> {
        loop {
            let (kind, bytes) = self.next().expect("the server has hung up");
            if kind == 2 {
                return bytes;
            }
        }
    }

    fn say(&mut self, text: &str) {
        let mut frame = vec![0x81];
        match text.len() {
            short @ 0..126 => frame.push(0x80 | short as u8),
            long => {
                frame.push(0x80 | 126);
                frame.extend_from_slice(&(long as u16).to_be_bytes());
            }
        }
        frame.extend_from_slice(&[0; 4]);
        frame.extend_from_slice(text.as_bytes());
        let _ = self.stream.write_all(&frame);
    }
}

#[test]
fn a_page_gets_the_scene_the_roster_the_past_and_the_present() {
    let view = view();
    let feed = view.feed();
    feed.scene(Scene { title: "five".into(), ..Scene::default() });
    feed.tell(Event { text: "the flock flies".into(), weight: Weight::Note, ..Event::default() });
    while !feed.update(flock(5)) {}
    let mut client = Client::open(&view);
    // The server may have looked before the feed was told: then what was there before comes first.
    let mut missing = vec!["\"title\":\"five\"", "\"numbers\":[1,2,3,4,5]", "the flock flies", "five in a frame"];
    while !missing.is_empty() {
        let (kind, bytes) = client.next().expect("the server has hung up");
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let is_of_five = kind == 2 && bytes[0] == 1 && bytes[4..8] == 5_u32.to_le_bytes();
        missing.retain(|wanted| if *wanted == "five in a frame" { !is_of_five } else { !text.contains(wanted) });
    }
    drop(view);
    assert_eq!(client.text_with("over"), "{\"over\":true}");
}

#[test]
fn other_origins_and_forged_hosts_are_refused_and_counted() {
    let view = view();
    let port = port(&view);
    let own = format!("127.0.0.1:{port}");
    assert_eq!(Client::upgrade(port, &own, Some("http://evil.example")).0, 403);
    assert_eq!(Client::upgrade(port, "evil.example", Some("http://evil.example")).0, 403);
    assert_eq!(Client::ask(port, "/", &format!("Host: evil.example:{port}\r\n")).0, 403);
    assert_eq!(Client::ask(port, "/live.js", &format!("Host: {own}\r\nOrigin: null\r\n")).0, 403);
    assert_eq!(Client::ask(port, "/", &format!("Host: localhost:{port}\r\n")).0, 200);
    assert_eq!(Client::ask(port, "/../Cargo.toml", &format!("Host: {own}\r\n")).0, 404);
    let refused = view.refused();
    assert_eq!((refused.origin, refused.host), (2, 2));
}

#[test]
fn words_need_the_token_and_are_answered() {
    let mut view = view();
    let mut words = view.take_words().unwrap();
    let mut client = Client::open(&view);
    client.say("{\"token\": \"0123\", \"say\": \"abort\", \"id\": 1}");
    assert!(client.text_with("\"id\":1").contains("refused"));
    client.say("abort");
    client.text_with("not understood");
    assert!(words.try_recv().is_err(), "nothing has come through");
    assert_eq!(view.refused().token, 1);
    let token = token(&view);
    client.say(&format!("{{\"token\": \"{token}\"}}"));
    client.text_with("\"may\":true");
    client.say(&format!("{{\"token\": \"{token}\", \"say\": \"drop 3\", \"id\": 2}}"));
    let said = words.blocking_recv().unwrap();
    assert_eq!(said.text, "drop 3");
    assert!(said.from.ip().is_loopback());
    said.answer.send(Answer { is_done: true, text: "dropped".into() }).unwrap();
    assert!(client.text_with("\"id\":2").contains("dropped"));
    client.say(&"x".repeat(5000));
    while client.next().is_some() {}
}

#[test]
fn a_page_that_does_not_read_costs_nobody_anything() {
    let view = view();
    let feed = view.feed();
    while !feed.update(flock(10_000)) {}
    let mut reads = Client::open(&view);
    let _stuck = Client::open(&view);
    // Frames of 200 kB fill what the system buffers for a page; the other page gets its frames all the same, and the
    // flight is never waited for.
    let mut times = Vec::new();
    for _ in 0..30 {
        feed.update(|frame| frame.time_s += 0.1);
        let frame = reads.frame();
        times.push(f64::from_le_bytes(frame[8..16].try_into().unwrap()));
    }
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]), "frames come in order");
    assert!(times.last().unwrap() > &1.0, "and they are of the present");
    assert_eq!(view.pages(), 2);
}

#[test]
fn a_page_is_told_the_choices_of_the_vehicle_that_it_looks_at_and_needs_no_token_for_that() {
    let view = view();
    let feed = view.feed();
    let choice = |vehicle, at_s| Choice { vehicle, at_s, members: vec![Member::default()], ..Choice::default() };
    feed.choose(choice(2, 0.5));
    feed.choose(choice(7, 0.5));
    let mut client = Client::open(&view);
    assert!(feed.watched().is_empty());
    client.say("{\"look\": 7}");
    let told = client.text_with("choices");
    assert!(told.starts_with("{\"choices\":[{\"vehicle\":7,\"at_s\":0.5") && !told.contains("\"vehicle\":2"), "{told}");
    while feed.watched() != [7] {
        client.frame();
    }
    feed.choose(choice(7, 1.0));
    assert!(client.text_with("choices").starts_with("{\"choices\":[{\"vehicle\":7,\"at_s\":1.0"));
    // Words without a token are refused, whatever else they say.
    client.say("{\"say\": \"abort\", \"look\": 7, \"id\": 3}");
    assert!(client.text_with("\"id\":3").contains("refused"));
    drop(client);
    let deadline = Instant::now() + PATIENCE;
    while !feed.watched().is_empty() {
        assert!(Instant::now() < deadline, "a page that is gone looks at nothing");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn pages_and_connections_are_bounded_and_those_that_are_open_go_on() {
    let view = view();
    let port = port(&view);
    let host = format!("127.0.0.1:{port}");
    let mut first = Client::open(&view);
    let others: Vec<Client> = (1..32).map(|_| Client::open(&view)).collect();
    assert_eq!(Client::upgrade(port, &host, None).0, 503, "one too many");
    assert_eq!((view.pages(), view.refused().full), (32, 1));
    // Connections that ask nothing, or only half of something.
    let mut idle: Vec<TcpStream> = (0..300).map(|_| TcpStream::connect(("127.0.0.1", port)).unwrap()).collect();
    idle.iter_mut().for_each(|stream| stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap());
    for _ in 0..5 {
        first.frame();
    }
    drop((others, idle));
    // There is room again once they are gone.
    let deadline = Instant::now() + PATIENCE;
    while Client::upgrade(port, &host, None).0 != 101 {
        assert!(Instant::now() < deadline, "a place is free again");
    }
}

#[test]
fn what_is_no_word_ends_nothing_but_its_own_connection() {
    let view = view();
    let mut client = Client::open(&view);
    for wrong in ["", "null", "[]", "{\"look\": -1}", "{\"look\": \"7\"}", "{\"token\": 5}", "{\"look\": 1e99}"] {
        client.say(wrong);
        client.text_with("not understood");
    }
    // A frame that is not masked, one of a reserved kind, one that says it is as long as all memory.
    for hostile in [&[0x81, 0x02, b'{', b'}'][..], &[0x8B, 0x80, 0, 0, 0, 0], &[0x81, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF]] {
        let mut other = Client::open(&view);
        other.stream.write_all(hostile).unwrap();
        other.stream.write_all(&[0xFF; 16]).unwrap();
        while other.next().is_some() {}
    }
    client.frame();
}

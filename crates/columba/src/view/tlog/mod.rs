//! `columba view FILE.tlog`: telemetry logs, ours and other people's, as recordings for the page.

mod clock;
mod log;
mod play;

pub use log::{Log, NotALog};
pub use play::play;

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::{Geodetic, LocalFrame, State};
    use live_view::{Scene, Tape};
    use mavlink_bridge::dialect::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType, Message};
    use mavlink_bridge::telemetry::global_position_int;
    use mavlink_bridge::{Encoder, Frame, TlogWriter};
    use std::time::Duration;

    fn heartbeat(custom_mode: u32) -> Message {
        Message::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode,
            mavtype: MavType::MAV_TYPE_FIXED_WING,
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        })
    }

    /// Vehicles 3 and 9, of which 9 leaves GUIDED (15) for RTL (11) after four seconds.
    fn log_of_two() -> Vec<u8> {
        log_from(0.0)
    }

    /// The same, so many metres north of there.
    fn log_from(north_m: f64) -> Vec<u8> {
        let origin = Geodetic { latitude_deg: 40.0, longitude_deg: 116.0, altitude_amsl_m: 30.0 };
        let frame = LocalFrame::new(origin);
        let mut log = TlogWriter::new(Vec::new());
        for tick in 0_u32..100 {
            let at_us = 1_700_000_000_000_000 + 100_000 * u64::from(tick);
            for (system, y_m) in [(3, 0.0), (9, 8.0)] {
                let mode = if system == 9 && tick > 40 { 11 } else { 15 };
                let x_m = north_m + f64::from(tick);
                let state = State { x_m, y_m, altitude_m: 50.0, speed_mps: 10.0, ..State::default() };
                let position =
                    global_position_int(Duration::from_millis(100 * u64::from(tick)), &state, 0.0, &frame, 0.0);
                for message in [heartbeat(mode), position] {
                    let mut bytes = Vec::new();
                    Encoder::new(system, 1).encode(&message, &mut bytes);
                    log.write(at_us, &bytes).unwrap();
                }
            }
        }
        log.finish().unwrap()
    }

    const TIME: usize = 8;

    /// A log as records: their time and their frame.
    fn records(bytes: &[u8]) -> Vec<(u64, Vec<u8>)> {
        let (mut records, mut at) = (Vec::new(), 0);
        while at < bytes.len() {
            let time_us = u64::from_be_bytes(bytes[at..at + TIME].try_into().unwrap());
            let head = &bytes[at + TIME..];
            let length = Frame::length(head[0], head[1], head[2]).unwrap();
            records.push((time_us, head[..length].to_vec()));
            at += TIME + length;
        }
        records
    }

    fn written(records: &[(u64, Vec<u8>)]) -> Vec<u8> {
        records.iter().flat_map(|(time_us, frame)| [&time_us.to_be_bytes()[..], frame].concat()).collect()
    }

    /// What the page is told of logs, and the times and places of their frames.
    fn played(logs: &[&[u8]], scene: Scene) -> (serde_json::Value, Vec<live_view::wire::Places>) {
        let name = |index: usize| format!("{index}.tlog");
        let logs = logs.iter().enumerate().map(|(index, bytes)| (name(index), Log::open(bytes.to_vec()).unwrap()));
        let tape = Tape::default();
        play(logs.collect(), scene, &tape).unwrap();
        let head: serde_json::Value = serde_json::from_str(&tape.head().unwrap()).unwrap();
        let (bytes, mut at, mut frames) = (tape.frames(), 0, Vec::new());
        while at < bytes.len() {
            let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
            frames.push(live_view::wire::places(&bytes[at + 4..at + 4 + length]).unwrap());
            at += 4 + length;
        }
        (head["recording"].clone(), frames)
    }

    #[test]
    fn a_log_is_played_back_with_what_happened_in_it() {
        let bytes = log_of_two();
        let survey = Log::open(bytes.clone()).unwrap().survey().clone();
        assert_eq!((survey.records, survey.autopilots.len(), survey.skipped_bytes), (400, 2, 0));
        let (head, frames) = played(&[&bytes], Scene { separation_m: 10.0, ..Scene::default() });
        assert_eq!(head["roster"]["systems"], serde_json::json!([3, 9]));
        let told = head["told"].to_string();
        assert!(told.contains("left GUIDED to RTL"), "{told}");
        assert!((head["least"]["separation"]["value_m"].as_f64().unwrap() - 8.0).abs() < 0.1, "{head}");
        assert_eq!((head["read"].as_f64(), frames.len()), (Some(1.0), 100), "ten seconds at ten frames a second");
    }

    #[test]
    fn the_page_plays_what_was_read_while_the_rest_is_being_read() {
        // Ten minutes, of which the third vehicle is there from the fifth on.
        let ten = records(&log_of_two());
        let mut long = Vec::new();
        for stretch in 0..60 {
            for (time_us, frame) in &ten {
                let mut frame = frame.clone();
                if stretch >= 30 && frame[5] == 9 {
                    frame = renumbered(&frame, 20);
                }
                long.push((time_us + 10_000_000 * stretch, frame));
            }
        }
        let tape = Tape::default();
        let seen = std::sync::Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            let (log, of_reader) = (Log::open(written(&long)).unwrap(), tape.clone());
            let reader = scope.spawn(move || play(vec![("long.tlog".into(), log)], Scene::default(), &of_reader));
            while !reader.is_finished() {
                let Some(head) = tape.head() else { continue };
                let head: serde_json::Value = serde_json::from_str(&head).unwrap();
                let mut seen = seen.lock().unwrap();
                seen.push((
                    head["recording"]["read"].as_f64().unwrap(),
                    head["recording"]["duration_s"].as_f64().unwrap(),
                ));
            }
        });
        let seen = seen.into_inner().unwrap();
        assert!(seen.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        assert!(seen.iter().all(|(_, duration_s)| (duration_s - 599.9).abs() < 0.01), "the length is known at once");
        let (head, frames) = played(&[&written(&long)], Scene::default());
        assert_eq!(head["roster"]["systems"], serde_json::json!([3, 9, 20]));
        assert!(frames.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
        assert_eq!((frames[0].vehicles.len(), frames[6000 - 1].vehicles.len()), (2, 3));
    }

    /// The same message from another system.
    fn renumbered(frame: &[u8], system: u8) -> Vec<u8> {
        let message = Frame::parse(frame).unwrap().message().unwrap();
        let mut bytes = Vec::new();
        Encoder::new(system, 1).encode(&message, &mut bytes);
        bytes
    }

    #[test]
    fn what_is_no_mavlink_is_skipped_and_told() {
        let whole = log_of_two();
        let mut bytes = whole[..whole.len() / 2].to_vec();
        bytes.extend_from_slice(&[0xFD; 333]);
        bytes.extend_from_slice(&whole);
        bytes.truncate(bytes.len() - 5);
        let survey = Log::open(bytes.clone()).unwrap().survey().clone();
        assert!(survey.records > 550 && survey.skipped_bytes > 300, "{} {}", survey.records, survey.skipped_bytes);
        assert!(played(&[&bytes], Scene::default()).0["told"].to_string().contains("are no MAVLink and were skipped"));
    }

    #[test]
    fn a_file_that_cannot_be_played_is_told_what_it_is() {
        let error = |bytes: &[u8]| Log::open(bytes.to_vec()).err();
        assert_eq!(error(b"this is a text, and no log of telemetry"), Some(NotALog::Nothing));
        assert_eq!(error(b""), Some(NotALog::Nothing));
        assert_eq!(error(b"ULog\x01\x12\x35\x01and so on"), Some(NotALog::ULog));
        assert_eq!(error(b"\xA3\x95\x80\x80FMT"), Some(NotALog::Dataflash));
        let all = records(&log_of_two());
        let raw: Vec<u8> = all.iter().flat_map(|(_, frame)| frame.clone()).collect();
        assert_eq!(error(&raw), Some(NotALog::Raw));
        let only = |id: u8| written(&all.iter().filter(|(_, frame)| frame[7] == id).cloned().collect::<Vec<_>>());
        assert_eq!(error(&only(0)), Some(NotALog::NoPositions(200)));
        assert_eq!(error(&only(33)), Some(NotALog::NoAutopilot(200)));
    }

    #[test]
    fn a_clock_that_is_set_meanwhile_tears_no_log() {
        let whole = records(&log_of_two());
        let year_us = 365 * 24 * 3600 * 1_000_000_u64;
        for jump_us in [year_us, year_us.wrapping_neg(), 10_000_000_u64.wrapping_neg()] {
            let mut set = whole.clone();
            set[200..].iter_mut().for_each(|(time_us, _)| *time_us = time_us.wrapping_add(jump_us));
            let bytes = written(&set);
            let survey = Log::open(bytes.clone()).unwrap().survey().clone();
            assert_eq!((survey.records, survey.skipped_bytes), (400, 0));
            let (first_us, last_us) = survey.span_us;
            assert!((9_700_000..10_000_000).contains(&(last_us - first_us)), "{}", last_us - first_us);
            let (head, frames) = played(&[&bytes], Scene::default());
            assert!(head["told"].to_string().contains("the clock of the log jumps by"));
            assert!(frames.last().unwrap().time_s < 10.0);
        }
    }

    #[test]
    fn several_logs_are_in_one_frame_and_their_vehicles_are_numbered_through() {
        let (head, frames) = played(&[&log_from(0.0), &log_from(300.0)], Scene::default());
        assert_eq!(head["roster"]["numbers"], serde_json::json!([3, 9, 1003, 1009]));
        let places = &frames[0].vehicles;
        let apart_m = places[2].unwrap()[0] - places[0].unwrap()[0];
        assert!((apart_m - 300.0).abs() < 0.1, "{apart_m}");
    }
}

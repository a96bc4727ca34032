//! Who is where on which port: the table that `columba vehicles` prints. docs/mavlink.md describes every field.

use crate::flying::{network, reachable};
use flight_model::Geodetic;
use serde::Serialize;
use sim_vehicle::{Host, Mode, Protocol, Vehicle};
use std::fmt::Write;
use std::net::{IpAddr, SocketAddr};

/// The whole table.
#[derive(Serialize)]
pub struct Table {
    /// Where telemetry of the first network goes unasked.
    ground: Option<SocketAddr>,
    /// Vehicle seconds for each second of the wall clock; none in lockstep.
    speed: Option<f64>,
    vehicles: Vec<Row>,
}

/// One vehicle.
#[derive(Serialize)]
struct Row {
    vehicle: usize,
    network: usize,
    system_id: u8,
    component_id: u8,
    address: SocketAddr,
    host: IpAddr,
    port: u16,
    /// Every address at which it listens.
    links: Vec<Line>,
    ground: Option<SocketAddr>,
    mode: Mode,
    armed: bool,
    latitude_deg: f64,
    longitude_deg: f64,
    altitude_amsl_m: f64,
    x_m: f64,
    y_m: f64,
    altitude_m: f64,
    speed_mps: f64,
    course_rad: f64,
    /// How many of its parameters are there for clients and change nothing.
    inert_parameters: usize,
}

/// A way to a vehicle.
#[derive(Serialize)]
struct Line {
    protocol: Protocol,
    address: SocketAddr,
}

impl Table {
    /// Of vehicles that have their ports and have not flown yet.
    pub fn of(host: &Host, speed: Option<f64>) -> Self {
        let rows = host.vehicles().zip(host.addresses()).zip(host.lines()).enumerate();
        let vehicles: Vec<Row> =
            rows.map(|(index, ((vehicle, address), lines))| Row::of(index, vehicle, *address, lines)).collect();
        Self { ground: vehicles.first().and_then(|row| row.ground), speed, vehicles }
    }

    /// For scripts, on one line.
    pub fn json(&self) -> String {
        // Nothing in a table can fail to be written.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    /// For people.
    pub fn words(&self) -> String {
        let networks = self.vehicles.last().map_or(1, |row| row.network);
        let mut words = format!(
            "{:>7} {:>6}  {:<21} {:>9} {:>9} {:>8}\n",
            "vehicle", "system", "listens on", "x m", "y m", "alt m"
        );
        for row in &self.vehicles {
            let Row { vehicle, system_id, x_m, y_m, altitude_m, .. } = row;
            let address = row.words();
            // Writing to a string cannot fail.
            let _ =
                writeln!(words, "{vehicle:>7} {system_id:>6}  {address:<21} {x_m:>9.1} {y_m:>9.1} {altitude_m:>8.1}");
        }
        if networks > 1 {
            let _ = writeln!(words, "{networks} networks of 250: vehicle 251 is system 1 of network 2, and so on");
        }
        if let Some(inert) = self.vehicles.first().map(|row| row.inert_parameters).filter(|inert| *inert > 0) {
            let _ = writeln!(words, "{inert} parameters are there for clients to read and set, and change nothing");
        }
        let unasked = self.ground.map(|address| format!("{address} and to ")).unwrap_or_default();
        let next = self.ground.filter(|_| networks > 1).map(|_| ", the port after it for the next network");
        let _ = writeln!(words, "telemetry to {unasked}clients that connect{}; Ctrl-C ends", next.unwrap_or_default());
        words
    }
}

impl Row {
    /// Where it listens, for people: the first of its TCP ports if it has any.
    fn words(&self) -> String {
        match self.links.iter().find(|line| line.protocol == Protocol::Tcp) {
            Some(line) => format!("tcp:{}", line.address),
            None => self.address.to_string(),
        }
    }

    fn of(index: usize, vehicle: &Vehicle, address: SocketAddr, lines: Vec<(Protocol, SocketAddr)>) -> Self {
        let (settings, start) = (vehicle.settings(), vehicle.state());
        let address = reachable(address);
        let Geodetic { latitude_deg, longitude_deg, altitude_amsl_m } =
            settings.frame.to_geodetic(start.x_m, start.y_m, start.altitude_m);
        Self {
            vehicle: index + 1,
            network: network(index),
            system_id: settings.system_id,
            component_id: settings.component_id,
            address,
            host: address.ip(),
            port: address.port(),
            links: lines
                .into_iter()
                .map(|(protocol, address)| Line { protocol, address: reachable(address) })
                .collect(),
            ground: settings.ground,
            mode: vehicle.mode(),
            armed: vehicle.is_armed(),
            latitude_deg,
            longitude_deg,
            altitude_amsl_m,
            x_m: start.x_m,
            y_m: start.y_m,
            altitude_m: start.altitude_m,
            speed_mps: start.speed_mps,
            course_rad: start.course_rad,
            inert_parameters: vehicle.inert_parameter_count(),
        }
    }
}

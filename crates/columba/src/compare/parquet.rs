//! `flights.parquet` and `timings.parquet`: one row for each flight, in the order scenario, contender, seed.
//!
//! What another run of the same flight would change, its wall times, is in the second file and nowhere in the first.

use super::results::Row;
use parquet::basic::{Compression, IntType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use std::sync::Arc;

/// A column: its name, and where its values come from. Every column may hold nulls.
type Column = (&'static str, Values);

/// What kind of values a column holds.
#[derive(Clone, Copy)]
enum Values {
    Text(for<'a> fn(&Row<'a>) -> Option<&'a str>),
    /// Up to 2^64.
    Whole(fn(&Row<'_>) -> Option<u64>),
    Real(fn(&Row<'_>) -> Option<f64>),
    Truth(fn(&Row<'_>) -> Option<bool>),
}
use Values::{Real, Text, Truth, Whole};

/// Which flight a row is of.
const IDENTITY: [Column; 3] = [
    ("scenario", Text(|row| Some(row.scenario))),
    ("contender", Text(|row| Some(row.contender))),
    ("seed", Whole(|row| Some(row.seed))),
];

const FLIGHT: [Column; 33] = [
    ("algorithm", Text(|row| Some(&row.summary.algorithm))),
    ("preset", Text(|row| Some(&row.summary.preset))),
    ("evaluations_per_solve", Whole(|row| Some(row.evaluations as u64))),
    ("vehicles", Whole(|row| Some(row.summary.vehicles as u64))),
    ("obstacles", Whole(|row| Some(row.summary.obstacles as u64))),
    ("duration_s", Real(|row| Some(row.summary.duration_s))),
    ("control_period_s", Real(|row| Some(row.summary.control_period_s))),
    ("completed", Truth(|row| Some(row.summary.completed))),
    ("success", Truth(|row| Some(row.summary.success))),
    ("failure", Text(|row| row.summary.failure.as_deref())),
    ("obstacle_collisions", Whole(|row| Some(row.summary.obstacle_collisions.into()))),
    ("vehicle_collisions", Whole(|row| Some(row.summary.vehicle_collisions.into()))),
    ("separation_losses", Whole(|row| Some(row.summary.separation_losses.into()))),
    ("min_clearance_m", Real(|row| row.summary.min_clearance_m)),
    ("min_clearance_at_s", Real(|row| row.summary.min_clearance_at_s)),
    ("min_clearance_vehicle", Whole(|row| row.summary.min_clearance_vehicle.map(u64::from))),
    ("min_separation_m", Real(|row| row.summary.min_separation_m)),
    ("min_separation_at_s", Real(|row| row.summary.min_separation_at_s)),
    ("min_separation_vehicle_a", Whole(|row| row.summary.min_separation_vehicles.map(|[one, _]| one.into()))),
    ("min_separation_vehicle_b", Whole(|row| row.summary.min_separation_vehicles.map(|[_, other]| other.into()))),
    ("passed_last_obstacle", Whole(|row| Some(row.summary.passed_last_obstacle as u64))),
    ("speed_convergence_s", Real(|row| row.summary.speed_convergence_s)),
    ("course_convergence_s", Real(|row| row.summary.course_convergence_s)),
    ("altitude_settling_s", Real(|row| row.summary.altitude_settling_s)),
    ("speed_variation_mps", Real(|row| Some(row.summary.speed_variation_mps))),
    ("course_variation_rad", Real(|row| Some(row.summary.course_variation_rad))),
    ("flock_radius_m", Real(|row| Some(row.summary.flock_radius_m))),
    ("flock_radius_end_m", Real(|row| Some(row.summary.flock_radius_end_m))),
    ("prediction_rms_m", Real(|row| row.summary.prediction_rms_m)),
    ("course_setpoint_change_p99_rad", Real(|row| row.summary.course_setpoint_change_p99_rad)),
    ("course_setpoint_change_p99_share", Real(|row| row.summary.course_setpoint_change_p99_share)),
    ("transport", Text(|row| Some(&row.summary.transport))),
    ("version", Text(|row| Some(&row.summary.version))),
];

const TIMES: [Column; 3] = [
    ("solve_us_p50", Real(|row| Some(row.summary.solve_us_p50))),
    ("solve_us_p99", Real(|row| Some(row.summary.solve_us_p99))),
    ("wall_s", Real(|row| Some(row.summary.wall_s))),
];

/// Every figure of every flight but its wall times; `null` where a flight has none.
pub fn flights_parquet(rows: &[Row<'_>]) -> Result<Vec<u8>, ParquetError> {
    write("flights", rows, &[&IDENTITY[..], &FLIGHT].concat())
}

/// The wall times of every flight.
pub fn timings_parquet(rows: &[Row<'_>]) -> Result<Vec<u8>, ParquetError> {
    write("timings", rows, &[&IDENTITY[..], &TIMES].concat())
}

fn write(name: &str, rows: &[Row<'_>], columns: &[Column]) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_created_by(concat!("columba ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::UNCOMPRESSED)
        .build();
    let fields = columns.iter().map(|&column| field(column)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder(name).with_fields(fields).build()?;
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, values) in columns {
        match values {
            Text(of) => write_column::<ByteArrayType>(&mut group, rows, |row| of(row).map(ByteArray::from))?,
            // The bits of an unsigned number; the logical type says so.
            Whole(of) => write_column::<Int64Type>(&mut group, rows, |row| of(row).map(u64::cast_signed))?,
            Real(of) => write_column::<DoubleType>(&mut group, rows, of)?,
            Truth(of) => write_column::<BoolType>(&mut group, rows, of)?,
        }
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

fn field((name, values): Column) -> Result<TypePtr, ParquetError> {
    let (physical, logical) = match values {
        Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Whole(_) => (Physical::INT64, Some(LogicalType::Integer(IntType { bit_width: 64, is_signed: false }))),
        Real(_) => (Physical::DOUBLE, None),
        Truth(_) => (Physical::BOOLEAN, None),
    };
    let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
    field.with_logical_type(logical).build().map(Arc::new)
}

fn write_column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
    rows: &[Row<'_>],
    value: impl Fn(&Row<'_>) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let cells: Vec<Option<T::T>> = rows.iter().map(value).collect();
    let levels: Vec<i16> = cells.iter().map(|cell| cell.is_some().into()).collect();
    let values: Vec<T::T> = cells.into_iter().flatten().collect();
    let column = group.next_column()?;
    let mut column = column.ok_or_else(|| ParquetError::General("more columns than the schema has".to_owned()))?;
    column.typed::<T>().write_batch(&values, Some(&levels), None)?;
    column.close()
}

#[cfg(test)]
mod tests {
    use super::super::results::tests::{flown, rows};
    use super::*;
    use crate::flight::Summary;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    fn read(bytes: Vec<u8>) -> Vec<Vec<(String, Field)>> {
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        reader.get_row_iter(None).unwrap().map(|row| row.unwrap().into_columns()).collect()
    }

    fn of(row: &[(String, Field)], name: &str) -> Field {
        row.iter().find(|(column, _)| column == name).unwrap_or_else(|| panic!("{name}")).1.clone()
    }

    #[test]
    fn every_flight_reads_back_and_what_it_has_not_is_null() {
        let flights = [
            Summary {
                failure: Some("UAV 1 and 2 at 3 s".to_owned()),
                min_separation_vehicles: Some([2, 3]),
                ..flown(u64::MAX, None, 0.5)
            },
            flown(2, Some(23.25), 4.125),
        ];
        let read = read(flights_parquet(&rows("NSGA-II, \u{fc}", &flights)).unwrap());
        assert_eq!(read.len(), 2);
        let (first, second) = (&read[0], &read[1]);
        assert_eq!(of(first, "contender"), Field::Str("NSGA-II, \u{fc}".to_owned()));
        assert_eq!(of(first, "seed"), Field::ULong(u64::MAX));
        assert_eq!(
            (of(first, "speed_convergence_s"), of(second, "speed_convergence_s")),
            (Field::Null, Field::Double(23.25))
        );
        assert_eq!((of(first, "success"), of(second, "success")), (Field::Bool(false), Field::Bool(true)));
        assert_eq!(of(second, "failure"), Field::Null);
        assert_eq!(
            (of(first, "min_separation_vehicle_b"), of(second, "min_separation_vehicle_b")),
            (Field::ULong(3), Field::Null)
        );
        assert_eq!(of(second, "min_separation_m"), Field::Double(4.125));
        assert_eq!(of(second, "evaluations_per_solve"), Field::ULong(651));
    }

    /// Whoever adds a figure to a summary is told here that it has a column, too.
    #[test]
    fn every_figure_of_a_summary_has_its_column() {
        let columns: Vec<&str> = [&IDENTITY[..], &FLIGHT, &TIMES].concat().iter().map(|(name, _)| *name).collect();
        let summary = serde_json::to_value(Summary::default()).unwrap();
        // A flight in memory has no link, no ground station and no present to estimate, one that was interrupted no
        // row, and the factor follows from the rest.
        let without = ["link", "station", "present", "interrupted", "real_time_factor"];
        for name in summary.as_object().unwrap().keys().filter(|name| !without.contains(&name.as_str())) {
            let split = format!("{}_a", name.trim_end_matches('s'));
            assert!(columns.contains(&name.as_str()) || columns.contains(&split.as_str()), "{name}");
        }
    }

    #[test]
    fn wall_times_are_in_their_own_file_only() {
        let flight = flown(1, None, 2.0);
        let slower =
            Summary { solve_us_p50: 1e3, solve_us_p99: 1e4, wall_s: 9.0, real_time_factor: 4.0, ..flight.clone() };
        let (flight, slower) = ([flight], [slower]);
        let (flight, slower) = (rows("one", &flight), rows("one", &slower));
        assert_eq!(flights_parquet(&flight).unwrap(), flights_parquet(&slower).unwrap());
        assert_ne!(timings_parquet(&flight).unwrap(), timings_parquet(&slower).unwrap());
        assert_eq!(of(&read(timings_parquet(&slower).unwrap())[0], "wall_s"), Field::Double(9.0));
    }
}

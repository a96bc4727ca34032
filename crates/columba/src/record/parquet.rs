//! `trajectory.parquet`: one row for each vehicle and tick, tick by tick, vehicles in order.
//!
//! The same flight gives the same bytes: nothing but the trajectory and this crate's name goes into the file.

use crate::flight::{Row, Tick, Trajectory, vehicle_number};
use parquet::{
    basic::{Compression, Repetition, Type as Physical},
    data_type::{DoubleType, Int32Type},
    errors::ParquetError,
    file::{
        properties::WriterProperties,
        writer::{SerializedFileWriter, SerializedRowGroupWriter},
    },
    schema::types::Type,
};
use std::sync::Arc;

/// How many ticks x vehicles share a row group, at most: what a reader holds in memory at once.
const ROWS_PER_GROUP: usize = 1 << 18;

/// A column of doubles: its name and where its value comes from.
type Column = (&'static str, fn(&Tick, &Row) -> f64);

/// The columns after `t_s` and `vehicle`.
const COLUMNS: [Column; 12] = [
    ("x_m", |_, row| row.state.x_m),
    ("y_m", |_, row| row.state.y_m),
    ("altitude_m", |_, row| row.state.altitude_m),
    ("speed_mps", |_, row| row.state.speed_mps),
    ("course_rad", |_, row| row.state.course_rad),
    ("climb_mps", |_, row| row.state.climb_mps),
    ("speed_setpoint_mps", |_, row| row.setpoint.speed_mps),
    ("course_setpoint_rad", |_, row| row.setpoint.course_rad),
    ("altitude_setpoint_m", |_, row| row.setpoint.altitude_m),
    ("alpha_formation", |_, row| row.alpha[0]),
    ("alpha_obstacle", |_, row| row.alpha[1]),
    ("alpha_velocity", |_, row| row.alpha[2]),
];

/// The trajectory as a Parquet file.
///
/// Columns: `t_s` (double), `vehicle` (int32, [`vehicle_number`]), the state `x_m`, `y_m`, `altitude_m`, `speed_mps`,
/// `course_rad`, `climb_mps`, the setpoint `speed_setpoint_mps`, `course_setpoint_rad`, `altitude_setpoint_m`, and
/// `alpha_formation`, `alpha_obstacle`, `alpha_velocity`. All required, uncompressed.
pub fn trajectory_parquet(trajectory: &Trajectory) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_created_by(concat!("columba ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::UNCOMPRESSED)
        .build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema()?, Arc::new(properties))?;

    let ticks: Vec<(&Tick, &[Row])> = trajectory.iter().collect();
    for ticks in ticks.chunks((ROWS_PER_GROUP / trajectory.vehicles.max(1)).max(1)) {
        let mut group = writer.next_row_group()?;
        write_doubles(&mut group, ticks, |tick, _| tick.t_s)?;
        write_vehicles(&mut group, ticks)?;
        for (_, value) in COLUMNS {
            write_doubles(&mut group, ticks, value)?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(bytes)
}

fn schema() -> Result<Arc<Type>, ParquetError> {
    let field = |name, physical| {
        Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let mut fields = vec![field("t_s", Physical::DOUBLE)?, field("vehicle", Physical::INT32)?];
    for (name, _) in COLUMNS {
        fields.push(field(name, Physical::DOUBLE)?);
    }
    Type::group_type_builder("trajectory").with_fields(fields).build().map(Arc::new)
}

type Group<'a, 'b> = SerializedRowGroupWriter<'a, &'b mut Vec<u8>>;

fn write_doubles(
    group: &mut Group<'_, '_>,
    ticks: &[(&Tick, &[Row])],
    value: fn(&Tick, &Row) -> f64,
) -> Result<(), ParquetError> {
    let values: Vec<f64> = ticks.iter().flat_map(|(tick, rows)| rows.iter().map(|row| value(tick, row))).collect();
    let mut column = next_column(group)?;
    column.typed::<DoubleType>().write_batch(&values, None, None)?;
    column.close()
}

fn write_vehicles(group: &mut Group<'_, '_>, ticks: &[(&Tick, &[Row])]) -> Result<(), ParquetError> {
    let number = |index| i32::try_from(vehicle_number(index)).unwrap_or(i32::MAX);
    let values: Vec<i32> = ticks.iter().flat_map(|(_, rows)| (0..rows.len()).map(number)).collect();
    let mut column = next_column(group)?;
    column.typed::<Int32Type>().write_batch(&values, None, None)?;
    column.close()
}

fn next_column<'a>(
    group: &'a mut Group<'_, '_>,
) -> Result<parquet::file::writer::SerializedColumnWriter<'a>, ParquetError> {
    group.next_column()?.ok_or_else(|| ParquetError::General("more columns than the schema has".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::{Setpoint, State};
    use parquet::{
        file::reader::{FileReader, SerializedFileReader},
        record::Field,
    };

    fn flight(vehicles: usize, ticks: usize) -> Trajectory {
        let mut trajectory = Trajectory::new(vehicles);
        for step in 0..ticks {
            let t_s = 0.5 * step as f64;
            let tick = Tick { t_s, min_separation_m: 5.0, min_clearance_m: f64::INFINITY, solve_us: 70.0 };
            let row = |vehicle: usize| {
                let base = 100.0 * vehicle as f64 + t_s;
                Row {
                    state: State {
                        x_m: base,
                        y_m: base + 1.0,
                        altitude_m: base + 2.0,
                        speed_mps: base + 3.0,
                        course_rad: base + 4.0,
                        climb_mps: base + 5.0,
                    },
                    setpoint: Setpoint { speed_mps: base + 6.0, course_rad: base + 7.0, altitude_m: base + 8.0 },
                    alpha: [base + 9.0, base + 10.0, base + 11.0],
                }
            };
            trajectory.push(tick, (0..vehicles).map(row));
        }
        trajectory
    }

    #[test]
    fn every_value_reads_back_under_its_name() {
        let bytes = trajectory_parquet(&flight(3, 4)).unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let rows: Vec<Vec<(String, Field)>> =
            reader.get_row_iter(None).unwrap().map(|row| row.unwrap().into_columns()).collect();
        assert_eq!(rows.len(), 12);
        let names: Vec<&str> = rows[0].iter().map(|(name, _)| name.as_str()).collect();
        let mut expected = vec!["t_s", "vehicle"];
        expected.extend(COLUMNS.iter().map(|(name, _)| name));
        assert_eq!(names, expected);
        for (index, row) in rows.iter().enumerate() {
            let (tick, vehicle) = (index / 3, index % 3);
            let t_s = 0.5 * tick as f64;
            assert_eq!(row[0].1, Field::Double(t_s));
            assert_eq!(row[1].1, Field::Int(vehicle as i32 + 1));
            for (column, (_, value)) in row[2..].iter().enumerate() {
                assert_eq!(*value, Field::Double(100.0 * vehicle as f64 + t_s + column as f64));
            }
        }
    }

    #[test]
    fn the_same_flight_is_the_same_bytes_and_how_long_it_took_is_not_in_them() {
        let mut slower = flight(3, 4);
        slower.ticks.iter_mut().for_each(|tick| tick.solve_us *= 10.0);
        assert_eq!(trajectory_parquet(&flight(3, 4)).unwrap(), trajectory_parquet(&slower).unwrap());
        assert_ne!(trajectory_parquet(&flight(3, 4)).unwrap(), trajectory_parquet(&flight(3, 5)).unwrap());
    }

    #[test]
    fn no_ticks_and_no_vehicles_are_an_empty_table() {
        for trajectory in [flight(3, 0), flight(0, 4)] {
            let bytes = trajectory_parquet(&trajectory).unwrap();
            let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
            assert_eq!(reader.get_row_iter(None).unwrap().count(), 0);
        }
    }

    #[test]
    fn long_flights_are_split_into_groups_of_whole_ticks() {
        let bytes = trajectory_parquet(&flight(1000, 300)).unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let groups: Vec<i64> = reader.metadata().row_groups().iter().map(|group| group.num_rows()).collect();
        assert_eq!(groups, [262_000, 38_000]);
    }
}

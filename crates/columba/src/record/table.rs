//! Any table as a Parquet file: columns of equal length under their names.
//!
//! The same columns give the same bytes: nothing but them and this crate's name goes into the file.

use parquet::{
    basic::{Compression, LogicalType, Repetition, Type as Physical},
    data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type},
    errors::ParquetError,
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::types::Type,
};
use std::sync::Arc;

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// UTF-8 strings.
    Text(Vec<String>),
    /// 64-bit integers.
    Integer(Vec<i64>),
    /// Doubles; `None` is null.
    Double(Vec<Option<f64>>),
}

/// The table as a Parquet file, uncompressed.
///
/// # Errors
/// The columns are not equally long.
pub fn table_parquet(name: &str, columns: &[(&str, Column)]) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_created_by(concat!("columba ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::UNCOMPRESSED)
        .build();
    let fields = columns.iter().map(|(name, column)| field(name, column)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder(name).with_fields(fields).build()?;
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, values) in columns {
        let Some(mut column) = group.next_column()? else { break };
        match values {
            Column::Text(values) => {
                let values: Vec<ByteArray> = values.iter().map(|value| value.as_str().into()).collect();
                column.typed::<ByteArrayType>().write_batch(&values, None, None)?
            }
            Column::Integer(values) => column.typed::<Int64Type>().write_batch(values, None, None)?,
            Column::Double(values) => {
                let present: Vec<f64> = values.iter().flatten().copied().collect();
                let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
                column.typed::<DoubleType>().write_batch(&present, Some(&levels), None)?
            }
        };
        column.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

fn field(name: &str, column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical, repetition) = match column {
        Column::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
        Column::Integer(_) => (Physical::INT64, None, Repetition::REQUIRED),
        Column::Double(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
    };
    let field = Type::primitive_type_builder(name, physical).with_logical_type(logical).with_repetition(repetition);
    field.build().map(Arc::new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::{
        file::reader::{FileReader, SerializedFileReader},
        record::Field,
    };

    #[test]
    fn every_value_reads_back_under_its_name() {
        let columns = [
            ("who", Column::Text(vec!["a".to_owned(), "ü".to_owned()])),
            ("seed", Column::Integer(vec![1, i64::MAX])),
            ("cost", Column::Double(vec![None, Some(-0.5)])),
        ];
        let bytes = table_parquet("table", &columns).unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(|row| row.unwrap().into_columns()).collect();
        let field = |name: &str, field| (name.to_owned(), field);
        let text = |text: &str| Field::Str(text.to_owned());
        assert_eq!(rows[0], [field("who", text("a")), field("seed", Field::Long(1)), field("cost", Field::Null)]);
        let last = [field("who", text("ü")), field("seed", Field::Long(i64::MAX)), field("cost", Field::Double(-0.5))];
        assert_eq!(rows[1..], [last]);
    }

    #[test]
    fn columns_of_unequal_length_are_refused() {
        let columns = [("a", Column::Integer(vec![1, 2])), ("b", Column::Integer(vec![1]))];
        assert!(table_parquet("table", &columns).is_err());
    }
}

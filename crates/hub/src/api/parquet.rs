//! The history as Parquet: one row a value, for notebooks and databases.

use std::io;
use std::sync::Arc;

use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use serde_json::Value;

use super::records::Rows;

/// Each change of a value; a value that is not known is null.
const CHANGES: &str = "message history { REQUIRED BINARY series (UTF8); \
    REQUIRED INT64 t_ms (TIMESTAMP_MILLIS); OPTIONAL DOUBLE value; }";
/// Minutes.
const MINUTES: &str = "message history { REQUIRED BINARY series (UTF8); \
    REQUIRED INT64 t_ms (TIMESTAMP_MILLIS); OPTIONAL DOUBLE mean; OPTIONAL DOUBLE least; \
    OPTIONAL DOUBLE most; }";

/// A whole file.
pub fn file(minutes: bool, all: &Rows) -> io::Result<Vec<u8>> {
    write(minutes, all).map_err(io::Error::other)
}

fn write(minutes: bool, all: &Rows) -> Result<Vec<u8>, ParquetError> {
    let schema = Arc::new(parse_message_type(if minutes { MINUTES } else { CHANGES })?);
    let mut bytes = Vec::new();
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties)?;
    let mut group = writer.next_row_group()?;
    let rows = || all.iter().flat_map(|(name, rows)| rows.iter().map(move |row| (name, row)));
    let series: Vec<ByteArray> =
        rows().map(|(name, _)| ByteArray::from(name.as_bytes().to_vec())).collect();
    if let Some(mut column) = group.next_column()? {
        column.typed::<ByteArrayType>().write_batch(&series, None, None)?;
        column.close()?;
    }
    let cell = |row: &[Value], index: usize| row.get(index).cloned().unwrap_or_default();
    let times: Vec<i64> = rows().map(|(_, row)| cell(row, 0).as_i64().unwrap_or(0)).collect();
    if let Some(mut column) = group.next_column()? {
        column.typed::<Int64Type>().write_batch(&times, None, None)?;
        column.close()?;
    }
    for index in 1..=if minutes { 3 } else { 1 } {
        let values: Vec<Option<f64>> = rows().map(|(_, row)| cell(row, index).as_f64()).collect();
        doubles(&mut group, &values)?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

/// A column of which some values are missing.
fn doubles(
    group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
    values: &[Option<f64>],
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Ok(()) };
    let present: Vec<f64> = values.iter().copied().flatten().collect();
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    column.typed::<DoubleType>().write_batch(&present, Some(&levels), None)?;
    column.close()
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use serde_json::json;

    use super::*;

    fn read(bytes: Vec<u8>) -> Vec<String> {
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        reader.get_row_iter(None).unwrap().map(|row| row.unwrap().to_string()).collect()
    }

    #[test]
    fn what_is_written_is_read() {
        let changes: Rows = vec![
            ("a".into(), vec![vec![json!(1000), json!(1.5)], vec![json!(2000), Value::Null]]),
            ("b".into(), vec![vec![json!(3000), json!(-2)]]),
        ];
        let rows = read(file(false, &changes).unwrap());
        assert_eq!(rows.len(), 3);
        assert!(rows[0].contains("\"a\"") && rows[0].contains("1.5"), "{rows:?}");
        assert!(rows[1].contains("null") && rows[2].contains("-2E0"), "{rows:?}");
        let minutes = vec![("a".into(), vec![vec![json!(0), json!(2), json!(1), json!(3)]])];
        let rows = read(file(true, &minutes).unwrap());
        assert!(rows[0].contains("mean: 2") && rows[0].contains("most: 3"), "{rows:?}");
        assert_eq!(read(file(false, &Vec::new()).unwrap()).len(), 0);
    }
}

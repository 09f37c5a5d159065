//! The history as Parquet: one row a value, for notebooks and databases.

use std::io;
use std::sync::Arc;

use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;

use super::records::Read;
use crate::error::ApiError;
use crate::store::{Rows, StoreError};

/// Each change of a value; a value that is not known is null.
const CHANGES: &str = "message history { REQUIRED BINARY series (UTF8); \
    REQUIRED INT64 t_ms (TIMESTAMP_MILLIS); OPTIONAL DOUBLE value; }";
/// Schema of the values per minute.
const MINUTES: &str = "message history { REQUIRED BINARY series (UTF8); \
    REQUIRED INT64 t_ms (TIMESTAMP_MILLIS); OPTIONAL DOUBLE mean; OPTIONAL DOUBLE least; \
    OPTIONAL DOUBLE most; }";

/// The values as a whole Parquet file.
pub fn file(read: &Read) -> Result<Vec<u8>, ApiError> {
    let file = write(read).map_err(|error| StoreError::Io(io::Error::other(error)));
    Ok(file?)
}

fn write(read: &Read) -> Result<Vec<u8>, ParquetError> {
    let minutes = read.resolution_ms > 0;
    let schema = Arc::new(parse_message_type(if minutes { MINUTES } else { CHANGES })?);
    let mut bytes = Vec::new();
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties)?;
    let mut group = writer.next_row_group()?;
    let (mut series, mut times) = (Vec::new(), Vec::new());
    let mut values = vec![Vec::new(); if minutes { 3 } else { 1 }];
    for (name, rows) in &read.series {
        let name = ByteArray::from(name.as_bytes().to_vec());
        let mut put = |t: u64, cells: &[Option<f64>]| {
            series.push(name.clone());
            times.push(t.cast_signed());
            values.iter_mut().zip(cells).for_each(|(column, cell)| column.push(*cell));
        };
        match rows {
            Rows::Changes(rows) => rows.iter().for_each(|(t, value)| put(*t, &[*value])),
            Rows::Spans(rows) => rows.iter().for_each(|(t, mean, least, most)| {
                put(*t, &[Some(*mean), Some(*least), Some(*most)]);
            }),
        }
    }
    if let Some(mut column) = group.next_column()? {
        column.typed::<ByteArrayType>().write_batch(&series, None, None)?;
        column.close()?;
    }
    if let Some(mut column) = group.next_column()? {
        column.typed::<Int64Type>().write_batch(&times, None, None)?;
        column.close()?;
    }
    for column in &values {
        doubles(&mut group, column)?;
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
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};

    fn read(bytes: Vec<u8>) -> Vec<String> {
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        reader.get_row_iter(None).unwrap().map(|row| row.unwrap().to_string()).collect()
    }

    #[test]
    fn what_is_written_is_read() {
        let read_of = |resolution_ms, all: Vec<(&str, Rows)>| Read {
            resolution_ms,
            series: all.into_iter().map(|(name, rows)| (name.to_owned(), rows)).collect(),
        };
        let changes = vec![
            ("a", Rows::Changes(vec![(1000, Some(1.5)), (2000, None)])),
            ("b", Rows::Changes(vec![(3000, Some(-2.0))])),
        ];
        let rows = read(file(&read_of(0, changes)).unwrap());
        assert_eq!(rows.len(), 3);
        assert!(rows[0].contains("\"a\"") && rows[0].contains("1.5"), "{rows:?}");
        assert!(rows[1].contains("null") && rows[2].contains("-2E0"), "{rows:?}");
        let minutes = vec![("a", Rows::Spans(vec![(0, 2.0, 1.0, 3.0)]))];
        let rows = read(file(&read_of(60_000, minutes)).unwrap());
        assert!(rows[0].contains("mean: 2") && rows[0].contains("most: 3"), "{rows:?}");
        assert_eq!(read(file(&read_of(0, Vec::new())).unwrap()).len(), 0);
    }
}

//! In the place of the history as Parquet where that is not built in.

use axum::http::StatusCode;
use lafet_texts::{Text as _, hub as text};

use super::records::Read;
use crate::error::ApiError;

/// Says that Parquet is not built in.
pub fn file(_: &Read) -> Result<Vec<u8>, ApiError> {
    let text = text::NoParquet.words();
    Err(ApiError::new(StatusCode::NOT_IMPLEMENTED, "not_built", text))
}

//! In the place of the history as Parquet where that is not built in.

use axum::http::StatusCode;

use super::records::Read;
use crate::error::ApiError;
use crate::text::both;

/// Says that Parquet is not built in.
pub fn file(_: &Read) -> Result<Vec<u8>, ApiError> {
    let text = both(
        "This lafet is built without Parquet. Take /api/history.csv, or build with the feature parquet.",
        "Этот lafet собран без Parquet. Возьмите /api/history.csv или соберите с возможностью parquet.",
    );
    Err(ApiError::new(StatusCode::NOT_IMPLEMENTED, "not_built", text))
}

//! Tests of the import over whole files.

mod broken;
mod placed;
mod truth;

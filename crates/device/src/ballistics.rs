//! Ballistics.

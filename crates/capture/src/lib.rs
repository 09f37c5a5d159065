//! Recordings of what goes between monitors and those who control them, and the tools to look at
//! them: MCAP, pcapng, a Wireshark dissector.
#![forbid(unsafe_code)]

pub mod dissector;

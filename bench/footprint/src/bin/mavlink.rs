//! mavlink: a HEARTBEAT of version 2 written and read.
#![no_std]
#![no_main]

use core::hint::black_box;

use mavlink::dialects::minimal::{
    HEARTBEAT_DATA, MavAutopilot, MavMessage, MavModeFlag, MavState, MavType,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkReader, MavlinkVersion};

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut reader = MavlinkReader::new(Line);
    lafet_bench_footprint::measure(|| message(&mut reader))
}

fn message(reader: &mut MavlinkReader<Line>) -> bool {
    let heartbeat = HEARTBEAT_DATA {
        custom_mode: black_box(0x41_0000),
        mavtype: MavType::MAV_TYPE_GCS,
        autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    };
    let mut raw = MAVLinkV2MessageRaw::new();
    let header = MavHeader { system_id: 1, component_id: 1, sequence: 7 };
    raw.serialize_message(header, &MavMessage::HEARTBEAT(heartbeat.clone()));
    send(raw.raw_bytes());
    match reader.read_message::<MavMessage>(MavlinkVersion::V2) {
        Ok((_, MavMessage::HEARTBEAT(seen))) => black_box(seen) == heartbeat,
        _ => false,
    }
}

static mut WIRE: ([u8; 280], usize, usize) = ([0; 280], 0, 0);

/// The line: what was sent comes back.
struct Line;

fn send(bytes: &[u8]) {
    // SAFETY: nothing else uses it meanwhile; there is one thread, and no interrupt.
    let (wire, len, taken) = unsafe { &mut *(&raw mut WIRE) };
    if let Some(place) = wire.get_mut(..bytes.len()) {
        place.copy_from_slice(bytes);
        (*len, *taken) = (bytes.len(), 0);
    }
}

impl embedded_io::ErrorType for Line {
    type Error = core::convert::Infallible;
}

impl embedded_io::Read for Line {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        // SAFETY: nothing else uses it meanwhile; there is one thread, and no interrupt.
        let (wire, len, taken) = unsafe { &mut *(&raw mut WIRE) };
        let sent = wire.get(*taken..*len).unwrap_or_default();
        let count = sent.len().min(buffer.len());
        for (place, byte) in buffer.iter_mut().zip(sent) {
            *place = *byte;
        }
        *taken += count;
        Ok(count)
    }
}

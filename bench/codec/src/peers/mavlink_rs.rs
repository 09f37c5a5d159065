//! mavlink: HEARTBEAT of version 2, 9 bytes of data, as a stream of bytes.

use std::io::Read;

use mavlink::dialects::minimal::{
    HEARTBEAT_DATA, MavAutopilot, MavMessage, MavModeFlag, MavState, MavType,
};
use mavlink::{MavHeader, MavlinkReader};

use crate::case;
use crate::case::Case;
use crate::values::ROOM;

pub fn cases() -> Vec<Case> {
    let mut state = State::new(&[]);
    drive_send(&mut state);
    let frame = state.out[..state.len].to_vec();
    let made: fn(&State) -> bool =
        |state| state.out[..state.len] == state.reader_bytes[..state.len] && state.len > 0;
    let seen: fn(&State) -> bool = |state| state.seen == sample() && state.count > 0;
    vec![
        case!(mavlink::drive_receive, frame.len(), State::new(&frame), seen),
        case!(mavlink::drive_send, frame.len(), State::new(&frame), made),
        case!(mavlink::eleven_receive, 11 * frame.len(), State::new(&frame), seen),
        case!(mavlink::whole_receive, 14 * frame.len(), State::new(&frame), seen),
        case!(mavlink::whole_send, 14 * frame.len(), State::new(&frame), |s| s.len == 14 * 21),
    ]
}

struct State {
    reader: MavlinkReader<Feed>,
    reader_bytes: Vec<u8>,
    out: [u8; ROOM],
    len: usize,
    seen: HEARTBEAT_DATA,
    count: u64,
}

impl State {
    fn new(frame: &[u8]) -> Self {
        Self {
            reader: MavlinkReader::new(Feed { frame: frame.to_vec() }),
            reader_bytes: frame.to_vec(),
            out: [0; ROOM],
            len: 0,
            seen: HEARTBEAT_DATA { custom_mode: 0, ..sample() },
            count: 0,
        }
    }
}

/// The same frame for ever, one a read: as messages come over a line.
struct Feed {
    frame: Vec<u8>,
}

impl Read for Feed {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let len = self.frame.len().min(buffer.len());
        buffer[..len].copy_from_slice(&self.frame[..len]);
        Ok(len)
    }
}

fn sample() -> HEARTBEAT_DATA {
    HEARTBEAT_DATA {
        custom_mode: 0x0041_0000,
        mavtype: MavType::MAV_TYPE_GCS,
        autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    }
}

#[inline(always)]
fn receive(state: &mut State) {
    if let Ok((_, MavMessage::HEARTBEAT(data))) =
        state.reader.read_message::<MavMessage>(mavlink::MavlinkVersion::V2)
    {
        state.seen = data;
        state.count += 1;
    }
}

#[inline(never)]
fn drive_receive(state: &mut State) {
    receive(state);
}

#[inline(never)]
fn eleven_receive(state: &mut State) {
    (0..11).for_each(|_| receive(state));
}

#[inline(never)]
fn whole_receive(state: &mut State) {
    (0..14).for_each(|_| receive(state));
}

#[inline(always)]
fn send(out: &mut &mut [u8]) {
    let header = MavHeader { system_id: 1, component_id: 1, sequence: 7 };
    // A buffer that is too short shows in the length.
    let _ = mavlink::write_v2_msg(out, header, &MavMessage::HEARTBEAT(sample()));
}

#[inline(never)]
fn drive_send(state: &mut State) {
    let mut out = state.out.as_mut_slice();
    send(&mut out);
    state.len = ROOM - out.len();
}

#[inline(never)]
fn whole_send(state: &mut State) {
    let mut out = state.out.as_mut_slice();
    (0..14).for_each(|_| send(&mut out));
    state.len = ROOM - out.len();
}

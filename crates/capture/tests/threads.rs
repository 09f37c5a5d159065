//! A recorder works in the thread of its caller: a hub writes sixteen at a time.

#![cfg(target_os = "linux")]

use std::fs;
use std::io::Cursor;

use lafet_capture::{Captured, Direction, Format, Recorder};

/// Alone in its program, so that no other test starts threads meanwhile.
#[test]
fn recorders_start_no_threads() {
    let threads = || fs::read_dir("/proc/self/task").unwrap().count();
    let before = threads();
    let mut recorders: Vec<_> =
        (0..16).map(|_| Recorder::new(Format::Mcap, Cursor::new(Vec::new())).unwrap()).collect();
    for recorder in &mut recorders {
        for at_ns in 0..1000 {
            let bytes = vec![0xFF, 0xC0, 0x01, 0x81, 0x21, 0x60, 0xC0];
            recorder.write(&Captured { at_ns, direction: Direction::ToMonitor, bytes }).unwrap();
        }
        recorder.flush().unwrap();
    }
    assert_eq!(threads(), before);
    recorders.into_iter().for_each(|it| it.finish().unwrap());
}

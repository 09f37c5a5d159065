//! A recorder takes little: a hub writes sixteen at a time.

#![cfg(target_os = "linux")]

use std::fs;
use std::io::Cursor;

use lafet_capture::{Captured, Direction, Format, Recorder};

/// Resident memory of this program, KiB.
fn memory_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// Alone in its program, so that no other test starts threads or takes memory meanwhile.
#[test]
fn recorders_start_no_threads_and_take_little_memory() {
    let threads = || fs::read_dir("/proc/self/task").unwrap().count();
    let before = (threads(), memory_kib());
    for _ in 0..4 {
        let mut recorders: Vec<_> = (0..16)
            .map(|_| Recorder::new(Format::Mcap, Cursor::new(Vec::new())).unwrap())
            .collect();
        for recorder in &mut recorders {
            for at_ns in 0..1000 {
                let bytes = vec![0xFF, 0xC0, 0x01, 0x81, 0x21, 0x60, 0xC0];
                recorder
                    .write(&Captured { at_ns, direction: Direction::ToMonitor, bytes })
                    .unwrap();
            }
            recorder.flush().unwrap();
        }
        assert_eq!(threads(), before.0);
        recorders.into_iter().for_each(|it| it.finish().unwrap());
    }
    let above_kib = memory_kib() - before.1;
    assert!(above_kib < 10 * 1024, "{above_kib} KiB");
}

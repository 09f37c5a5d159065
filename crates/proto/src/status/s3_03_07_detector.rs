//! §3.3.7 «Флаги состояния Detector».

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of Detector (§3.3, §3.3.7), 4 bytes.
    DetectorStatus [flags: DetectorFlags] {}
}

flag_class! {
    /// §3.3.7 Detector.
    DetectorFlags "3.3.7";
    SEARCHING = 16 "Searching" Info Detector;
    FOUND = 17 "Found" Alarm Detector;
    DEVICE_FAULT = 18 "DeviceFault" Alarm Detector;
    CANCELED = 19 "Canceled" Notice Detector;
    BAD_SECTOR = 20 "BadSector" Warning Detector;
    JUSTIFYING = 21 "Justifying" Info Detector;
    JUSTIFIED = 22 "Justified" Info Detector;
    DIRTY_LENS = 23 "DirtyLens" Warning Detector;
}

//! §3.3.6 «Флаги состояния Control» with its notes 1–5 on trajectories.

use super::structure;
use crate::flags::flag_class;

structure! {
    /// State of Control (§3.3, §3.3.6), 4 bytes.
    ControlStatus [flags: ControlFlags] {}
}

flag_class! {
    /// §3.3.6 Control.
    ControlFlags "3.3.6";
    QUENCH = 16 "Quench" Info Control;
    OUTSIDE_LIMITS = 17 "OutsideLimits" Warning Control;
    MODE_FAULT = 18 "ModeFault" Warning Control;
    PAUSED = 19 "Paused" Notice Control;
    TRAJECTORY_PRESSURE_FAULT = 20 "TrajectoryPressureFault" Warning Control;
    TRAJECTORY_RANGE_FAULT = 21 "TrajectoryRangeFault" Warning Control;
    TRAJECTORY_ANGLE_FAULT = 22 "TrajectoryAngleFault" Warning Control;
    TRAJECTORY_CRC_FAULT = 23 "TrajectoryCRCFault" Warning Control;
    TRAJECTORY = 24 "Trajectory" Info Control;
}

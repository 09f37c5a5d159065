//! The line of a trace.

use core::fmt::Write;

use lafet_device::image::{Axis, ValveOutput};

use crate::fault::axis_name;
use crate::world::World;

/// The state in one line: true positions (° or mm), commanded speeds (°/s or mm/s), valves,
/// water, jet, the brightest spot in the detector's view (° from its axis), fires.
pub(super) fn trace_line(world: &World) -> String {
    let outputs = world.outputs();
    let mut line = format!("t={:.2}", world.now_ms() as f64 / 1000.0);
    for axis in Axis::ALL {
        let unit = if axis == Axis::Nozzle { 1.0 } else { 60.0 };
        let position = world.drives[axis as usize].position / unit;
        let speed = f64::from(outputs.drives[axis as usize].speed_tenths) / 10.0;
        let _ = write!(line, " {}={position:.2}@{speed:.1}", axis_name(axis));
    }
    for (index, valve) in world.valves.iter().enumerate() {
        let sign = match outputs.valves[index] {
            ValveOutput::Off => '=',
            ValveOutput::Opening => '+',
            ValveOutput::Closing => '-',
        };
        let _ = write!(line, " valve{}={:.2}{sign}", index + 1, valve.opening);
    }
    let water = &world.water;
    let _ = write!(line, " p={:.2}atm q={:.1}l/s", water.pressure_atm(), water.flow_lps);
    match world.landing() {
        Some(jet) => {
            let _ = write!(line, " jet={:.2},{:.2}m", jet.at.0, jet.at.1);
        }
        None => line.push_str(" jet=-"),
    }
    match world.inputs().detector.spots[0] {
        Some(spot) => {
            let middle = |a: i16, b: i16| (f64::from(a) + f64::from(b)) / 120.0;
            let (left, up) = (middle(spot.left, spot.right), middle(spot.top, spot.bottom));
            let _ = write!(line, " spot={left:.2},{up:.2}#{}", spot.brightness);
        }
        None => line.push_str(" spot=-"),
    }
    for (index, fire) in world.fires.iter().enumerate() {
        let _ = write!(line, " fire{index}={:.3}@{:.3}", fire.heat, fire.density);
    }
    let _ = write!(line, " u={:.1}V", world.climate.voltage_v);
    line
}

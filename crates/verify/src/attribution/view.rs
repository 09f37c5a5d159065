//! What there is to see of a monitor after a step.

use lafet_device::cause::Causes;
use lafet_device::image::{AXES, Axis, Inputs, Outputs, VALVES, ValveNo};
use lafet_device::params::Params;
use lafet_device::{Device, Source};
use lafet_proto::SubsystemId;
use lafet_proto::answer::{Answer, Reply};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::{Body, Request};
use lafet_sim::fault::Fault;
use lafet_sim::sim::Sim;

/// What the monitor says of itself on the wire: the flags of its subsystems.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// General.
    pub general: u32,
    /// Control.
    pub control: u32,
    /// Detector.
    pub detector: u32,
    /// Drives, by [`Axis`]; that of Deployer has the flags of deployment.
    pub drives: [u32; AXES],
    /// Valves, by number.
    pub valves: [u32; VALVES],
    /// Positions of the drives, by [`Axis`].
    pub positions: [i16; AXES],
}

impl Told {
    /// Asks for the state of everything, as a client would, but without a moment's wait: also
    /// while the flash is busy.
    pub fn ask(sim: &mut Sim) -> Self {
        let mut told = Self::default();
        let mut buffer = [0; 8];
        let mut writer = Writer::new(&mut buffer);
        if Request::new(SubsystemId::ALL, Body::GetStatus).encode(&mut writer).is_err() {
            return told;
        }
        // A poll is no attempt to control, so the interface does not matter (§3.3.9).
        let bytes = sim.handle(Source::ExternalConn, writer.written());
        for record in Records::new(&bytes).flatten() {
            let Ok(answer) = Answer::decode(&record) else { continue };
            match answer.data {
                Reply::General(status) => told.general = status.flags.bits(),
                Reply::Control(status) => told.control = status.flags.bits(),
                Reply::Detector(status) => told.detector = status.flags.bits(),
                Reply::Deployer(status) => {
                    told.drives[Axis::Deployer as usize] = status.flags.bits();
                    told.positions[Axis::Deployer as usize] = status.position;
                }
                Reply::Drive(status) => {
                    if let Some(axis) = axis_of(answer.from) {
                        told.drives[axis as usize] = status.flags.bits();
                        told.positions[axis as usize] = status.position;
                    }
                }
                Reply::Valve(status) => {
                    let index = usize::from(answer.from == SubsystemId::VALVE2);
                    told.valves[index] = status.flags.bits();
                }
                _ => {}
            }
        }
        told
    }
}

/// The monitor and the world after a step.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Virtual time, ms.
    pub now_ms: u64,
    /// What is really sensed.
    pub inputs: &'a Inputs,
    /// What the world is really driven by.
    pub outputs: &'a Outputs,
    /// Why, as the device says.
    pub causes: &'a Causes,
    /// What the monitor is set to.
    pub params: &'a Params,
    /// Which subsystems there are.
    pub device: &'a Device,
    /// What it reports.
    pub told: Told,
    /// True positions, in the coordinates of the encoders.
    pub positions: [f64; AXES],
    /// What is added to readings of position sensors that have been homed (§D/7), by [`Axis`].
    pub offsets: [i32; AXES],
    /// True speeds, arc-minutes or mm per second.
    pub speeds: [f64; AXES],
    /// How fast the drives can go.
    pub max_speeds: [f64; AXES],
    /// Whether the barrel truly is in its working position.
    pub deployed: bool,
    /// Whether water truly flows into a folded barrel.
    pub flooded: bool,
    /// Which valves of the monitor truly are not closed.
    pub wet: [bool; VALVES],
    /// What is broken.
    pub faults: &'a [Fault],
}

impl<'a> View<'a> {
    /// What there is to see of a simulation.
    pub fn of(sim: &'a Sim, told: Told) -> Self {
        let (world, device) = (sim.world(), sim.device());
        Self {
            now_ms: sim.now_ms(),
            inputs: world.inputs(),
            outputs: world.outputs(),
            causes: device.causes(),
            params: device.params(),
            device,
            told,
            positions: Axis::ALL.map(|axis| {
                let drive = &world.drives[axis as usize];
                drive.position - drive.spec.encoder_zero
            }),
            offsets: [0; AXES],
            speeds: Axis::ALL.map(|axis| world.drives[axis as usize].speed),
            max_speeds: Axis::ALL.map(|axis| world.drives[axis as usize].spec.max_speed),
            deployed: world.deployed(),
            flooded: world.flooded(),
            wet: ValveNo::ALL.map(|valve| {
                device.has(valve.id()) && world.valves[valve as usize].free_area() > 0.0
            }),
            faults: world.faults.active(),
        }
    }
}

/// The drive of a subsystem.
pub fn axis_of(id: SubsystemId) -> Option<Axis> {
    Axis::ALL.into_iter().find(|axis| axis.id() == id)
}

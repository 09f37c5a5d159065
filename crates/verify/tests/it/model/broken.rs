//! Faulty monitors: a device, and around it a defect.
#![allow(dead_code, reason = "a module of interlock.rs; by itself it has no tests")]

use lafet_device::guard::Passed;
use lafet_device::hal::{Hal, Key, Storage, StorageError};
use lafet_device::image::{Axis, Inputs, Outputs, ValveOutput};
use lafet_device::{Composition, Device};
use lafet_proto::id::key;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Answer, Request, RequestId, Status, SubsystemId};
use lafet_verify::model::monitor::Monitor;
use lafet_verify::model::plant::Plant;
use std::fmt::Debug;

/// MaxLimit of the deployer in the small configuration.
const DEPLOYED_ARCMIN: i32 = 1200;

/// A defect. By default nothing is wrong.
pub trait Defect: Clone + Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// Called with a request before the device; `false` keeps it from the device.
    fn hears(&mut self, _body: &Body<'_>) -> bool {
        true
    }

    /// An answer instead of the device's.
    fn answers(&self, _body: &Body<'_>) -> Option<Status> {
        None
    }

    /// Changes what the device senses.
    fn sensed(&self, _inputs: &mut Inputs) {}

    /// Changes the outputs; the inputs are the true ones.
    fn driven(&self, _inputs: &Inputs, _outputs: &mut Outputs) {}

    /// A request made by the monitor itself.
    fn asks(&mut self) -> Option<Request<'static>> {
        None
    }

    /// Whether a value of this length survives in the memory.
    fn remembers(&self, _len: usize) -> bool {
        true
    }

    /// State besides the device.
    fn extra(&self) -> u32 {
        0
    }
}

/// A monitor with a defect.
#[derive(Clone, Debug)]
pub struct Broken<D> {
    device: Device,
    defect: D,
}

struct Bent<'a, D> {
    plant: &'a mut Plant,
    defect: D,
}

impl<D: Defect> Storage for Bent<'_, D> {
    fn load<'b>(
        &mut self,
        key: Key,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, StorageError> {
        let value = self.plant.load(key, buffer)?;
        Ok(value.filter(|value| self.defect.remembers(value.len())))
    }

    fn store(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        self.plant.store(key, value)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.plant.erase()
    }
}

impl<D: Defect> Hal for Bent<'_, D> {
    fn read(&mut self, inputs: &mut Inputs) {
        self.plant.read(inputs);
        self.defect.sensed(inputs);
    }

    fn write(&mut self, outputs: &Passed) {
        let mut inputs = Inputs::default();
        self.plant.read(&mut inputs);
        let mut outputs = **outputs;
        self.defect.driven(&inputs, &mut outputs);
        self.plant.drive(outputs);
    }

    fn reset(&mut self) {
        self.plant.reset();
    }
}

impl<D: Defect> Monitor for Broken<D> {
    fn power_up(now_ms: u32, composition: &Composition, plant: &mut Plant) -> Self {
        let defect = D::default();
        let mut bent = Bent { plant, defect };
        Self { device: Device::power_up(now_ms, composition, 1, None, &mut bent), defect }
    }

    fn handle(&mut self, now_ms: u32, payload: &[u8], out: &mut [u8]) -> usize {
        let request = Records::new(payload).flatten().next().map(|record| {
            (record, Request::decode(&record).expect("the model's requests are valid"))
        });
        let Some((record, request)) = request else { return 0 };
        if let Some(status) = self.defect.answers(&request.body) {
            let mut writer = Writer::new(out);
            let from = if status == Status::DENIED { SubsystemId::GENERAL } else { record.device };
            Answer::bare(from, record.request, status).encode(&mut writer).unwrap();
            return if status == Status::OK && request.body == Body::Deploy {
                0
            } else {
                writer.len()
            };
        }
        if self.defect.hears(&request.body) {
            return Monitor::handle(&mut self.device, now_ms, payload, out);
        }
        Monitor::handle(&mut self.device.clone(), now_ms, payload, out)
    }

    fn step(&mut self, now_ms: u32, plant: &mut Plant) {
        if let Some(request) = self.defect.asks() {
            let mut payload = [0; 64];
            let mut writer = Writer::new(&mut payload);
            request.encode(&mut writer).unwrap();
            let len = writer.len();
            Monitor::handle(&mut self.device, now_ms, &payload[..len], &mut [0; 512]);
        }
        self.device.step(now_ms, &mut Bent { plant, defect: self.defect });
    }

    fn device(&self) -> &Device {
        &self.device
    }

    fn extra(&self) -> u32 {
        self.defect.extra()
    }
}

macro_rules! defect {
    ($(#[$doc:meta])* $monitor:ident $defect:ident { $($body:tt)* }) => {
        $(#[$doc])*
        pub type $monitor = Broken<$defect>;

        #[doc = concat!("The defect of [`", stringify!($monitor), "`].")]
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $defect;

        impl Defect for $defect { $($body)* }
    };
}

defect! {
    /// Is always Busy and does nothing: no law is broken.
    Deaf Nothing {
        fn answers(&self, body: &Body<'_>) -> Option<Status> {
            (*body != Body::GetStatus).then_some(Status::BUSY)
        }
    }
}

defect! {
    /// Answers Ok to Lockout without executing it.
    IgnoresLockout LockoutUnheard {
        fn hears(&mut self, body: &Body<'_>) -> bool {
            body.id() != RequestId::LOCKOUT
        }
    }
}

defect! {
    /// Its memory loses the lockout.
    ForgetsLockout LockoutLost {
        fn remembers(&self, len: usize) -> bool {
            // The lockout is the only value this short.
            len > 4
        }
    }
}

defect! {
    /// Keeps turning, whatever the outputs, as long as there was motion before.
    RunsOn Inertia {
        fn driven(&self, inputs: &Inputs, outputs: &mut Outputs) {
            let horizontal = Axis::Horizontal as usize;
            let speed = inputs.drives[horizontal].speed_tenths;
            if outputs.drives[horizontal].speed_tenths == 0 {
                outputs.drives[horizontal].speed_tenths = speed;
            }
        }
    }
}

defect! {
    /// Answers Ok to Stop All and continues.
    NeverStops StopUnheard {
        fn hears(&mut self, body: &Body<'_>) -> bool {
            *body != Body::Stop
        }
    }
}

defect! {
    /// Always senses that it is deployed, by its switches and by its position.
    AlwaysDeployed SwitchIgnored {
        fn sensed(&self, inputs: &mut Inputs) {
            let deployer = &mut inputs.drives[Axis::Deployer as usize];
            (deployer.min_switch, deployer.max_switch) = (false, true);
            deployer.position = DEPLOYED_ARCMIN;
        }
    }
}

defect! {
    /// Its switches always say that it is deployed; its position is right.
    SwitchSticks SwitchContradicted {
        fn sensed(&self, inputs: &mut Inputs) {
            let deployer = &mut inputs.drives[Axis::Deployer as usize];
            (deployer.min_switch, deployer.max_switch) = (false, true);
        }
    }
}

defect! {
    /// Always senses that every valve is closed.
    SeesNoWater WaterIgnored {
        fn sensed(&self, inputs: &mut Inputs) {
            for valve in &mut inputs.valves {
                (valve.open_switch, valve.close_switch) = (false, true);
            }
        }
    }
}

defect! {
    /// Opens where it should close.
    OpensUnasked OutputFlipped {
        fn driven(&self, _: &Inputs, outputs: &mut Outputs) {
            for valve in &mut outputs.valves {
                if *valve == ValveOutput::Closing {
                    *valve = ValveOutput::Opening;
                }
            }
        }
    }
}

defect! {
    /// Stops not at a limit but at the end switch.
    Overruns LimitIgnored {
        fn driven(&self, inputs: &Inputs, outputs: &mut Outputs) {
            let horizontal = Axis::Horizontal as usize;
            let input = &inputs.drives[horizontal];
            let output = &mut outputs.drives[horizontal];
            if output.speed_tenths == 0 && input.speed_tenths != 0 && !input.max_switch {
                output.speed_tenths = input.speed_tenths;
            }
        }
    }
}

defect! {
    /// Opens during a search.
    OpensInSearch Unguarded {
        fn answers(&self, body: &Body<'_>) -> Option<Status> {
            matches!(body, Body::Open { .. }).then_some(Status::ACCEPTED)
        }
    }
}

/// Restarts the last program after a lockout.
pub type Resumes = Broken<Comeback>;

/// The defect of [`Resumes`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Comeback {
    program: bool,
    locked: bool,
    due: bool,
}

impl Defect for Comeback {
    fn hears(&mut self, body: &Body<'_>) -> bool {
        match body {
            Body::StartQuench(_) => self.program = true,
            Body::Lockout { key: key::ENABLE } => self.locked = true,
            Body::Lockout { .. } => {
                self.due = self.program && self.locked;
                self.locked = false;
            }
            _ => {}
        }
        true
    }

    fn asks(&mut self) -> Option<Request<'static>> {
        std::mem::take(&mut self.due).then_some(lafet_verify::model::ask::QUENCH)
    }

    fn extra(&self) -> u32 {
        u32::from(self.program) | u32::from(self.locked) << 1 | u32::from(self.due) << 2
    }
}

/// Does not answer Deploy.
pub type Silent = Broken<Mute>;

/// The defect of [`Silent`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mute;

impl Defect for Mute {
    fn answers(&self, body: &Body<'_>) -> Option<Status> {
        (*body == Body::Deploy).then_some(Status::OK)
    }
}

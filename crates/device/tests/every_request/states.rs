//! Monitors in their states.

use crate::common::Rig;
use crate::tables::VALVE2;
use lafet_device::Composition;
use lafet_proto::SubsystemId;
use lafet_proto::flags::DeployerFlags;
use lafet_proto::request::{Body, Quench, Sector, Seek};

/// What the state of the monitor says to everything.
#[derive(Clone, Copy, PartialEq)]
pub enum Gate {
    Open,
    Locked,
    Restarting,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Place {
    Wrapped,
    Deployed,
    OnTheWay,
    Between,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Operation {
    None,
    Search,
    Justification,
    Program,
}

/// A monitor in a state, and what the rules must know of it.
pub struct State {
    pub name: &'static str,
    pub rig: Rig,
    pub gate: Gate,
    /// Where a Deployer is; a monitor without one counts as deployed.
    pub place: Place,
    pub operation: Operation,
    /// The valve that is not closed.
    pub open: Option<u8>,
    /// Nothing is stored.
    pub erased: bool,
    /// Drives have limit switches.
    pub switches: bool,
}

impl State {
    /// Deployed and idle.
    fn of(name: &'static str, rig: Rig) -> Self {
        Self {
            name,
            rig,
            gate: Gate::Open,
            place: Place::Deployed,
            operation: Operation::None,
            open: None,
            erased: false,
            switches: false,
        }
    }

    pub fn has(&self, device: u8) -> bool {
        self.rig.device.has(SubsystemId(device))
    }
}

/// A monitor that does this, and has started to.
pub fn doing(to: SubsystemId, body: Body<'_>, flag: u32) -> Rig {
    let mut rig = if to == SubsystemId::DEPLOYER { wrapped() } else { Rig::deployed() };
    rig.accepts(to, body);
    rig.run(400);
    assert!(rig.flags(to) & flag != 0, "{body:?}");
    rig
}

pub fn wrapped() -> Rig {
    let mut rig = Rig::new(Composition::FULL);
    assert!(rig.deployer().contains(DeployerFlags::WRAPPED));
    rig
}

pub fn states() -> Vec<State> {
    let mut locked = Rig::deployed();
    locked.all_accept(Body::Lockout { key: 0x2FFA });
    locked.run(100);
    let mut restarting = Rig::deployed();
    restarting.all_accept(Body::Restart);
    restarting.run(50);
    let mut erased = Rig::new(Composition::FULL);
    erased.accepts(SubsystemId::GENERAL, Body::CleanFlash { key: 0xA4F6 });
    erased.run(500);
    assert!(erased.plant.memory.is_empty() && erased.plant.resets == 1);
    let switches = Rig::new(Composition { drives: [SWITCHES; 4], ..Composition::REMOTE });
    let deploying = doing(SubsystemId::DEPLOYER, Body::Deploy, 1 << 29);
    let mut between = deploying.clone();
    between.accepts(SubsystemId::DEPLOYER, Body::Stop);
    between.run(100);
    let mut seek = Seek { start_h: -900, end_h: 900, start_v: 0, end_v: 600, analyse: 0 };
    let seeking = doing(SubsystemId::DETECTOR, Body::StartSeek(seek), 1 << 16);
    seek.analyse = 1;
    let mut waiting = wrapped();
    waiting.accepts(SubsystemId::DETECTOR, Body::StartSeek(seek));
    waiting.run(400);
    let sector = Sector { nozzle: 40, width: 600, height: 300, step: 1, ..Sector::default() };
    let quench = Body::StartQuench(Quench::Full { sector, distance: 0 });
    let quenching = doing(SubsystemId::CONTROL, quench, 1 << 16);
    let justifying = doing(SubsystemId::DETECTOR, Body::StartJustify, 1 << 21);
    let open = doing(SubsystemId::VALVE2, Body::Open { key: 0x4C70 }, 1 << 16);
    let with = |place, operation, name, rig| State { place, operation, ..State::of(name, rig) };
    vec![
        with(Place::Wrapped, Operation::None, "wrapped", wrapped()),
        with(Place::OnTheWay, Operation::None, "deploying", deploying),
        with(Place::Between, Operation::None, "in between", between),
        State::of("deployed", Rig::deployed()),
        with(Place::Deployed, Operation::Search, "searching", seeking),
        with(Place::OnTheWay, Operation::Search, "search that deploys", waiting),
        with(Place::Deployed, Operation::Justification, "justifying", justifying),
        with(Place::Deployed, Operation::Program, "quenching", quenching),
        State { open: Some(VALVE2), ..State::of("with open valve", open) },
        State { gate: Gate::Locked, ..State::of("locked out", locked) },
        State { gate: Gate::Restarting, ..State::of("restarting", restarting) },
        State { place: Place::Wrapped, erased: true, ..State::of("erased", erased) },
        State::of("without Deployer", Rig::new(Composition::REMOTE)),
        State { switches: true, ..State::of("limit switches", switches) },
    ]
}

pub const SWITCHES: lafet_device::composition::DriveKind =
    lafet_device::composition::DriveKind::LimitSwitches;

//! What a monitor holds, and how it is asked.

use lafet_device::Source;
use lafet_proto::flags::GeneralFlags;
use lafet_proto::param::Param;
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Ints, Request, Status, SubsystemId};
use lafet_sim::sim::{Config, Sim};

/// Everything that a start finds, and whether it found it in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    pub numbers: Vec<i32>,
    pub programs: Vec<[i16; 7]>,
    pub trajectories: Vec<Vec<[u8; 6]>>,
    pub corrections: Vec<Option<i8>>,
    pub locked: bool,
    /// Subsystems whose set is incomplete.
    pub incomplete: Vec<SubsystemId>,
}

impl Held {
    /// Panics when anything could not be read: no power cut may lead to that.
    pub fn by(sim: &mut Sim, what: &dyn Fn() -> String) -> Self {
        let params = sim.device().params();
        for id in SubsystemId::TABLE {
            assert!(!params.has_read_fault(id), "{}: ConfigFault of {id}", what());
        }
        let table = SubsystemId::TABLE.into_iter();
        let trajectory =
            |number| params.trajectory(number).iter().map(|point| point.to_bytes()).collect();
        let mut held = Self {
            numbers: Param::ALL.into_iter().map(|param| params.get(param)).collect(),
            programs: (0..8).map(|number| params.program(number).unwrap()).collect(),
            trajectories: (0..8).map(trajectory).collect(),
            corrections: (0..256).map(|pressure| params.correction(pressure)).collect(),
            locked: false,
            incomplete: table.filter(|id| params.is_incomplete(*id)).collect(),
        };
        held.locked = is_locked(sim);
        held
    }
}

pub fn is_locked(sim: &mut Sim) -> bool {
    let mut flags = 0;
    sim.ask(SubsystemId::GENERAL, Body::GetStatus, |answer| {
        flags = answer.data.flags_bits().unwrap();
    });
    GeneralFlags::from_bits_retain(flags).contains(GeneralFlags::LOCKED_OUT)
}

/// Asks; the last answer's status, which is General's when all answer.
pub fn ask(sim: &mut Sim, to: SubsystemId, body: Body<'_>) -> Status {
    let mut buffer = [0; 260];
    let mut writer = Writer::new(&mut buffer);
    Request::new(to, body).encode(&mut writer).unwrap();
    let answers = sim.request(Source::ExternalConn, writer.written());
    Records::new(&answers).flatten().last().unwrap().status
}

pub fn set(sim: &mut Sim, param: Param, values: &[i32]) -> Status {
    let spec = param.spec();
    ask(sim, spec.subsystem, Body::SetParam { id: spec.id, values: Ints::Values(values) })
}

/// Until nothing is left to be stored and the flash rests.
pub fn settle(sim: &mut Sim) {
    for _ in 0..200 {
        sim.tick();
        if sim.device().params().is_stored() && !sim.world().is_stalled() {
            return;
        }
    }
    panic!("never stored");
}

/// Wrapped, every motor at rest.
pub fn monitor(seed: u64) -> Sim {
    let mut sim = Sim::new(Config { seed, ..Config::default() });
    sim.advance_ms(300);
    assert!(sim.device().outputs().is_still());
    sim
}

pub fn starts(sim: &mut Sim) -> usize {
    use lafet_sim::event::What;
    let events = sim.world_mut().take_events();
    events.iter().filter(|event| event.what == What::PoweredUp).count()
}

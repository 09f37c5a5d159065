//! What a picture of the monitor needs, and its state as GetStatus shows it.

use lafet_device::Source;
use lafet_device::image::Axis;
use lafet_proto::answer::Reply;
use lafet_proto::dictionary::{self, layouts};
use lafet_proto::record::{Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Answer, Request, RequestId, SubsystemId, flags};
use lafet_sim::sim::Sim;
use lafet_texts::Text as _;

use crate::anatomy::{flags_of, severity, shown};
use crate::view::{Burning, Scene, State, Value, Water};
use crate::walk::word;

/// Points of the jet's path.
const POINTS: u32 = 24;
/// Slower than this is at rest, units/s.
const STILL: f64 = 1e-3;

impl Scene {
    /// As everything truly is.
    pub fn of(sim: &Sim) -> Self {
        let world = sim.world();
        let [elevation, azimuth, nozzle, deployer] = &world.drives;
        let (stowed, deployed) = deployer.spec.switches;
        let motion = [elevation, azimuth, nozzle, deployer].map(|drive| match drive.speed {
            speed if speed > STILL => 1,
            speed if speed < -STILL => -1,
            _ => 0,
        });
        let fires = world.fires.iter().map(|fire| Burning {
            at: [fire.at.0, fire.at.1],
            size_m: fire.size_m,
            heat: fire.heat,
        });
        let folds = sim.device().has(SubsystemId::DEPLOYER);
        let way = ((deployer.position - stowed) / (deployed - stowed)).clamp(0.0, 1.0);
        Self {
            azimuth: azimuth.position / 60.0,
            elevation: elevation.position / 60.0,
            nozzle_mm: nozzle.position,
            deployment: if folds { way } else { 1.0 },
            deployed: world.deployed(),
            motion,
            valves: [world.valves[0].opening, world.valves[1].opening],
            pressure_atm: world.water.pressure_atm(),
            flow_lps: world.water.flow_lps,
            limits: limits(sim),
            height_m: world.height_m,
            water: water(sim),
            fires: fires.collect(),
            wind: [world.wind.0, world.wind.1],
        }
    }
}

fn water(sim: &Sim) -> Option<Water> {
    let landing = sim.world().landing()?;
    let jet = sim.world().jet();
    let points = (0..=POINTS).map(|point| {
        let (distance, height) = jet.after(landing.flight_s * f64::from(point) / f64::from(POINTS));
        [distance, height.max(0.0)]
    });
    Some(Water {
        arc: points.collect(),
        at: [landing.at.0, landing.at.1],
        along_m: landing.along_m,
        across_m: landing.across_m,
        heading: landing.heading,
    })
}

/// The records that a copy of the monitor answers: a look changes nothing.
fn ask(sim: &Sim, to: SubsystemId, body: Body<'_>) -> Vec<u8> {
    let mut buffer = [0; 8];
    let mut writer = Writer::new(&mut buffer);
    match Request::new(to, body).encode(&mut writer) {
        Ok(()) => sim.clone().handle(Source::ExternalConn, writer.written()),
        Err(_) => Vec::new(),
    }
}

fn limits(sim: &Sim) -> Option<[f64; 4]> {
    let of = |axis: Axis| {
        let bytes = ask(sim, axis.id(), Body::RetrieveLimits);
        let record = Records::new(&bytes).flatten().next()?;
        match Answer::decode(&record).ok()?.data {
            Reply::Limits(it) => Some([f64::from(it.min) / 60.0, f64::from(it.max) / 60.0]),
            _ => None,
        }
    };
    let ([left, right], [low, high]) = (of(Axis::Horizontal)?, of(Axis::Vertical)?);
    Some([left, right, low, high])
}

/// Every subsystem, as a client sees it.
pub fn states(sim: &Sim) -> Vec<State> {
    let bytes = ask(sim, SubsystemId::ALL, Body::GetStatus);
    let state = |record: lafet_proto::Record<'_>| {
        let id = record.device;
        let bits = Answer::decode(&record).map(|answer| word(&answer.data)).unwrap_or_default();
        let layouts = layouts::of_answer(RequestId::GET_STATUS, id);
        let layout = layouts.iter().find(|layout| layout.fits(record.data));
        let values = layout.into_iter().flat_map(|layout| layout.values(record.data));
        let values = values.filter(|(_, field, _)| field.kind != layouts::Kind::Flags);
        let invalid = |name| dictionary::invalid(id, bits).any(|(field, _)| field == name);
        State {
            name: id.to_string(),
            title: dictionary::subsystem(id).map(|info| info.title.words()).unwrap_or_default(),
            severity: severity(flags::flags_of(id).severity(bits)),
            values: values
                .map(|(_, field, value)| Value {
                    name: field.name.to_owned(),
                    value: shown(field.unit, value),
                    meaning: field.text.words(),
                    invalid: invalid(field.name),
                })
                .collect(),
            flags: flags_of(id, bits),
        }
    };
    Records::new(&bytes).flatten().map(state).collect()
}

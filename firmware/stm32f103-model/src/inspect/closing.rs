//! Water is turned off, whatever else of the board fails.

use lafet_device::image::ValveNo;
use lafet_proto::SubsystemId;
use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_sim::fault::{Fault, ValveFault};
use lafet_stm32f103::record::Record;

use super::starts::restart;
use super::{deployed, ensure, is_live, near};
use crate::rig::{Rig, Wrong};

/// ADC1_CR2: without its lowest bit nothing is converted.
const ADC_CONTROL: u32 = 0x4001_2408;
/// A valve takes 5 s.
const CLOSED_MS: u64 = 8_000;

fn opening(rig: &Rig) -> [f64; 2] {
    rig.parts(|parts| [0, 1].map(|valve| parts.plant.world.valves[valve].opening))
}

fn with_water(wrong: Wrong) -> Result<Rig, String> {
    let mut rig = deployed(wrong)?;
    for id in [SubsystemId::VALVE1, SubsystemId::VALVE2] {
        rig.order(id, Body::Open { key: key::OPEN })?;
    }
    rig.run(CLOSED_MS);
    near("open valves", opening(&rig).iter().sum(), 2.0, 0.01)?;
    Ok(rig)
}

/// Close, Lockout and a power-up close valves without samples and without a record; nothing else is driven.
pub(super) fn whatever_fails(wrong: Wrong) -> Result<(), String> {
    let close = (SubsystemId::VALVE1, Body::Close { key: key::CLOSE });
    let lockout = (SubsystemId::ALL, Body::Lockout { key: key::ENABLE });
    let mut rig = with_water(wrong)?;
    let open = rig.save();
    for (to, body) in [close, lockout] {
        rig.restore(&open);
        rig.parts(|parts| _ = parts.chip.write(ADC_CONTROL, 0));
        rig.run(50);
        rig.order(to, body)?;
        rig.run(CLOSED_MS);
        near("valve 1 without ADC", opening(&rig)[0], 0.0, 0.01)?;
        ensure(!is_live(&rig), "a motor has voltage without ADC")?;
        let _ = rig.ask(SubsystemId::VALVE1, Body::Open { key: key::OPEN })?;
        rig.run(1_000);
        near("valve 1, opened without ADC", opening(&rig)[0], 0.0, 0.01)?;
    }
    rig.restore(&open);
    let mut damaged = Record::NOMINAL.encode();
    damaged[24] ^= 1;
    restart(&mut rig, &damaged, false);
    ensure(!rig.has_record(), "a damaged record is taken")?;
    rig.run(CLOSED_MS);
    near("valves without a record", opening(&rig).iter().sum(), 0.0, 0.01)?;
    ensure(!is_live(&rig), "a motor has voltage without a record")
}

/// The valves share a sensor of current: one that jams does not keep the other open, and rests at last.
pub(super) fn beside_a_jam(wrong: Wrong) -> Result<(), String> {
    let mut rig = with_water(wrong)?;
    let jam = Fault::Valve(ValveNo::Valve2, ValveFault::Jam);
    rig.parts(|parts| parts.plant.world.inject(jam));
    rig.cut_power();
    rig.run(CLOSED_MS);
    near("valve 1 beside a jam", opening(&rig)[0], 0.0, 0.01)?;
    rig.run(30_000);
    let on = rig.parts(|parts| parts.plant.relays(&parts.chip));
    ensure(on == [[false; 2]; 2], "a jammed valve is fed without end")
}

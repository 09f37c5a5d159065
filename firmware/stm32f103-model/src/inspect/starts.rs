//! What a start finds: the memory, the positions, a crystal, a blank flash.

use lafet_device::hal::FaultInfo;
use lafet_device::image::Axis;
use lafet_proto::crash::Context;
use lafet_proto::flags::DriveFlags;
use lafet_proto::id::key;
use lafet_proto::request::Body;
use lafet_proto::{Ints, ParamId, SubsystemId};
use lafet_stm32f103::record::{Record, START};

use super::{deployed, drive_flags, ensure, fresh, is_live, near, position_of, truth};
use crate::chip::Reset;
use crate::image;
use crate::rig::{Rig, Wrong};

/// Parameters survive power cuts, however often the pages go round.
pub(super) fn memory(wrong: Wrong) -> Result<(), String> {
    let mut rig = fresh(wrong);
    let id = ParamId::of("Speed");
    for (round, speed) in (0..24).zip([7, 8, 9, 10].into_iter().cycle()) {
        let values = [speed];
        let body = Body::SetParam { id, values: Ints::Values(&values) };
        rig.order(SubsystemId::VERTICAL, body)?;
        rig.run(150);
        if round % 8 == 7 {
            rig.cut_power();
            rig.run(300);
        }
        let answers = rig.ask(SubsystemId::VERTICAL, Body::GetParam { id })?;
        let data = answers.first().map(|(_, _, data)| data.clone()).unwrap_or_default();
        let stored = data.get(2..6).map(|bytes| bytes.to_vec());
        ensure(stored == Some(values[0].to_le_bytes().to_vec()), format!("{speed}: {data:?}"))?;
        let address = rig.device.address();
        ensure(address == 7, format!("the address is {address}"))?;
    }
    let broken = rig.parts(|parts| parts.chip.violations.clone());
    ensure(broken.is_empty(), format!("{broken:?}"))
}

/// A drive at rest keeps its position over a power cut; one in motion reports that it has lost it.
pub(super) fn position(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 600 })?;
    rig.run(6_000);
    rig.cut_power();
    rig.run(500);
    near("position after a power cut", position_of(&rig, Axis::Horizontal), 600.0, 6.0)?;
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    ensure(!found.contains(DriveFlags::POS_ENCODER_FAULT), format!("{found:?}"))?;
    // Restart stops a motion in order, and the position is known behind it.
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 3_000 })?;
    rig.run(800);
    rig.order(SubsystemId::ALL, Body::Restart)?;
    rig.run(1_000);
    ensure(rig.resets.last() == Some(&Reset::Software), format!("{:?}", rig.resets))?;
    let (got, wanted) = (position_of(&rig, Axis::Horizontal), truth(&rig, Axis::Horizontal));
    near("position after Restart in motion", got, wanted, 6.0)?;
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    ensure(
        !found.contains(DriveFlags::POS_ENCODER_FAULT),
        format!("Restart in motion: {found:?}"),
    )?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: -1_200 })?;
    rig.run(800);
    rig.cut_power();
    rig.run(500);
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    ensure(
        found.contains(DriveFlags::POS_ENCODER_FAULT),
        "power was cut in motion, and all is well",
    )?;
    ensure(!is_live(&rig), "a motor has voltage after a power cut")
}

/// A drive that is homed comes back from a reset in motion: slowly to its end switch, and then it knows where
/// it is. Of the others, whose position is lost, none moves.
pub(super) fn homing(wrong: Wrong) -> Result<(), String> {
    let mut own = Record::NOMINAL;
    (wrong.record)(&mut own);
    let mut rig = deployed(wrong)?;
    for (name, value) in [("Homing", 1), ("HomePosition", own.drives[0].ends.0)] {
        let (id, values) = (ParamId::of(name), [value]);
        let body = Body::SetParam { id, values: Ints::Values(&values) };
        rig.order(SubsystemId::VERTICAL, body)?;
        rig.run(300);
    }
    rig.order(SubsystemId::VERTICAL, Body::Move { destination: 1_200 })?;
    rig.run(800);
    rig.cut_power();
    rig.run(500);
    let found = drive_flags(&mut rig, Axis::Vertical)?;
    let homes = found & (DriveFlags::POS_ENCODER_FAULT | DriveFlags::LIMITLESS);
    ensure(homes == DriveFlags::LIMITLESS, format!("to be homed, and says {found:?}"))?;
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    let lost = found.contains(DriveFlags::POS_ENCODER_FAULT);
    ensure(lost, format!("its position is lost, and it says {found:?}"))?;
    rig.order(SubsystemId::VERTICAL, Body::Move { destination: -32_767 })?;
    let mut homed = false;
    for _ in 0..120 {
        rig.run(500);
        homed |= !drive_flags(&mut rig, Axis::Vertical)?.contains(DriveFlags::LIMITLESS);
        if homed {
            break;
        }
    }
    ensure(homed, "it is not homed at its end")?;
    rig.order(SubsystemId::VERTICAL, Body::Move { destination: 300 })?;
    rig.run(15_000);
    near("position of a drive that was homed", truth(&rig, Axis::Vertical), 300.0, 10.0)
}

type Change = fn(&mut Record);

/// Counts that were kept under another record mean no position, and none do without a record.
pub(super) fn record(wrong: Wrong) -> Result<(), String> {
    let mut own = Record::NOMINAL;
    (wrong.record)(&mut own);
    let others: [(&str, Change); 5] = [
        ("another scale", |it| it.drives[1].counts_per_100 /= 2),
        ("another sign", |it| it.drives[0].counts_per_100 *= -1),
        ("parked elsewhere", |it| it.drives[1].parked += 90),
        ("ends moved", |it| it.drives[2].ends.1 += 1),
        ("drives exchanged", |it| it.drives.swap(0, 1)),
    ];
    let mut rig = deployed(wrong)?;
    for (what, change) in others {
        let mut other = own;
        change(&mut other);
        restart(&mut rig, &other.encode(), false);
        ensure(rig.has_record(), format!("{what}: no record"))?;
        ensure(!believes(&mut rig)?, format!("{what}, and the old position is believed"))?;
        restart(&mut rig, &own.encode(), false);
        ensure(believes(&mut rig)?, format!("{what} and back, nothing has moved: not believed"))?;
    }
    let mut damaged = own.encode();
    damaged[24] ^= 1;
    for parked in [false, true] {
        restart(&mut rig, &damaged, parked);
        ensure(!rig.has_record(), "a damaged record is taken")?;
        rig.parts(|parts| parts.chip.line_baud = 19_200);
        ensure(!believes(&mut rig)?, "a position is believed without a record")?;
    }
    let mut rig = fresh(wrong);
    let mut other = own;
    other.drives[1].counts_per_100 += 1;
    restart(&mut rig, &other.encode(), true);
    ensure(believes(&mut rig)?, "parked under a new record, and not believed")?;
    restart(&mut rig, &other.encode(), false);
    ensure(believes(&mut rig)?, "kept under the new record, and not believed")
}

/// Switches on with this record, with or without the jumper.
pub(super) fn restart(rig: &mut Rig, record: &[u8], parked: bool) {
    rig.parts(|parts| {
        parts.chip.program(START, record);
        parts.plant.parked = parked;
    });
    rig.cut_power();
    rig.run(500);
}

/// Whether all drives know where they are; they know it together.
fn believes(rig: &mut Rig) -> Result<bool, String> {
    let mut faulty = 0;
    for axis in Axis::ALL {
        let found = drive_flags(rig, axis)?;
        faulty += u8::from(found.contains(DriveFlags::POS_ENCODER_FAULT));
    }
    match faulty {
        0 => Ok(true),
        4 => Ok(false),
        _ => Err(format!("{faulty} of four drives do not know where they are")),
    }
}

/// Without its crystal the chip runs, and says so; one that fails in motion stops it.
pub(super) fn crystal(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 3_000 })?;
    rig.run(500);
    rig.parts(|parts| parts.chip.crystal = false);
    rig.hang(100_000);
    ensure(!is_live(&rig), "drives run on without a clock")?;
    rig.run(500);
    ensure(rig.resets == [Reset::Clock], format!("{:?}", rig.resets))?;
    let hz = rig.parts(|parts| parts.chip.hz());
    ensure(hz == 64_000_000, format!("runs at {hz} Hz"))?;
    says_nmi(&mut rig)?;
    ensure(!is_live(&rig), "a motor has voltage after the failure")?;
    // Dead from the power-up on, it interrupts nothing.
    rig.cut_power();
    rig.run(500);
    says_nmi(&mut rig)
}

/// The crystal is the last fault: exception 2.
fn says_nmi(rig: &mut Rig) -> Result<(), String> {
    let answers = rig.ask(SubsystemId::GENERAL, Body::GetCrashData)?;
    let data = answers.first().map(|(_, _, data)| data.clone()).unwrap_or_default();
    let context = FaultInfo::decode(&data).map(|info| info.context());
    ensure(context == Some(Context::Handler("NMI")), format!("no crystal, and says {context:?}"))
}

/// Without a record and parameters it answers, and drives nothing.
pub(super) fn blank(wrong: Wrong) -> Result<(), String> {
    let mut rig = Rig::with_flash(wrong, Vec::new(), image::flash(None));
    rig.parts(|parts| parts.chip.line_baud = 19_200);
    rig.set_address(1);
    rig.run(300);
    ensure(!rig.has_record(), "a record in a blank flash")?;
    rig.ask(SubsystemId::GENERAL, Body::GetStatus)?;
    let _ = rig.ask(SubsystemId::DEPLOYER, Body::Deploy)?;
    let _ = rig.ask(SubsystemId::VALVE1, Body::Open { key: key::OPEN })?;
    rig.run(1_000);
    let relays = rig.parts(|parts| parts.plant.relays(&parts.chip));
    ensure(!is_live(&rig) && relays == [[false; 2]; 2], "a blank board drives something")
}

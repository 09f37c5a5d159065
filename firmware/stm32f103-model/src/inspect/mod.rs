//! Whether a board is as it should be: what is looked at before one is let near a motor, in the model.

mod busy;
mod closing;
pub mod iron;
mod starts;

use lafet_device::image::{Axis, Inputs};
use lafet_proto::flags::{DriveFlags, ValveFlags};
use lafet_proto::id::key;
use lafet_proto::record::Writer;
use lafet_proto::request::{Body, Quench, Sector};
use lafet_proto::{Request, SubsystemId};
use lafet_sim::fire::FireSpec;

use crate::chip::Reset;
use crate::plant::{DEPLOYER_AT, ENDS, RELAYS};
use crate::rig::{Rig, Wrong};
use starts::{blank, crystal, homing, memory, position, record};

/// A look at a board: what is wrong, if anything is.
pub type Check = fn(Wrong) -> Result<(), String>;

/// All of them, the quick ones first.
pub const CHECKS: [(&str, Check); 26] = [
    ("start", start),
    ("line", line),
    ("watchdog", watchdog),
    ("sensors", sensors),
    ("motion", motion),
    ("ends", ends),
    ("stop chain", stop_chain),
    ("read-back", read_back),
    ("supply", supply),
    ("stop", stop),
    ("valves", valves),
    ("closing", closing::whatever_fails),
    ("a jammed valve", closing::beside_a_jam),
    ("heaters", heaters),
    ("flow", flow),
    ("memory", memory),
    ("position", position),
    ("homing", homing),
    ("record", record),
    ("crystal", crystal),
    ("blank flash", blank),
    ("line while a page is erased", busy::release),
    ("memory in motion", busy::motion),
    ("stop while a page is erased", busy::stop),
    ("iron", iron::check),
    ("outputs with iron", iron::outputs),
];

const MS_NS: u64 = 1_000_000;
/// What a step may take of the processor: 54,000 cycles of 72 MHz.
const STEP_NS: u64 = 750_000;
/// From the opening of the stop chain until no motor has voltage, ns: the capacitance of its cable included.
const BREAK_NS: u64 = 10_000;

fn ensure(holds: bool, otherwise: impl Into<String>) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise.into()) }
}

fn near(what: &str, got: f64, wanted: f64, by: f64) -> Result<(), String> {
    ensure((got - wanted).abs() <= by, format!("{what}: {got:.1} instead of {wanted:.1}"))
}

fn sound(rig: &Rig) -> Result<(), String> {
    let broken = rig.parts(|parts| parts.chip.violations.clone());
    ensure(broken.is_empty(), format!("{broken:?}"))?;
    ensure(rig.resets.is_empty(), format!("{:?}", rig.resets))
}

fn is_live(rig: &Rig) -> bool {
    rig.parts(|parts| parts.plant.is_live(&parts.chip))
}

fn truth(rig: &Rig, axis: Axis) -> f64 {
    rig.parts(|parts| parts.plant.world.drives[axis as usize].position)
}

fn inputs(rig: &Rig) -> Inputs {
    rig.device.inputs().clone()
}

fn flags(rig: &mut Rig, id: SubsystemId) -> Result<u32, String> {
    let answers = rig.ask(id, Body::GetStatus)?;
    let data = answers.first().map(|(_, _, data)| data.clone()).unwrap_or_default();
    data.first_chunk().map(|bytes| u32::from_le_bytes(*bytes)).ok_or("no status".into())
}

fn drive_flags(rig: &mut Rig, axis: Axis) -> Result<DriveFlags, String> {
    flags(rig, axis.id()).map(DriveFlags::from_bits_retain)
}

fn fresh(wrong: Wrong) -> Rig {
    let mut rig = Rig::new(wrong, Vec::new());
    rig.run(300);
    rig
}

fn deployed(wrong: Wrong) -> Result<Rig, String> {
    deployed_beside(wrong, Vec::new())
}

fn deployed_beside(wrong: Wrong, fires: Vec<FireSpec>) -> Result<Rig, String> {
    let mut rig = Rig::new(wrong, fires);
    rig.run(300);
    rig.order(SubsystemId::DEPLOYER, Body::Deploy)?;
    let there = rig.run_until(25_000, |rig| {
        rig.parts(|parts| parts.plant.world.deployed()) && rig.device.inputs().drives[3].max_switch
    });
    ensure(there, "the deployer does not deploy")?;
    rig.run(500);
    sound(&rig)?;
    Ok(rig)
}

fn start(wrong: Wrong) -> Result<(), String> {
    let mut rig = fresh(wrong);
    sound(&rig)?;
    let hz = rig.parts(|parts| parts.chip.hz());
    ensure(hz == 72_000_000, format!("runs at {hz} Hz"))?;
    let pwm_hz = rig.parts(|parts| parts.chip.pwm_hz());
    near("PWM, Hz", pwm_hz, 20_000.0, 500.0)?;
    ensure(!is_live(&rig), "a motor has voltage at the start")?;
    ensure(rig.has_record(), "the record is not found")?;
    let faults: Vec<_> = Axis::ALL
        .into_iter()
        .filter(|axis| rig.device.inputs().drives[*axis as usize].motor_open)
        .collect();
    ensure(faults.is_empty(), format!("stages off without a reason: {faults:?}"))?;
    for axis in Axis::ALL {
        let found = drive_flags(&mut rig, axis)?;
        ensure(!found.contains(DriveFlags::POS_ENCODER_FAULT), format!("{axis:?}: {found:?}"))?;
    }
    ensure(rig.device.inputs().main_voltage_dv > 0, "nothing is sampled")?;
    rig.cut_power();
    let first = inputs(&rig);
    let warm = first.places.iter().all(|place| place.temperature_dc.is_some());
    ensure(warm && first.main_voltage_dv > 0, "nothing is sampled before the first request")
}

fn line(wrong: Wrong) -> Result<(), String> {
    let mut rig = fresh(wrong);
    // More than the ring of the receiver holds.
    for _ in 0..60 {
        let answers = rig.ask(SubsystemId::ALL, Body::GetStatus)?;
        ensure(answers.len() >= 10, format!("{} answers of all subsystems", answers.len()))?;
        rig.run(5);
        let held = rig.parts(|parts| parts.chip.holds_line());
        ensure(!held, "the transmitter holds the line")?;
    }
    // The next sender may start soon after the last stop bit.
    rig.parts(|parts| parts.chip.outgoing.clear());
    rig.send(&request(SubsystemId::ALL, Body::GetStatus)?);
    rig.run(60);
    let (last, released) = rig
        .parts(|parts| (parts.chip.outgoing.last().map(|byte| byte.at_ns), parts.chip.released_ns));
    let last = last.ok_or("nothing was sent")?;
    let held_ns = released.checked_sub(last).ok_or("the line was released before the last byte")?;
    ensure(held_ns <= 10_000, format!("the line was held {held_ns} ns behind the last byte"))?;
    sound(&rig)
}

fn watchdog(wrong: Wrong) -> Result<(), String> {
    let mut rig = Rig::before_steps(wrong, Vec::new());
    rig.hang(1_400 * MS_NS);
    let cause = rig.parts(|parts| parts.chip.reset);
    ensure(cause == Some(Reset::Watchdog), "without a step the watchdog does not bite in 1.4 s")?;
    let mut rig = fresh(wrong);
    rig.hang(600 * MS_NS);
    ensure(rig.parts(|parts| parts.chip.reset).is_none(), "the watchdog bites after 0.6 s")?;
    rig.run(300);
    rig.hang(1_400 * MS_NS);
    let cause = rig.parts(|parts| parts.chip.reset);
    ensure(cause == Some(Reset::Watchdog), "the watchdog does not bite in 1.4 s")?;
    rig.run(500);
    ensure(rig.resets == [Reset::Watchdog], format!("{:?}", rig.resets))?;
    ensure(!is_live(&rig), "a motor has voltage after the watchdog")
}

fn sensors(wrong: Wrong) -> Result<(), String> {
    let mut rig = fresh(wrong);
    rig.parts(|parts| {
        let climate = &mut parts.plant.world.climate;
        climate.places_c = [-20.0, 5.0, 31.0, 47.0, 60.0];
        climate.supply_v = 21.0;
        let drives = parts.plant.world.drives.iter_mut();
        for (drive, amperes) in drives.zip([4.0, 8.0, 16.0, 24.0]) {
            drive.current_a = amperes;
        }
    });
    // Before the currents fall again: the world moves each 10 ms.
    let mut seen = [0; 4];
    for _ in 0..100 {
        rig.round();
        for (most, drive) in seen.iter_mut().zip(&rig.device.inputs().drives) {
            *most = drive.current_da.max(*most);
        }
    }
    for (axis, (got, wanted)) in seen.into_iter().zip([40.0, 80.0, 160.0, 240.0]).enumerate() {
        near(&format!("current {axis}, 0.1 A"), f64::from(got), wanted, wanted / 3.0)?;
        ensure(got > 0, "no current")?;
    }
    rig.run(400);
    let (got, wanted) = (inputs(&rig), rig.parts(|parts| parts.plant.world.inputs().clone()));
    for (place, (got, wanted)) in got.places.iter().zip(&wanted.places).enumerate() {
        let tenths = |it: Option<i16>| f64::from(it.unwrap_or(-9_999));
        near(
            &format!("temperature {place}, 0.1 °C"),
            tenths(got.temperature_dc),
            tenths(wanted.temperature_dc),
            12.0,
        )?;
    }
    let dv = f64::from(got.main_voltage_dv);
    near("supply, 0.1 V", dv, wanted.main_voltage_dv.into(), 3.0)?;
    near("pressure loop, µA", got.pressure_ua.into(), wanted.pressure_ua.into(), 60.0)?;
    let percent = |it: Option<u8>| f64::from(it.unwrap_or(255));
    near("humidity, %", percent(got.humidity_percent), percent(wanted.humidity_percent), 2.0)
}

/// Each drive alone, in both directions: the right one moves, in the right direction, as far and as fast
/// as it should.
fn motion(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    let moves = [
        (Axis::Vertical, 1_500, 120.0),
        (Axis::Horizontal, -1_800, 200.0),
        (Axis::Nozzle, 20, 100.0),
        (Axis::Vertical, 300, -120.0),
        (Axis::Horizontal, 600, 200.0),
        (Axis::Nozzle, 50, 100.0),
    ];
    for (axis, destination, _) in moves {
        let before = Axis::ALL.map(|axis| truth(&rig, axis));
        rig.order(axis.id(), Body::Move { destination })?;
        let (mut fastest, mut seen) = (0_f64, 0_f64);
        let there = rig.run_until(25_000, |rig| {
            let drive = rig.parts(|parts| parts.plant.world.drives[axis as usize].clone());
            fastest = fastest.max(drive.speed.abs() / drive.spec.unit_per_tenth);
            seen = seen.max(rig.device.inputs().drives[axis as usize].speed_tenths.abs().into());
            (drive.position - f64::from(destination)).abs() <= 8.0 && drive.speed == 0.0
        });
        ensure(there, format!("{axis:?} is at {:.0}, not {destination}", truth(&rig, axis)))?;
        rig.run(300);
        let speed =
            f64::from(rig.device.params().drive(axis, lafet_proto::param::DriveParam::Speed));
        near(&format!("{axis:?}, greatest speed"), fastest, speed * 10.0, speed * 1.5)?;
        near(&format!("{axis:?}, speed as measured"), seen, fastest, 15.0)?;
        near(
            &format!("{axis:?}, position as measured"),
            position_of(&rig, axis),
            truth(&rig, axis),
            3.0,
        )?;
        for other in Axis::ALL.into_iter().filter(|other| *other != axis) {
            near(
                &format!("{other:?} beside {axis:?}"),
                truth(&rig, other),
                before[other as usize],
                3.0,
            )?;
        }
        let found = drive_flags(&mut rig, axis)?;
        let faults = DriveFlags::POS_ENCODER_FAULT
            | DriveFlags::SPEED_ENCODER_FAULT
            | DriveFlags::POSITION_WAY_FAULT
            | DriveFlags::SPEED_WAY_FAULT
            | DriveFlags::MOTOR_BROKEN
            | DriveFlags::INTERNAL_FAULT
            | DriveFlags::AMPERAGE_OVERLOAD;
        ensure(!found.intersects(faults), format!("{axis:?}: {found:?}"))?;
    }
    sound(&rig)
}

fn position_of(rig: &Rig, axis: Axis) -> f64 {
    rig.device.inputs().drives[axis as usize].position.into()
}

/// A broken wire of a switch is noticed, whichever it is.
fn ends(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    let (seen, at_rest) = (inputs(&rig), rig.save());
    for axis in [Axis::Vertical, Axis::Horizontal, Axis::Nozzle] {
        let drive = seen.drives[axis as usize];
        ensure(!drive.min_switch && !drive.max_switch, format!("{axis:?} is at an end"))?;
    }
    let wires = [
        (Axis::Vertical, ENDS[0][0]),
        (Axis::Vertical, ENDS[0][1]),
        (Axis::Horizontal, ENDS[1][0]),
        (Axis::Horizontal, ENDS[1][1]),
        (Axis::Deployer, ENDS[3][0]),
        (Axis::Deployer, DEPLOYER_AT[1]),
    ];
    for (axis, pin) in wires {
        rig.restore(&at_rest);
        if axis == Axis::Vertical {
            rig.order(axis.id(), Body::Move { destination: 1_500 })?;
            rig.run(4_000);
        }
        rig.parts(|parts| parts.plant.broken.insert(pin));
        rig.run(400);
        let found = drive_flags(&mut rig, axis)?;
        let reported = found.contains(DriveFlags::POS_ENCODER_FAULT);
        ensure(reported, format!("the wire of {pin:?} is broken, {axis:?} says {found:?}"))?;
    }
    rig.restore(&at_rest);
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 600 })?;
    rig.run(500);
    // Whichever side the switch of the direction is on, the motion ends there.
    rig.parts(|parts| parts.plant.broken.insert(ENDS[1][1]));
    rig.run(20);
    ensure(!is_live(&rig), "a drive goes on into its open end switch")
}

/// The stop chain takes the voltage away without the program, and nothing goes on by itself.
fn stop_chain(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 3_000 })?;
    rig.run(500);
    ensure(is_live(&rig), "the drive does not run")?;
    rig.parts(|parts| parts.plant.stop(&mut parts.chip, true));
    // The program hangs meanwhile.
    rig.hang(BREAK_NS);
    ensure(!is_live(&rig), "the stop chain alone stops nothing")?;
    rig.run(200);
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    ensure(found.contains(DriveFlags::MOTOR_BROKEN), format!("stopped, and says {found:?}"))?;
    rig.parts(|parts| parts.plant.stop(&mut parts.chip, false));
    rig.run(1_000);
    ensure(!is_live(&rig), "a drive goes on when the stop chain is closed")?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 0 })?;
    rig.run(500);
    ensure(is_live(&rig), "no drive runs after the stop chain was closed")?;
    // A comparator closes it again with the end of the current: the motion is over, and the report too.
    rig.parts(|parts| parts.plant.stop(&mut parts.chip, true));
    rig.hang(BREAK_NS);
    rig.parts(|parts| parts.plant.stop(&mut parts.chip, false));
    rig.run(500);
    ensure(!is_live(&rig), "a drive goes on after an overcurrent")?;
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    ensure(!found.contains(DriveFlags::MOTOR_BROKEN), format!("closed again, and says {found:?}"))
}

/// A shorted stage is cut off, a motor without voltage is reported.
fn read_back(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.parts(|parts| parts.plant.shorted[1] = true);
    rig.run(200);
    ensure(!is_live(&rig), "a shorted stage goes on driving")?;
    rig.run(1_000);
    ensure(!is_live(&rig), "a shorted stage drives again")?;
    let found = drive_flags(&mut rig, Axis::Horizontal)?;
    ensure(found.contains(DriveFlags::MOTOR_BROKEN), format!("shorted, and says {found:?}"))
}

fn supply(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 3_000 })?;
    rig.run(500);
    rig.parts(|parts| parts.chip.supply_low = true);
    rig.run(3);
    ensure(!is_live(&rig), "drives run while the chip's supply goes")
}

/// Motors are off 2 ms after the last byte of Stop, Lockout and Restart at the latest, whatever is being
/// sent.
fn stop(wrong: Wrong) -> Result<(), String> {
    let bodies = [Body::Stop, Body::Lockout { key: key::ENABLE }, Body::Restart];
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::HORIZONTAL, Body::Move { destination: 6_000 })?;
    rig.run(500);
    let moving = rig.save();
    for (n, body) in (0..9).zip(bodies.into_iter().cycle()) {
        rig.restore(&moving);
        rig.set_step_ns(STEP_NS);
        rig.run(5);
        // Another moment of the step each time.
        rig.hang(n * 111_000);
        // An answer of all is on its way when the request comes.
        rig.send(&request(SubsystemId::ALL, Body::GetStatus)?);
        rig.run(2);
        let last_ns = rig.send(&request(SubsystemId::ALL, body)?);
        ensure(is_live(&rig), "nothing moves that could be stopped")?;
        while rig.now_ns() < last_ns + 20 * MS_NS {
            rig.round();
        }
        let off_ns = rig.parts(|parts| parts.off_ns);
        let off_ns = off_ns.ok_or_else(|| format!("{body:?} stops nothing"))?;
        let late_ns = off_ns.saturating_sub(last_ns);
        ensure(late_ns <= 2 * MS_NS, format!("motors off {late_ns} ns after {body:?}"))?;
        sound(&rig)?;
    }
    Ok(())
}

fn request(to: SubsystemId, body: Body<'_>) -> Result<Vec<u8>, String> {
    let mut payload = [0; 64];
    let mut writer = Writer::new(&mut payload);
    Request::new(to, body).encode(&mut writer).map_err(|_| "too long a request")?;
    Ok(writer.written().to_vec())
}

fn valves(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    let opening =
        |rig: &Rig| rig.parts(|parts| [0, 1].map(|it| parts.plant.world.valves[it].opening));
    let cases = [
        (SubsystemId::VALVE1, true, [1.0, 0.0]),
        (SubsystemId::VALVE2, true, [1.0, 1.0]),
        (SubsystemId::VALVE1, false, [0.0, 1.0]),
        (SubsystemId::VALVE2, false, [0.0, 0.0]),
    ];
    for (id, open, wanted) in cases {
        let body =
            if open { Body::Open { key: key::OPEN } } else { Body::Close { key: key::CLOSE } };
        rig.order(id, body)?;
        rig.run(1_000);
        let current = rig.device.inputs().valves.iter().map(|valve| valve.current_da).max();
        ensure(current >= Some(8), format!("the valve's current is {current:?}"))?;
        rig.run(5_000);
        for (got, wanted) in opening(&rig).into_iter().zip(wanted) {
            near(&format!("{id}"), got, wanted, 0.01)?;
        }
        let found = ValveFlags::from_bits_retain(flags(&mut rig, id)?);
        let there = if open { ValveFlags::OPEN } else { ValveFlags::CLOSED };
        ensure(found.contains(there), format!("{id}: {found:?}"))?;
    }
    // A welded relay: the valve loses its power, and it is reported.
    rig.parts(|parts| parts.plant.welded.insert(RELAYS[0][0]));
    rig.run(300);
    let on = rig.parts(|parts| parts.plant.relays(&parts.chip));
    ensure(on == [[false; 2]; 2], "a welded relay keeps its power")?;
    let found = ValveFlags::from_bits_retain(flags(&mut rig, SubsystemId::VALVE1)?);
    ensure(found.contains(ValveFlags::BLOCKED), format!("welded, and says {found:?}"))
}

fn heaters(wrong: Wrong) -> Result<(), String> {
    let mut rig = fresh(wrong);
    rig.parts(|parts| parts.plant.world.climate.places_c = [20.0, -30.0, 20.0, 20.0, -30.0]);
    rig.run(500);
    let on = rig.parts(|parts| parts.plant.heaters(&parts.chip));
    ensure(on == [false, true, false, false, true], format!("heaters {on:?}"))?;
    let faults = inputs(&rig).places.map(|place| place.heater_fault);
    ensure(faults == [false; 5], format!("sound heaters reported as faulty: {faults:?}"))?;
    rig.parts(|parts| parts.plant.cold[4] = true);
    // The core switches it off at once, and then it is as it should be.
    let mut reported = [false; 5];
    for _ in 0..4_000 {
        rig.round();
        for (seen, place) in reported.iter_mut().zip(&rig.device.inputs().places) {
            *seen |= place.heater_fault;
        }
    }
    ensure(reported == [false, false, false, false, true], format!("a dead heater: {reported:?}"))
}

fn flow(wrong: Wrong) -> Result<(), String> {
    let mut rig = deployed(wrong)?;
    rig.order(SubsystemId::VALVE1, Body::Open { key: key::OPEN })?;
    rig.run(9_000);
    let (got, wanted) = rig.parts(|parts| {
        let world = &parts.plant.world;
        (f64::from(rig.device.inputs().flow_lps), world.water.flow_lps)
    });
    ensure(wanted > 10.0, "no water flows")?;
    near("flow, l/s", got, wanted, 1.0)?;
    let pressure = rig.parts(|parts| parts.plant.world.inputs().pressure_ua);
    near("pressure loop, µA", inputs(&rig).pressure_ua.into(), pressure.into(), 80.0)
}

/// A fire at 30°, 25 m off, is put out by requests; the time it took, s.
pub fn fire(wrong: Wrong) -> Result<f64, String> {
    let fire = FireSpec { azimuth_deg: 30.0, range_m: 25.0, ..FireSpec::default() };
    let mut rig = deployed_beside(wrong, vec![fire])?;
    let began = rig.now_ns();
    rig.order(SubsystemId::VALVE1, Body::Open { key: key::OPEN })?;
    let sector =
        Sector { centre_h: 1_800, centre_v: -180, nozzle: 60, width: 300, height: 120, step: 1 };
    let quench = Quench::Full { sector, distance: 25 };
    rig.order(SubsystemId::CONTROL, Body::StartQuench(quench))?;
    let out = rig.run_until(90_000, |rig| {
        rig.parts(|parts| !parts.plant.world.fires.iter().any(|fire| fire.burns()))
    });
    ensure(out, "the fire burns on")?;
    let took_s = (rig.now_ns() - began) as f64 / 1e9;
    rig.order(SubsystemId::ALL, Body::Stop)?;
    rig.order(SubsystemId::VALVE1, Body::Close { key: key::CLOSE })?;
    rig.run(6_000);
    let opening = rig.parts(|parts| parts.plant.world.valves[0].opening);
    near("the valve after the fire", opening, 0.0, 0.01)?;
    sound(&rig)?;
    Ok(took_s)
}

/// The first check that a board does not pass.
pub fn find_fault(wrong: Wrong) -> Option<(&'static str, String)> {
    CHECKS.iter().find_map(|(name, check)| Some((*name, check(wrong).err()?)))
}

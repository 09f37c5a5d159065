use super::*;
use lafet_device::image::{Spot, UnitError, UnitOp, UnitReply, ValveOutput};
use lafet_proto::flags::ButtonState;

/// All inputs set, with different values where they could be confused.
fn full_inputs() -> Inputs {
    let mut image = Inputs::default();
    let mut n: i16 = 1;
    let mut next = || {
        n += 7;
        n
    };
    for drive in &mut image.drives {
        drive.position = -100_000 * i32::from(next());
        drive.speed_tenths = -next();
        drive.current_da = next().cast_unsigned();
        drive.max_switch = true;
        drive.speed_sensor_fault = true;
    }
    for valve in &mut image.valves {
        valve.current_da = next().cast_unsigned();
        valve.close_switch = true;
        valve.blocked = true;
    }
    for place in &mut image.places {
        place.temperature_dc = Some(-next());
    }
    image.humidity_percent = Some(47);
    image.main_voltage_dv = 241;
    image.pressure_ua = 12_345;
    image.flow_lps = 21;
    image.detector.ready = true;
    for spot in &mut image.detector.spots {
        let (left, right, bottom, top) = (next(), -next(), -next(), next());
        *spot = Some(Spot { left, right, bottom, top, brightness: 123_456 });
    }
    for (index, state) in image.buttons.iter_mut().flatten().enumerate() {
        *state = match index % 4 {
            0 => ButtonState::Released,
            1 => ButtonState::Pressed,
            2 => ButtonState::Short,
            _ => ButtonState::Open,
        };
    }
    for (index, unit) in image.units.iter_mut().enumerate() {
        unit.online = true;
        let result = if index % 2 == 0 { Ok(-70_000) } else { Err(UnitError::BadValue) };
        unit.reply = Some(UnitReply { seq: index as u8, result });
    }
    image
}

fn full_outputs() -> Outputs {
    let mut image = Outputs::default();
    for (index, drive) in image.drives.iter_mut().enumerate() {
        drive.speed_tenths = -300 + 100 * index as i16;
        drive.cut = index % 2 == 1;
    }
    image.valves = [ValveOutput::Opening, ValveOutput::Closing];
    image.heaters = [true, false, true, true, false];
    for (index, unit) in image.units.iter_mut().enumerate() {
        let write = (index % 2 == 0).then_some(-5);
        *unit = Some(UnitOp { seq: index as u8, param: 0x103, write });
    }
    image
}

fn payload_of(wire: &[u8]) -> std::vec::Vec<u8> {
    let mut decoder = Decoder::counting();
    let (used, frame) = decoder.push_slice(wire);
    assert_eq!(used, wire.len());
    frame.expect("a frame").payload.to_vec()
}

fn payload_of_order(order: &Order<&Inputs>) -> std::vec::Vec<u8> {
    let mut wire = [0; WIRE_MAX];
    let len = order.encode(&mut wire).expect("it fits");
    payload_of(&wire[..len])
}

#[test]
fn orders_come_through() {
    let orders = [
        (
            Order::Provision { composition: 3, address: 77 },
            Order::Provision { composition: 3, address: 77 },
        ),
        (
            Order::Start { now_ms: 0x0102_0304, composition: 1, address: 2 },
            Order::Start { now_ms: 0x0102_0304, composition: 1, address: 2 },
        ),
        (Order::Fail(Failure::Astray), Order::Fail(Failure::Astray)),
        (Order::Fail(Failure::UndefinedInstruction), Order::Fail(Failure::UndefinedInstruction)),
        (Order::Fail(Failure::Hang), Order::Fail(Failure::Hang)),
        (Order::MeasureStack, Order::MeasureStack),
        (Order::MeasureTime, Order::MeasureTime),
    ];
    for (order, read) in orders {
        let payload = payload_of_order(&order);
        assert_eq!(Order::decode(&payload), Ok(read));
        assert_eq!(Order::decode(&payload[..payload.len() - 1]), Err(Unknown), "cut short");
        assert_eq!(Order::decode(&[payload.as_slice(), &[0]].concat()), Err(Unknown), "too long");
    }
}

#[test]
fn what_is_sensed_comes_through() {
    for (sent_ms, sensed) in [(u32::MAX - 3, full_inputs()), (0, Inputs::default())] {
        let payload = payload_of_order(&Order::Step { now_ms: sent_ms, inputs: &sensed });
        let read = |payload: &[u8]| {
            let Order::Step { now_ms, inputs } = Order::decode(payload)? else {
                return Err(Unknown);
            };
            let mut image = full_inputs();
            inputs.read(&mut image)?;
            Ok((now_ms, image))
        };
        assert_eq!(read(&payload), Ok((sent_ms, sensed)));
        assert_eq!(read(&payload[..payload.len() - 1]), Err(Unknown), "cut short");
        assert_eq!(read(&[payload.as_slice(), &[0]].concat()), Err(Unknown), "too long");
        assert_eq!(Order::decode(&payload[..4]), Err(Unknown), "no time");
    }
}

#[test]
fn reports_come_through() {
    let reports = [
        Report::Started { after_fault: true },
        Report::Driven(full_outputs()),
        Report::Driven(Outputs::default()),
        Report::Done,
        Report::Failed,
        Report::Stack(1_234),
        Report::Time { steps: 70_000, answers: 1, gauge: 2_500 },
    ];
    for report in reports {
        let mut wire = std::vec::Vec::new();
        report.send(&mut |byte| wire.push(byte));
        let payload = payload_of(&wire);
        assert_eq!(Report::decode(&payload), Ok(report));
        assert_eq!(Report::decode(&payload[..payload.len() - 1]), Err(Unknown), "cut short");
    }
}

#[test]
fn nonsense_is_refused() {
    assert_eq!(Order::decode(&[]), Err(Unknown));
    assert_eq!(Order::decode(&[9]), Err(Unknown));
    assert_eq!(Order::decode(&[3, 3]), Err(Unknown));
    // A valve that is neither at rest nor opening nor closing.
    assert_eq!(
        Report::decode(&[&[1, 0, 0, 0, 0, 0, 0, 0, 0, 3][..], &[0; 12]].concat()),
        Err(Unknown)
    );
}

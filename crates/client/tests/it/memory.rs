//! Client and Monitor over a stream in memory, on virtual time.

use std::time::Duration;

use crate::fake::{self, Log, answer, answer_within, frame, serve};
use lafet_client::{Cause, Client, Config, Deviation, Error, Lang, Monitor, Saved, Verdict};
use lafet_proto::param::Param;
use lafet_proto::record::Records;
use lafet_proto::request::{Body, LimitsState, Quench, Sector, Seek};
use lafet_proto::status::Limits;
use lafet_proto::{ParamId, Request, RequestId, Status, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::task::JoinHandle;

/// A client, and a monitor that behaves like this.
fn start<B>(behave: B) -> (Client, Log, JoinHandle<()>)
where
    B: FnMut(&[u8]) -> Vec<u8> + Send + 'static,
{
    let log = Log::default();
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let server = tokio::spawn(serve(theirs, log.clone(), behave));
    (Client::over("sim:", ours, Config::default()), log, server)
}

fn well() -> (Monitor, Log) {
    let (client, log, _) = start(|payload| frame(&answer(payload)));
    (Monitor::new(client), log)
}

const VERTICAL: SubsystemId = SubsystemId::VERTICAL;

fn read(who: SubsystemId) -> Request<'static> {
    Request::new(who, Body::GetStatus)
}

#[tokio::test(start_paused = true)]
async fn state_is_typed() {
    let (monitor, log) = well();
    let status = monitor.status_all().await.unwrap();
    assert_eq!(status.horizontal.unwrap().position, -1200);
    assert_eq!(status.drive(VERTICAL), status.vertical);
    assert_eq!(status.general.unwrap().pressure, 80);
    assert_eq!((status.deployer, status.valve2), (None, None));
    let present: Vec<_> = status.present().map(|id| id.to_string()).collect();
    assert_eq!(present, ["General", "Vertical", "Horizontal", "Valve1", "Control", "Detector"]);
    assert_eq!(*log.lock().unwrap(), [[0xD4, 0x5D, 0, 0]]);
    assert_eq!(monitor.limits(VERTICAL).await.unwrap(), Limits { min: -900, max: 5400 });
    assert_eq!(monitor.limits_all().await.unwrap().len(), 2);
    assert_eq!(monitor.hotbeds().await.unwrap(), [fake::HOTBED]);
    assert_eq!(monitor.crash_data().await.unwrap().signature, 0);
    monitor.client().probe().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn commands_go_out_as_the_document_has_them() {
    let (monitor, log) = well();
    assert_eq!(monitor.move_to(VERTICAL, -21600).await.unwrap(), Status::ACCEPTED);
    monitor.open(SubsystemId::VALVE1).await.unwrap();
    monitor.close(SubsystemId::VALVE1).await.unwrap();
    assert_eq!(monitor.stop(SubsystemId::ALL).await.unwrap().len(), 5);
    monitor.lockout(true).await.unwrap();
    monitor.lockout(false).await.unwrap();
    monitor.restart().await.unwrap();
    let seek = Seek { start_h: 1, end_h: 2, start_v: 3, end_v: 4, analyse: 1 };
    monitor.seek(seek).await.unwrap();
    let sector = Sector { centre_h: 1, centre_v: 2, nozzle: 3, width: 4, height: 5, step: 6 };
    monitor.quench(Quench::Full { sector, distance: 7 }).await.unwrap();
    monitor.switch_limits(SubsystemId::MOTORS, LimitsState::Reject).await.unwrap();
    monitor.clean_flash().await.unwrap();
    let sent: [&[u8]; 11] = [
        &[0x4D, 0x0D, 0, 2, 0xA0, 0xAB],
        &[0x21, 0xA6, 0, 2, 0x70, 0x4C],
        &[0x24, 0xA6, 0, 2, 0x56, 0x74],
        &[0x46, 0x5D, 0, 0],
        &[0xE9, 0x5D, 0, 2, 0xFA, 0x2F],
        &[0xE9, 0x5D, 0, 2, 0x53, 0x73],
        &[0x0A, 0x5D, 0, 0],
        &[0x76, 0xC8, 0, 10, 1, 0, 2, 0, 3, 0, 4, 0, 1, 0],
        &[0xC5, 0x45, 0, 12, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 7],
        &[0xD9, 0xAB, 0, 2, 2, 0],
        &[0x16, 0xC2, 0, 2, 0xF6, 0xA4],
    ];
    assert_eq!(*log.lock().unwrap(), sent);
}

#[tokio::test(start_paused = true)]
async fn tables_and_parameters_are_sent_in_pieces() {
    let (monitor, log) = well();
    monitor.correction_table(0, &[-3; 256]).await.unwrap();
    {
        let log = log.lock().unwrap();
        let firsts: Vec<_> = log.iter().map(|payload| (payload[4], payload.len())).collect();
        assert_eq!(firsts, [(0, 4 + 129), (128, 4 + 129)]);
    }
    assert_eq!(monitor.param(VERTICAL, "Speed").await.unwrap(), [12]);
    assert_eq!(monitor.param(SubsystemId::DETECTOR, "0x23FE").await.unwrap().len(), 5);
    monitor.set_param(VERTICAL, "Speed", &[13]).await.unwrap();
    let results = monitor.params(&Param::ALL).await;
    assert_eq!(results.len(), Param::COUNT);
    let of = |param: Param| &results[param as usize];
    assert_eq!(*of(Param::DetectorHotbeds).as_ref().unwrap(), fake::HOTBED.to_values());
    assert!(of(Param::GeneralAddress).as_ref().is_err_and(Error::is_refused));
    let frames = log.lock().unwrap().len();
    assert!(frames < Param::COUNT, "several in a frame: {frames}");
}

/// §3.5/9 Stored is what Ok says; a monitor that never says it is asked three times more and believed
/// no further; one that cannot write reports ConfigWriteFault.
#[tokio::test(start_paused = true)]
async fn accepted_and_stored_are_told_apart() {
    let save = async |answers: &[Status], flags: u8| {
        let answers = answers.to_vec();
        let mut statuses = answers.into_iter();
        let (client, log, _) = start(move |payload| match payload[0] {
            0xF1 => {
                let status = statuses.next().unwrap_or(Status::ACCEPTED);
                frame(&[0xF1, 0x0D, status.0, 2, payload[4], payload[5]])
            }
            0x9D => frame(&[0x9D, 0x0D, 0, 6, payload[4], payload[5], 8, 0, 0, 0]),
            _ => frame(&[0xD4, 0x0D, 0, 8, flags, 0, 0, 0, 0, 0, 0, 0]),
        });
        let saved = Monitor::new(client).save_param(VERTICAL, "Speed", &[8]).await;
        let sets = log.lock().unwrap().iter().filter(|payload| payload[0] == 0xF1).count();
        (saved, sets)
    };
    let (accepted, stored) = (Status::ACCEPTED, Status::OK);
    assert!(matches!(save(&[stored], 0).await, (Ok(Saved::Stored), 1)));
    assert!(matches!(save(&[accepted, accepted, stored], 0).await, (Ok(Saved::Stored), 3)));
    assert!(matches!(save(&[], 0).await, (Ok(Saved::Unconfirmed), 4)));
    assert!(matches!(save(&[], 4).await, (Ok(Saved::WriteFailed), 4)));
    // Another value could not be written; this one could.
    assert!(matches!(save(&[accepted, accepted, stored], 4).await, (Ok(Saved::Stored), 3)));
    // A remote unit is asked until it has taken it, and not again.
    let unit = [Status::CACHED, Status::CACHED, accepted];
    assert!(matches!(save(&unit, 0).await, (Ok(Saved::Unconfirmed), 3)));
    let (refused, _) = save(&[Status::CACHED; 40], 0).await;
    assert!(refused.is_err_and(|error| error.is_refused()));
    let (refused, sets) = save(&[Status::INVALID_VALUE], 0).await;
    assert!(refused.is_err_and(|error| error.is_refused()) && sets == 1);
    // A zero point, once taken, is no longer the present position.
    let zero = [accepted, Status::INVALID_VALUE];
    assert!(matches!(save(&zero, 0).await, (Ok(Saved::Unconfirmed), 2)));
}

#[tokio::test(start_paused = true)]
async fn refusals_name_who_refuses() {
    let (monitor, _) = well();
    let error = monitor.justify().await.unwrap_err();
    let Error::Refused { request, to, status, by } = error.clone() else { panic!("{error}") };
    assert_eq!((request, to), (RequestId::START_JUSTIFY, SubsystemId::DETECTOR));
    assert_eq!((status, by), (Status::DENIED, SubsystemId::CONTROL));
    assert!(error.localized(Lang::Ru).contains("Control"));
    let error = monitor.deploy().await.unwrap_err();
    assert!(matches!(error, Error::Refused { status: Status::MODULE_NOT_EXIST, .. }), "{error}");
    // At the client a refusal is an answer.
    let answers = monitor.client().request(&Request::close(SubsystemId::VALVE2)).await.unwrap();
    assert_eq!(answers.refusal().unwrap().status(), Status::MODULE_NOT_EXIST);
}

/// §1, §2 NoRoom: the client asks again for what was not processed.
#[tokio::test(start_paused = true)]
async fn what_found_no_room_is_asked_again() {
    let (client, log, _) = start(|payload| frame(&answer_within(payload, 64)));
    let requests = [
        read(VERTICAL),
        read(SubsystemId::HORIZONTAL),
        read(SubsystemId::GENERAL),
        read(SubsystemId::VALVE1),
        Request::new(VERTICAL, Body::Move { destination: 1 }),
        read(SubsystemId::ALL),
    ];
    let results = client.batch(&requests).await;
    for (request, result) in requests.iter().zip(&results).take(5) {
        let answers = result.as_ref().unwrap();
        assert_eq!((answers.to(), answers.first().request()), (request.to, request.body.id()));
        assert!(answers.first().status().is_success());
    }
    let log = log.lock().unwrap();
    assert_eq!(log[0].len(), 5 * 4 + 6);
    assert!(log.len() > 1);
    // Alone it does not fit either: that is the answer.
    assert!(results[5].as_ref().unwrap().lacks_room());
    let moves = log.iter().filter(|payload| payload.starts_with(&[0x4D])).count();
    assert!(moves <= 1);
}

#[tokio::test(start_paused = true)]
async fn silence_is_told_apart_by_what_it_means() {
    let (client, log, _) = start(|_| vec![]);
    let monitor = Monitor::new(client);
    let error = monitor.status(VERTICAL).await.unwrap_err();
    assert!(matches!(error, Error::NoAnswer { tries: 3, .. }), "{error}");
    assert_eq!(log.lock().unwrap().len(), 3);
    let error = monitor.move_to(VERTICAL, 1).await.unwrap_err();
    assert!(matches!(error, Error::OutcomeUnknown { .. }), "{error}");
    assert_eq!(log.lock().unwrap().len(), 4, "a command is sent once");
    let error = monitor.stop(SubsystemId::ALL).await.unwrap_err();
    assert!(matches!(error, Error::OutcomeUnknown { .. }), "{error}");
    assert_eq!(log.lock().unwrap().len(), 9, "a Stop is repeated sooner");
    let error = monitor.client().probe().await.unwrap_err();
    assert!(matches!(error, Error::Absent { tries: 3, .. }), "{error}");
    // Of a batch, what is behind the silent frame is not sent.
    let requests = [
        Request::new(VERTICAL, Body::Move { destination: 1 }),
        read(SubsystemId::ALL),
        read(VERTICAL),
    ];
    let results = monitor.client().batch(&requests).await;
    assert!(matches!(results[0], Err(Error::NotSent { cause: Cause::Silence, .. })));
    assert!(matches!(results[1], Err(Error::NoAnswer { .. })));
    assert!(matches!(results[2], Err(Error::NotSent { .. })));
}

/// The values of late answers are never believed, end to end.
#[tokio::test(start_paused = true)]
async fn late_answers_are_not_believed() {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    tokio::spawn(slow(theirs));
    let config = Config { tries: 1, ..Config::default() };
    let client = Client::over("sim:", ours, config);
    let request = Request::new(VERTICAL, Body::Unknown { request: RequestId(1), data: &[] });
    for n in 0..50u8 {
        let data = [n];
        let body = Body::Unknown { request: RequestId(1), data: &data };
        let request = Request::new(request.to, body);
        if let Ok(answers) = client.request(&request).await {
            assert_eq!(answers.first().data(), [n]);
        }
    }
    let stats = client.stats();
    assert!(stats.believed > 20 && stats.late > 10, "{stats:?}");
}

/// Repeats what it is asked; every third answer takes 1.5 s.
async fn slow(stream: DuplexStream) {
    let (mut read, write) = tokio::io::split(stream);
    let write = std::sync::Arc::new(tokio::sync::Mutex::new(write));
    let mut decoder: lafet_proto::link::Decoder = lafet_proto::link::Decoder::new();
    let mut count = 0;
    while let Ok(byte) = read.read_u8().await {
        let Some(asked) = decoder.push(byte) else { continue };
        let mut payload = asked.payload.to_vec();
        // §1: a subsystem that does not exist is answered for by General.
        for header in [0, 4] {
            if payload[header] == 0xD4 {
                payload[header + 2] = Status::MODULE_NOT_EXIST.0;
            }
        }
        count += 1;
        let delay = Duration::from_millis(if count % 3 == 0 { 1500 } else { 5 });
        let write = write.clone();
        tokio::spawn(async move {
            tokio::time::sleep(delay).await;
            _ = write.lock().await.write_all(&frame(&payload)).await;
        });
    }
}

#[tokio::test(start_paused = true)]
async fn a_dropped_future_leaves_nothing_behind() {
    let mut ignore = 1;
    let (client, log, _) = start(move |payload| {
        let ignored = ignore > 0;
        ignore -= i32::from(ignored);
        if ignored { vec![] } else { frame(&answer(payload)) }
    });
    let moving = Request::new(VERTICAL, Body::Move { destination: 1 });
    let asked = read(SubsystemId::ALL);
    let waiting = async { tokio::join!(client.request(&asked), client.request(&moving)) };
    // Dropped after a moment: the first is on the line, the second has not been sent.
    assert!(tokio::time::timeout(Duration::from_millis(10), waiting).await.is_err());
    let answers = client.request(&read(VERTICAL)).await.unwrap();
    assert_eq!(answers.first().from(), VERTICAL);
    let log = log.lock().unwrap();
    assert!(log.iter().all(|payload| !payload.starts_with(&[RequestId::MOVE.0])), "{log:x?}");
    assert_eq!(log.len(), 2, "the read without an addressee is not repeated: {log:x?}");
}

#[tokio::test(start_paused = true)]
async fn a_stop_overtakes_and_is_sent_even_if_nobody_waits() {
    let (client, log, server) = start(|payload| match payload[0] {
        0x46 => frame(&answer(payload)),
        _ => vec![],
    });
    let monitor = Monitor::new(client);
    let (status, moved, stopped) = tokio::join!(
        monitor.status(VERTICAL),
        monitor.move_to(VERTICAL, 1),
        monitor.stop(SubsystemId::ALL),
    );
    assert!(stopped.is_ok());
    assert!(matches!(moved, Err(Error::NotSent { .. })), "{moved:?}");
    assert!(matches!(status, Err(Error::NoAnswer { .. })), "{status:?}");
    let sent: Vec<_> = log.lock().unwrap().iter().map(|payload| payload[0]).collect();
    assert_eq!(sent[0], 0x46, "asked last, sent first");
    assert!(!sent.contains(&0x4D));

    log.lock().unwrap().clear();
    let stop = monitor.stop(SubsystemId::ALL);
    assert!(tokio::time::timeout(Duration::ZERO, stop).await.is_err());
    drop(monitor);
    server.await.unwrap();
    assert_eq!(*log.lock().unwrap(), [[0x46, 0x5D, 0, 0]]);
}

#[tokio::test(start_paused = true)]
async fn garbage_and_strangers_disturb_nobody() {
    let (client, _, _) = start(|payload| {
        let good = answer(payload);
        let mut bytes = b"\xC0\xDBnoise\x00\xFF".to_vec();
        bytes.extend(fake::encode(130, 1, &good));
        bytes.extend(fake::encode(129, 2, &good));
        bytes.extend(frame(&[0x46, 0x0D, 0, 0]));
        bytes.extend(frame(&[0x46, 0x0D, 0, 9]));
        bytes.extend(frame(&good));
        bytes.extend(frame(&good));
        bytes
    });
    let mut trace = client.trace();
    for _ in 0..5 {
        let answers = client.request(&read(VERTICAL)).await.unwrap();
        assert_eq!(answers.first().from(), VERTICAL);
    }
    let stats = client.stats();
    assert_eq!((stats.believed, stats.foreign, stats.retries), (5, 10, 0), "{stats:?}");
    assert!(stats.framing_errors >= 5 && stats.strays() >= 20, "{stats:?}");
    let first: Vec<_> = (0..4).map(|_| trace.try_recv().unwrap().verdict).collect();
    assert_eq!(first, [Verdict::Sent, Verdict::Foreign, Verdict::Foreign, Verdict::Unmatched]);
}

#[tokio::test(start_paused = true)]
async fn an_answer_of_the_wrong_shape_is_named() {
    let (client, _, _) = start(|payload| frame(&[payload[0], payload[1], 0, 3, 1, 2, 3]));
    let error = client.request(&read(VERTICAL)).await.unwrap_err();
    assert!(matches!(error, Error::Protocol { from: VERTICAL, .. }), "{error}");
    let (client, _, _) = start(|payload| frame(&[payload[0], payload[1], 0, 0]));
    let error = Monitor::new(client).limits(VERTICAL).await.unwrap_err();
    assert!(matches!(error, Error::Protocol { from: VERTICAL, .. }), "{error}");
}

/// An answer that is none of the protocol's is an error that names it, not silence and not a success.
#[tokio::test(start_paused = true)]
async fn odd_answers_are_named() {
    let named = |error: &Error, what: &str| {
        let (english, russian) = (error.to_string(), error.localized(Lang::Ru));
        assert!(english.contains("not what the protocol says"), "{english}");
        assert!(english.contains(what), "{english}");
        assert!(!english.contains("power"), "{english}");
        assert_ne!(english, russian);
    };
    // A state without data, and a status that does not exist.
    let (client, _, _) = start(|payload| frame(&[payload[0], payload[1], 0, 0]));
    let error = client.request(&read(VERTICAL)).await.unwrap_err();
    named(&error, "has no data");
    assert!(matches!(error, Error::Protocol { what: Deviation::NoData, .. }));
    let (client, _, _) = start(|payload| frame(&[payload[0], payload[1], 0xC8, 0]));
    let error = client.request(&read(VERTICAL)).await.unwrap_err();
    named(&error, "no status of the protocol");
    let moving = Request::new(VERTICAL, Body::Move { destination: 1 });
    let error = client.request(&moving).await.unwrap_err();
    assert!(matches!(error, Error::OutcomeUnknown { cause: Cause::Odd { .. }, .. }), "{error}");
    named(&error, "It may have been executed");
    // Another parameter, however often it is asked; the others are read all the same.
    let (client, _, _) = start(|payload| {
        let answers = Records::new(payload).flatten().map(|record| match record.data {
            [7, 0] => vec![record.request.0, record.device.0, 0, 6, 8, 0, 1, 0, 0, 0],
            [id, 0] => vec![record.request.0, record.device.0, 0, 6, *id, 0, 1, 0, 0, 0],
            _ => vec![record.request.0, record.device.0, Status::MODULE_NOT_EXIST.0, 0],
        });
        frame(&answers.collect::<Vec<_>>().concat())
    });
    let reading = |id| Request::new(VERTICAL, Body::GetParam { id: ParamId(id) });
    let error = client.request(&reading(7)).await.unwrap_err();
    named(&error, "was asked for");
    let all = [reading(7), reading(5), reading(7), reading(7), reading(6)];
    let results = client.complete(&all, |_| {}).await;
    let fine: Vec<_> = results.iter().map(Result::is_ok).collect();
    assert_eq!(fine, [false, true, false, false, true]);
    // A device is there that does not answer a probe as it should.
    let (client, _, _) = start(|_| frame(&[0xD4, 0x5D, 0, 0]));
    client.probe().await.unwrap();
    // One subsystem of many does not spoil what the others say.
    let (client, _, _) = start(|_| {
        let mut all = vec![0xD4, 0xA6, 0, 0, 0xD4, 0x0D, 0, 8];
        all.extend([0; 8]);
        frame(&all)
    });
    let status = Monitor::new(client).status_all().await;
    assert_eq!(
        status.map(|status| (status.vertical.is_some(), status.others.len())).unwrap(),
        (true, 1)
    );
}

#[tokio::test(start_paused = true)]
async fn a_stream_that_ends_is_told() {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let client = Client::over("sim:", ours, Config::default());
    drop(theirs);
    let error = client.request(&read(VERTICAL)).await.unwrap_err();
    assert!(matches!(error, Error::Link { .. }), "{error}");
    let moving = Request::new(VERTICAL, Body::Move { destination: 1 });
    let error = client.request(&moving).await.unwrap_err();
    assert!(matches!(error, Error::NotSent { .. }), "{error}");
    let url = "sim:?seed=7".parse().unwrap();
    assert!(matches!(Client::connect(&url).await, Err(Error::NeedsStream)));
}

/// A user who reads the error looks for the monitor that was asked.
#[tokio::test(start_paused = true)]
async fn errors_name_the_monitor_that_was_asked() {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    tokio::spawn(serve(theirs, Log::default(), |_| Vec::new()));
    let first = Client::over("tcp://10.0.0.7:10485?addr=1", ours, Config::default());
    let third = first.at(3).unwrap();
    assert_eq!(third.endpoint(), "tcp://10.0.0.7:10485?addr=3");
    let silent = third.request(&read(VERTICAL)).await.unwrap_err();
    assert!(silent.to_string().contains("addr=3"), "{silent}");
    assert_eq!(first.endpoint(), "tcp://10.0.0.7:10485?addr=1");
    let refused = first.at(0).map(|it| it.endpoint().to_owned()).unwrap_err();
    assert!(refused.to_string().contains("10.0.0.7"), "{refused}");
}

//! Who decides whether a value was taken: the subsystem that stores it. What another client has done since is
//! not undone.

use crate::fake::{Log, frame, serve};
use lafet_client::transport::memory::pair;
use lafet_client::{Client, Config, Error, Monitor, Saved};
use lafet_proto::record::Writer;
use lafet_proto::{Answer, RequestId, Status, SubsystemId};

/// A monitor whose subsystems answer Lockout like this.
fn monitor(answers: &'static [(SubsystemId, Status)]) -> Monitor {
    let (ours, theirs) = pair();
    tokio::spawn(serve(theirs, Log::default(), move |_| {
        let mut buffer = [0; 64];
        let mut out = Writer::new(&mut buffer);
        for (from, status) in answers {
            Answer::bare(*from, RequestId::LOCKOUT, *status).encode(&mut out).unwrap();
        }
        frame(out.written())
    }));
    Monitor::new(Client::over("test", ours, Config::default()))
}

const VALVE: SubsystemId = SubsystemId::VALVE1;
const GENERAL: SubsystemId = SubsystemId::GENERAL;

/// A valve that has nothing to close does not make a lockout that General has taken a refusal; one with a fault does.
#[tokio::test(start_paused = true)]
async fn general_decides_on_a_lockout() {
    let idle: [&'static [_]; 2] = [
        &[(VALVE, Status::DENIED), (GENERAL, Status::OK)],
        &[(VALVE, Status::NOT_SUPPORTED), (GENERAL, Status::OK)],
    ];
    for all in idle {
        let (answers, saved) = monitor(all).save_lockout(true).await.unwrap();
        assert_eq!((answers.len(), saved), (2, Saved::Stored));
    }
    let refused = monitor(&[(VALVE, Status::OK), (GENERAL, Status::DENIED)]);
    let error = refused.save_lockout(true).await.unwrap_err();
    assert!(matches!(error, Error::Refused { by: GENERAL, .. }), "{error}");
    let fault = monitor(&[(VALVE, Status::MODULE_FAULT), (GENERAL, Status::OK)]);
    let error = fault.save_lockout(true).await.unwrap_err();
    assert!(matches!(error, Error::Refused { by: VALVE, .. }), "{error}");
    let without = monitor(&[(VALVE, Status::DENIED)]);
    let error = without.save_lockout(true).await.unwrap_err();
    assert!(matches!(error, Error::Refused { by: VALVE, .. }), "{error}");
}

/// §3.18 A release that is not stored at once is not repeated: it would end a lockout of another client.
#[tokio::test(start_paused = true)]
async fn a_release_is_sent_once() {
    for (flags, wanted) in [(0, Saved::Unconfirmed), (4, Saved::WriteFailed)] {
        let (log, (ours, theirs)) = (Log::default(), pair());
        tokio::spawn(serve(theirs, log.clone(), move |payload| match RequestId(payload[0]) {
            RequestId::LOCKOUT => frame(&[payload[0], GENERAL.0, Status::ACCEPTED.0, 0]),
            _ => frame(&[payload[0], GENERAL.0, 0, 10, flags, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        }));
        let monitor = Monitor::new(Client::over("test", ours, Config::default()));
        let (_, saved) = monitor.save_lockout(false).await.unwrap();
        assert_eq!(saved, wanted);
        let log = log.lock().unwrap();
        let sent = log.iter().filter(|payload| payload[0] == RequestId::LOCKOUT.0).count();
        assert_eq!(sent, 1, "{log:x?}");
    }
}

/// A value that waits to be stored is not set again over the one that another client has set since.
#[tokio::test(start_paused = true)]
async fn a_value_of_another_client_stays() {
    let who = SubsystemId::VERTICAL;
    for (now, sets) in [(8, 4), (5, 1)] {
        let (log, (ours, theirs)) = (Log::default(), pair());
        tokio::spawn(serve(theirs, log.clone(), move |payload| match RequestId(payload[0]) {
            RequestId::SET_PARAM => {
                frame(&[payload[0], who.0, Status::ACCEPTED.0, 2, payload[4], payload[5]])
            }
            RequestId::GET_PARAM => {
                frame(&[payload[0], who.0, 0, 6, payload[4], payload[5], now, 0, 0, 0])
            }
            _ => frame(&[payload[0], who.0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0]),
        }));
        let monitor = Monitor::new(Client::over("test", ours, Config::default()));
        let saved = monitor.save_param(who, "Speed", &[8]).await.unwrap();
        assert_eq!(saved, Saved::Unconfirmed);
        let log = log.lock().unwrap();
        let sent = log.iter().filter(|payload| payload[0] == RequestId::SET_PARAM.0).count();
        assert_eq!(sent, sets, "{log:x?}");
    }
}

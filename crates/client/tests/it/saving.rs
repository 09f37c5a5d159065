//! Who decides whether a value was taken: the subsystem that stores it.

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

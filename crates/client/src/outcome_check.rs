//! Which requests may be repeated without a check, and how to check the outcome of the others.
//!
//! | request | sent again by itself | because |
//! |---|---|---|
//! | GetStatus, GetParam, RetrieveLimits, GetHotbed, GetCrashData, GetNetworkStatus, GetLog | yes | changes nothing |
//! | Stop, Close, Lockout on | yes, and sooner | twice has the effect of once, and leads to the safe state |
//! | Move, Open, Deploy, Wrap, Start…, Lockout off | no | starts or allows a motion that may no longer be wanted |
//! | SetParam, SetupCorrectionTable, SwitchLimits | no | another value may have been set meanwhile |
//! | Restart, CleanFlash | no | twice has another effect than once |
//!
//! Busy, NotCached and Cached are answers, not silence: the request was not executed, so
//! [`crate::Client::complete`] may ask again.

use lafet_proto::RequestId;
use lafet_texts::{Fixed, client as text};

/// How to check whether a request without answer was executed.
pub fn outcome_check(request: RequestId) -> Fixed {
    match request {
        RequestId::MOVE => text::CheckMove.fixed(),
        RequestId::STOP => text::CheckStop.fixed(),
        RequestId::OPEN => text::CheckOpen.fixed(),
        RequestId::CLOSE => text::CheckClose.fixed(),
        RequestId::DEPLOY | RequestId::WRAP => text::CheckDeployer.fixed(),
        RequestId::SET_PARAM => text::CheckParameter.fixed(),
        RequestId::SETUP_CORRECTION_TABLE => text::CheckCorrectionTable.fixed(),
        RequestId::START_JUSTIFY => text::CheckJustify.fixed(),
        RequestId::START_QUENCH | RequestId::START_TRAJECTORY => text::CheckProgram.fixed(),
        RequestId::START_SEEK => text::CheckSeek.fixed(),
        RequestId::SWITCH_LIMITS => text::CheckLimits.fixed(),
        RequestId::LOCKOUT => text::CheckLockout.fixed(),
        RequestId::RESTART => text::CheckRestart.fixed(),
        RequestId::CLEAN_FLASH => text::CheckCleanFlash.fixed(),
        _ => text::CheckOther.fixed(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RequestBuf;
    use lafet_proto::id::key;
    use lafet_proto::request::{Body, Path, Quench, Seek, Trajectory};
    use lafet_proto::{Bytes, Ints, ParamId, Request, SubsystemId};

    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Again {
        Read,
        Safe,
        Never,
    }

    /// Every request of the document and of the bus controller, and an unknown one.
    fn table() -> Vec<(Body<'static>, Again)> {
        use Again::{Never, Read, Safe};
        let path = Path::Stored(&[0]);
        let quench = Quench::Program { program: 0, centre_h: 0, centre_v: 0, nozzle: 0 };
        let bare = |request| Body::Unknown { request, data: &[] };
        vec![
            (Body::Move { destination: 1 }, Never),
            (Body::Stop, Safe),
            (Body::GetStatus, Read),
            (Body::GetParam { id: ParamId(1) }, Read),
            (Body::SetParam { id: ParamId(1), values: Ints::Values(&[1]) }, Never),
            (Body::SetupCorrectionTable { first: 0, corrections: Bytes(&[1]) }, Never),
            (Body::RetrieveLimits, Read),
            (Body::Open { key: key::OPEN }, Never),
            (Body::Close { key: key::CLOSE }, Safe),
            (Body::Deploy, Never),
            (Body::Wrap, Never),
            (Body::Restart, Never),
            (Body::StartJustify, Never),
            (Body::StartQuench(quench), Never),
            (Body::StartTrajectory(Trajectory { ballistics: false, repeat: false, path }), Never),
            (Body::StartSeek(Seek::default()), Never),
            (Body::SwitchLimits { new_state: 1 }, Never),
            (Body::GetHotbed, Read),
            (Body::Lockout { key: key::ENABLE }, Safe),
            (Body::Lockout { key: key::DISABLE }, Never),
            (Body::CleanFlash { key: key::CLEAN_FLASH }, Never),
            (Body::GetCrashData, Read),
            (bare(RequestId::GET_NETWORK_STATUS), Read),
            (bare(RequestId::GET_LOG), Read),
            (bare(RequestId::ACCESS_GRANTED), Never),
            (bare(RequestId(1)), Never),
        ]
    }

    #[test]
    fn the_table_has_every_request_of_the_document() {
        let table = table();
        for info in &lafet_proto::dictionary::REQUESTS {
            assert!(table.iter().any(|(body, _)| body.id() == info.id), "{}", info.name);
        }
        for (body, again) in table {
            let request = RequestBuf::new(&Request::new(SubsystemId::VALVE1, body)).unwrap();
            let is = match (request.is_read(), request.is_urgent()) {
                (true, false) => Again::Read,
                (false, true) => Again::Safe,
                (false, false) => Again::Never,
                (true, true) => panic!("{body:?} is both"),
            };
            assert_eq!(is, again, "{body:?}");
            assert_eq!(request.is_repeatable(), again != Again::Never, "{body:?}");
            // Each request that is not repeated has a text of its own.
            let general = outcome_check(RequestId(1));
            let known = body.id().name().is_some();
            assert_eq!(
                outcome_check(body.id()) != general,
                known && again != Again::Read,
                "{body:?}"
            );
        }
    }

    #[test]
    fn the_way_to_find_out_is_told_in_both_languages() {
        for info in &lafet_proto::dictionary::REQUESTS {
            let Fixed { en, ru } = outcome_check(info.id);
            assert!(en.is_ascii() && en.ends_with('.'), "{en}");
            assert!(ru.ends_with('.') && ru.chars().any(|c| ('а'..='я').contains(&c)), "{ru}");
        }
    }
}

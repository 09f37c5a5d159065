//! What a frame asks of a monitor, as far as a controller has to know.

use lafet_proto::Request;
use lafet_proto::record::Records;

use crate::answers::RequestBuf;

/// Whether every request of a frame may be executed twice; a probe may.
pub(super) fn is_repeatable(payload: &[u8]) -> bool {
    every(payload, RequestBuf::is_repeatable)
}

/// Whether a frame stops, closes or locks out and does nothing else: it may go before others, and
/// late.
pub(super) fn is_urgent(payload: &[u8]) -> bool {
    let mut urgent = false;
    let harmless = every(payload, |request| {
        urgent |= request.is_urgent();
        request.is_urgent() || request.is_read()
    });
    urgent && harmless
}

fn every(payload: &[u8], mut is: impl FnMut(&RequestBuf) -> bool) -> bool {
    Records::new(payload).all(|record| {
        let request = record.ok().and_then(|record| Request::decode(&record).ok());
        let request = request.and_then(|request| RequestBuf::new(&request).ok());
        request.is_some_and(|request| is(&request))
    })
}

#[cfg(test)]
mod tests {
    use lafet_proto::SubsystemId;
    use lafet_proto::id::key;
    use lafet_proto::request::Body;

    use super::*;

    /// A release of the lockout is no Stop, nor is a frame that does anything else besides.
    #[test]
    fn only_what_stops_and_nothing_else_is_urgent() {
        let frame = |requests: &[Request<'_>]| {
            let bufs = requests.iter().map(|request| RequestBuf::new(request).unwrap());
            bufs.flat_map(|buf| buf.bytes().to_vec()).collect::<Vec<u8>>()
        };
        let stop = Request::new(SubsystemId::ALL, Body::Stop);
        let lockout = |key| Request::new(SubsystemId::ALL, Body::Lockout { key });
        let moves = Request::new(SubsystemId::VERTICAL, Body::Move { destination: 1 });
        let numbered = Request::new(SubsystemId(0x77), Body::GetStatus);
        let cut = [frame(&[stop]), vec![0x4D]].concat();
        for (payload, urgent) in [
            (frame(&[stop]), true),
            (frame(&[Request::new(SubsystemId::VALVE1, Body::Close { key: key::CLOSE })]), true),
            (frame(&[lockout(key::ENABLE)]), true),
            (frame(&[numbered, stop]), true),
            (frame(&[lockout(key::DISABLE)]), false),
            (frame(&[lockout(0)]), false),
            (frame(&[stop, moves]), false),
            (frame(&[lockout(key::DISABLE), stop]), false),
            (frame(&[numbered]), false),
            (cut, false),
            (Vec::new(), false),
        ] {
            assert_eq!(is_urgent(&payload), urgent, "{payload:02x?}");
        }
    }
}

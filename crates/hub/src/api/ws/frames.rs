//! The frames of a monitor, shown to the connections that watch them.

use std::sync::Arc;

use lafet_client::{Direction, Traced};
use lafet_proto::Request;
use lafet_proto::link::Frame;
use lafet_proto::record::Records;
use lafet_proto::text::AnswerText;
use tokio::sync::broadcast::error::RecvError;

use crate::hub::{Caller, Hub};
use crate::monitor::station::Station;
use crate::publish::messages::{Message, ShownFrame};
use crate::words::{DirectionWord, VerdictWord};

/// Shows the frames of a monitor to a connection.
pub async fn show_frames(hub: Hub, caller: Caller, station: Arc<Station>) {
    let mut clients = station.client.subscribe();
    let Ok(client) = clients.wait_for(Option::is_some).await.map(|client| client.clone()) else {
        return;
    };
    let Some(client) = client else { return };
    let mut frames = client.trace();
    loop {
        match frames.recv().await {
            Ok(frame) if frame.dst == client.address() || frame.src == client.address() => {
                let message = show(station.id(), hub.clock().now_ms(), &frame);
                hub.send_to(&caller.seat.seat, &Message::Frame(message));
            }
            Ok(_) => {}
            Err(RecvError::Lagged(count)) => {
                hub.send_to(&caller.seat.seat, &Message::Missed { count });
            }
            Err(RecvError::Closed) => return,
        }
    }
}

fn show(monitor: &str, at_ms: u64, frame: &Traced) -> ShownFrame {
    let sent = frame.direction() == Direction::Sent;
    let verdict = frame.verdict.into();
    let frame = Frame { dst: frame.dst, src: frame.src, payload: &frame.payload };
    show_frame(monitor, at_ms, sent, verdict, &frame)
}

/// A frame as text and bytes.
pub fn show_frame(
    monitor: &str,
    at_ms: u64,
    sent: bool,
    verdict: VerdictWord,
    frame: &Frame<'_>,
) -> ShownFrame {
    let texts = Records::new(frame.payload).map(|record| match record {
        Ok(record) if sent => match Request::decode(&record) {
            Ok(request) => request.to_string(),
            Err(error) => error.to_string(),
        },
        Ok(record) => AnswerText(record).to_string(),
        Err(error) => error.to_string(),
    });
    let bytes: Vec<String> = frame.payload.iter().map(|byte| format!("{byte:02x}")).collect();
    ShownFrame {
        monitor: monitor.to_owned(),
        at_ms,
        direction: if sent { DirectionWord::Out } else { DirectionWord::In },
        verdict,
        dst: frame.dst,
        src: frame.src,
        bytes: bytes.join(" "),
        text: texts.collect::<Vec<_>>().join(" ; "),
    }
}

#[cfg(test)]
mod tests {
    use lafet_client::Verdict;
    use serde_json::json;

    use super::*;

    /// Every frame has one of the words that the interface names.
    #[test]
    fn what_became_of_a_frame_is_a_word_of_the_interface() {
        let told = |verdict| {
            let payload = [0x46_u8, 0x5D, 0, 0];
            let frame =
                Traced { verdict, dst: 1, src: 129, tagged: false, payload: payload.into() };
            let shown = serde_json::to_value(show("M1", 0, &frame)).unwrap();
            [shown["verdict"].clone(), shown["direction"].clone()]
        };
        assert_eq!(told(Verdict::Sent), [json!("sent"), json!("out")]);
        assert_eq!(told(Verdict::Believed), [json!("believed"), json!("in")]);
        assert_eq!(told(Verdict::Late), [json!("late"), json!("in")]);
        assert_eq!(told(Verdict::Duplicate), [json!("duplicate"), json!("in")]);
        assert_eq!(told(Verdict::Foreign), [json!("foreign"), json!("in")]);
        assert_eq!(told(Verdict::Unmatched), [json!("unmatched"), json!("in")]);
    }
}

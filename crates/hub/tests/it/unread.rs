//! What had come over a WebSocket that ends before it was read: what stops is carried out.

use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;

use crate::support::{Site, Socket, until};

const PING: [u8; 6] = [0x89, 0x80, 0, 0, 0, 0];

/// A message of a client, as it is on the line.
fn frame(message: &Value) -> Vec<u8> {
    let text = message.to_string();
    let len = u8::try_from(text.len()).unwrap();
    assert!(len < 126, "{text}");
    [&[0x81, 0x80 | len, 0, 0, 0, 0], text.as_bytes()].concat()
}

fn stop() -> Vec<u8> {
    frame(&json!({ "type": "stop", "monitor": "M1" }))
}

fn stops(site: &Site) -> u64 {
    site.hub.station("M1").unwrap().urgent_count()
}

/// It has left a ping unanswered, and takes nothing any more: neither the answer nor anything else can be sent.
#[tokio::test]
async fn a_stop_of_a_client_that_is_gone_is_carried_out() {
    let site = Site::open(1).await;
    for before in [&[][..], &PING, &PING.repeat(50)] {
        for ends in ["reset", "closed", "half closed"] {
            let carried_out = stops(&site);
            let Socket { mut socket, .. } = site.ws("").await;
            let stream = socket.get_mut();
            if ends == "reset" {
                stream.set_zero_linger().unwrap();
            }
            stream.write_all(&[before, &stop()].concat()).await.unwrap();
            if ends == "half closed" {
                stream.shutdown().await.unwrap();
            } else {
                drop(socket);
            }
            let what = format!("{ends}, {} bytes before it", before.len());
            until(&what, || stops(&site) > carried_out).await;
        }
    }
}

/// The connection is closed for what comes before it.
#[tokio::test]
async fn a_stop_behind_too_many_messages_is_carried_out() {
    let site = Site::open(1).await;
    let mut socket = site.ws("").await;
    let watch = frame(&json!({ "type": "watch", "frames": [] }));
    let stream = socket.socket.get_mut();
    // As many as the system keeps of a connection that is not read.
    stream.write_all(&[watch.repeat(128 * 1024 / watch.len()), stop()].concat()).await.unwrap();
    until("it is stopped", || stops(&site) > 0).await;
}

/// Several at a time: which of two things that are due has its turn first is a matter of chance.
#[tokio::test]
async fn a_stop_that_had_come_when_the_hub_ends_is_carried_out() {
    const CLIENTS: usize = 8;
    let site = Site::open(1).await;
    let mut sockets = Vec::new();
    for _ in 0..CLIENTS {
        sockets.push(site.ws("").await);
    }
    for socket in &mut sockets {
        let sent = socket.socket.get_mut().try_write(&stop()).unwrap();
        assert_eq!(sent, stop().len());
    }
    // Nothing else has had its turn meanwhile.
    assert_eq!(stops(&site), 0);
    site.hub.begin_shutdown();
    until("each has stopped it", || stops(&site) == CLIENTS as u64).await;
}

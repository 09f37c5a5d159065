//! A parameter that is set, and waited for until it is stored (§3.5/9).

use std::time::Duration;

use lafet_client::{Answers, Client, Error, Monitor, Saved};
use lafet_proto::flags::CommonFlags;
use lafet_proto::{Request, Status};
use tokio::time::sleep;

/// How long a remote unit may take for a parameter (§3.5/7), in pauses.
const UNIT_TRIES: usize = 12;
const UNIT_PAUSE: Duration = Duration::from_millis(150);

/// Times between a request and its repetitions.
const PAUSES: [Duration; 3] =
    [Duration::from_millis(60), Duration::from_millis(340), Duration::from_millis(1100)];

/// What was answered to a value, and what became of it; `None`: it was refused.
pub async fn save(
    client: &Client,
    request: &Request<'_>,
) -> Result<(Answers, Option<Saved>), Error> {
    let mut tries = 0;
    let answers = loop {
        let answers = client.request(request).await?;
        let busy = answers.refusal().is_some_and(|it| it.status() == Status::CACHED);
        if !busy || tries == UNIT_TRIES {
            break answers;
        }
        tries += 1;
        sleep(UNIT_PAUSE).await;
    };
    let saved = match answers.first().status() {
        _ if answers.refusal().is_some() => None,
        Status::OK => Some(Saved::Stored),
        // Each repetition would be one more write for the unit.
        _ if tries > 0 => Some(Saved::Unconfirmed),
        // It is in force, whatever becomes of the connection.
        _ => Some(confirm(client, request).await.unwrap_or(Saved::Unconfirmed)),
    };
    Ok((answers, saved))
}

/// Repeats what was accepted until Ok says that it is stored.
async fn confirm(client: &Client, request: &Request<'_>) -> Result<Saved, Error> {
    let monitor = Monitor::new(client.clone());
    let mut saved = Saved::Unconfirmed;
    for pause in PAUSES {
        sleep(pause).await;
        let answers = client.request(request).await?;
        match answers.refusal() {
            None if answers.first().status() == Status::OK => return Ok(Saved::Stored),
            // A zero point that was taken is not the present position any more (§3.17).
            Some(_) => return Ok(Saved::Unconfirmed),
            None => {}
        }
        let status = monitor.status(request.to).await?;
        let bits = status.decode().ok().and_then(|answer| answer.data.flags_bits()).unwrap_or(0);
        let failed = CommonFlags::from_bits_retain(bits).contains(CommonFlags::CONFIG_WRITE_FAULT);
        saved = if failed { Saved::WriteFailed } else { Saved::Unconfirmed };
    }
    Ok(saved)
}

/// As the API names it.
pub const fn name(saved: Saved) -> &'static str {
    match saved {
        Saved::Stored => "stored",
        Saved::Unconfirmed => "unconfirmed",
        Saved::WriteFailed => "write_failed",
    }
}

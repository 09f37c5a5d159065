//! One camera over RTSP, until it fails.

use std::io;
use std::pin::pin;
use std::time::Duration;

use bytes::Bytes;
use futures_util::StreamExt;
use retina::client::{
    Credentials, Demuxed, PlayOptions, Session, SessionOptions, SetupOptions, TeardownPolicy,
    Transport,
};
use retina::codec::{CodecItem, FrameFormat, ParametersRef, VideoFrame};
use retina::rtcp::ReceivedCompoundPacket;
use tokio::io::{AsyncWrite, AsyncWriteExt};
use tokio::time::{MissedTickBehavior, interval, timeout};
use url::Url;

use crate::clock::Report;
use crate::wire::{Fault, FaultKind, Frame, Picture, Said, Settings, UNIT_MAX};

/// Longest time until a camera plays.
const OPENING: Duration = Duration::from_secs(8);
/// A camera that sends nothing for so long is asked again.
const SILENT: Duration = Duration::from_secs(8);
/// How often the hub hears that the process runs.
const ALIVE: Duration = Duration::from_millis(500);

/// Watches a camera, and says what it sends; returns why it ends.
///
/// # Errors
///
/// The hub reads no more.
pub async fn watch(settings: &Settings, to: &mut (impl AsyncWrite + Unpin)) -> io::Result<Fault> {
    let mut ticks = interval(ALIVE);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut opening = pin!(timeout(OPENING, open(settings)));
    let opened = loop {
        tokio::select! {
            opened = &mut opening => break opened,
            _ = ticks.tick() => say(to, &Said::Alive).await?,
        }
    };
    let (mut session, at) = match opened {
        Ok(Ok(opened)) => opened,
        Ok(Err(fault)) => return Ok(fault),
        Err(_) => return Ok(Fault::new(FaultKind::Unreachable, "no answer in time")),
    };
    let mut report = None;
    let mut silent = pin!(tokio::time::sleep(SILENT));
    loop {
        let item = tokio::select! {
            item = session.next() => item,
            _ = ticks.tick() => {
                say(to, &Said::Alive).await?;
                continue;
            }
            () = &mut silent => return Ok(Fault::new(FaultKind::Silent, "no picture")),
        };
        let frame = match item {
            None => return Ok(Fault::new(FaultKind::Ended, "end of the stream")),
            Some(Err(error)) => return Ok(fault(settings, &error)),
            Some(Ok(CodecItem::Rtcp(packet))) => {
                report = report_of(&packet).or(report);
                continue;
            }
            Some(Ok(CodecItem::VideoFrame(frame))) => frame,
            Some(Ok(_)) => continue,
        };
        silent.as_mut().reset(tokio::time::Instant::now() + SILENT);
        let parameters = session.streams().get(at).and_then(|it| it.parameters());
        match unit(frame, parameters, report) {
            Ok(Some(frame)) => say(to, &Said::Frame(frame)).await?,
            Ok(None) => {}
            Err(fault) => return Ok(fault),
        }
    }
}

/// Writes a message, whole.
///
/// # Errors
///
/// The hub reads no more.
pub async fn say(to: &mut (impl AsyncWrite + Unpin), said: &Said) -> io::Result<()> {
    to.write_all(&said.written()).await?;
    to.flush().await
}

/// A session that plays, and which of its streams the pictures are.
async fn open(settings: &Settings) -> Result<(Demuxed, usize), Fault> {
    let url = Url::parse(&settings.url);
    let url = url.map_err(|error| settings.fault(FaultKind::Missing, &error.to_string()))?;
    let failed = |error: retina::Error| fault(settings, &error);
    let credentials = settings.login.as_ref().map(|login| Credentials {
        username: login.user.clone(),
        password: login.password.clone(),
    });
    // The process ends with its connection: no task is left that could send TEARDOWN later.
    let options = SessionOptions::default()
        .creds(credentials)
        .user_agent("lafet".to_owned())
        .teardown(TeardownPolicy::Never);
    let described = Session::describe(url, options).await;
    let mut session = described.map_err(failed)?;
    let has = |name: &str| {
        let is = |it: &retina::client::Stream| it.media() == "video" && it.encoding_name() == name;
        session.streams().iter().position(is)
    };
    let Some(at) = has("h264").or_else(|| has("h265")) else {
        let names = session.streams().iter().map(|it| it.encoding_name().to_owned());
        let names = names.collect::<Vec<_>>().join(" ");
        return Err(settings.fault(FaultKind::Codec, &names));
    };
    // Parameter sets before each key frame: a viewer may begin with any.
    let options =
        SetupOptions::default().transport(Transport::default()).frame_format(FrameFormat::SIMPLE);
    session.setup(at, options).await.map_err(failed)?;
    let playing = session.play(PlayOptions::default()).await.map_err(failed)?;
    Ok((playing.demuxed().map_err(failed)?, at))
}

fn report_of(packet: &ReceivedCompoundPacket) -> Option<Report> {
    let sent = packet.pkts().find_map(|it| it.as_sender_report().ok().flatten())?;
    Some(Report { ntp: sent.ntp_timestamp().0, rtp: sent.rtp_timestamp() })
}

/// What the hub is sent of a picture; nothing, if it has no content.
fn unit(
    frame: VideoFrame,
    parameters: Option<ParametersRef<'_>>,
    report: Option<Report>,
) -> Result<Option<Frame>, Fault> {
    if frame.data().len() > UNIT_MAX {
        return Err(Fault::new(FaultKind::Large, &frame.data().len().to_string()));
    }
    let time = frame.timestamp();
    let rate = time.clock_rate().get();
    let shown = i128::from(time.elapsed()) * 1_000_000 / i128::from(rate);
    // The low half of the time is what RTP has.
    let rtp = (time.timestamp() & 0xFFFF_FFFF) as u32;
    let picture = match parameters {
        Some(ParametersRef::Video(video)) if frame.is_random_access_point() => {
            let (width, height) = video.pixel_dimensions();
            let side = |it: u32| u16::try_from(it).unwrap_or(u16::MAX);
            let codec = video.rfc6381_codec().to_owned();
            Some(Picture { codec, width: side(width), height: side(height) })
        }
        _ => None,
    };
    let lost = frame.loss();
    let data = Bytes::from(frame.into_data());
    Ok((!data.is_empty()).then_some(Frame {
        key: picture,
        shown_us: i64::try_from(shown).unwrap_or(i64::MAX),
        captured_us: report.and_then(|it| it.date_us(rtp, rate)),
        lost,
        data,
    }))
}

/// The library's errors are opaque: their text and the status of an answer are all that there is.
fn fault(settings: &Settings, error: &retina::Error) -> Fault {
    let text = error.to_string();
    let kind = match error.status_code() {
        Some(401 | 403) => FaultKind::Login,
        Some(400..) => FaultKind::Missing,
        _ if text.starts_with("Unable to connect") => FaultKind::Unreachable,
        _ if text.starts_with("Unsupported") => FaultKind::Codec,
        _ if text.starts_with("Timeout") => FaultKind::Silent,
        _ if text.starts_with("Error reading from RTSP peer") => FaultKind::Ended,
        _ => FaultKind::Broken,
    };
    settings.fault(kind, text.lines().next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use tokio::io::AsyncReadExt;
    use tokio::net::TcpListener;

    use super::*;

    /// What a camera that answers so is taken for.
    async fn of(answer: &'static str) -> Fault {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("rtsp://{}/1", listener.local_addr().unwrap());
        let camera = tokio::spawn(async move {
            let (mut stream, _) = listener.accept().await.unwrap();
            let mut asked = [0; 1024];
            _ = stream.read(&mut asked).await;
            _ = stream.write_all(answer.as_bytes()).await;
        });
        let fault = watch(&Settings { url, login: None }, &mut tokio::io::sink()).await.unwrap();
        camera.await.unwrap();
        fault
    }

    #[tokio::test]
    async fn why_there_is_no_picture_is_known() {
        let login = "RTSP/1.0 401 Unauthorized\r\nCSeq: 1\r\n\
                     WWW-Authenticate: Basic realm=\"camera\"\r\n\r\n";
        assert_eq!(of(login).await.kind, FaultKind::Login);
        let missing = "RTSP/1.0 404 Not Found\r\nCSeq: 1\r\n\r\n";
        assert_eq!(of(missing).await.kind, FaultKind::Missing);
        assert_eq!(of("HTTP/1.1 200 OK\r\n\r\n<html>").await.kind, FaultKind::Broken);
        assert_eq!(of("").await.kind, FaultKind::Ended);
        let sdp = "v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=x\r\nt=0 0\r\n\
                   m=video 0 RTP/AVP 26\r\na=control:1\r\n";
        let jpeg = format!(
            "RTSP/1.0 200 OK\r\nCSeq: 1\r\nContent-Type: application/sdp\r\n\
             Content-Length: {}\r\n\r\n{sdp}",
            sdp.len()
        );
        assert_eq!(of(jpeg.leak()).await.kind, FaultKind::Codec);
    }

    #[tokio::test]
    async fn a_camera_that_is_not_there_is_unreachable() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("rtsp://{}/1", listener.local_addr().unwrap());
        drop(listener);
        let settings = Settings { url, login: None };
        let fault = watch(&settings, &mut tokio::io::sink()).await.unwrap();
        assert_eq!(fault.kind, FaultKind::Unreachable, "{fault:?}");
    }

    /// A camera that takes the connection and says nothing does not keep the hub waiting for a sign of life.
    #[tokio::test(start_paused = true)]
    async fn the_process_says_that_it_runs_while_it_waits() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("rtsp://{}/1", listener.local_addr().unwrap());
        let mut said = Vec::new();
        let fault = watch(&Settings { url, login: None }, &mut said).await.unwrap();
        assert_eq!(fault.kind, FaultKind::Unreachable, "{fault:?}");
        let (mut rest, mut signs) = (&said[..], 0);
        while let Some(said) = Said::read(&mut rest).await.unwrap() {
            assert_eq!(said, Said::Alive);
            signs += 1;
        }
        assert!(signs >= 15, "{signs}");
    }
}

//! A monitor with many parameters behind a serial line: bytes take their time, frames are lost.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lafet_client::{Answers, Client, Config, Error, Progress, Stats};
use lafet_proto::link::Decoder;
use lafet_proto::param::{Param, ParamSpec};
use lafet_proto::record::{Record, Records, Writer};
use lafet_proto::request::Body;
use lafet_proto::{Request, RequestId, Status, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::{Instant, sleep};

use super::frame;

/// How long the monitor thinks before it answers.
const THINKS: Duration = Duration::from_millis(5);
/// The answer buffer.
const ROOM: usize = 512;

/// The line and the monitor behind it.
#[derive(Clone, Debug)]
pub struct SlowLine {
    /// Bits a second; ten bits a byte (8N1).
    pub baud: u32,
    /// Share of frames lost, each way, in thousandths.
    pub loss_permille: u64,
    /// Each so many parameters are kept by a remote unit: NotCached, Cached at first.
    pub remote_every: u16,
    /// Each so many answer Busy at first.
    pub busy_every: u16,
    /// A frame in which one of these parameters is asked for is not answered.
    pub mute: &'static [(SubsystemId, u16)],
    /// Frames of more requests than this are not answered.
    pub records_max: usize,
    pub seed: u64,
}

/// What went over the line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traffic {
    pub frames: u32,
    pub lost: u32,
    pub bytes: usize,
    /// The monitor is off.
    pub off: bool,
}

impl SlowLine {
    pub const fn new(baud: u32, loss_permille: u64) -> Self {
        Self {
            baud,
            loss_permille,
            remote_every: 0,
            busy_every: 0,
            mute: &[],
            records_max: usize::MAX,
            seed: 1,
        }
    }

    fn time(&self, bytes: usize) -> Duration {
        Duration::from_micros(bytes as u64 * 10_000_000 / u64::from(self.baud))
    }

    fn loses(&mut self) -> bool {
        self.seed = self.seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.seed >> 33) % 1000 < self.loss_permille
    }

    /// Serves a stream until it ends.
    pub async fn serve(mut self, mut stream: DuplexStream, traffic: Arc<Mutex<Traffic>>) {
        let mut decoder: Decoder = Decoder::new();
        let mut asked_before = HashMap::new();
        let mut buffer = [0; 2048];
        while let Ok(len @ 1..) = stream.read(&mut buffer).await {
            sleep(self.time(len)).await;
            let mut replies = Vec::new();
            for byte in &buffer[..len] {
                let Some(asked) = decoder.push(*byte) else { continue };
                let (lost, answer_lost) = (self.loses(), self.loses());
                let mut traffic = traffic.lock().unwrap();
                traffic.frames += 1;
                traffic.bytes += len;
                traffic.lost += u32::from(lost || answer_lost);
                if !lost && !traffic.off && self.answers(asked.payload) {
                    let answer = frame(&self.answer(asked.payload, &mut asked_before));
                    traffic.bytes += answer.len();
                    if !answer_lost {
                        replies.extend(answer);
                    }
                }
            }
            if !replies.is_empty() {
                sleep(THINKS + self.time(replies.len())).await;
                if stream.write_all(&replies).await.is_err() {
                    return;
                }
            }
        }
    }

    fn answers(&self, payload: &[u8]) -> bool {
        let id = |data: &[u8]| data.first_chunk().map(|id| u16::from_le_bytes(*id));
        let asked = |record: &Record<'_>| Some((record.device, id(record.data)?));
        let mut all = Records::new(payload).map(Result::unwrap);
        all.clone().count() <= self.records_max
            && !all.any(|record| asked(&record).is_some_and(|it| self.mute.contains(&it)))
    }

    fn answer(
        &self,
        payload: &[u8],
        asked_before: &mut HashMap<(SubsystemId, u16), u32>,
    ) -> Vec<u8> {
        let mut buffer = [0; ROOM];
        let mut out = Writer::new(&mut buffer);
        for record in Records::new(payload) {
            let Record { request, device, data, .. } = record.unwrap();
            let bare = |status, data| Record { request, device, status, data };
            let Some(id) = data.first_chunk().map(|id| u16::from_le_bytes(*id)) else {
                // The two requests that number a frame.
                out.push(&bare(Status::MODULE_NOT_EXIST, &[])).unwrap();
                continue;
            };
            let before = asked_before.entry((device, id)).or_insert(0);
            *before += 1;
            let not_yet = |every: u16| every > 0 && id.is_multiple_of(every) && *before <= 2;
            let later =
                if request == RequestId::GET_PARAM { Status::NOT_CACHED } else { Status::CACHED };
            let value = value_of(device, id).to_le_bytes();
            let values = [&data[..2], &value].concat();
            let answer = match request {
                _ if not_yet(self.remote_every) => bare(later, &data[..2]),
                _ if not_yet(self.busy_every) => bare(Status::BUSY, &[]),
                RequestId::GET_PARAM => bare(Status::OK, &values),
                _ => bare(Status::ACCEPTED, &data[..2]),
            };
            out.push(&answer).expect("the client leaves room");
        }
        out.written().to_vec()
    }
}

/// Every parameter has a value of its own, so that a wrong one is found out.
pub fn value_of(device: SubsystemId, id: u16) -> i32 {
    i32::from(id) * 7919 + i32::from(device.0)
}

/// So many reads of parameters of the dictionary that have one value.
pub fn reads(count: usize) -> Vec<Request<'static>> {
    let scalar = Param::ALL.into_iter().map(Param::spec).filter(|spec| spec.max_len == 1);
    let read =
        |spec: &'static ParamSpec| Request::new(spec.subsystem, Body::GetParam { id: spec.id });
    scalar.cycle().take(count).map(read).collect()
}

/// Reads them, several in a frame or one, and how long that took on the line's clock.
pub async fn read_all(line: SlowLine, count: usize, several: bool) -> Reading {
    let (ours, theirs) = lafet_client::transport::memory::pair();
    let traffic = Arc::new(Mutex::new(Traffic::default()));
    tokio::spawn(line.serve(theirs, traffic.clone()));
    let client = Client::over("sim:", ours, Config::default());
    let requests = reads(count);
    let (began, mut told) = (Instant::now(), Vec::new());
    let results = if several {
        client.complete(&requests, |progress| told.push(progress)).await
    } else {
        let mut results = Vec::new();
        for request in &requests {
            results.push(client.request(request).await);
        }
        results
    };
    let took = began.elapsed();
    let right = |(request, result): &(&Request<'_>, &Result<Answers, Error>)| {
        let (Body::GetParam { id }, Ok(answers)) = (request.body, result) else { return false };
        let expected = value_of(request.to, id.0).to_le_bytes();
        answers.first().data().ends_with(&expected)
    };
    let right = requests.iter().zip(&results).filter(right).count();
    let traffic = *traffic.lock().unwrap();
    Reading { took, right, told, traffic, stats: client.stats() }
}

/// What came of reading many parameters.
pub struct Reading {
    pub took: Duration,
    /// Values that are what they should be.
    pub right: usize,
    pub told: Vec<Progress>,
    pub traffic: Traffic,
    pub stats: Stats,
}

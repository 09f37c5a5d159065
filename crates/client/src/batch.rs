//! Batches: several requests in a frame; those that were not executed are sent again one by one.

use std::time::Duration;

use lafet_proto::link::PAYLOAD_MAX;
use lafet_proto::record::HEADER_SIZE;
use lafet_proto::{Request, RequestId, Status};
use tokio::time::{Instant, sleep_until};

use crate::answers::{Answers, RequestBuf, Requests};
use crate::client::{Client, not_sent, odd};
use crate::deviation::Deviation;
use crate::engine::{Ended, Reply};
use crate::error::{Cause, Error};
use crate::plan::frame_len;
use crate::session::{Outcome, Slot, Slots, Ticket};

/// Most requests in a frame.
const FRAME_MAX: usize = PAYLOAD_MAX / HEADER_SIZE;
/// First pause before a request answered with Busy, NotCached or Cached is repeated; doubled each
/// time.
const RESUME_FIRST: Duration = Duration::from_millis(100);
/// The longest pause.
const RESUME_LAST: Duration = Duration::from_secs(1);
/// After so many answers to frames of the greatest length, one of twice as many requests is tried.
const STEADY: u32 = 16;
/// So often is one request sent after a frame without answer before it fails.
const ALONE: u32 = 4;

type Outcomes = Vec<Result<Answers, Error>>;

/// Progress of [`Client::complete`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Requests that have a result.
    pub done: usize,
    /// Requests in total.
    pub total: usize,
    /// Frames answered so far.
    pub frames: u32,
    /// Repetitions of requests because of Busy, NotCached, Cached, NoRoom or no answer.
    pub again: u32,
}

impl Client {
    /// Sends requests in order, several in a frame, and waits for all answers; returns one result
    /// for each request. If a frame gets no answer, the frames after it are not sent; if a request
    /// does not fit a record, none is sent.
    pub async fn batch(&self, requests: &[Request<'_>]) -> Vec<Result<Answers, Error>> {
        let encoded: Vec<_> = requests.iter().map(RequestBuf::new).collect();
        if encoded.iter().all(Result::is_ok) {
            return self.run(encoded.into_iter().flatten().collect()).await;
        }
        let refuse = |one: Result<RequestBuf, Error>| {
            Err(one.map_or_else(|error| error, |fine| not_sent(&fine, Cause::EarlierFailed)))
        };
        encoded.into_iter().map(refuse).collect()
    }

    /// Like [`Client::batch`], but repeats what was not executed: a read or SetParam that is
    /// answered with Busy, NotCached or Cached is sent again, alone, for at most `Config::resume`
    /// (the others continue meanwhile). After a frame of reads without answer its first request is
    /// sent alone, because short frames pass a noisy line more easily; with each answer the next
    /// frame has twice as many, up to what passes. If the request alone is not answered four times
    /// (with all tries of a request each), it fails, and the batch ends; if the monitor answered
    /// others before, the next request is tried first, but only once in a batch. A read that is the
    /// only request is asked twice. Every other request is sent once.
    pub async fn complete(
        &self,
        requests: &[Request<'_>],
        progress: impl FnMut(Progress),
    ) -> Vec<Result<Answers, Error>> {
        let encoded: Vec<_> = requests.iter().map(RequestBuf::new).collect();
        let results = encoded.iter().map(|one| one.as_ref().err().cloned().map(Err)).collect();
        let indexed = encoded.into_iter().enumerate();
        let items = indexed.filter_map(|(index, one)| Some(Item::new(index, one.ok()?))).collect();
        let complete = Complete {
            client: self,
            results,
            items,
            first: None,
            limit: FRAME_MAX,
            longest: FRAME_MAX,
            steady: 0,
            passed: 0,
            left: None,
            passed_over: false,
            told: Progress { total: requests.len(), ..Progress::default() },
            progress,
        };
        complete.run().await
    }

    /// Runs one request.
    pub(crate) async fn run_one(&self, request: RequestBuf) -> Result<Answers, Error> {
        let mut first = None;
        loop {
            let frame = Requests::from_buf([request.clone()]);
            let ended = self.exchange(frame, first, None).await;
            let Some(Ok(Ended { outcome: Outcome::Answered(slots), ticket, .. })) = ended else {
                return Err(self.failure(&request, &ended));
            };
            first = first.or(ticket);
            if let Some(Slot::Answered(answers)) = slots.into_iter().next()
                && fits(&answers, &request, 0)
            {
                return well_formed(self.endpoint(), &request, answers);
            }
        }
    }

    /// Runs one frame of requests that belong together: if one finds no room, it is not repeated
    /// without the others.
    pub(crate) async fn run_frame(
        &self,
        requests: Vec<RequestBuf>,
        expires: Option<Instant>,
    ) -> Outcomes {
        let sent = self.exchange_of_motion(requests.iter().cloned().collect(), expires);
        let ended = sent.await;
        let Some(Ok(Ended { outcome: Outcome::Answered(slots), .. })) = ended else {
            return requests.iter().map(|request| Err(self.failure(request, &ended))).collect();
        };
        let result = |(slot, request)| match slot {
            Slot::Answered(answers) => well_formed(self.endpoint(), request, answers),
            _ => Err(not_sent(request, Cause::EarlierFailed)),
        };
        slots.into_iter().zip(&requests).map(result).collect()
    }

    pub(crate) async fn run(&self, requests: Vec<RequestBuf>) -> Outcomes {
        let mut results: Vec<_> =
            requests.iter().map(|request| Err(not_sent(request, Cause::EarlierFailed))).collect();
        let mut waiting: Vec<usize> = (0..requests.len()).collect();
        let mut first = None;
        while !waiting.is_empty() {
            let upcoming: Vec<RequestBuf> =
                waiting.iter().take(FRAME_MAX).map(|index| requests[*index].clone()).collect();
            let len = frame_len(&upcoming, self.config.framing);
            let frame: Vec<usize> = waiting.drain(..len).collect();
            let frame_requests = upcoming.into_iter().take(len).collect();
            let ended = self.exchange(frame_requests, first, None).await;
            let Some(Ok(Ended { outcome: Outcome::Answered(slots), ticket, .. })) = ended else {
                for index in frame {
                    results[index] = Err(self.failure(&requests[index], &ended));
                }
                break;
            };
            first = first.or(ticket);
            let mut again = Vec::new();
            for (place, (index, slot)) in frame.into_iter().zip(slots).enumerate() {
                match slot {
                    Slot::Answered(answers) if fits(&answers, &requests[index], place) => {
                        results[index] = well_formed(self.endpoint(), &requests[index], answers);
                    }
                    _ => again.push(index),
                }
            }
            waiting.splice(..0, again);
        }
        results
    }
}

/// The answers that conform to the protocol. Among several subsystems, a deviation of one does not
/// invalidate the answers of the others, as long as every record can be read.
pub(crate) fn well_formed(
    endpoint: &str,
    request: &RequestBuf,
    answers: Answers,
) -> Result<Answers, Error> {
    let group = answers.len() > 1;
    let wrong = |what: &Deviation| !group || matches!(what, Deviation::Shape(_));
    let odd_one = answers.iter().find_map(|answer| {
        let what = answer.deviation().filter(wrong)?;
        Some((answer.from(), what))
    });
    match odd_one {
        Some((from, what)) => Err(odd(request, from, what, endpoint)),
        None => Ok(answers),
    }
}

/// A request without result so far.
struct Item {
    index: usize,
    request: RequestBuf,
    /// The earliest time to send it.
    due: Option<Instant>,
    /// The next pause before a repetition.
    pause: Duration,
    /// Time after which it is not repeated.
    until: Option<Instant>,
}

impl Item {
    const fn new(index: usize, request: RequestBuf) -> Self {
        Self { index, request, due: None, pause: RESUME_FIRST, until: None }
    }
}

struct Complete<'a, P> {
    client: &'a Client,
    results: Vec<Option<Result<Answers, Error>>>,
    items: Vec<Item>,
    first: Option<Ticket>,
    /// Most requests in the next frame.
    limit: usize,
    /// Most that a frame has until enough frames of this length are answered: fewer than in one
    /// without answer that may have been too long.
    longest: usize,
    /// Answered frames of this length.
    steady: u32,
    /// Most requests in a frame that was answered.
    passed: usize,
    /// If the last frame was not answered: so many more of one request may be sent.
    left: Option<u32>,
    /// The batch went on after a request that was not answered.
    passed_over: bool,
    told: Progress,
    progress: P,
}

impl<P: FnMut(Progress)> Complete<'_, P> {
    async fn run(mut self) -> Outcomes {
        self.tell();
        while !self.items.is_empty() {
            let frame = self.next_frame();
            if frame.is_empty() {
                if let Some(due) = self.items.iter().filter_map(|item| item.due).min() {
                    sleep_until(due).await;
                }
                continue;
            }
            let requests = frame.iter().map(|item| item.request.clone()).collect();
            let ended = self.client.exchange(requests, self.first, None).await;
            let more = match ended {
                Some(Ok(Ended { outcome: Outcome::Answered(slots), ticket, .. })) => {
                    self.first = self.first.or(ticket);
                    self.answered(frame, slots);
                    true
                }
                ended => self.failed(frame, &ended),
            };
            self.tell();
            if !more {
                break;
            }
        }
        let Self { mut results, items, .. } = self;
        for item in items {
            results[item.index] = Some(Err(not_sent(&item.request, Cause::EarlierFailed)));
        }
        results.into_iter().map(|result| result.unwrap_or(Err(Error::Closed))).collect()
    }

    fn tell(&mut self) {
        self.told.done = self.told.total - self.items.len();
        (self.progress)(self.told);
    }

    /// Takes the items of the next frame; reads are not mixed with requests that may be sent only
    /// once.
    fn next_frame(&mut self) -> Vec<Item> {
        let now = Instant::now();
        let is_due = |item: &&Item| item.due.is_none_or(|due| now >= due);
        let due: Vec<&Item> = self.items.iter().filter(is_due).take(self.limit).collect();
        let Some(kind) = due.first().map(|item| item.request.is_repeatable()) else {
            return Vec::new();
        };
        let same = due.iter().take_while(|item| item.request.is_repeatable() == kind);
        let requests: Vec<RequestBuf> = same.map(|item| item.request.clone()).collect();
        let len = frame_len(&requests, self.client.config.framing);
        let taken: Vec<usize> = due.iter().take(len).map(|item| item.index).collect();
        let (frame, rest) = self.items.drain(..).partition(|item| taken.contains(&item.index));
        self.items = rest;
        frame
    }

    fn answered(&mut self, frame: Vec<Item>, slots: Slots) {
        self.told.frames += 1;
        self.left = None;
        self.grow(frame.len());
        let mut again = Vec::new();
        for (place, (mut item, slot)) in frame.into_iter().zip(slots).enumerate() {
            match slot {
                Slot::Answered(answers) if fits(&answers, &item.request, place) => {
                    match self.resume(&mut item, &answers) {
                        true => again.push(item),
                        false => {
                            let result =
                                well_formed(self.client.endpoint(), &item.request, answers);
                            self.results[item.index] = Some(result);
                        }
                    }
                }
                _ => again.push(item),
            }
        }
        self.told.again += again.len() as u32;
        self.items.splice(..0, again);
    }

    /// Chooses the length of the next frame after an answer to one of this length.
    fn grow(&mut self, len: usize) {
        self.passed = self.passed.max(len);
        if len >= self.longest {
            self.steady += 1;
            if self.steady >= STEADY {
                (self.longest, self.steady) = ((self.longest * 2).min(FRAME_MAX), 0);
            }
        }
        self.limit = (self.limit * 2).min(self.longest);
    }

    /// Takes note of a frame of reads of this length without answer; returns how many more frames
    /// may be sent.
    fn silent(&mut self, len: usize) -> u32 {
        // Frames of a length that passed before were lost by chance.
        if len > self.passed.max(1) {
            (self.longest, self.steady) = (self.passed.midpoint(len).max(1), 0);
        }
        self.limit = 1;
        let most = if len == 1 && self.told.frames == 0 { 1 } else { ALONE };
        let left = self.left.map_or(most, |left| left.saturating_sub(1));
        self.left = Some(left);
        left
    }

    /// Schedules a repetition if an answer says "later" and time is left; returns whether it did.
    fn resume(&self, item: &mut Item, answers: &Answers) -> bool {
        if !answers.iter().any(|answer| says_later(item.request.id(), answer.status())) {
            return false;
        }
        let now = Instant::now();
        let until = *item.until.get_or_insert(now + self.client.config.resume);
        item.due = Some(now + item.pause);
        item.pause = (item.pause * 2).min(RESUME_LAST);
        item.due.is_some_and(|due| due < until)
    }

    /// Handles a frame without answer; returns whether to continue.
    fn failed(&mut self, frame: Vec<Item>, ended: &Option<Reply>) -> bool {
        let outcome = ended.as_ref().and_then(|ended| Some(&ended.as_ref().ok()?.outcome));
        let odd = matches!(outcome, Some(Outcome::Odd { .. }));
        let silent = matches!(outcome, Some(Outcome::Silence { .. }));
        let reads = frame.iter().all(|item| item.request.is_repeatable());
        let alone = frame.len() == 1;
        let apart = if silent && reads {
            self.silent(frame.len()) > 0
        } else {
            self.left = None;
            odd && !alone
        };
        if reads && apart {
            if odd {
                self.limit = frame.len() / 2;
            }
            self.told.again += frame.len() as u32;
            self.items.splice(..0, frame);
            return true;
        }
        for item in frame {
            let error = self.client.failure(&item.request, ended);
            self.results[item.index] = Some(Err(error));
        }
        // A monitor that answers one read wrongly may answer the next correctly, and so may one that
        // leaves one read without answer. The next shows whether it is there.
        let passes_over = silent && reads && self.told.frames > 0 && !self.passed_over;
        if passes_over {
            (self.passed_over, self.left) = (true, Some(1));
        }
        reads && (passes_over || (odd && alone))
    }
}

/// §2, §3.4, §3.5: whether the request was not executed, but may be later.
fn says_later(request: RequestId, status: Status) -> bool {
    match request {
        RequestId::GET_PARAM => matches!(status, Status::NOT_CACHED | Status::BUSY),
        RequestId::SET_PARAM => matches!(status, Status::CACHED | Status::BUSY),
        RequestId::GET_STATUS | RequestId::RETRIEVE_LIMITS | RequestId::GET_HOTBED => {
            status == Status::BUSY
        }
        _ => false,
    }
}

/// Whether an answer is final. A request that found no room after others is repeated alone (§1, §2:
/// the client repeats what was not processed); one that found no room alone never fits.
pub(crate) fn fits(answers: &Answers, request: &RequestBuf, place: usize) -> bool {
    place == 0 || !answers.lacks_room() || !request.is_read()
}

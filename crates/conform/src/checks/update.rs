//! §U: the update of the software over the link (ours; docs/update.md). No key is needed: no order here starts an
//! update or commits one, and a monitor on which one is under way is left alone.

use lafet_proto::update::KEY;
use lafet_proto::{ParamId, RequestId as R, Status, SubsystemId as S};
use lafet_texts::{Fixed, Shown, conform as text};

use super::{bits, le, motion, service};
use crate::bench::Bench;
use crate::raw::{self, Rec, several};
use crate::verdict::{Step, fail, must, not_applicable};

/// The orders, by their numbers.
const STATE: u8 = 0;
const BEGIN: u8 = 1;
const DATA: u8 = 2;
const VERIFY: u8 = 3;
const COMMIT: u8 = 4;
const CONFIRM: u8 = 5;
const ABANDON: u8 = 6;
/// Numbers that no order has.
const NO_ORDERS: [u8; 4] = [7, 8, 128, 255];
/// Bytes of a report, of a header, of a digest, of a word.
const REPORT: usize = 24;
const HEADER: usize = 160;
const DIGEST: usize = 32;
const WORD: usize = 16;
/// Where a report has why the last order was not carried out.
const REASON: usize = 3;
/// The greatest of the numbered reasons, and the one without a state for the order.
const REASON_MAX: u8 = 21;
const NOT_READY: u8 = 255;
/// A board that no monitor is built with.
const NO_BOARD: &str = "lafet-conform-no";
/// An accepted order is carried out within this time: a signature may take seconds, ms.
const CARRIED_OUT_MS: u64 = 20_000;
/// A valve that the lockout closes once more has come to rest by then, ms.
const READY_MS: u64 = 60_000;

/// A report.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Report([u8; REPORT]);

impl Report {
    /// That of an answer of General.
    fn of(rec: &Rec) -> Step<Self> {
        match rec.data.first_chunk() {
            Some(bytes) if rec.data.len() == REPORT && rec.device == S::GENERAL => Ok(Self(*bytes)),
            _ => fail(text::ReportOf24Bytes, Shown(rec.words(true))),
        }
    }

    const fn head(&self) -> [u8; 4] {
        let [phase, slot, flags, reason, ..] = self.0;
        [phase, slot, flags, reason]
    }

    const fn is_idle(&self) -> bool {
        let [phase, _, flags, _] = self.head();
        // Not on trial, no order that waits, no commit that a later start may try.
        phase == 0 && flags & 0b1101 == 0
    }

    const fn waits(&self) -> bool {
        self.head()[2] & 4 != 0
    }

    const fn reason(&self) -> u8 {
        self.head()[3]
    }

    /// Bytes that are there, bytes of the payload.
    fn sizes(&self) -> [u32; 2] {
        let [_, _, _, _, r0, r1, r2, r3, s0, s1, s2, s3, ..] = self.0;
        [[r0, r1, r2, r3], [s0, s1, s2, s3]].map(u32::from_le_bytes)
    }

    /// What is running: slot and version.
    fn running(&self) -> (u8, &[u8]) {
        (self.head()[1], self.0.get(12..20).unwrap_or_default())
    }

    /// Whether it says what a monitor can say.
    fn is_possible(&self) -> bool {
        let [phase, slot, flags, reason] = self.head();
        let [received, size] = self.sizes();
        let nothing = received == 0 && size == 0;
        phase <= 4
            && matches!(slot, 1 | 2)
            && flags < 32
            && (reason <= REASON_MAX || reason == NOT_READY)
            && received <= size
            && (phase > 0 || nothing)
    }

    /// Whether it is the same but for the reason, which is that of the last order.
    fn is_as(&self, other: &Self) -> bool {
        let both = self.0.iter().zip(&other.0).enumerate();
        both.into_iter().all(|(at, (one, other))| at == REASON || one == other)
    }

    fn hex(&self) -> String {
        raw::hex(&self.0)
    }
}

/// The data of an order: its number, the key, what else it has.
fn order(kind: u8, key: u16, rest: &[u8]) -> Vec<u8> {
    [&[kind][..], &key.to_le_bytes(), rest].concat()
}

/// Every order but the state, with this key. None of them could be carried out: no header is an image, nothing
/// was received, no word confirms anything.
fn orders(key: u16) -> [Vec<u8>; 5] {
    [
        order(BEGIN, key, &[0; HEADER + DIGEST]),
        order(DATA, key, &[0; 4 + 8]),
        order(VERIFY, key, &[]),
        order(COMMIT, key, &[0; DIGEST]),
        order(CONFIRM, key, &[0; WORD]),
    ]
}

/// The report of a monitor that has to have one.
fn state(b: &mut Bench<'_>) -> Step<Report> {
    let rec = b.want(R::UPDATE, S::GENERAL, &[STATE], S::GENERAL, &[Status::OK])?;
    Report::of(&rec)
}

/// Whether the monitor has no such request.
fn is_absent(b: &mut Bench<'_>) -> Step<bool> {
    let rec = b.ask(R::UPDATE, S::GENERAL, &[STATE])?;
    let unknown = if b.found.locked_out { Status::DENIED } else { Status::WRONG_REQUEST };
    Ok(rec.data.is_empty() && rec.status == unknown)
}

/// The first report; not applicable to a monitor whose software is not updated over its link.
fn present(b: &mut Bench<'_>) -> Step<Report> {
    match is_absent(b)? {
        true => not_applicable(text::NoUpdateOverLink),
        false => state(b),
    }
}

/// The same of a monitor on which none is under way.
fn idle(b: &mut Bench<'_>) -> Step<Report> {
    let found = present(b)?;
    match found.is_idle() {
        true => Ok(found),
        false => not_applicable(text::UpdateUnderWay),
    }
}

/// An order that is refused at once, with a report that is the one before.
fn refused(b: &mut Bench<'_>, data: &[u8], status: Status, before: &Report) -> Step {
    let rec = b.want(R::UPDATE, S::GENERAL, data, S::GENERAL, &[status])?;
    let report = Report::of(&rec)?;
    must(report == *before, text::NothingCarriedOut, report.hex())?;
    let now = state(b)?;
    must(now == *before, text::NothingCarriedOut, now.hex())
}

/// Standby, locked out, and that stored: orders are accepted then.
fn ready(b: &mut Bench<'_>) -> Step<Report> {
    let found = idle(b)?;
    if b.has(S::DEPLOYER) {
        b.wrapped()?;
    }
    service::locked_and_stored(b)?;
    let verify = order(VERIFY, KEY, &[]);
    b.until(READY_MS, text::OrdersAccepted, |b| {
        let rec = b.ask(R::UPDATE, S::GENERAL, &verify)?;
        Ok(rec.status == Status::ACCEPTED)
    })?;
    b.until(CARRIED_OUT_MS, text::OrderWaitsNoMore, |b| Ok(!state(b)?.waits()))?;
    Ok(found)
}

/// An order that is accepted; returns the report once it does not wait any more.
fn accepted(b: &mut Bench<'_>, data: &[u8]) -> Step<Report> {
    let rec = b.want(R::UPDATE, S::GENERAL, data, S::GENERAL, &[Status::ACCEPTED])?;
    let mut report = Report::of(&rec)?;
    b.until(CARRIED_OUT_MS, text::OrderWaitsNoMore, |b| {
        report = state(b)?;
        Ok(!report.waits())
    })?;
    Ok(report)
}

/// §U
pub fn report(b: &mut Bench<'_>) -> Step {
    let first = present(b)?;
    must(first.is_possible(), text::ReportPossible, first.hex())?;
    let second = state(b)?;
    must(second.running() == first.running(), text::SameSoftware, second.hex())?;
    must(second == first || !first.is_idle(), text::NothingCarriedOut, second.hex())
}

/// §U/9
pub fn parameters(b: &mut Bench<'_>) -> Step {
    let found = present(b)?;
    let (slot, version) = found.running();
    let numbers = version.as_chunks().0.iter().map(|bytes| i32::from(u16::from_le_bytes(*bytes)));
    let version: Vec<i32> = numbers.collect();
    same_value(b, "SoftwareVersion", |values| values == version)?;
    same_value(b, "SoftwareSlot", |values| values == [i32::from(slot)])?;
    let beginning = found.0.last_chunk().copied().map(i32::from_be_bytes);
    // While an update is under way, the report has the hash of the other image.
    let known = beginning.filter(|_| found.is_idle());
    same_value(b, "SoftwareHash", |values| {
        values.len() == 8 && known.is_none_or(|known| values.first() == Some(&known))
    })
}

/// §U/9 It would be the slot that is running already.
pub fn parameters_set(b: &mut Bench<'_>) -> Step {
    let (slot, _) = present(b)?.running();
    let id = ParamId::of("SoftwareSlot").0.to_le_bytes();
    let set = [&id[..], &i32::from(slot).to_le_bytes()].concat();
    let rec = b.ask(R::SET_PARAM, S::GENERAL, &set)?;
    must(rec.status == Status::ACCESS_DENIED, text::SoftwareNotSet, rec.words(true))
}

fn same_value(b: &mut Bench<'_>, name: &str, is_same: impl Fn(&[i32]) -> bool) -> Step {
    let values = b.get(S::GENERAL, name)?;
    let right = values.as_deref().is_some_and(is_same);
    let values = values.unwrap_or_default();
    must(right, text::SoftwareParameters, format!("{name}: {}", several(&values)))
}

/// §U/1
pub fn state_everywhere(b: &mut Bench<'_>) -> Step {
    let found = idle(b)?;
    let same = |b: &mut Bench<'_>| {
        let now = state(b)?;
        must(now.is_as(&found), text::SameSoftware, now.hex())
    };
    b.deployed()?;
    same(b)?;
    if let Some(id) = [S::HORIZONTAL, S::VERTICAL].into_iter().find(|id| b.has(*id)) {
        b.moves(&[id]);
        let (sign, _) = motion::room(b, id)?;
        b.done(R::MOVE, id, &le(sign * motion::FAR))?;
        b.wait(300)?;
        same(b)?;
    }
    service::locked(b)?;
    same(b)?;
    service::released(b)?;
    let asked_ms = b.now_ms();
    service::restart(b)?;
    let restarting = same(b);
    let in_time = b.now_ms() - asked_ms < 200;
    service::back(b)?;
    if restarting.is_err() && !in_time {
        return not_applicable(text::LineTooSlow);
    }
    restarting?;
    same(b)
}

/// §U/2 A wrong key, so that nothing could be carried out even if a size were taken.
pub fn sizes(b: &mut Bench<'_>) -> Step {
    let found = idle(b)?;
    let of = |kind, size| order(kind, !KEY, &vec![0; size]);
    let sizes = [
        vec![],
        vec![STATE, 0],
        vec![BEGIN],
        vec![VERIFY, 0],
        of(BEGIN, HEADER + DIGEST - 1),
        of(BEGIN, HEADER + DIGEST + 1),
        of(DATA, 0),
        of(DATA, 4),
        of(DATA, 4 + 7),
        of(DATA, 4 + 12),
        of(DATA, 4 + HEADER),
        of(VERIFY, 1),
        of(COMMIT, DIGEST - 1),
        of(COMMIT, DIGEST + 1),
        of(CONFIRM, WORD - 1),
        of(CONFIRM, WORD + 1),
        of(ABANDON, DIGEST - 1),
        of(ABANDON, DIGEST + 1),
    ];
    for data in sizes {
        let rec = b.want(R::UPDATE, S::GENERAL, &data, S::GENERAL, &[Status::WRONG_DATA])?;
        must(rec.data.is_empty(), text::WrongDataWithoutReport, rec.words(true))?;
    }
    let now = state(b)?;
    must(now == found, text::NothingCarriedOut, now.hex())
}

/// §U/2
pub fn no_order(b: &mut Bench<'_>) -> Step {
    let found = idle(b)?;
    for kind in NO_ORDERS {
        for rest in [&[][..], &[0; 8]] {
            refused(b, &order(kind, KEY, rest), Status::INVALID_VALUE, &found)?;
        }
    }
    Ok(())
}

/// §U/3
pub fn key(b: &mut Bench<'_>) -> Step {
    let found = idle(b)?;
    for wrong in [0, KEY ^ 1, KEY.swap_bytes(), !KEY] {
        for data in orders(wrong) {
            refused(b, &data, Status::NEED_CONFIRM, &found)?;
        }
    }
    Ok(())
}

/// §U/4
pub fn not_locked_out(b: &mut Bench<'_>) -> Step {
    let found = idle(b)?;
    b.needs_release()?;
    for data in orders(KEY) {
        refused(b, &data, Status::DENIED, &found)?;
    }
    Ok(())
}

/// §U/4
pub fn not_stowed(b: &mut Bench<'_>) -> Step {
    let found = idle(b)?;
    b.needs(S::DEPLOYER)?;
    b.deployed()?;
    service::locked_and_stored(b)?;
    for data in orders(KEY) {
        refused(b, &data, Status::DENIED, &found)?;
    }
    Ok(())
}

/// A header of the right form: version 65535 of this board, that reads every layout of parameters; what has to be
/// its signature is none.
fn header(board: &str, key: u8, size: u32) -> [u8; HEADER] {
    let mut header = [0x5A; HEADER];
    let mut name = [0; 16];
    name.iter_mut().zip(board.bytes()).for_each(|(to, from)| *to = from);
    let fields: [(usize, &[u8]); 7] = [
        (0, b"LAFETIMG"),
        (8, &[1, 0, 0, 0]),
        (12, &size.to_le_bytes()),
        (16, &[0xFF; 8]),
        (24, &name),
        (40, &[0, key, 0, 0, 0, 0, 0xFF, 0xFF]),
        (48, &[0; 16]),
    ];
    for (at, field) in fields {
        header.iter_mut().skip(at).zip(field).for_each(|(to, from)| *to = *from);
    }
    header
}

/// A header, what is wrong with it, and the reasons of which one has to be given.
type Bad = ([u8; HEADER], Fixed, &'static [u8]);

/// Headers that no monitor takes. What is checked first decides: form, board, key, signature.
fn headers(board: Option<&str>) -> Vec<Bad> {
    let with = |at: usize, bytes: &[u8]| {
        let mut header = header(NO_BOARD, 0, 8);
        header.iter_mut().skip(at).zip(bytes).for_each(|(to, from)| *to = *from);
        header
    };
    let field = text::HeaderField.fixed();
    let mut all: Vec<Bad> = vec![
        ([0; HEADER], text::HeaderNoImage.fixed(), &[1]),
        (with(7, b"g"), text::HeaderNoImage.fixed(), &[1]),
        (with(8, &[2, 0]), text::HeaderFormat.fixed(), &[2]),
        (with(10, &[1]), field, &[3]),
        (with(24, b" "), field, &[3]),
        (with(40, &[3]), field, &[3]),
        (with(41, &[16]), field, &[3]),
        (with(44, &[2, 0, 1, 0]), field, &[3]),
        (with(63, &[1]), field, &[3]),
        (with(42, &[1]), text::HeaderRevokes.fixed(), &[9]),
        (with(0, b"L"), text::HeaderBoard.fixed(), &[4]),
        (with(12, &[0; 4]), text::HeaderBoard.fixed(), &[4]),
        (with(12, &[0xF8, 0xFF, 0xFF, 0xFF]), text::HeaderBoard.fixed(), &[4]),
    ];
    if let Some(board) = board {
        let forged = (0..16).map(|key| header(board, key, 8));
        all.extend(forged.map(|it| (it, text::HeaderForged.fixed(), &[7, 8, 10][..])));
        let large = header(board, 0, u32::MAX - 7);
        all.push((large, text::HeaderLarge.fixed(), &[6, 7, 8, 10]));
    }
    all
}

/// §U/5
pub fn begin(b: &mut Bench<'_>) -> Step {
    let found = ready(b)?;
    for (header, what, reasons) in headers(b.options.board.as_deref()) {
        let data = order(BEGIN, KEY, &[&header[..], &[0; DIGEST]].concat());
        let report = accepted(b, &data)?;
        let expected = text::NotStarted { what, reasons: raw::several(reasons) };
        must(reasons.contains(&report.reason()), expected, report.hex())?;
        must(report.is_as(&found), text::NothingCarriedOut, report.hex())?;
    }
    Ok(())
}

/// §U/6
pub fn nothing_started(b: &mut Bench<'_>) -> Step {
    let found = ready(b)?;
    for offset in [0_u32, 8] {
        let data = order(DATA, KEY, &[&offset.to_le_bytes()[..], &[0; 8]].concat());
        let rec = b.want(R::UPDATE, S::GENERAL, &data, S::GENERAL, &[Status::INVALID_VALUE])?;
        let report = Report::of(&rec)?;
        must(report.is_as(&found), text::NothingCarriedOut, report.hex())?;
    }
    for (kind, rest, reason) in
        [(VERIFY, &[][..], 13), (COMMIT, &[0; DIGEST], 17), (CONFIRM, &[0; WORD], 19)]
    {
        let report = accepted(b, &order(kind, KEY, rest))?;
        must(report.reason() == reason, text::NotCarriedOut { reason }, report.hex())?;
        must(report.is_as(&found), text::NothingCarriedOut, report.hex())?;
        let flags = b.flags(S::GENERAL)?;
        must(flags & bits::RESTARTING == 0, text::DoesNotRestart, format!("{flags:#010x}"))?;
    }
    Ok(())
}

/// Any order, to a monitor that knows none.
fn unknown(b: &mut Bench<'_>, to: S, status: Status) -> Step {
    let more = [vec![], vec![STATE], order(NO_ORDERS[0], KEY, &[])];
    for data in orders(KEY).into_iter().chain(more) {
        let rec = b.want(R::UPDATE, to, &data, S::GENERAL, &[status])?;
        must(rec.data.is_empty(), text::AnswerWithoutData, rec.words(true))?;
    }
    // It goes on as before.
    b.flags(S::GENERAL)?;
    b.watch()
}

/// Not applicable to a monitor that has the request.
fn absent(b: &mut Bench<'_>) -> Step {
    let rec = b.ask(R::UPDATE, S::GENERAL, &[STATE])?;
    match rec.status {
        Status::OK => not_applicable(text::HasUpdate),
        _ => Ok(()),
    }
}

/// §U/7
pub fn without(b: &mut Bench<'_>) -> Step {
    absent(b)?;
    let status = if b.found.locked_out { Status::DENIED } else { Status::WRONG_REQUEST };
    for to in [S::GENERAL, S::HORIZONTAL, S::ALL] {
        unknown(b, to, status)?;
    }
    Ok(())
}

/// §U/7
pub fn without_locked(b: &mut Bench<'_>) -> Step {
    absent(b)?;
    service::locked(b)?;
    unknown(b, S::GENERAL, Status::DENIED)
}

/// A request that is refused without a report.
fn bare(b: &mut Bench<'_>, to: S, from: S, status: Status) -> Step {
    let rec = b.want(R::UPDATE, to, &[STATE], from, &[status])?;
    must(rec.data.is_empty(), text::AnswerWithoutData, rec.words(true))
}

/// §U/8
pub fn addressee(b: &mut Bench<'_>) -> Step {
    let found = present(b)?;
    for to in [S::ALL, S::MOTORS] {
        bare(b, to, S::GENERAL, Status::WRONG_REQUEST)?;
    }
    bare(b, S(0x00), S(0x00), Status::MODULE_NOT_EXIST)?;
    for id in S::CHAIN.into_iter().filter(|id| *id != S::GENERAL) {
        let there = b.has(id);
        let status = if there { Status::WRONG_REQUEST } else { Status::MODULE_NOT_EXIST };
        bare(b, id, id, status)?;
    }
    let now = state(b)?;
    must(now.running() == found.running(), text::SameSoftware, now.hex())
}

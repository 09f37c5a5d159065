//! §1 «Общие сведения»: the chain of handlers. Order of checks: §1/11.

use crate::answers::Answers;
use crate::cause::Asked;
use crate::composition::ChainSet;
use crate::device::Device;
use crate::subsystem::conn::Source;
use crate::subsystem::valve::forbids_folding;
use crate::time::Millis;
use lafet_proto::param::Param;
use lafet_proto::record::Records;
use lafet_proto::request::Body;
use lafet_proto::{Expected, Record, RequestId, Status, SubsystemId};

mod way;

pub use way::Way;

/// Who may be asked for what (the tables «Адресаты» of §3).
#[derive(Clone, Copy)]
struct Addressees {
    subsystems: ChainSet,
    all: bool,
    motors: bool,
}

const AIMING: [SubsystemId; 3] =
    [SubsystemId::HORIZONTAL, SubsystemId::VERTICAL, SubsystemId::NOZZLE];
const DRIVES: [SubsystemId; 4] = {
    let [horizontal, vertical, nozzle] = AIMING;
    [horizontal, vertical, nozzle, SubsystemId::DEPLOYER]
};
const DRIVE_SET: ChainSet = only(&DRIVES).subsystems;
const VALVES: [SubsystemId; 2] = [SubsystemId::VALVE1, SubsystemId::VALVE2];

const fn only(ids: &[SubsystemId]) -> Addressees {
    let mut subsystems = ChainSet::exactly(0);
    let mut rest = ids;
    while let [id, tail @ ..] = rest {
        subsystems = subsystems.with(*id);
        rest = tail;
    }
    Addressees { subsystems, all: false, motors: false }
}

impl Addressees {
    const ANY: Self = Self { subsystems: ChainSet::ALL, all: false, motors: false };

    const fn and_all(self) -> Self {
        Self { all: true, ..self }
    }

    const fn and_motors(self) -> Self {
        Self { motors: true, ..self }
    }
}

/// `None` for a request that the document does not know.
const fn addressees(request: RequestId) -> Option<Addressees> {
    const STOPPABLE: [SubsystemId; 8] = [
        SubsystemId::HORIZONTAL,
        SubsystemId::VERTICAL,
        SubsystemId::NOZZLE,
        SubsystemId::DEPLOYER,
        SubsystemId::DETECTOR,
        SubsystemId::CONTROL,
        SubsystemId::VALVE1,
        SubsystemId::VALVE2,
    ];
    Some(match request {
        RequestId::MOVE => const { only(&DRIVES) },
        RequestId::STOP => const { only(&STOPPABLE).and_all().and_motors() },
        // §3.3/1
        RequestId::GET_STATUS => Addressees::ANY.and_all().and_motors(),
        RequestId::GET_PARAM | RequestId::SET_PARAM => Addressees::ANY,
        RequestId::RETRIEVE_LIMITS | RequestId::SWITCH_LIMITS => {
            const { only(&DRIVES).and_all().and_motors() }
        }
        RequestId::OPEN | RequestId::CLOSE => const { only(&VALVES) },
        RequestId::DEPLOY | RequestId::WRAP => const { only(&[SubsystemId::DEPLOYER]) },
        RequestId::START_JUSTIFY | RequestId::START_SEEK | RequestId::GET_HOTBED => {
            const { only(&[SubsystemId::DETECTOR]) }
        }
        RequestId::START_QUENCH
        | RequestId::START_TRAJECTORY
        | RequestId::SETUP_CORRECTION_TABLE => const { only(&[SubsystemId::CONTROL]) },
        // §3.12, §3.18: only the monitor as a whole; every subsystem answers.
        RequestId::RESTART | RequestId::LOCKOUT => {
            Addressees { subsystems: ChainSet::exactly(0), all: true, motors: false }
        }
        RequestId::CLEAN_FLASH => const { only(&[SubsystemId::GENERAL]) },
        RequestId::GET_CRASH_DATA => const { only(&[SubsystemId::GENERAL]).and_all() },
        _ => return None,
    })
}

/// Requests that read and change nothing: answered in every state (§3.3/2).
const fn is_read(request: RequestId) -> bool {
    matches!(
        request,
        RequestId::GET_STATUS
            | RequestId::GET_PARAM
            | RequestId::RETRIEVE_LIMITS
            | RequestId::GET_CRASH_DATA
            | RequestId::GET_HOTBED
    )
}

/// §3.18/3 What still works under lockout.
const fn passes_lockout(request: RequestId) -> bool {
    is_read(request) || matches!(request, RequestId::SET_PARAM | RequestId::LOCKOUT)
}

/// §3.12/2 What ends something, and nothing else: it is carried out while a reset is awaited, too.
fn is_safe(request: RequestId, data: &[u8]) -> bool {
    match request {
        RequestId::STOP | RequestId::CLOSE => true,
        RequestId::LOCKOUT => {
            Body::decode(request, data) == Ok(Body::Lockout { key: lafet_proto::id::key::ENABLE })
        }
        _ => false,
    }
}

/// §3.3.9/1 Requests that count as an attempt to control the monitor.
const fn is_control(request: RequestId) -> bool {
    matches!(
        request,
        RequestId::MOVE
            | RequestId::STOP
            | RequestId::OPEN
            | RequestId::CLOSE
            | RequestId::DEPLOY
            | RequestId::WRAP
            | RequestId::START_QUENCH
            | RequestId::START_TRAJECTORY
            | RequestId::START_SEEK
    )
}

impl Device {
    /// Answers the records of a frame received without errors; returns the length of the answer.
    ///
    /// `out` should take [`lafet_proto::link::PAYLOAD_MAX`] bytes. Never touches hardware: what
    /// it changes shows in the outputs of the next [`Device::step`].
    #[inline(never)]
    pub fn handle(&mut self, now_ms: u32, source: Source, payload: &[u8], out: &mut [u8]) -> usize {
        let now = Millis(now_ms);
        let mut answers = Answers::new(out);
        let mut records = Records::new(payload);
        // §1/8
        loop {
            let rest = records.rest();
            match records.next() {
                None => return answers.len(),
                Some(Ok(record)) => self.serve(now, source, &record, &mut answers),
                Some(Err(_)) => self.cut_short(rest, &mut answers),
            }
        }
    }

    fn serve(&mut self, now: Millis, source: Source, record: &Record<'_>, answers: &mut Answers) {
        // §2/1: the status of a request is not looked at.
        let Record { request, device: to, .. } = *record;
        // §3.3/1, §3.3/2: no subsystem forbids it, and a monitor is asked for it all the time.
        let state = request == RequestId::GET_STATUS && record.data.is_empty();
        if state && self.has(to) {
            return self.tell_status(to, answers);
        }
        // GetParam changes something too: of a lost unit, the parameter is fetched (§3.4).
        self.disturbed |= request != RequestId::GET_STATUS;
        let by = Asked { request, to, source };
        if is_control(request) {
            self.note_control(now, source);
        }
        if answers.is_full() {
            self.stop_unanswered(now, record, by);
            return;
        }
        #[cfg(feature = "update")]
        if request == RequestId::UPDATE && self.software.is_present() {
            return self.update(record, answers);
        }
        if let Some(status) = self.general_refusal(request, record.data) {
            return answers.bare(SubsystemId::GENERAL, request, status);
        }
        // §1/4; whatever its number, it comes back in the answer (§2/5).
        let Some(who) = addressees(request) else {
            return answers.bare(SubsystemId::GENERAL, request, Status::WRONG_REQUEST);
        };
        match to {
            SubsystemId::ALL | SubsystemId::MOTORS => self.broadcast(now, record, by, who, answers),
            _ => self.unicast(now, record, by, who, answers),
        }
    }

    /// §3.18/2, §3.12/2 General looks before any other subsystem.
    fn general_refusal(&self, request: RequestId, data: &[u8]) -> Option<Status> {
        if self.general.is_locked() && !passes_lockout(request) {
            Some(Status::DENIED)
        } else if self.general.is_restarting() && !is_read(request) && !is_safe(request, data) {
            Some(Status::BUSY)
        } else {
            None
        }
    }

    fn unicast(
        &mut self,
        now: Millis,
        record: &Record<'_>,
        by: Asked,
        who: Addressees,
        answers: &mut Answers,
    ) {
        let Record { request, device: to, data, .. } = *record;
        // §1/3 (§3.1/6, §3.2/7, §3.8/5, §3.9/4, §3.10/5, §3.11/5)
        if !self.has(to) {
            return answers.bare(to, request, Status::MODULE_NOT_EXIST);
        }
        // §1/12 (§3.1/5, §3.2/6, §3.8/4, §3.9/3, §3.10/4, §3.11/4, §3.12/3)
        if !who.subsystems.contains(to) {
            return answers.bare(to, request, Status::WRONG_REQUEST);
        }
        // §1/2
        if let Some((refusing, status)) = self.intercept(request, to) {
            return answers.bare(refusing, request, status);
        }
        let data_size = if request == RequestId::SET_PARAM { 2 } else { 0 };
        if !is_read(request) && !answers.has_room(to, request, data_size) {
            return;
        }
        match Body::decode(request, data) {
            Ok(body) => self.execute(now, to, &body, by, answers),
            Err(error) => answers.bare(to, request, refusal_of_data(error.expected)),
        }
    }

    /// §1/5, §1/6, §1/7: every subsystem that handles the request answers, in chain order.
    fn broadcast(
        &mut self,
        now: Millis,
        record: &Record<'_>,
        by: Asked,
        who: Addressees,
        answers: &mut Answers,
    ) {
        let Record { request, device: to, data, .. } = *record;
        let motors = to == SubsystemId::MOTORS;
        let handlers = self.handlers(request, motors, who);
        if handlers == ChainSet::exactly(0) {
            return answers.bare(SubsystemId::GENERAL, request, Status::WRONG_REQUEST);
        }
        // §1/1
        let in_chain = handlers.in_chain();
        match Body::decode(request, data).map_err(|error| refusal_of_data(error.expected)) {
            Err(status) => in_chain.for_each(|id| answers.bare(id, request, status)),
            Ok(body) => match self.execute_as_a_whole(now, &body, motors, by) {
                Some(status) => in_chain.for_each(|id| {
                    answers.bare(id, request, self.part_of_whole(id, request, status));
                }),
                None => in_chain.for_each(|id| {
                    if is_read(request) || answers.has_room(id, request, 0) {
                        self.execute(now, id, &body, by, answers);
                    }
                }),
            },
        }
    }

    /// Who handles a request to All or Motors; the empty set if neither may be asked for it.
    #[inline(always)]
    fn handlers(&self, request: RequestId, motors: bool, who: Addressees) -> ChainSet {
        let whole = matches!(request, RequestId::RESTART | RequestId::LOCKOUT);
        match motors {
            true if !who.motors => ChainSet::exactly(0),
            false if !who.all => ChainSet::exactly(0),
            _ if whole => self.chain,
            true => self.chain.and(who.subsystems).and(DRIVE_SET),
            false => self.chain.and(who.subsystems),
        }
    }

    /// §1/9 Stop All and Lockout on take effect even where their answers find no room: a stop that
    /// waits for a buffer is no stop.
    fn stop_unanswered(&mut self, now: Millis, record: &Record<'_>, by: Asked) {
        let refused = || self.general_refusal(record.request, record.data).is_some();
        if record.device != SubsystemId::ALL || refused() {
            return;
        }
        match Body::decode(record.request, record.data) {
            Ok(body @ Body::Stop) => {
                self.execute_as_a_whole(now, &body, false, by);
            }
            Ok(body @ Body::Lockout { key: lafet_proto::id::key::ENABLE }) => {
                self.execute_as_a_whole(now, &body, false, by);
            }
            _ => {}
        }
    }

    /// §2/2 A record cut short by the end of the frame: nothing of it is executed.
    #[inline(never)]
    fn cut_short(&mut self, rest: &[u8], answers: &mut Answers) {
        if answers.is_full() {
            return;
        }
        let mut header = rest.iter().copied();
        let request = RequestId(header.next().unwrap_or_default());
        let to = header.next().map_or(SubsystemId::GENERAL, SubsystemId);
        if let Some(status) = self.general_refusal(request, &[]) {
            return answers.bare(SubsystemId::GENERAL, request, status);
        }
        let from = if self.has(to) { to } else { SubsystemId::GENERAL };
        answers.bare(from, request, Status::WRONG_DATA);
    }

    // Apart, as is what follows a broken record: most requests read.
    #[inline(never)]
    fn note_control(&mut self, now: Millis, source: Source) {
        match source {
            Source::ExternalConn => {
                let timeout_ms = self.params.get(Param::ExternalConnTimeout);
                self.external_conn.note_control(now, timeout_ms);
            }
            Source::Radio => {
                let timeout_ms = self.params.get(Param::RadioTimeout);
                self.radio.note_control(now, timeout_ms);
            }
        }
    }

    /// §1/2 The first subsystem of the chain whose state contradicts the request, and what it
    /// answers.
    pub(crate) fn intercept(
        &self,
        request: RequestId,
        to: SubsystemId,
    ) -> Option<(SubsystemId, Status)> {
        let by = match request {
            RequestId::MOVE if to == SubsystemId::DEPLOYER => self.refusal_of_move_deployer(),
            RequestId::MOVE => self.refusal_of_move(to),
            RequestId::STOP => self.refusal_of_stop(to),
            RequestId::OPEN => self.refusal_of_work(),
            // §3.9/1; Deployer has no say: closing is the safe direction (§3.9/6).
            RequestId::CLOSE => self.seeking(),
            // §3.11/6, §3.11/7; the barrel is brought to its rest first, which a held button forbids.
            RequestId::WRAP => AIMING
                .iter()
                .find_map(|drive| self.held_by_button(*drive))
                .or(self.busy_detector())
                .or(self.open_valve())
                .or(self.unsettled_deployer()),
            // §3.13/2
            RequestId::START_JUSTIFY => self.not_deployed().or(self.seeking()).or(self.quenching()),
            // §3.14/6, §3.15/4
            RequestId::START_QUENCH | RequestId::START_TRAJECTORY => self.busy_detector(),
            // §3.16/4, §3.16/8
            RequestId::START_SEEK => {
                let busy = self.control.is_active() || self.detector.is_justifying();
                busy.then_some(SubsystemId::DETECTOR).or(self.open_valve())
            }
            _ => None,
        };
        let program = matches!(
            request,
            RequestId::START_QUENCH | RequestId::START_TRAJECTORY | RequestId::START_SEEK
        );
        // §3.3.1/4
        let weak = self.general.is_weak() && request.needs_supply();
        by.or(weak.then_some(SubsystemId::GENERAL))
            .map(|by| (by, Status::DENIED))
            .or_else(|| program.then(|| self.broken_deployer()).flatten())
    }

    /// Who forbids to move a drive by a request.
    fn refusal_of_move(&self, to: SubsystemId) -> Option<SubsystemId> {
        self.held_by_button(to).or(self.refusal_of_work())
    }

    /// §3.1/1, §3.1/2, §3.8/1, §3.8/2: who forbids aiming and opening, to requests and buttons.
    pub(crate) fn refusal_of_work(&self) -> Option<SubsystemId> {
        self.not_deployed().or(self.busy_detector())
    }

    /// §3.1/9: standing still, neither wrapped nor busy, the barrel dry.
    fn refusal_of_move_deployer(&self) -> Option<SubsystemId> {
        let free = self.deployer.is_deployed() || self.deployer.is_between();
        (!free)
            .then_some(SubsystemId::DEPLOYER)
            .or(self.busy_detector())
            .or(self.quenching())
            .or(self.open_valve())
            .or(self.unsettled_deployer())
    }

    /// §3.2/2, §3.2/3, §3.2/4. What waits for the deployment does not intercept: otherwise
    /// Deployer and Detector would each refuse the Stop to the other.
    fn refusal_of_stop(&self, to: SubsystemId) -> Option<SubsystemId> {
        let deploying = self.has(SubsystemId::DEPLOYER) && self.deployer.is_moving();
        if deploying {
            return (to != SubsystemId::DEPLOYER).then_some(SubsystemId::DEPLOYER);
        }
        self.busy_detector()
            .filter(|_| to != SubsystemId::DETECTOR)
            .or(self.quenching().filter(|_| to != SubsystemId::CONTROL))
    }

    fn held_by_button(&self, to: SubsystemId) -> Option<SubsystemId> {
        let axis = crate::execute::axis_of(to)?;
        let held = |id, post: &crate::subsystem::buttons::ButtonPost| {
            (self.has(id) && post.holds(axis)).then_some(id)
        };
        held(SubsystemId::EXT_BUTTONS, &self.ext_buttons)
            .or(held(SubsystemId::BUTTONS, &self.buttons))
    }

    /// §D/1 That it is between its positions is not known before the inputs have settled.
    fn unsettled_deployer(&self) -> Option<SubsystemId> {
        let unknown = self.settling.is_running() && self.deployer.is_between();
        unknown.then_some(SubsystemId::DEPLOYER)
    }

    fn not_deployed(&self) -> Option<SubsystemId> {
        (!self.is_deployed()).then_some(SubsystemId::DEPLOYER)
    }

    fn seeking(&self) -> Option<SubsystemId> {
        self.detector.is_searching().then_some(SubsystemId::DETECTOR)
    }

    /// Searching or justifying.
    pub(crate) fn busy_detector(&self) -> Option<SubsystemId> {
        (self.detector.is_searching() || self.detector.is_justifying())
            .then_some(SubsystemId::DETECTOR)
    }

    fn quenching(&self) -> Option<SubsystemId> {
        self.control.is_active().then_some(SubsystemId::CONTROL)
    }

    /// A valve that is not closed, or water that flows all the same (§D/6): in a folding barrel it
    /// destroys it.
    fn open_valve(&self) -> Option<SubsystemId> {
        let [valve1, valve2] = &self.valves;
        let flows = || {
            let valve = VALVES.into_iter().find(|id| self.has(*id));
            self.flows().then_some(valve.unwrap_or(SubsystemId::DEPLOYER))
        };
        forbids_folding(valve2, self.has(SubsystemId::VALVE2))
            .or(forbids_folding(valve1, self.has(SubsystemId::VALVE1)))
            .or_else(flows)
    }

    /// A program that would have to deploy first cannot when Deployer is faulty.
    fn broken_deployer(&self) -> Option<(SubsystemId, Status)> {
        let [.., drive] = &self.drives;
        (!self.is_deployed() && self.deployer.refuses(drive, true))
            .then_some((SubsystemId::DEPLOYER, Status::MODULE_FAULT))
    }
}

/// §2/3, §2/4
const fn refusal_of_data(expected: Expected) -> Status {
    match expected {
        Expected::Value => Status::INVALID_VALUE,
        _ => Status::WRONG_DATA,
    }
}

#[cfg(test)]
mod tests;

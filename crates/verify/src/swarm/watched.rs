//! A simulated monitor under watch: whatever is done to it goes through here, into the ledger of
//! the check, into the counts, and into the log.

use lafet_device::Source;
use lafet_device::cause::{Cause, Causes};
use lafet_device::image::Outputs;
use lafet_device::port::Port;
use lafet_proto::Status;
use lafet_proto::flags::{Button, DeployerFlags, GeneralFlags};
use lafet_proto::link::{Check, Decoder, Frame, WIRE_MAX, encode_with};
use lafet_proto::record::Records;
use lafet_proto::status::FaultInfo;
use lafet_sim::event::What;
use lafet_sim::fault::{Fault, Post, SingleFault};
use lafet_sim::sim::{Config, Sim};

use super::plan::setting;
use super::tally::{Seen, Tally};
use crate::attribution::{Attribution, Output, Told, View, Violation};

/// Address of who sends link frames.
const SENDER: u8 = 200;

/// Something that happened to a monitor or that it did.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a> {
    /// It begins.
    Begin {
        /// What it is built from.
        config: &'a Config,
    },
    /// Records of a frame were delivered, and these were answered.
    Frame {
        /// Through which interface.
        source: Source,
        /// The records.
        payload: &'a [u8],
        /// The answer's records.
        answer: &'a [u8],
    },
    /// Bytes without sense were received.
    Garbage {
        /// How many.
        len: usize,
    },
    /// An output changed.
    Output {
        /// Which.
        output: Output,
        /// Its value before.
        before: i16,
        /// Its value now.
        after: i16,
        /// Why.
        cause: Cause,
        /// Whether the cause is another than before.
        anew: bool,
    },
    /// A fault comes into force, or is repaired.
    Fault {
        /// Which.
        fault: Fault,
        /// It comes.
        on: bool,
    },
    /// A button is pressed or released.
    Button {
        /// At which post.
        post: Post,
        /// Which.
        button: Button,
        /// It is pressed.
        pressed: bool,
    },
    /// Something happened in the world.
    Event(What),
    /// What must never happen.
    Violation(&'a Violation),
}

/// Gets all entries.
pub trait Log {
    /// Takes an entry, with the virtual time in ms.
    fn note(&mut self, at_ms: u64, entry: &Entry<'_>);
}

/// Takes nothing down.
impl Log for () {
    fn note(&mut self, _at_ms: u64, _entry: &Entry<'_>) {}
}

/// A monitor that does something wrong: it is between device, world and client, to prove that the
/// check finds it out.
pub trait Wrong {
    /// May change what a step drives, and what is given as the cause.
    fn drives(
        &mut self,
        view: &View<'_>,
        stood_still: bool,
        outputs: &mut Outputs,
        causes: &mut Causes,
    ) {
        let _ = (view, stood_still, outputs, causes);
    }

    /// May change an answer.
    fn answers(&mut self, payload: &[u8], answer: &mut Vec<u8>) {
        let _ = (payload, answer);
    }

    /// May have the device do, just before this frame, what no request asks for.
    fn asks(&mut self, source: Source, payload: &[u8]) -> Vec<Vec<u8>> {
        let _ = (source, payload);
        Vec::new()
    }
}

/// A monitor under watch.
pub(super) struct Watched<'l> {
    /// The monitor.
    pub sim: Sim,
    attribution: Attribution,
    told: Told,
    port: Port,
    tally: Tally,
    failure: Option<Violation>,
    causes: Vec<Cause>,
    values: Vec<i16>,
    resets: u32,
    was_deployed: bool,
    homed: u64,
    clock_ms: u32,
    booted_ms: u64,
    wrong: Option<&'l mut dyn Wrong>,
    log: &'l mut dyn Log,
}

impl<'l> Watched<'l> {
    pub fn new(seed: u64, wrong: Option<&'l mut dyn Wrong>, log: &'l mut dyn Log) -> Self {
        let config = setting(seed);
        log.note(0, &Entry::Begin { config: &config });
        let mut tally = Tally::new();
        tally.profile(config.composition.name);
        let clock_ms = config.clock_ms;
        let mut sim = Sim::new(config);
        sim.world_mut().take_events();
        Self {
            attribution: Attribution::new(sim.now_ms()),
            told: Told::default(),
            port: Port::new(Source::Radio),
            tally,
            failure: None,
            causes: Output::all().map(|output| output.cause(sim.device().causes())).collect(),
            values: Output::all().map(|_| 0).collect(),
            resets: 0,
            was_deployed: sim.world().deployed(),
            homed: 0,
            clock_ms,
            booted_ms: 0,
            sim,
            wrong,
            log,
        }
    }

    /// Whether the life is over.
    pub const fn failed(&self) -> bool {
        self.failure.is_some()
    }

    /// What it reported in the last step.
    pub const fn told(&self) -> &Told {
        &self.told
    }

    /// Counts something.
    pub fn see(&mut self, what: Seen) {
        self.tally.see(what);
    }

    /// Delivers records; they must be answered with whole records.
    pub fn request(&mut self, source: Source, payload: &[u8]) -> Vec<u8> {
        self.wait_for_flash();
        if let Some(wrong) = &mut self.wrong {
            for hidden in wrong.asks(source, payload) {
                self.sim.request(source, &hidden);
            }
        }
        let mut answer = self.sim.request(source, payload);
        if let Some(wrong) = &mut self.wrong {
            wrong.answers(payload, &mut answer);
        }
        self.delivered(source, payload, &answer);
        answer
    }

    /// Sends a frame behind bytes without sense over a line: of two such frames the second at
    /// least must be answered.
    pub fn request_behind(&mut self, garbage: &[u8], payload: &[u8]) {
        let dst = self.sim.address();
        let mut wire = [0; WIRE_MAX];
        // §L/7 An interface may be set to take nothing else.
        let wants = self.sim.device().wants_crc32c(Source::Radio);
        let check = if wants { Check::Crc32c } else { Check::Crc16 };
        let frame = Frame { dst, src: SENDER, payload };
        let Some(len) = encode_with(check, &frame, &mut wire) else { return };
        self.log.note(self.sim.now_ms(), &Entry::Garbage { len: garbage.len() });
        self.tally.see(Seen::Garbage);
        self.wait_for_flash();
        let bytes = [garbage, &wire[..len], &wire[..len]].concat();
        let answered = self.sim.receive(&mut self.port, &bytes);
        let mut decoder: Decoder = Decoder::new();
        let mut rest = answered.as_slice();
        let mut frames = 0;
        while !rest.is_empty() {
            let (used, frame) = decoder.push_slice(rest);
            if let Some(Frame { payload: answer, .. }) = frame {
                let answer = answer.to_vec();
                frames += 1;
                self.delivered(Source::Radio, payload, &answer);
            }
            rest = &rest[used..];
        }
        if frames == 0 {
            self.fail("a frame behind garbage is not answered");
        }
    }

    /// What comes while the flash is busy is looked at afterwards; the time until then is under
    /// watch as any other.
    fn wait_for_flash(&mut self) {
        while self.sim.world().stays_stalled() {
            self.tick();
        }
    }

    fn delivered(&mut self, source: Source, payload: &[u8], answer: &[u8]) {
        let now_ms = self.sim.now_ms();
        self.log.note(now_ms, &Entry::Frame { source, payload, answer });
        self.tally.frames += 1;
        self.tally.requests += Records::new(payload).count() as u64;
        if let Some(violation) = self.attribution.delivered(now_ms, source, payload, answer) {
            self.fail_with(violation);
        }
        if answer.is_empty() != payload.is_empty() {
            self.fail("a frame is not answered");
        }
        for record in Records::new(answer) {
            match record {
                Ok(record) if record.status.is_success() => self.tally.accept(record.request),
                Ok(record) if record.status == Status::NO_ROOM => self.tally.see(Seen::NoRoom),
                Ok(_) => {}
                Err(_) => self.fail("an answer is cut short"),
            }
        }
    }

    /// One step, and the check of it.
    pub fn tick(&mut self) {
        self.sim.tick();
        self.tally.steps += u64::from(!self.sim.stood_still());
        let now_ms = self.sim.now_ms();
        let reset = self.sim.resets() != self.resets;
        if reset {
            self.resets = self.sim.resets();
            self.tally.see(Seen::Reset);
            self.powered_up();
        }
        let before = self.device_ms(now_ms - lafet_sim::world::STEP_MS);
        if self.device_ms(now_ms) < before && now_ms > self.booted_ms {
            self.tally.see(Seen::ClockWrap);
        }
        self.told = Told::ask(&mut self.sim);
        let causes = self.tamper();
        let view = View { causes: &causes, ..View::of(&self.sim, self.told) };
        // What has started again has not looked at anything yet.
        let violations = match reset || self.sim.stood_still() {
            true => self.attribution.stand_still(&view),
            false => self.attribution.check(&view),
        };
        self.note_outputs();
        self.note_world();
        let homed = self.attribution.ledger().homings.homed;
        if std::mem::replace(&mut self.homed, homed) != homed {
            self.tally.see(Seen::Homed);
        }
        for violation in violations {
            self.tally.unexplained += u64::from(violation.unexplained);
            self.tally.violations += u64::from(!violation.unexplained);
            self.log.note(violation.at_ms, &Entry::Violation(&violation));
            self.failure.get_or_insert(violation);
        }
    }

    /// What the world is driven by instead, and why, if there is a wrong.
    fn tamper(&mut self) -> Causes {
        let mut causes = *self.sim.device().causes();
        let Some(wrong) = &mut self.wrong else { return causes };
        let mut outputs = *self.sim.world().outputs();
        let view = View::of(&self.sim, self.told);
        wrong.drives(&view, self.sim.stood_still(), &mut outputs, &mut causes);
        if outputs != *self.sim.world().outputs() {
            self.sim.world_mut().drive(outputs);
        }
        causes
    }

    fn device_ms(&self, now_ms: u64) -> u32 {
        self.clock_ms.wrapping_add(now_ms.saturating_sub(self.booted_ms) as u32)
    }

    fn note_outputs(&mut self) {
        let now_ms = self.sim.now_ms();
        let (outputs, causes) = (self.sim.world().outputs(), self.sim.device().causes());
        for (index, output) in Output::all().enumerate() {
            let (before, after) = (self.values[index], output.value(outputs));
            let cause = output.cause(causes);
            let anew = self.causes[index] != cause;
            if before != after {
                let entry = Entry::Output { output, before, after, cause, anew };
                self.log.note(now_ms, &entry);
            }
            if anew || before != after && (before == 0 || after == 0) {
                self.tally.output(output, cause, after);
            }
            (self.values[index], self.causes[index]) = (after, cause);
        }
    }

    fn note_world(&mut self) {
        let now_ms = self.sim.now_ms();
        for event in self.sim.world_mut().take_events() {
            self.tally.event(event.what);
            self.log.note(now_ms, &Entry::Event(event.what));
        }
        let flags = DeployerFlags::from_bits_retain(
            self.told.drives[lafet_device::image::Axis::Deployer as usize],
        );
        let deployed = self.sim.world().deployed();
        if deployed && !self.was_deployed {
            self.tally.see(Seen::Deployed);
        }
        if self.was_deployed && flags.contains(DeployerFlags::WRAPPED) {
            self.tally.see(Seen::WrappedAgain);
        }
        self.was_deployed =
            deployed || self.was_deployed && !flags.contains(DeployerFlags::WRAPPED);
        if self.told.general & GeneralFlags::LOCKED_OUT.bits() != 0 {
            self.tally.see(Seen::LockedOut);
        }
    }

    /// Runs for a while, or until the life is over.
    pub fn run(&mut self, ms: u64) {
        for _ in 0..ms / lafet_sim::world::STEP_MS {
            if self.failed() {
                return;
            }
            self.tick();
        }
    }

    pub fn power_cut(&mut self) {
        self.tally.see(Seen::PowerCut);
        self.sim.power_cycle();
        self.powered_up();
    }

    pub fn crash(&mut self) {
        self.tally.see(Seen::Crash);
        self.sim.crash(FaultInfo { signature: 0xDEAD_FA11, ..FaultInfo::NONE });
        self.powered_up();
    }

    fn powered_up(&mut self) {
        self.booted_ms = self.sim.now_ms();
        let faults = &self.sim.world().faults;
        let sound =
            !faults.single(SingleFault::FlashRead) && !faults.single(SingleFault::FlashWrite);
        let params = self.sim.device().params();
        self.attribution.powered_up(self.booted_ms, params, sound);
        // What was driven went off with the power, which needs no explanation.
        self.values.fill(0);
    }

    pub fn inject(&mut self, fault: Fault) {
        self.log.note(self.sim.now_ms(), &Entry::Fault { fault, on: true });
        self.tally.fault(fault);
        self.sim.world_mut().inject(fault);
        if self.sim.world().faults.active().len() > 1 {
            self.tally.see(Seen::SeveralFaults);
        }
    }

    pub fn clear(&mut self, fault: Fault) {
        self.log.note(self.sim.now_ms(), &Entry::Fault { fault, on: false });
        self.sim.world_mut().clear(fault);
    }

    pub fn clear_all(&mut self) {
        for fault in self.sim.world().faults.active().to_vec() {
            self.clear(fault);
        }
    }

    pub fn press(&mut self, post: Post, button: Button, pressed: bool) {
        self.log.note(self.sim.now_ms(), &Entry::Button { post, button, pressed });
        self.sim.world_mut().press(post, button, pressed);
    }

    pub fn panicked(&mut self) {
        self.fail("the device panicked");
    }

    fn fail(&mut self, what: &str) {
        let text = what.to_owned();
        self.fail_with(Violation { at_ms: self.sim.now_ms(), unexplained: false, text });
    }

    fn fail_with(&mut self, violation: Violation) {
        self.tally.violations += 1;
        self.log.note(violation.at_ms, &Entry::Violation(&violation));
        self.failure.get_or_insert(violation);
    }

    pub fn end(mut self) -> (Tally, Option<Violation>) {
        self.tally.virtual_ms = self.sim.now_ms();
        self.tally.changes = self.attribution.changes();
        self.tally.resets = self.sim.resets().into();
        (self.tally, self.failure)
    }
}

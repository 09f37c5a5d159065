//! What the sessions with brokers have in common, whatever their topics are: the line, its loss, and the seat in the hub.

use std::sync::Arc;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use rumqttc::mqttbytes::QoS;
use rumqttc::{
    AsyncClient, ClientError, Event, EventLoop, MqttOptions, Packet, PublishOptions,
    RetainForwardRule, SubscribeFilterInput, SubscribeReasonCode,
};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::{Instant, Interval, MissedTickBehavior, interval, sleep, timeout_at};

use super::desk::{Act, Around, Desk, Heard, Reply};
use super::hand::{Answer, Hand, Tongue};
use super::message::Asked;
use super::outbox::Letter;
use super::{Broker, VIA, link, words};
use crate::access::{Bucket, Kind, Principal, Role, Standing};
use crate::config::is_name;
use crate::hub::{Caller, Hub, SeatKey};
use crate::plugs::noted::Reports;
use crate::plugs::refusal::{Failed, Refusal};
use crate::plugs::view::PlugClient;
use crate::text::Both;

/// Pauses between attempts to connect.
const PAUSE_FIRST: Duration = Duration::from_secs(1);
const PAUSE_LAST: Duration = Duration::from_secs(30);
/// A connection that has lasted for this time was a good one: the next pause is the first again.
const LASTED: Duration = Duration::from_secs(60);
/// The broker is heard at least this often: it confirms something each second or two.
const STALLED: Duration = Duration::from_secs(8);
/// States are looked at this often.
pub const LOOK_EACH: Duration = Duration::from_millis(100);
/// What is said last is taken within this time.
pub const FAREWELL: Duration = Duration::from_secs(2);
/// Commands to monitors that are not here, at once and per second: more have no result.
const UNKNOWN: (f64, f64) = (20.0, 20.0);
/// Messages that wait for the session.
const HEARD_MAX: usize = 64;
/// Results that wait for the session.
const RESULTS_MAX: usize = 64;

/// What is said of the clients of a broker.
const TONGUE: Tongue = Tongue {
    silent: |client, from| text::MqttSilent { client, from }.words(),
    refusal: words::of,
    ids: true,
};

/// Attempts to connect to a broker: what is said between them, and how long they are apart.
pub struct Retry {
    hub: Hub,
    broker: Arc<Broker>,
    pause: Duration,
}

impl Retry {
    /// Before the first attempt.
    pub fn new(hub: &Hub, broker: &Arc<Broker>) -> Self {
        Self { hub: hub.clone(), broker: broker.clone(), pause: PAUSE_FIRST }
    }

    /// The next attempt comes after the first pause.
    pub const fn soon(&mut self) {
        self.pause = PAUSE_FIRST;
    }

    /// A connection has ended, or did not come about: waits for the next attempt. `false`: the hub ends.
    pub async fn after(&mut self, began: Instant, why: Both) -> bool {
        let (name, url) = (&self.broker.config.name, self.broker.config.url());
        if self.broker.counts.set_error(Some(why.clone())) {
            self.hub.event(None, &text::MqttNotConnected { name, url: &url, why: &why }.words());
        }
        if began.elapsed() > LASTED {
            self.pause = PAUSE_FIRST;
        }
        let mut shutdown = self.hub.shutdown();
        tokio::select! {
            () = sleep(self.pause) => {}
            () = shutdown.requested() => return false,
        }
        self.pause = (self.pause * 2).min(PAUSE_LAST);
        true
    }
}

/// What comes from the broker.
pub enum News {
    /// It has taken the connection.
    Connected,
    /// It has taken a subscription, and what was sent before it.
    Subscribed,
    /// A message.
    Message {
        /// Where it was published.
        topic: String,
        /// Its text.
        payload: Vec<u8>,
        /// It was sent to be kept.
        retained: bool,
    },
    /// The connection has ended.
    Lost(Both),
}

/// The tasks of a connection. Dropped, they end.
#[derive(Default)]
pub struct Tasks(Vec<JoinHandle<()>>);

impl Tasks {
    /// One more.
    pub fn spawn(&mut self, task: impl Future<Output = ()> + Send + 'static) {
        self.0.push(tokio::spawn(task));
    }
}

impl Drop for Tasks {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// A connection that the broker has taken.
pub struct Line {
    /// Sends.
    pub client: AsyncClient,
    /// What is heard.
    pub heard: mpsc::Receiver<News>,
    /// What reads and writes.
    pub tasks: Tasks,
}

impl Line {
    /// Connects; the last so many subscriptions may be refused. `Err(None)`: the hub ends.
    ///
    /// # Errors
    ///
    /// Why there is no connection.
    pub async fn open(
        hub: &Hub,
        broker: &Arc<Broker>,
        options: MqttOptions,
        spare: usize,
    ) -> Result<Self, Option<Both>> {
        let builder = AsyncClient::builder(options).capacity(link::AHEAD);
        let (client, events) = builder
            .try_build()
            .map_err(|error| Some(text::MqttFailed { error: error.to_string() }.words()))?;
        let (news, mut heard) = mpsc::channel(HEARD_MAX);
        let mut tasks = Tasks::default();
        tasks.spawn(poll(events, broker.clone(), news, spare));
        let mut shutdown = hub.shutdown();
        let first = tokio::select! {
            first = heard.recv() => first,
            () = shutdown.requested() => return Err(None),
        };
        match first {
            Some(News::Connected) => Ok(Self { client, heard, tasks }),
            Some(News::Lost(why)) => Err(Some(why)),
            _ => Err(Some(link::silent())),
        }
    }
}

/// Hears the broker until the connection ends.
async fn poll(mut events: EventLoop, broker: Arc<Broker>, news: mpsc::Sender<News>, spare: usize) {
    let mut heard = Instant::now();
    loop {
        // What the hub sends is no sign of life of the broker, and keeps the library from asking for one.
        let polled = timeout_at(heard + STALLED, events.poll()).await;
        if let Ok(Ok(Event::Incoming(_))) = polled {
            heard = Instant::now();
        }
        let one = match polled {
            Err(_) => News::Lost(link::silent()),
            Ok(Err(error)) => News::Lost(link::said(&broker.config, &error)),
            Ok(Ok(Event::Incoming(Packet::ConnAck(_)))) => News::Connected,
            Ok(Ok(Event::Incoming(Packet::SubAck(answer)))) => {
                let refused =
                    |it: &SubscribeReasonCode| !matches!(it, SubscribeReasonCode::Success(_));
                let needed = answer.return_codes.len().saturating_sub(spare);
                if answer.return_codes.iter().take(needed).any(refused) {
                    News::Lost(text::MqttNoSubscription { prefix: &broker.config.prefix }.words())
                } else {
                    News::Subscribed
                }
            }
            Ok(Ok(Event::Incoming(Packet::Publish(it)))) => News::Message {
                topic: String::from_utf8_lossy(&it.topic).into_owned(),
                payload: it.payload.to_vec(),
                retained: it.retain,
            },
            Ok(Ok(_)) => continue,
        };
        let ends = matches!(one, News::Lost(_));
        if news.send(one).await.is_err() || ends {
            return;
        }
    }
}

/// Publishes a message.
///
/// # Errors
///
/// The connection has ended.
pub async fn send(client: &AsyncClient, letter: Letter) -> Result<(), ClientError> {
    let Letter { topic, payload, retained, confirmed } = letter;
    let quality = if confirmed { QoS::AtLeastOnce } else { QoS::AtMostOnce };
    client.publish(topic, payload, PublishOptions::new(quality).retain(retained)).await
}

/// Asks for messages as they come: not for those that the broker has kept from before.
pub fn live(topic: String) -> SubscribeFilterInput {
    SubscribeFilterInput::new(topic, QoS::AtLeastOnce)
        .preserve_retain(true)
        .retain_forward_rule(RetainForwardRule::Never)
}

/// When the states are looked at.
pub fn looks() -> Interval {
    let mut looks = interval(LOOK_EACH);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    looks
}

/// The seat of a broker's clients in the hub, with what decides and what carries out. Dropped, it ends what it has
/// started.
pub struct Seated {
    /// The hub.
    pub hub: Hub,
    /// The broker.
    pub broker: Arc<Broker>,
    /// The seat.
    pub key: SeatKey,
    /// Decides.
    pub desk: Desk,
    /// Carries out.
    pub hand: Hand,
    /// Results of commands.
    pub results: mpsc::Receiver<Answer>,
    /// Since when, ms since 1970.
    pub since_ms: u64,
    /// Results of commands to monitors that are not here.
    unknown: Bucket,
}

impl Seated {
    /// A connection has come about.
    pub fn begin(hub: &Hub, broker: &Arc<Broker>, reports: &Reports) -> Self {
        let config = &broker.config;
        let operates = config.terms.operates;
        let principal = Principal {
            user: format!("mqtt {}", config.name),
            role: if operates { Role::Operator } else { Role::Observer },
            kind: Kind::Mqtt,
            key: format!("mqtt {} {}", config.name, hub.now().as_nanos()),
            csrf: String::new(),
            expires_ms: 0,
            standing: Standing::Good,
        };
        let (place, since_ms) = (config.place(), hub.clock().now_ms());
        let key = hub.connect(&principal, &place, None);
        let caller = Caller::plug(principal, place.clone(), key.seat.clone(), VIA);
        let (answers, results) = mpsc::channel(RESULTS_MAX);
        let ids = &config.monitors;
        let client = PlugClient {
            name: config.client_id.clone(),
            from: place,
            seat: key.seat.clone(),
            since_ms,
        };
        broker.counts.came(client);
        if broker.counts.set_error(None) {
            let (name, url) = (&config.name, config.url());
            hub.event(None, &text::MqttConnected { name, url: &url }.words());
        }
        Self {
            hub: hub.clone(),
            broker: broker.clone(),
            desk: Desk::new(config.terms, ids.len(), hub.now(), &mut random),
            hand: Hand::new(hub, &caller, ids, answers, (reports.clone(), TONGUE)),
            results,
            since_ms,
            key,
            unknown: Bucket::new(hub.now(), UNKNOWN.0, UNKNOWN.1),
        }
    }

    /// A command has come; what is to be published of it.
    pub fn command(&mut self, heard: Heard, asked: Asked) -> Vec<Act> {
        self.broker.counts.count(|it| &it.requests);
        let acts = self.around(|desk, around| desk.command(around, heard, asked));
        self.carry_out(acts)
    }

    /// A command to a monitor that is not here, such as one that had another name: its client has to know. `None`:
    /// there are too many, or none can have this name.
    pub fn refuse_unknown(
        &mut self,
        id: &str,
        retained: bool,
        asked: impl FnOnce() -> Asked,
    ) -> Option<Reply> {
        self.broker.counts.count(|it| &it.requests);
        if !is_name(id) || self.unknown.take(self.hub.now()).is_err() {
            self.broker.counts.count(|it| &it.rejected);
            return None;
        }
        let heard = Heard { monitor: None, retained };
        Some(Reply::to(heard, &asked(), Err(Failed::from(Refusal::Monitor))))
    }

    /// A sign of life has come: a ticket, if it can be read.
    pub fn alive(&mut self, ticket: Option<u64>) -> Vec<Act> {
        let (is_new, acts) = self.around(|desk, around| desk.alive(around, ticket));
        if !is_new {
            self.broker.counts.count(|it| &it.malformed);
        }
        self.carry_out(acts)
    }

    /// Time has passed.
    pub fn tick(&mut self) -> Vec<Act> {
        let acts = self.desk.tick(self.hub.now(), &mut random);
        self.carry_out(acts)
    }

    /// The monitor has answered.
    pub fn answered(&mut self, (number, result): Answer) -> Vec<Act> {
        let acts = self.desk.answered(number, result);
        self.carry_out(acts)
    }

    /// The connection ends.
    pub fn end(&mut self) -> Vec<Act> {
        let acts = self.desk.end(&mut random);
        self.carry_out(acts)
    }

    /// Carries out what the desk orders; the rest is to be published.
    fn carry_out(&self, acts: Vec<Act>) -> Vec<Act> {
        self.hand.carry_out(&self.desk, acts)
    }

    fn around<T>(&mut self, what: impl FnOnce(&mut Desk, &mut Around<'_>) -> T) -> T {
        let (hand, now) = (&self.hand, self.hub.now());
        let holder = |at: usize| hand.holder(at);
        let mut random = random;
        let mut around = Around { now, holder: &holder, random: &mut random };
        what(&mut self.desk, &mut around)
    }
}

impl Drop for Seated {
    fn drop(&mut self) {
        self.end();
        self.hub.disconnect(&self.key);
        self.broker.counts.went(&self.key.seat);
    }
}

/// A random number of the system; `None`: there is none.
pub fn random() -> Option<u64> {
    getrandom::u64().ok()
}

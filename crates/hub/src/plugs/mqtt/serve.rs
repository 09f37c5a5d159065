//! The lines: connects to a broker, publishes, hears commands. What is decided is in [`super::desk`].

use std::sync::Arc;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use rumqttc::mqttbytes::QoS;
use rumqttc::{
    AsyncClient, Event, EventLoop, Packet, PublishOptions, RetainForwardRule, SubscribeFilterInput,
    SubscribeReasonCode,
};
use serde::Serialize;
use serde_json::Value;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep, sleep_until, timeout, timeout_at};

use super::desk::{Act, Around, Desk, Heard, Reply};
use super::hand::{Answer, Hand};
use super::outbox::{Letter, Outbox};
use super::state::{self, AlarmList, Key, Online, Ticket, Urgent};
use super::{Broker, VIA, discovery, link, message};
use crate::access::{Kind, Principal, Role, Standing};
use crate::hub::{Caller, Hub, SeatKey};
use crate::plugs::noted::Seldom;
use crate::plugs::view::PlugClient;
use crate::text::Both;

/// Pauses between attempts to connect.
const PAUSE_FIRST: Duration = Duration::from_secs(1);
const PAUSE_LAST: Duration = Duration::from_secs(30);
/// A connection that has lasted for this time was a good one: the next pause is the first again.
const LASTED: Duration = Duration::from_secs(60);
/// States are looked at this often.
const LOOK_EACH: Duration = Duration::from_millis(100);
/// The broker is heard at least this often: it confirms a ticket each second.
const STALLED: Duration = Duration::from_secs(8);
/// What is said last is taken within this time.
const FAREWELL: Duration = Duration::from_secs(2);
/// Messages that wait for the session.
const HEARD_MAX: usize = 64;
/// Results that wait for the session.
const RESULTS_MAX: usize = 64;

/// Connects until the hub ends.
pub async fn run(hub: Hub, broker: Arc<Broker>) {
    let mut shutdown = hub.shutdown();
    let (said, mut pause) = (Seldom::default(), PAUSE_FIRST);
    loop {
        let began = Instant::now();
        let connected = connect(&hub, &broker, &said);
        let Some(why) = connected.await else { return };
        let (name, url) = (&broker.config.name, broker.config.url());
        if broker.counts.set_error(Some(why.clone())) {
            hub.event(None, &text::MqttNotConnected { name, url: &url, why: &why }.words());
        }
        if began.elapsed() > LASTED {
            pause = PAUSE_FIRST;
        }
        tokio::select! {
            () = sleep(pause) => {}
            () = shutdown.requested() => return,
        }
        pause = (pause * 2).min(PAUSE_LAST);
    }
}

/// What comes from the broker.
enum News {
    Connected,
    Message { topic: String, payload: Vec<u8>, retained: bool },
    Lost(Both),
}

/// The tasks of a connection. Dropped, they end.
struct Tasks(Vec<JoinHandle<()>>);

impl Drop for Tasks {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// A connection, from its beginning to its end. Why it has ended; `None`: the hub ends.
async fn connect(hub: &Hub, broker: &Arc<Broker>, said: &Seldom) -> Option<Both> {
    let options = match link::options(&broker.config) {
        Ok(options) => options,
        Err(why) => return Some(why),
    };
    let builder = AsyncClient::builder(options).capacity(link::AHEAD);
    let (client, events) = match builder.try_build() {
        Ok(built) => built,
        Err(error) => return Some(text::MqttFailed { error: error.to_string() }.words()),
    };
    let outbox = Arc::new(Outbox::default());
    let (news, mut heard) = mpsc::channel(HEARD_MAX);
    let poll = tokio::spawn(poll(events, broker.clone(), news));
    let mut tasks = Tasks(vec![poll]);
    let mut shutdown = hub.shutdown();
    let first = tokio::select! {
        first = heard.recv() => first,
        () = shutdown.requested() => return None,
    };
    match first {
        Some(News::Connected) => {}
        Some(News::Lost(why)) => return Some(why),
        _ => return Some(link::silent()),
    }
    if let Err(why) = subscribe(&client, broker).await {
        return Some(why);
    }
    tasks.0.push(tokio::spawn(write(client.clone(), outbox.clone())));
    let mut session = Session::begin(hub, broker, outbox, said);
    let ended = session.run(&mut heard).await;
    if ended.is_none() {
        session.say_goodbye(&client, &mut heard).await;
    }
    drop(session);
    ended
}

/// Hears the broker until the connection ends.
async fn poll(mut events: EventLoop, broker: Arc<Broker>, news: mpsc::Sender<News>) {
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
                if !answer.return_codes.iter().any(refused) {
                    continue;
                }
                News::Lost(text::MqttNoSubscription { prefix: &broker.config.prefix }.words())
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

/// Asks for commands as they come: not for those that the broker has kept from before.
async fn subscribe(client: &AsyncClient, broker: &Broker) -> Result<(), Both> {
    let config = &broker.config;
    let of_hub = ["command", "alive"].map(|part| config.topic(part));
    let of_monitors = (0..config.monitors.len()).map(|at| config.topic_of(Some(at), "command"));
    let all = of_hub.into_iter().chain(of_monitors).chain(discovery::birth(config));
    let live = |topic: String| {
        SubscribeFilterInput::new(topic, QoS::AtLeastOnce)
            .preserve_retain(true)
            .retain_forward_rule(RetainForwardRule::Never)
    };
    let filters: Vec<_> = all.map(live).collect();
    let asked = client.subscribe_many(filters).await;
    asked.map_err(|error| text::MqttFailed { error: error.to_string() }.words())
}

/// Publishes what waits. A broker that takes nothing holds up nothing but this.
async fn write(client: AsyncClient, outbox: Arc<Outbox>) {
    loop {
        let Letter { topic, payload, retained, confirmed } = outbox.next().await;
        let quality = if confirmed { QoS::AtLeastOnce } else { QoS::AtMostOnce };
        let options = PublishOptions::new(quality).retain(retained);
        if client.publish(topic, payload, options).await.is_err() {
            return;
        }
    }
}

/// A session with a broker. Dropped, it ends what it has started.
struct Session {
    hub: Hub,
    broker: Arc<Broker>,
    key: SeatKey,
    number: String,
    desk: Desk,
    hand: Hand,
    outbox: Arc<Outbox>,
    results: mpsc::Receiver<Answer>,
    /// Of each monitor, when its state was published, and what of it matters at once.
    published: Vec<Option<(Duration, Urgent)>>,
    alarms: Vec<u8>,
}

impl Session {
    fn begin(hub: &Hub, broker: &Arc<Broker>, outbox: Arc<Outbox>, said: &Seldom) -> Self {
        let config = &broker.config;
        let number = message::shown(random().unwrap_or_default());
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
        let session = Self {
            hub: hub.clone(),
            broker: broker.clone(),
            number,
            desk: Desk::new(config.terms, ids.len(), hub.now(), &mut random),
            hand: Hand::new(hub, &caller, ids, answers, said.clone()),
            outbox,
            results,
            published: vec![None; ids.len()],
            alarms: Vec::new(),
            key,
        };
        session.put("hub", &Online::since(&session.number, since_ms));
        session.discover();
        (0..ids.len()).for_each(|at| session.put_key(at));
        session
    }

    /// Until the connection ends, and why; `None`: the hub ends.
    async fn run(&mut self, heard: &mut mpsc::Receiver<News>) -> Option<Both> {
        let (mut shutdown, start) = (self.hub.shutdown(), self.hub.start());
        let mut looks = interval(LOOK_EACH);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let next = self.desk.timeout();
            tokio::select! {
                () = shutdown.requested() => return None,
                news = heard.recv() => match news {
                    Some(News::Message { topic, payload, retained }) => {
                        self.heed(&topic, &payload, retained);
                    }
                    Some(News::Connected) => {}
                    Some(News::Lost(why)) => return Some(why),
                    None => return Some(link::silent()),
                },
                Some((number, result)) = self.results.recv() => {
                    let acts = self.desk.answered(number, result);
                    self.carry_out(acts);
                }
                Some(event) = self.key.events.recv() => self.tell(&event),
                _ = looks.tick() => self.look(),
                () = sleep_until(start + next) => {
                    let acts = self.desk.tick(self.hub.now(), &mut random);
                    self.carry_out(acts);
                }
            }
        }
    }

    fn heed(&mut self, topic: &str, payload: &[u8], retained: bool) {
        let config = &self.broker.config;
        if discovery::birth(config).as_deref() == Some(topic) {
            if payload == b"online" {
                self.discover();
            }
            return;
        }
        let Some(rest) = topic.strip_prefix(&config.prefix).and_then(|it| it.strip_prefix('/'))
        else {
            return;
        };
        let monitor = match rest.strip_suffix("/command") {
            Some(id) => match config.monitors.iter().position(|it| it == id) {
                Some(at) => Some(at),
                None => return,
            },
            None => None,
        };
        let hand = self.hand.clone();
        let holder = |at: usize| hand.holder(at);
        let mut random = random;
        let now = self.hub.now();
        let mut around = Around { now, holder: &holder, random: &mut random };
        let acts = if rest == "alive" {
            let (is_new, acts) =
                if retained { (false, Vec::new()) } else { self.desk.alive(&mut around, payload) };
            if !is_new {
                self.broker.counts.count(|it| &it.malformed);
            }
            acts
        } else {
            self.broker.counts.count(|it| &it.requests);
            self.desk.command(&mut around, Heard { monitor, retained, payload })
        };
        self.carry_out(acts);
    }

    fn carry_out(&mut self, acts: Vec<Act>) {
        for act in self.hand.carry_out(&self.desk, acts) {
            match act {
                Act::Ticket(ticket) => {
                    let session = &self.number;
                    let ticket = Ticket { ticket: message::shown(ticket), session };
                    self.letter("ticket", &ticket, false);
                }
                Act::Key(at) => self.put_key(at),
                Act::Say(reply) => self.say(&reply),
                _ => {}
            }
        }
    }

    fn say(&self, reply: &Reply) {
        let counts = &self.broker.counts;
        if reply.result.is_err() {
            counts.count(|it| &it.exceptions);
        }
        let topic = self.broker.config.topic_of(reply.monitor, "result");
        let payload = serde_json::to_vec(&state::Result::new(reply)).unwrap_or_default();
        let letter = Letter { topic, payload, retained: false, confirmed: true };
        if !self.outbox.put_result(letter, reply.is_of_flood()) {
            counts.count(|it| &it.rejected);
        }
    }

    /// A message of the hub that concerns all, in its own words.
    fn tell(&self, message: &str) {
        let Ok(mut event) = serde_json::from_str::<Value>(message) else { return };
        let monitor = event["monitor"].as_str();
        let own = monitor.is_none_or(|id| self.broker.config.monitors.iter().any(|it| it == id));
        if event["type"] != "event" || !own {
            return;
        }
        event.as_object_mut().map(|it| it.remove("type"));
        let topic = self.broker.config.topic("event");
        let payload = event.to_string().into_bytes();
        self.outbox.put_event(Letter { topic, payload, retained: false, confirmed: false });
    }

    /// Publishes states whose time has come, and at once what matters.
    fn look(&mut self) {
        let (now, interval) = (self.hub.now(), self.broker.config.interval);
        for (at, state) in self.hand.states().iter().enumerate() {
            let urgent = state.urgent();
            let last = self.published.get(at).copied().flatten();
            let is_same = last.is_some_and(|(_, it)| it == urgent);
            if is_same && last.is_some_and(|(since, _)| now < since + interval) {
                continue;
            }
            let topic = |part| self.broker.config.topic_of(Some(at), part);
            let payload = serde_json::to_vec(state).unwrap_or_default();
            let letter =
                Letter { topic: topic("state"), payload, retained: true, confirmed: false };
            self.outbox.put(letter);
            if !is_same {
                self.put_available(at, state.is_available());
            }
            if let Some(published) = self.published.get_mut(at) {
                *published = Some((now, urgent));
            }
        }
        let alarms = self.hub.alarms();
        let list = AlarmList::new(&alarms.list(), &self.broker.config.monitors);
        let list = serde_json::to_vec(&list).unwrap_or_default();
        drop(alarms);
        if list != self.alarms {
            let topic = self.broker.config.topic("alarms");
            self.outbox.put(Letter {
                topic,
                payload: list.clone(),
                retained: true,
                confirmed: true,
            });
            self.alarms = list;
        }
    }

    fn discover(&self) {
        let config = &self.broker.config;
        for (topic, text) in
            (0..config.monitors.len()).filter_map(|at| discovery::of_monitor(config, at))
        {
            let payload = text.to_string().into_bytes();
            self.outbox.put(Letter { topic, payload, retained: true, confirmed: true });
        }
    }

    fn put(&self, part: &str, value: &impl Serialize) {
        self.letter(part, value, true);
    }

    fn letter(&self, part: &str, value: &impl Serialize, retained: bool) {
        let topic = self.broker.config.topic(part);
        let payload = serde_json::to_vec(value).unwrap_or_default();
        self.outbox.put(Letter { topic, payload, retained, confirmed: true });
    }

    fn put_key(&self, at: usize) {
        self.letter_of(at, "key", &Key { key: self.desk.key(at).map(message::shown) });
    }

    fn letter_of(&self, at: usize, part: &str, value: &impl Serialize) {
        let topic = self.broker.config.topic_of(Some(at), part);
        let payload = serde_json::to_vec(value).unwrap_or_default();
        self.outbox.put(Letter { topic, payload, retained: true, confirmed: true });
    }

    fn put_available(&self, at: usize, available: bool) {
        let topic = self.broker.config.topic_of(Some(at), "available");
        let payload = if available { "online" } else { "offline" }.into();
        self.outbox.put(Letter { topic, payload, retained: true, confirmed: true });
    }

    /// The hub ends: the broker knows at once, not only when it misses the connection.
    async fn say_goodbye(&mut self, client: &AsyncClient, heard: &mut mpsc::Receiver<News>) {
        let acts = self.desk.end(&mut random);
        self.carry_out(acts);
        for at in 0..self.published.len() {
            self.put_available(at, false);
            self.letter_of(at, "key", &Key { key: None });
        }
        self.put("hub", &Online::no());
        let last = async {
            while !self.outbox.is_empty() {
                sleep(Duration::from_millis(10)).await;
            }
            _ = client.disconnect().await;
            while !matches!(heard.recv().await, None | Some(News::Lost(_))) {}
        };
        _ = timeout(FAREWELL, last).await;
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let acts = self.desk.end(&mut random);
        self.hand.carry_out(&self.desk, acts);
        self.hub.disconnect(&self.key);
        self.broker.counts.went(&self.key.seat);
    }
}

fn random() -> Option<u64> {
    getrandom::u64().ok()
}

//! The lines: connects to a broker, publishes, hears commands. What is decided is in [`super::desk`].

use std::collections::BTreeSet;
use std::future::pending;
use std::sync::Arc;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use rumqttc::mqttbytes::QoS;
use rumqttc::{AsyncClient, LastWill, SubscribeFilterInput};
use serde::Serialize;
use serde_json::Value;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, sleep_until, timeout};

use super::desk::{Act, Heard, Reply};
use super::outbox::{Letter, Outbox};
use super::session::{FAREWELL, Line, News, Retry, Seated, live, looks, random, send};
use super::state::{self, AlarmList, Key, Online, Ticket, Urgent};
use super::{Broker, discovery, leftover, link, message};
use crate::hub::Hub;
use crate::plugs::noted::{Reports, Seldom};
use crate::text::Both;

/// Connects until the hub ends.
pub async fn run(hub: Hub, broker: Arc<Broker>) {
    let (reports, mut retry) = (Reports::default(), Retry::new(&hub, &broker));
    loop {
        let began = Instant::now();
        let connected = connect(&hub, &broker, &reports);
        let Some(why) = connected.await else { return };
        if !retry.after(began, why).await {
            return;
        }
    }
}

/// A connection, from its beginning to its end. Why it has ended; `None`: the hub ends.
async fn connect(hub: &Hub, broker: &Arc<Broker>, reports: &Reports) -> Option<Both> {
    let gone = serde_json::to_vec(&Online::no()).unwrap_or_default();
    let will = LastWill::new(broker.config.topic("hub"), gone, QoS::AtLeastOnce, true, None);
    let options = match link::options(&broker.config, will, link::Reached::default()) {
        Ok(options) => options,
        Err(why) => return Some(why),
    };
    // The last subscription is not needed for commands.
    let mut line = match Line::open(hub, broker, options, 1).await {
        Ok(line) => line,
        Err(why) => return why,
    };
    if let Err(why) = subscribe(&line.client, broker).await {
        return Some(why);
    }
    let outbox = Arc::new(Outbox::default());
    line.tasks.spawn(write(line.client.clone(), outbox.clone()));
    let mut session = Session::begin(hub, broker, outbox, reports);
    let ended = session.run(&mut line.heard).await;
    if ended.is_none() {
        session.say_goodbye(&line.client, &mut line.heard).await;
    }
    drop(session);
    ended
}

/// Asks for commands as they come: not for those that the broker has kept from before. Those to monitors that are not
/// here have their result, too. What is asked for last is not needed: what the broker keeps of such monitors.
async fn subscribe(client: &AsyncClient, broker: &Broker) -> Result<(), Both> {
    let config = &broker.config;
    let all = ["command", "alive", "+/command"].map(|part| config.topic(part));
    let all = all.into_iter().chain(discovery::birth(config));
    let kept = SubscribeFilterInput::new(leftover::filter(config), QoS::AtLeastOnce).no_local(true);
    let filters: Vec<_> = all.map(live).chain([kept]).collect();
    let asked = client.subscribe_many(filters).await;
    asked.map_err(|error| text::MqttFailed { error: error.to_string() }.words())
}

/// Publishes what waits. A broker that takes nothing holds up nothing but this.
async fn write(client: AsyncClient, outbox: Arc<Outbox>) {
    loop {
        if send(&client, outbox.next().await).await.is_err() {
            return;
        }
    }
}

/// A session with a broker.
struct Session {
    own: Seated,
    number: String,
    outbox: Arc<Outbox>,
    /// Of each monitor, when its state was published, and what of it matters at once.
    published: Vec<Option<(Duration, Urgent)>>,
    alarms: Vec<u8>,
    /// Home Assistant has started, and what it discovers is to be published once more.
    born: bool,
    births: Seldom,
    /// Monitors that were configured before, and are not kept by the broker any more.
    cleared: BTreeSet<String>,
}

impl Session {
    fn begin(hub: &Hub, broker: &Arc<Broker>, outbox: Arc<Outbox>, reports: &Reports) -> Self {
        let number = message::shown(random().unwrap_or_default());
        let monitors = broker.config.monitors.len();
        let session = Self {
            own: Seated::begin(hub, broker, reports),
            number,
            outbox,
            published: vec![None; monitors],
            alarms: Vec::new(),
            born: false,
            births: Seldom::default(),
            cleared: BTreeSet::new(),
        };
        session.put("hub", &Online::since(&session.number, session.own.since_ms));
        session.discover();
        (0..monitors).for_each(|at| session.put_key(at));
        session
    }

    /// Until the connection ends, and why; `None`: the hub ends.
    async fn run(&mut self, heard: &mut mpsc::Receiver<News>) -> Option<Both> {
        let (mut shutdown, start) = (self.own.hub.shutdown(), self.own.hub.start());
        let mut looks = looks();
        loop {
            let next = self.own.desk.timeout();
            tokio::select! {
                () = shutdown.requested() => return None,
                news = heard.recv() => match news {
                    Some(News::Message { topic, payload, retained }) => {
                        self.heed(&topic, &payload, retained);
                    }
                    Some(News::Connected | News::Subscribed) => {}
                    Some(News::Lost(why)) => return Some(why),
                    None => return Some(link::silent()),
                },
                Some(answer) = self.own.results.recv() => {
                    let acts = self.own.answered(answer);
                    self.publish(acts);
                }
                // What is for this client alone is published with the states.
                Some(_) = self.own.key.events.recv() => {}
                event = self.own.key.common.recv() => match event {
                    Ok(event) => self.tell(&event),
                    Err(RecvError::Lagged(count)) => self.own.hub.count_missed(count),
                    Err(RecvError::Closed) => return None,
                },
                _ = looks.tick() => self.look(),
                () = sleep_until(start + next) => {
                    let acts = self.own.tick();
                    self.publish(acts);
                }
            }
        }
    }

    fn heed(&mut self, topic: &str, payload: &[u8], retained: bool) {
        let config = &self.own.broker.config;
        if discovery::birth(config).as_deref() == Some(topic) {
            // It is published by and by: however often it starts.
            self.born |= payload == b"online";
            return;
        }
        let Some(rest) = topic.strip_prefix(&config.prefix).and_then(|it| it.strip_prefix('/'))
        else {
            return;
        };
        if let Some(id) = rest.strip_suffix("/key") {
            if retained && leftover::is_left(config, id, payload) {
                self.clear(id);
            }
            return;
        }
        let id = rest.strip_suffix("/command");
        let monitor = id.map(|id| config.monitors.iter().position(|it| it == id));
        let acts = match (rest, id, monitor.flatten()) {
            (_, Some(id), None) => {
                self.refuse_unknown(id, payload, retained);
                Vec::new()
            }
            ("alive", ..) => self.own.alive(message::read_alive(payload).filter(|_| !retained)),
            (_, _, monitor) => {
                self.own.command(Heard { monitor, retained }, message::read(payload))
            }
        };
        self.publish(acts);
        let acts = self.own.carried(payload);
        self.publish(acts);
    }

    /// What the desk has left to its broker.
    fn publish(&self, acts: Vec<Act>) {
        for act in acts {
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
        let topic = self.own.broker.config.topic_of(reply.monitor, "result");
        self.say_on(topic, reply, reply.is_of_flood());
    }

    fn say_on(&self, topic: String, reply: &Reply, of_flood: bool) {
        let counts = &self.own.broker.counts;
        if reply.result.is_err() {
            counts.count(|it| &it.exceptions);
        }
        let payload = serde_json::to_vec(&state::Result::new(reply)).unwrap_or_default();
        let letter = Letter { topic, payload, retained: false, confirmed: true };
        if !self.outbox.put_result(letter, of_flood) {
            counts.count(|it| &it.rejected);
        }
    }

    /// Results of others do not give way to that of a command to a monitor that is not here.
    fn refuse_unknown(&mut self, id: &str, payload: &[u8], retained: bool) {
        let reply = self.own.refuse_unknown(id, retained, || message::read(payload));
        let Some(reply) = reply else { return };
        self.say_on(self.own.broker.config.topic(&format!("{id}/result")), &reply, true);
    }

    /// The broker keeps nothing more of a monitor that is not configured now.
    fn clear(&mut self, id: &str) {
        if self.cleared.len() >= leftover::LEFT_MAX || !self.cleared.insert(id.to_owned()) {
            return;
        }
        for topic in leftover::topics(&self.own.broker.config, id) {
            self.outbox.put(Letter { topic, payload: Vec::new(), retained: true, confirmed: true });
        }
    }

    /// A message of the hub that concerns all, in its own words.
    fn tell(&self, message: &str) {
        let Ok(mut event) = serde_json::from_str::<Value>(message) else { return };
        let monitor = event["monitor"].as_str();
        let own =
            monitor.is_none_or(|id| self.own.broker.config.monitors.iter().any(|it| it == id));
        if event["type"] != "event" || !own {
            return;
        }
        event.as_object_mut().map(|it| it.remove("type"));
        let topic = self.own.broker.config.topic("event");
        let payload = event.to_string().into_bytes();
        self.outbox.put_event(Letter { topic, payload, retained: false, confirmed: false });
    }

    /// Publishes states whose time has come, and at once what matters.
    fn look(&mut self) {
        let (now, interval) = (self.own.hub.now(), self.own.broker.config.interval);
        if self.born && self.births.is_due(now) {
            self.born = false;
            self.discover();
        }
        for (at, state) in self.own.hand.states().iter().enumerate() {
            let urgent = state.urgent();
            let last = self.published.get(at).copied().flatten();
            let is_same = last.is_some_and(|(_, it)| it == urgent);
            if is_same && last.is_some_and(|(since, _)| now < since + interval) {
                continue;
            }
            let topic = |part| self.own.broker.config.topic_of(Some(at), part);
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
        let alarms = self.own.hub.alarms();
        let list = AlarmList::new(&alarms.list(), &self.own.broker.config.monitors);
        let list = serde_json::to_vec(&list).unwrap_or_default();
        drop(alarms);
        if list != self.alarms {
            let topic = self.own.broker.config.topic("alarms");
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
        let config = &self.own.broker.config;
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
        let topic = self.own.broker.config.topic(part);
        let payload = serde_json::to_vec(value).unwrap_or_default();
        self.outbox.put(Letter { topic, payload, retained, confirmed: true });
    }

    fn put_key(&self, at: usize) {
        self.letter_of(at, "key", &Key { key: self.own.desk.key(at).map(message::shown) });
    }

    fn letter_of(&self, at: usize, part: &str, value: &impl Serialize) {
        let topic = self.own.broker.config.topic_of(Some(at), part);
        let payload = serde_json::to_vec(value).unwrap_or_default();
        self.outbox.put(Letter { topic, payload, retained: true, confirmed: true });
    }

    fn put_available(&self, at: usize, available: bool) {
        let topic = self.own.broker.config.topic_of(Some(at), "available");
        let payload = if available { "online" } else { "offline" }.into();
        self.outbox.put(Letter { topic, payload, retained: true, confirmed: true });
    }

    /// The hub ends: the broker knows at once, not only when it misses the connection. What stops is taken until then.
    async fn say_goodbye(&mut self, client: &AsyncClient, heard: &mut mpsc::Receiver<News>) {
        let acts = self.own.end();
        self.publish(acts);
        for at in 0..self.published.len() {
            self.put_available(at, false);
            self.letter_of(at, "key", &Key { key: None });
        }
        self.put("hub", &Online::no());
        let outbox = self.outbox.clone();
        let sent = async {
            while !outbox.is_empty() {
                sleep(Duration::from_millis(10)).await;
            }
            _ = client.disconnect().await;
            pending::<()>().await;
        };
        let last = async {
            while let Some(news) = heard.recv().await {
                match news {
                    News::Message { topic, payload, retained } => {
                        self.heed(&topic, &payload, retained);
                    }
                    News::Lost(_) => return,
                    News::Connected | News::Subscribed => {}
                }
            }
        };
        let last = async {
            tokio::select! {
                () = sent => {}
                () = last => {}
            }
        };
        _ = timeout(FAREWELL, last).await;
    }
}

#[cfg(test)]
mod tests {
    use super::super::session::LOOK_EACH;
    use super::*;
    use crate::Config;
    use crate::plugs::mqtt::Brokers;

    fn session(hub: &Hub) -> Session {
        let text = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n[[mqtt]]\nname = \"site\"\n\
                    url = \"mqtt://127.0.0.1\"\nhomeassistant = \"homeassistant\"\n";
        let folder = std::path::Path::new("/");
        let read = Config::parse("hub.toml", text, folder, &crate::Overrides::default());
        let brokers = Brokers::new(&read.unwrap().mqtt);
        Session::begin(hub, &brokers.all[0], Arc::default(), &Reports::default())
    }

    /// What was put out since this was asked last.
    async fn taken(session: &Session) -> Vec<Letter> {
        let mut all = Vec::new();
        while let Ok(letter) = timeout(Duration::from_millis(1), session.outbox.next()).await {
            all.push(letter);
        }
        all
    }

    fn discovered(letters: &[Letter]) -> usize {
        letters.iter().filter(|it| it.topic.starts_with("homeassistant/")).count()
    }

    #[tokio::test(start_paused = true)]
    async fn however_often_home_assistant_starts_it_is_answered_seldom_and_at_last() {
        let (hub, _) = Hub::of_one(None);
        let mut session = session(&hub);
        assert_eq!(discovered(&taken(&session).await), 1, "at the beginning");
        let mut answers = 0;
        for _ in 0..600 {
            session.heed("homeassistant/status", b"online", false);
            tokio::time::advance(LOOK_EACH).await;
            session.look();
            answers += discovered(&taken(&session).await);
        }
        assert!((6..=8).contains(&answers), "{answers} in a minute");
        // The last one is not forgotten.
        session.heed("homeassistant/status", b"offline", false);
        tokio::time::advance(Duration::from_secs(10)).await;
        session.look();
        assert_eq!(discovered(&taken(&session).await), 1);
        tokio::time::advance(Duration::from_secs(60)).await;
        session.look();
        assert_eq!(discovered(&taken(&session).await), 0, "once");
    }

    #[tokio::test(start_paused = true)]
    async fn what_is_kept_of_a_monitor_that_has_gone_is_cleared() {
        let (hub, _) = Hub::of_one(None);
        let mut session = session(&hub);
        taken(&session).await;
        let key = br#"{"key":"00000000000000ff"}"#;
        for (topic, payload, retained) in [
            ("lafet/M1/key", &key[..], true),
            ("lafet/M2/key", key, false),
            ("lafet/pump/key", br#"{"key":"red"}"#, true),
            ("lafet/pump/key", br#"{"key":null,"x":1}"#, true),
            ("lafet/pump/key", b"online", true),
            ("lafet/a b/key", key, true),
        ] {
            session.heed(topic, payload, retained);
        }
        assert_eq!(taken(&session).await, [], "what is here, or of other devices, is left alone");
        for _ in 0..3 {
            session.heed("lafet/M2/key", key, true);
        }
        session.heed("lafet/M3/key", br#"{"key":null}"#, true);
        let letters = taken(&session).await;
        let topics: Vec<&str> = letters.iter().map(|it| it.topic.as_str()).collect();
        let of = ["lafet/M2/state", "lafet/M2/available"];
        assert_eq!(topics[..2], of);
        assert_eq!(topics[2..4], ["homeassistant/device/lafet_M2/config", "lafet/M2/key"]);
        assert_eq!(topics.len(), 8, "{topics:?}");
        assert!(letters.iter().all(|it| it.payload.is_empty() && it.retained));
        for number in 0..10_000 {
            session.heed(&format!("lafet/X{number}/key"), key, true);
        }
        assert!(taken(&session).await.len() <= 4 * leftover::LEFT_MAX);
    }

    /// Assumed: the hub ends while messages of its clients are on their way.
    #[tokio::test(start_paused = true)]
    async fn what_comes_while_the_hub_ends_stops_and_commands_nothing() {
        let (hub, station) = Hub::of_one(None);
        let mut session = session(&hub);
        let will = LastWill::new("lafet/hub", "", QoS::AtLeastOnce, true, None);
        let options = link::options(&session.own.broker.config, will, link::Reached::default());
        let (client, _events) = AsyncClient::builder(options.unwrap()).capacity(8).build();
        let (news, mut heard) = mpsc::channel(8);
        let message = |topic: &str, text: &str| News::Message {
            topic: topic.into(),
            payload: text.into(),
            retained: false,
        };
        for one in [
            message("lafet/M1/command", r#"{"id":"1","command":"take"}"#),
            message("lafet/M1/command", r#"{"id":"2","command":"stop"}"#),
            message("lafet/command", r#"{"command":"lockout"}"#),
            News::Lost(Both::default()),
        ] {
            assert!(news.send(one).await.is_ok());
        }
        session.say_goodbye(&client, &mut heard).await;
        let counts = station.urgent_counts();
        assert_eq!((counts.stop, counts.lockout), (1, 1));
        let letters = taken(&session).await;
        assert!(letters.iter().all(|it| !it.topic.ends_with("/result")), "{letters:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn a_command_to_a_monitor_that_is_not_here_has_its_result() {
        let (hub, _) = Hub::of_one(None);
        let mut session = session(&hub);
        taken(&session).await;
        session.heed("lafet/M2/command", br#"{"id":"a","command":"stop"}"#, false);
        let letters = taken(&session).await;
        let [letter] = &letters[..] else { panic!("{letters:?}") };
        assert_eq!(letter.topic, "lafet/M2/result");
        let result: Value = serde_json::from_slice(&letter.payload).unwrap();
        assert_eq!((&result["id"], &result["command"]), (&"a".into(), &"stop".into()));
        assert_eq!((&result["ok"], &result["refusal"]), (&false.into(), &2.into()));
        for number in 0..10_000 {
            session.heed(&format!("lafet/X{number}/command"), b"{}", false);
            session.heed("lafet/a\u{7}b/command", b"{}", false);
        }
        assert!(taken(&session).await.len() < 40);
    }
}

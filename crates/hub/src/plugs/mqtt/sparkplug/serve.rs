//! The lines of the edge node: connects to a broker, publishes, hears commands. What is decided is in [`super::node`] and
//! in the desk.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use rumqttc::mqttbytes::QoS;
use rumqttc::mqttbytes::v5::{DisconnectProperties, DisconnectReasonCode};
use rumqttc::{AsyncClient, LastWill, RetainForwardRule, SubscribeFilterInput};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until, timeout};

use super::NodeConfig;
use super::commands::{self, Write};
use super::node::Node;
use crate::hub::{Caller, Hub};
use crate::plugs::mqtt::desk::{Act, Heard, Reply};
use crate::plugs::mqtt::outbox::Letter;
use crate::plugs::mqtt::session::{FAREWELL, Line, News, Retry, Seated, live, looks, send};
use crate::plugs::mqtt::{Broker, link, message, state};
use crate::plugs::noted::{Reports, Seldom};
use crate::plugs::seat::PlugSeat;
use crate::text::Both;

/// The broker is asked this often whether it has taken what was sent.
const ASK_EACH: Duration = Duration::from_secs(2);

/// Connects until the hub ends. What the monitors show is kept meanwhile.
pub async fn run(hub: Hub, broker: Arc<Broker>) {
    let Some(config) = broker.config.sparkplug.clone() else { return };
    let (reports, mut retry) = (Reports::default(), Retry::new(&hub, &broker));
    let dropped = Seldom::default();
    let mut node = Node::new(&config, &broker.config.monitors, broker.config.interval);
    loop {
        let (began, before) = (Instant::now(), node.dropped());
        let connected = connect(&hub, &broker, (&config, &mut node), &reports);
        let why = match connected.await {
            End::Hub => return,
            End::Lost(why) => why,
            End::Host => {
                // The broker is as good as ever, and what stops comes over it.
                retry.soon();
                text::SparkplugWaits { host: config.host.as_deref().unwrap_or_default() }.words()
            }
        };
        node.lost();
        let pause = retry.after(began, why);
        if !aside(&hub, &broker, &mut node, pause).await {
            return;
        }
        if node.dropped() > before && dropped.is_due(hub.now()) {
            let (name, count) = (&broker.config.name, node.dropped());
            hub.event(None, &text::SparkplugDropped { name, count }.words());
        }
    }
}

/// Waits for something; what changes meanwhile is kept.
async fn aside<T>(hub: &Hub, broker: &Broker, node: &mut Node, what: impl Future<Output = T>) -> T {
    let (caller, mut looks) = (Caller::hub(), looks());
    let mut what = pin!(what);
    loop {
        tokio::select! {
            done = &mut what => return done,
            _ = looks.tick() => {
                let seat = PlugSeat { hub, caller: &caller };
                let states = state::all(seat, &broker.config.monitors);
                node.look(hub.now(), hub.clock().now_ms(), &states);
            }
        }
    }
}

/// Why a session has ended.
enum End {
    /// The hub ends.
    Hub,
    /// The host has gone.
    Host,
    /// The connection has.
    Lost(Both),
}

/// What is sent.
enum Out {
    Letter(Letter),
    /// A question to the broker, which it answers once it has taken what was sent before.
    Ask,
    /// The end.
    End,
}

/// A connection, from its beginning to its end.
async fn connect(
    hub: &Hub,
    broker: &Arc<Broker>,
    (config, node): (&NodeConfig, &mut Node),
    reports: &Reports,
) -> End {
    let Letter { topic, payload, .. } = node.connect(hub.clock().now_ms());
    let will = LastWill::new(topic, payload, QoS::AtLeastOnce, false, None);
    let reached = link::Reached::default();
    let options = match link::options(&broker.config, will, reached.clone()) {
        Ok(options) => options,
        Err(why) => return End::Lost(why),
    };
    let opened = Line::open(hub, broker, options, 0);
    let opened = aside(hub, broker, node, opened).await;
    if reached.load(Ordering::SeqCst) {
        node.reached();
    }
    let mut line = match opened {
        Ok(line) => line,
        Err(why) => return why.map_or(End::Hub, End::Lost),
    };
    if let Err(error) = line.client.subscribe_many(filters(config)).await {
        return End::Lost(text::MqttFailed { error: error.to_string() }.words());
    }
    let (out, letters) = mpsc::channel(link::AHEAD);
    line.tasks.spawn(write(line.client.clone(), letters, config.topic("NCMD")));
    let mut session = Session {
        own: Seated::begin(hub, broker, reports),
        config,
        node,
        out,
        is_subscribed: false,
    };
    session.keys();
    let end = session.run(&mut line.heard).await;
    if !matches!(end, End::Lost(_)) {
        session.say_goodbye(&mut line.heard).await;
    }
    end
}

/// Commands as they come, none that the broker has kept; and what it has kept of the host.
fn filters(config: &NodeConfig) -> Vec<SubscribeFilterInput> {
    let commands = [config.topic("NCMD"), config.topic_of("DCMD", "+")].map(live);
    let host = config.host_topic().map(|topic| {
        SubscribeFilterInput::new(topic, QoS::AtLeastOnce)
            .preserve_retain(true)
            .retain_forward_rule(RetainForwardRule::OnEverySubscribe)
    });
    commands.into_iter().chain(host).collect()
}

/// Publishes what is sent, in its order. A broker that takes nothing holds up nothing but this.
async fn write(client: AsyncClient, mut letters: mpsc::Receiver<Out>, asked: String) {
    while let Some(out) = letters.recv().await {
        let done = match out {
            Out::Letter(letter) => send(&client, letter).await,
            Out::Ask => client.subscribe_many([live(asked.clone())]).await,
            // The broker publishes the death as well: so the format wants it.
            Out::End => {
                let properties = DisconnectProperties {
                    session_expiry_interval: None,
                    reason_string: None,
                    user_properties: Vec::new(),
                    server_reference: None,
                };
                let reason = DisconnectReasonCode::DisconnectWithWillMessage;
                client.disconnect_with_properties(reason, properties).await
            }
        };
        if done.is_err() {
            return;
        }
    }
}

/// Once there is room; `false`: nothing is sent any more.
async fn is_taken(out: &mpsc::Sender<Out>) -> bool {
    out.reserve().await.is_ok()
}

/// A session with a broker.
struct Session<'a> {
    own: Seated,
    config: &'a NodeConfig,
    node: &'a mut Node,
    out: mpsc::Sender<Out>,
    is_subscribed: bool,
}

impl Session<'_> {
    fn now(&self) -> (Duration, u64) {
        (self.own.hub.now(), self.own.hub.clock().now_ms())
    }

    /// Until the connection is to end.
    async fn run(&mut self, heard: &mut mpsc::Receiver<News>) -> End {
        let (mut shutdown, start) = (self.own.hub.shutdown(), self.own.hub.start());
        let (mut looks, mut asks) = (looks(), interval(ASK_EACH));
        asks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let is_full = self.send();
            if self.node.is_full() && !self.ask() {
                return End::Lost(link::silent());
            }
            let next = self.own.desk.timeout();
            tokio::select! {
                () = shutdown.requested() => return End::Hub,
                news = heard.recv() => match news {
                    Some(News::Message { topic, payload, retained }) => {
                        if self.heed(&topic, &payload, retained) {
                            return End::Host;
                        }
                    }
                    Some(News::Connected) => {}
                    Some(News::Subscribed) => self.subscribed(),
                    Some(News::Lost(why)) => return End::Lost(why),
                    None => return End::Lost(link::silent()),
                },
                Some(answer) = self.own.results.recv() => {
                    let acts = self.own.answered(answer);
                    self.publish(acts);
                }
                // What is for this client alone is published with the states; events are not published.
                Some(_) = self.own.key.events.recv() => {}
                event = self.own.key.common.recv() => match event {
                    Ok(_) => {}
                    Err(RecvError::Lagged(count)) => self.own.hub.count_missed(count),
                    Err(RecvError::Closed) => return End::Hub,
                },
                _ = looks.tick() => self.look(),
                _ = asks.tick() => if !self.ask() {
                    return End::Lost(link::silent());
                },
                taken = is_taken(&self.out), if is_full => if !taken {
                    return End::Lost(link::silent());
                },
                () = sleep_until(start + next) => {
                    let acts = self.own.tick();
                    self.publish(acts);
                }
            }
        }
    }

    /// Sends what can be sent; whether there is more than the broker takes.
    fn send(&mut self) -> bool {
        let (now, now_ms) = self.now();
        loop {
            let Ok(free) = self.out.try_reserve() else { return true };
            match self.node.next(now, now_ms) {
                Some(letter) => free.send(Out::Letter(letter)),
                None => return false,
            }
        }
    }

    /// Asks whether the broker has taken what was sent; `false`: it leaves such questions unanswered.
    fn ask(&mut self) -> bool {
        if !self.is_subscribed {
            return true;
        }
        let Ok(free) = self.out.try_reserve() else { return true };
        let is_answered = self.node.fence();
        if is_answered {
            free.send(Out::Ask);
        }
        is_answered
    }

    fn subscribed(&mut self) {
        if self.is_subscribed {
            return self.node.confirmed();
        }
        self.is_subscribed = true;
        self.node.begin(self.own.hub.now());
        self.show_host();
    }

    /// Whether it waits for its host, for those who look at the hub.
    fn show_host(&self) {
        let host = self.config.host.as_ref().filter(|_| self.node.waits());
        let waits = host.map(|host| text::SparkplugWaits { host }.words());
        self.own.broker.counts.set_error(waits);
    }

    /// What was heard; `true`: the host has gone.
    fn heed(&mut self, topic: &str, payload: &[u8], retained: bool) -> bool {
        if self.config.host_topic().as_deref() == Some(topic) {
            let has_gone = self.node.host(self.own.hub.now(), payload);
            if self.is_subscribed {
                self.show_host();
            }
            return has_gone;
        }
        if topic == self.config.topic("NCMD") {
            self.writes(None, payload, retained);
        } else if let Some(id) = topic.strip_prefix(&self.config.topic_of("DCMD", "")) {
            match self.own.broker.config.monitors.iter().position(|it| it == id) {
                Some(at) => self.writes(Some(at), payload, retained),
                None => self.refuse_unknown(id, payload, retained),
            }
        }
        let acts = self.own.carried(payload);
        self.publish(acts);
        false
    }

    fn writes(&mut self, monitor: Option<usize>, payload: &[u8], retained: bool) {
        for write in commands::read(monitor, payload) {
            let acts = match write {
                Write::Rebirth if retained => continue,
                Write::Rebirth => {
                    self.own.broker.counts.count(|it| &it.requests);
                    self.node.rebirth(self.own.hub.now());
                    continue;
                }
                Write::Alive(ticket) => self.own.alive(ticket.filter(|_| !retained)),
                Write::Asked { asked, is_old } => {
                    self.own.command(Heard { monitor, retained: retained || is_old }, asked)
                }
            };
            self.publish(acts);
        }
    }

    fn refuse_unknown(&mut self, id: &str, payload: &[u8], retained: bool) {
        for write in commands::read(Some(usize::MAX), payload) {
            let Write::Asked { asked, .. } = write else { continue };
            if let Some(reply) = self.own.refuse_unknown(id, retained, || asked) {
                self.say(id.to_owned(), reply);
            }
        }
    }

    /// What the desk has left to its broker.
    fn publish(&mut self, acts: Vec<Act>) {
        let now_ms = self.now().1;
        for act in acts {
            match act {
                Act::Ticket(ticket) => self.node.set_ticket(now_ms, message::shown(ticket)),
                Act::Key(at) => self.key(at),
                Act::Say(reply) => {
                    let monitor =
                        reply.monitor.and_then(|at| self.own.broker.config.monitors.get(at));
                    let id = monitor.cloned().unwrap_or_default();
                    self.say(id, reply);
                }
                _ => {}
            }
        }
    }

    fn say(&mut self, id: String, reply: Reply) {
        let counts = &self.own.broker.counts;
        if reply.result.is_err() {
            counts.count(|it| &it.exceptions);
        }
        if !self.node.say(reply.monitor, id, reply) {
            counts.count(|it| &it.rejected);
        }
    }

    fn keys(&mut self) {
        (0..self.own.broker.config.monitors.len()).for_each(|at| self.key(at));
    }

    fn key(&mut self, at: usize) {
        let key = self.own.desk.key(at).map(message::shown);
        let now_ms = self.now().1;
        self.node.set_key(at, now_ms, key);
    }

    fn look(&mut self) {
        let (now, now_ms) = self.now();
        self.node.look(now, now_ms, &self.own.hand.states());
    }

    /// It ends by will: the hosts know at once. What stops is taken until then.
    async fn say_goodbye(&mut self, heard: &mut mpsc::Receiver<News>) {
        let acts = self.own.end();
        self.publish(acts);
        self.send();
        let death = self.node.death(self.now().1);
        let last = async {
            for out in [Out::Letter(death), Out::End] {
                _ = self.out.send(out).await;
            }
            while let Some(news) = heard.recv().await {
                match news {
                    News::Message { topic, payload, retained } => {
                        _ = self.heed(&topic, &payload, retained);
                    }
                    News::Lost(_) => return,
                    News::Connected | News::Subscribed => {}
                }
            }
        };
        _ = timeout(FAREWELL, last).await;
    }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;

    use super::super::payload::{Metric, Payload, Value};
    use super::*;
    use crate::Config;
    use crate::plugs::mqtt::Brokers;

    /// Assumed: the hub ends while a write of its host is on its way.
    #[tokio::test(start_paused = true)]
    async fn what_comes_while_the_node_ends_stops() {
        let (hub, station) = Hub::of_one(None);
        let text = "[[monitor]]\nid = \"M1\"\nurl = \"tcp://h?addr=1\"\n[[mqtt]]\nname = \"scada\"\n\
                    url = \"mqtt://127.0.0.1\"\n[mqtt.sparkplug]\ngroup = \"g\"\nnode = \"n\"\n";
        let folder = std::path::Path::new("/");
        let read = Config::parse("hub.toml", text, folder, &crate::Overrides::default());
        let brokers = Brokers::new(&read.unwrap().mqtt);
        let broker = &brokers.all[0];
        let config = broker.config.sparkplug.clone().unwrap();
        let mut node = Node::new(&config, &broker.config.monitors, broker.config.interval);
        let (out, mut letters) = mpsc::channel(8);
        let mut session = Session {
            own: Seated::begin(&hub, broker, &Reports::default()),
            config: &config,
            node: &mut node,
            out,
            is_subscribed: true,
        };
        let (news, mut heard) = mpsc::channel(8);
        let (name, value) = (Some("Command/Stop".to_owned()), Some(Value::Boolean(true)));
        let metrics = vec![Metric { name, value, ..Metric::default() }];
        let payload = Payload { metrics, ..Payload::default() }.encode_to_vec();
        let topic = config.topic_of("DCMD", "M1");
        for one in [News::Message { topic, payload, retained: false }, News::Lost(Both::default())]
        {
            assert!(news.send(one).await.is_ok());
        }
        session.say_goodbye(&mut heard).await;
        assert_eq!(station.urgent_counts().stop, 1);
        letters.close();
    }
}

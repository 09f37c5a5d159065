//! The server: its thread, the library on it, and its bounds.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use lafet_texts::{Text as _, hub as text};
use opcua::server::address_space::AddressSpace;
use opcua::server::diagnostics::DiagnosticsNodeManagerBuilder;
use opcua::server::node_manager::ServerContext;
use opcua::server::node_manager::memory::InMemoryNodeManagerBuilder;
use opcua::server::{
    ANONYMOUS_USER_TOKEN_ID, Limits, OperationalLimits, ServerBuilder, ServerEndpoint,
    ServerHandle, SubscriptionLimits,
};
use opcua::types::{BuildInfo, DateTime, MessageSecurityMode};
use tokio::net::{TcpListener, TcpSocket};
use tokio::runtime::{Builder, Handle};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval, sleep};

use super::alarms::Conditions;
use super::base::Base;
use super::door::POLICIES;
use super::login::Login;
use super::nodes::{Nodes, View};
use super::peers::Peers;
use super::seats::Seats;
use super::{Server, ServerConfig, folder, front, history};
use crate::field::line::said;
use crate::hub::Hub;
use crate::text::Both;

/// Rest before a server that failed is started again.
const RETRY: Duration = Duration::from_secs(2);
/// Values and alarms are looked at this often.
const LOOK_EACH: Duration = Duration::from_millis(50);
/// The folder of rejected certificates is looked at this often.
const PRUNE_EACH: Duration = Duration::from_secs(2);
/// Subscriptions are looked at this often, and published and sampled at most so often, ms.
const TICK_MS: u64 = 25;
const INTERVAL_MS: f64 = 50.0;
/// A session without a request ends after this time, and so does one that is never used, ms.
const SESSION_MS: u64 = 60_000;
/// Keys of a channel are renewed within this time, ms.
const CHANNEL_MS: u32 = 3_600_000;
/// A request is answered within this time, ms.
const REQUEST_MS: u32 = 15_000;
/// A channel begins within this time, s.
const HELLO_S: u32 = 5;
/// Connections that wait to be taken.
const BACKLOG: u32 = 32;
/// Elements of an array, bytes of a string, and chunks of a message.
const ARRAY_MAX: usize = 10_000;
const STRING_MAX: usize = 65_535;
const CHUNKS_MAX: usize = 32;
/// Subscriptions of a session, items of one, events that wait for an item, and notifications that wait.
const SUBSCRIPTIONS_MAX: usize = 4;
const ITEMS_MAX: usize = 5000;
const EVENTS_MAX: usize = 1000;
const NOTIFICATIONS_MAX: usize = 20;
/// Values and events of one message.
const PUBLISHED_MAX: u64 = 1000;
/// Of each kind of thing, in one request; nodes in a browse, and references of one.
const AT_ONCE: usize = 1000;
const BROWSED_MAX: usize = 100;
const REFERENCES_MAX: usize = 500;
/// Methods in one call.
const CALLS_MAX: usize = 16;
/// Variables whose history is read in one request.
const HISTORIES_MAX: usize = 4;
/// Places in a browse, in the history and in a query that a session may come back to.
const PLACES_MAX: usize = 16;

/// Serves until the hub ends. A server that fails is started again.
pub async fn run(hub: Hub, server: Arc<Server>) {
    let mut shutdown = hub.shutdown();
    loop {
        let failed = tokio::select! {
            failed = listen(&hub, &server) => failed,
            () = shutdown.requested() => return,
        };
        let name = &server.config.name;
        if server.counts.set_error(Some(failed.clone())) {
            hub.event(None, &text::OpcuaNotListening { name, why: &failed }.words());
        }
        tokio::select! {
            () = sleep(RETRY) => {}
            () = shutdown.requested() => return,
        }
    }
}

/// Returns why it does not listen any more.
async fn listen(hub: &Hub, server: &Arc<Server>) -> Both {
    if let Err(error) = folder::prepare(&server.config) {
        return said(&error);
    }
    let listener = match bind(server.config.listen) {
        Ok(listener) => listener,
        Err(error) => return said(&error),
    };
    let (ended, end) = oneshot::channel();
    let (own, of, main) = (hub.clone(), server.clone(), Handle::current());
    // Dropped, the thread ends.
    let (_running, stop) = oneshot::channel::<()>();
    let thread = std::thread::Builder::new().name("lafet-opcua".into());
    let started = thread.spawn(move || {
        let runtime = match Builder::new_current_thread().enable_all().build() {
            Ok(runtime) => runtime,
            Err(error) => {
                _ = ended.send(said(&error));
                return;
            }
        };
        let why = runtime.block_on(async {
            tokio::select! {
                why = serve(&own, &of, listener, &main) => why,
                _ = stop => Both::default(),
            }
        });
        _ = ended.send(why);
    });
    match started {
        Ok(_) => end.await.unwrap_or_else(|_| text::OpcuaEnded.words()),
        Err(error) => said(&error),
    }
}

/// Listens. The listener is taken over by the server's thread.
fn bind(address: SocketAddr) -> io::Result<std::net::TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    socket.set_reuseaddr(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)?.into_std()
}

/// On its own thread.
async fn serve(
    hub: &Hub,
    server: &Arc<Server>,
    listener: std::net::TcpListener,
    main: &Handle,
) -> Both {
    let sockets = async {
        let inner = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        Ok::<_, io::Error>((inner.local_addr()?, inner))
    };
    let (address, inner) = match sockets.await {
        Ok(sockets) => sockets,
        Err(error) => return said(&error),
    };
    let peers = Peers::default();
    let config = Arc::new(server.config.clone());
    let seats = Seats::new(hub, server, &peers, main);
    let space = Arc::default();
    let view = View::new(hub, &config, &space);
    let conditions = Conditions::new(hub, &config, &seats, &space);
    let login = Arc::new(Login::new(hub, server, main));
    let builder = builder(&server.config).with_authenticator(login);
    let built = with_nodes(builder, (&view, &seats, &conditions)).build();
    let (library, handle) = match built {
        Ok(built) => built,
        Err(error) => return text::OpcuaFailed { error: &error }.words(),
    };
    if handle.info().server_certificate.is_none() || handle.info().server_pkey.is_none() {
        return text::OpcuaNoCertificate.words();
    }
    let running = tokio::spawn(library.run_with(inner));
    // The library shows clients the port on which it listens itself: they connect to the front.
    let port = &handle.info().port;
    while port.load(Ordering::Relaxed) != address.port() {
        if running.is_finished() {
            return text::OpcuaEnded.words();
        }
        sleep(Duration::from_millis(1)).await;
    }
    port.store(server.config.listen.port(), Ordering::Relaxed);
    if server.counts.set_error(None) {
        let (name, url) = (&server.config.name, server.config.url());
        hub.event(None, &text::OpcuaListening { name, url: &url }.words());
    }
    let front = front::run(hub.clone(), server.clone(), peers, (listener, address));
    let mut front = Front(main.spawn(front));
    tokio::select! {
        ended = running => match ended {
            Ok(Err(error)) => text::OpcuaFailed { error: &error }.words(),
            _ => text::OpcuaEnded.words(),
        },
        ended = &mut front.0 => ended.unwrap_or_else(|_| text::OpcuaEnded.words()),
        () = look(&handle, &view, &conditions) => text::OpcuaEnded.words(),
        () = watch(hub, &seats) => text::OpcuaEnded.words(),
        () = prune(&server.config) => text::OpcuaEnded.words(),
    }
}

/// The front, on the hub's own threads. Dropped, it takes no connection any more.
struct Front(JoinHandle<Both>);

impl Drop for Front {
    fn drop(&mut self) {
        self.0.abort();
    }
}

async fn look(handle: &ServerHandle, view: &View, conditions: &Conditions) {
    let mut looks = interval(LOOK_EACH);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        looks.tick().await;
        view.look(handle.subscriptions());
        conditions.look(handle.subscriptions(), handle.type_tree());
    }
}

/// Sees to it that who has lost rights reads nothing more.
async fn watch(hub: &Hub, seats: &Seats) {
    let mut changes = hub.access_changes();
    while changes.changed().await.is_ok() {
        seats.end_others();
    }
    std::future::pending().await
}

async fn prune(config: &ServerConfig) {
    let mut looks = interval(PRUNE_EACH);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        looks.tick().await;
        if let Err(error) = folder::prune(&folder::rejected(config)) {
            tracing::warn!(server = config.name, %error, "rejected certificates are not removed");
        }
    }
}

fn with_nodes(
    builder: ServerBuilder,
    (view, seats, conditions): (&View, &Seats, &Conditions),
) -> ServerBuilder {
    let (view, seats, conditions) = (view.clone(), seats.clone(), conditions.clone());
    let own = conditions.clone();
    let base = move |context: ServerContext| Base::new(context, own);
    let nodes = move |context: ServerContext, nodes: &mut AddressSpace| {
        Nodes::new((context, nodes), (view, seats, conditions))
    };
    builder
        .without_node_managers()
        .with_node_manager(base)
        .with_node_manager(DiagnosticsNodeManagerBuilder)
        .with_node_manager(InMemoryNodeManagerBuilder::new(nodes))
}

fn builder(config: &ServerConfig) -> ServerBuilder {
    let uri = format!("urn:{}:lafet:{}", config.host, config.name);
    let mut builder = ServerBuilder::new()
        .application_name(format!("lafet {}", config.name))
        .application_uri(uri)
        .product_uri("urn:lafet")
        .build_info(BuildInfo {
            product_uri: "urn:lafet".into(),
            manufacturer_name: "lafet".into(),
            product_name: "lafet hub".into(),
            software_version: env!("CARGO_PKG_VERSION").into(),
            build_number: env!("CARGO_PKG_VERSION").into(),
            build_date: DateTime::null(),
        })
        .host(if config.host.contains(':') {
            format!("[{}]", config.host)
        } else {
            config.host.clone()
        })
        .port(config.listen.port())
        .discovery_urls(vec![config.url()])
        .pki_dir(config.folder.clone())
        .create_sample_keypair(config.own.is_none())
        .trust_client_certs(false)
        .check_cert_time(true)
        .hello_timeout(HELLO_S)
        .max_timeout_ms(REQUEST_MS)
        .max_session_timeout_ms(SESSION_MS)
        .max_secure_channel_token_lifetime_ms(CHANNEL_MS)
        .subscription_poll_interval_ms(TICK_MS)
        .diagnostics_enabled(false)
        .limits(limits(config));
    let (cert, key) = match &config.own {
        Some((cert, key)) => {
            // A relative one would be looked for in the folder of certificates.
            let absolute = |it: &PathBuf| std::path::absolute(it).unwrap_or_else(|_| it.clone());
            (absolute(cert), absolute(key))
        }
        None => ("own/cert.der".into(), "private/private.pem".into()),
    };
    builder = builder.certificate_path(cert).private_key_path(key);
    let users = [ANONYMOUS_USER_TOKEN_ID.to_owned()];
    for policy in POLICIES {
        let mode = MessageSecurityMode::SignAndEncrypt;
        let endpoint = ServerEndpoint::new("/", policy, mode, &users);
        builder = builder.add_endpoint(policy.to_string(), endpoint);
    }
    if config.plain {
        builder = builder.add_endpoint("None", ServerEndpoint::new_none("/", &users));
    }
    builder
}

/// All that a client may have of the hub's memory.
fn limits(config: &ServerConfig) -> Limits {
    Limits {
        max_array_length: ARRAY_MAX,
        max_string_length: STRING_MAX,
        max_byte_string_length: STRING_MAX,
        max_message_size: CHUNKS_MAX * front::CHUNK_MAX,
        max_chunk_count: CHUNKS_MAX,
        send_buffer_size: front::CHUNK_MAX,
        receive_buffer_size: front::CHUNK_MAX,
        subscriptions: SubscriptionLimits {
            max_subscriptions_per_session: SUBSCRIPTIONS_MAX,
            min_sampling_interval_ms: INTERVAL_MS,
            min_publishing_interval_ms: INTERVAL_MS,
            max_monitored_items_per_sub: ITEMS_MAX,
            max_monitored_item_queue_size: EVENTS_MAX,
            max_queued_notifications: NOTIFICATIONS_MAX,
            max_notifications_per_publish: PUBLISHED_MAX,
            ..SubscriptionLimits::default()
        },
        operational: OperationalLimits {
            max_nodes_per_read: AT_ONCE,
            max_nodes_per_write: 1,
            max_nodes_per_method_call: CALLS_MAX,
            max_nodes_per_browse: BROWSED_MAX,
            max_references_per_browse_node: REFERENCES_MAX,
            max_nodes_per_register_nodes: AT_ONCE,
            max_monitored_items_per_call: AT_ONCE,
            max_nodes_per_history_read_data: HISTORIES_MAX,
            max_nodes_per_history_read_events: 1,
            max_nodes_per_history_update: 1,
            max_nodes_per_node_management: 1,
            ..OperationalLimits::default()
        },
        max_browse_continuation_points: PLACES_MAX,
        max_history_continuation_points: PLACES_MAX,
        max_query_continuation_points: PLACES_MAX,
        max_sessions: config.sessions_max,
    }
}

const _: () = assert!(history::RETURNED_MAX <= ARRAY_MAX);

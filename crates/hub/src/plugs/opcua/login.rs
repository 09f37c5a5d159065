//! Who may log in: the users of the hub, with their passwords.

use std::sync::{Arc, Mutex};

use async_trait::async_trait;
use opcua::server::ServerEndpoint;
use opcua::server::authenticator::{
    AuthManager, Password, UserToken, user_pass_security_policy_id,
};
use opcua::types::{Error, StatusCode, UAString, UserTokenPolicy, UserTokenType};
use tokio::runtime::Handle;

use super::seats::Who;
use super::{Server, VIA};
use crate::access::{AccessError, Bucket, Kind, Place};
use crate::api::slowly;
use crate::hub::{Caller, Hub};
use crate::plugs::modbus::access::Level;
use crate::store::Act;
use crate::sync::lock;

/// Longest name, bytes.
const NAME_MAX: usize = 256;
/// The id of the policy without a user, as the library has it.
const ANONYMOUS: &str = "anonymous";

/// Logins that are looked at, at once and per second: the library decrypts a password before it is checked, and who
/// tries that very often could learn from it.
const TRIES: (f64, f64) = (32.0, 1.0);

/// The door of a server.
pub struct Login {
    hub: Hub,
    server: Arc<Server>,
    main: Handle,
    tries: Mutex<Bucket>,
}

impl Login {
    /// The door.
    pub fn new(hub: &Hub, server: &Arc<Server>, main: &Handle) -> Self {
        let tries = Mutex::new(Bucket::new(hub.now(), TRIES.0, TRIES.1));
        Self { hub: hub.clone(), server: server.clone(), main: main.clone(), tries }
    }
}

fn refused(why: &str) -> Error {
    Error::new(StatusCode::BadIdentityTokenRejected, why)
}

/// Checks a password, as slowly as over HTTP, and among the same tries. The library does not say from where: all
/// clients of a server are one place.
async fn log_in(
    hub: Hub,
    (place, role): (String, Level),
    user: String,
    password: String,
) -> Result<UserToken, ()> {
    if user.len() > NAME_MAX {
        return Err(());
    }
    let at = Place { address: place.clone(), device: false };
    let rank = hub.logins().begin(hub.now(), &user, &at).map_err(drop)?;
    let name = user.clone();
    let checked = slowly(&hub, rank, move |hub| {
        hub.access().check_password(&name, &password)?;
        let standing = hub.access().standing(&name);
        standing.filter(|_| role != Level::None).ok_or(AccessError::Wrong)
    });
    let checked = checked.await;
    let mut record = hub.record(&Caller::hub(), "", "login", "Ok").about(&Act::Login);
    (record.user, record.from, record.via) = (user.clone(), place, VIA.into());
    record.kind = Some(Kind::Opcua);
    record.role.clear();
    match checked {
        Ok((role, password)) => {
            hub.logins().succeeded(&user, &at);
            record.role = role.name().into();
            drop(hub.audit().note(record));
            Ok(Who::user(&user, &password))
        }
        Err(_) => {
            hub.counts().logins_failed.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            record.outcome = "login_failed".into();
            if hub.logins().failed(hub.now(), &user, &at) {
                drop(hub.audit().note(record));
            }
            Err(())
        }
    }
}

#[async_trait]
impl AuthManager for Login {
    async fn authenticate_anonymous_token(&self, _: &ServerEndpoint) -> Result<(), Error> {
        if self.server.config.anonymous == Level::None {
            return Err(refused("a user is needed"));
        }
        Ok(())
    }

    async fn authenticate_username_identity_token(
        &self,
        _: &ServerEndpoint,
        username: &str,
        password: &Password,
    ) -> Result<UserToken, Error> {
        let place = format!("opcua {}", self.server.config.name);
        let (user, password) = (username.to_owned(), password.get().to_owned());
        let at = (place, self.server.config.role);
        let logged_in = self.main.spawn(log_in(self.hub.clone(), at, user, password));
        match logged_in.await {
            Ok(Ok(token)) => Ok(token),
            _ => Err(refused("wrong user or password, or too many tries")),
        }
    }

    /// The library asks this when someone logs in, before it decrypts.
    fn supports_user_pass(&self, _: &ServerEndpoint) -> bool {
        lock(&self.tries).take(self.hub.now()).is_ok()
    }

    fn user_token_policies(&self, endpoint: &ServerEndpoint) -> Vec<UserTokenPolicy> {
        let policy = |policy_id: UAString, token_type| UserTokenPolicy {
            policy_id,
            token_type,
            issued_token_type: UAString::null(),
            issuer_endpoint_url: UAString::null(),
            security_policy_uri: UAString::null(),
        };
        let user = policy(user_pass_security_policy_id(endpoint), UserTokenType::UserName);
        let none = self.server.config.anonymous != Level::None;
        let none = none.then(|| policy(ANONYMOUS.into(), UserTokenType::Anonymous));
        none.into_iter().chain([user]).collect()
    }
}

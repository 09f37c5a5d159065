//! What a browser keeps of a login, and who waits because of whom.

use super::*;

/// Without it Stop would ask for a login, while the hub would still take it.
#[tokio::test]
async fn a_browser_keeps_the_cookie_for_as_long_as_it_serves_for_stop() {
    let site = Site::with(1, |_| {}).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let login = log_in(&site, "anna", PASSWORD).await;
    let cookie = login.header("set-cookie").unwrap();
    let age = cookie.split("; ").find_map(|it| it.strip_prefix("Max-Age=")).unwrap();
    // A session of a week, and a day of Stop.
    assert!(age.parse::<u64>().unwrap() > 8 * 24 * 3600, "{cookie}");
}

/// With IPv6 a client has 2⁶⁴ addresses to guess from.
#[tokio::test]
async fn a_network_of_64_bits_waits_as_one_client() {
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    site.hub.access().add(1, "anna", Role::Operator, PASSWORD).unwrap();
    let body = json!({ "user": "anna", "password": "wrong" }).to_string();
    let guess = async |address: &str| {
        site.http("POST", "/api/login", &[("X-Forwarded-For", address)], &body).await.status
    };
    assert_eq!(guess("2001:db8:0:7::1").await, 401);
    assert_eq!(guess("2001:db8:0:7:a:b:c:d").await, 429, "the same network");
    assert_eq!(guess("2001:db8:0:8::1").await, 401, "another one");
    let log = site.hub.audit().latest(None, 10, None, None).await.unwrap();
    let from = log.iter().filter(|it| it.record.outcome == "login_failed");
    let from: Vec<&str> = from.map(|it| it.record.from.as_str()).collect();
    assert_eq!(from, ["2001:db8:0:8::1", "2001:db8:0:7::1"], "whole addresses are noted");
}

/// They have no link, and guess at the name that the administrator is going to have.
#[tokio::test]
async fn strangers_do_not_hold_back_the_first_setup() {
    let site = Site::with(1, |config| config.proxies = vec!["127.0.0.1".parse().unwrap()]).await;
    let link = site.hub.access().setup_link().unwrap().unwrap();
    let body = |token: &str, password: &str| {
        json!({ "token": token, "user": "root", "password": password }).to_string()
    };
    let post = async |path: &str, body: &str, from: &str| {
        site.http("POST", path, &[("X-Forwarded-For", from)], body).await
    };
    let (mut set_up, mut logins) = (Vec::new(), Vec::new());
    for n in 0..16 {
        let from = format!("6.6.6.{n}");
        set_up.push(post("/api/setup", &body("0", PASSWORD), &from).await.status);
        logins.push(post("/api/login", &body("0", "wrong"), &from).await.status);
    }
    for statuses in [set_up, logins] {
        assert!(statuses.iter().all(|it| [401, 429].contains(it)), "{statuses:?}");
        assert!(statuses.contains(&401) && statuses.contains(&429), "{statuses:?}");
    }
    let weak = post("/api/setup", &body(&link, "short"), "6.6.6.1").await;
    assert_eq!((weak.status, weak.code()), (400, "bad_request"), "{weak:?}");
    let made = post("/api/setup", &body(&link, PASSWORD), "6.6.6.1").await;
    assert_eq!((made.status, &made.body["user"]), (200, &json!("root")), "{made:?}");
    assert!(made.headers.contains("lafet_device_0="), "{made:?}");
    let again = post("/api/setup", &body(&link, PASSWORD), "7.7.7.7").await;
    assert!([401, 429].contains(&again.status), "{again:?}");
}

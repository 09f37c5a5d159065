//! Images that are uploaded and removed.

use super::*;

async fn listed(site: &Site) -> usize {
    site.get("", "/api/updates").await.body["images"].as_array().unwrap().len()
}

async fn remove(site: &Site, digest: &str) -> Reply {
    site.http("DELETE", &format!("/api/updates/images/{digest}"), &[], "").await
}

#[tokio::test]
async fn an_image_is_stored_with_what_it_says_and_removed() {
    let data = std::env::temp_dir().join(format!("lafet-updates-{}", std::process::id()));
    _ = std::fs::remove_dir_all(&data);
    let own = data.clone();
    let site = with(1, |config| (config.login, config.data) = (false, Some(own))).await;
    let reply = send(&site, "", &made(NEW, SMALL, Some(Slot::B))).await;
    assert_eq!(reply.status, 201, "{reply:?}");
    let stored = &reply.body;
    assert_eq!((&stored["version"], &stored["board"]), (&json!("2.0.0.0"), &json!("bench")));
    assert_eq!((&stored["slot"], &stored["key"]), (&json!("b"), &json!(3)));
    assert_eq!((&stored["size"], &stored["by"]), (&json!(SMALL), &json!("demo")));
    assert!(stored["at_ms"].as_u64() > Some(0));
    assert_eq!(site.get("", "/api/updates").await.body["images"], json!([stored]));
    let files = || std::fs::read_dir(data.join("updates/images")).unwrap().count();
    assert_eq!(files(), 2);
    let digest = stored["digest"].as_str().unwrap();
    assert_eq!(remove(&site, digest).await.status, 204);
    assert_eq!((remove(&site, digest).await.status, files()), (404, 0));
    for odd in ["..", "%2e%2e%2fhub.db", "x"] {
        assert_eq!(remove(&site, odd).await.status, 404, "{odd}");
    }
    let log = acts(&site).await;
    for kind in ["store_image", "remove_image"] {
        assert_eq!(log.iter().filter(|it| it.0 == kind).count(), 1, "{log:?}");
    }
    drop(site);
    _ = std::fs::remove_dir_all(&data);
}

#[tokio::test]
async fn what_is_no_image_is_not_stored() {
    let site = open(1).await;
    let good = image(NEW, SMALL);
    let mut flipped = good.clone();
    flipped[1000] ^= 1;
    let large = vec![0; (16 << 20) + 1];
    for (bytes, status, code) in [
        (&b""[..], 400, "bad_request"),
        (b"\x7fELF", 400, "bad_request"),
        (&good[..100], 400, "bad_request"),
        (&good[..good.len() - 8], 400, "bad_request"),
        (&flipped, 400, "bad_request"),
        (&large, 413, "too_large"),
    ] {
        let reply = send(&site, "", bytes).await;
        assert_eq!(
            (reply.status, reply.code()),
            (status, code),
            "{} bytes: {reply:?}",
            bytes.len()
        );
        assert!(reply.body["error"]["ru"].is_string());
    }
    assert_eq!(listed(&site).await, 0);
}

#[tokio::test]
async fn there_are_eight_and_one_of_a_payload() {
    let site = open(1).await;
    for number in 1..=8 {
        store(&site, &image([number, 0, 0, 0], SMALL)).await;
    }
    let ninth = send(&site, "", &image([9, 0, 0, 0], SMALL)).await;
    assert_eq!((ninth.status, ninth.code()), (409, "images_full"), "{ninth:?}");
    // One that is there is there.
    assert_eq!(send(&site, "", &image([8, 0, 0, 0], SMALL)).await.status, 200);
    // The same program, signed for another board.
    let bytes = image([8, 0, 0, 0], SMALL);
    let header = Header {
        board: BoardName::new("other").unwrap(),
        ..Header::parse(bytes.first_chunk().unwrap()).unwrap()
    };
    let payload = &bytes[160..];
    let other = [maker().sign(&header, payload).unwrap().as_slice(), payload].concat();
    let differs = send(&site, "", &other).await;
    assert_eq!((differs.status, differs.code()), (409, "image_differs"), "{differs:?}");
    assert_eq!(listed(&site).await, 8);
}

/// The network fails in the middle of a file, the sender's rights end, or it never ends.
#[tokio::test]
async fn an_upload_that_is_cut_off_leaves_nothing() {
    let site = with(1, |_| {}).await;
    let engineer = site.token(Role::Engineer);
    let file = image(NEW, LARGE);
    let head = |token: &str| {
        format!(
            "POST /api/updates/images HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
             Authorization: Bearer {token}\r\nContent-Length: {}\r\n\r\n",
            file.len()
        )
    };
    let half = async |token: &str| {
        let mut stream = TcpStream::connect(site.address).await.unwrap();
        stream.write_all(head(token).as_bytes()).await.unwrap();
        stream.write_all(&file[..file.len() / 2]).await.unwrap();
        let began = Instant::now();
        while send(&site, &engineer, b"no image").await.code() != "slow_down" {
            assert!(began.elapsed() < Duration::from_secs(30), "it has no turn");
        }
        stream
    };
    drop(half(&engineer).await);
    let began = Instant::now();
    while send(&site, &engineer, b"no image").await.code() != "bad_request" {
        assert!(began.elapsed() < Duration::from_secs(30), "it keeps its turn");
    }
    let (id, late) = site.hub.access().add_token(1, "late", Role::Engineer).unwrap();
    let mut stream = half(&late).await;
    site.hub.access().remove_token(id).unwrap();
    stream.write_all(&file[file.len() / 2..]).await.unwrap();
    let mut answer = String::new();
    _ = stream.read_to_string(&mut answer).await;
    assert!(answer.starts_with("HTTP/1.1 401 "), "{answer}");
    let images = site.get(&engineer, "/api/updates").await.body["images"].clone();
    assert_eq!(images, json!([]));
    assert_eq!(send(&site, &engineer, &file).await.status, 201);
}

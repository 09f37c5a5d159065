//! The console: files that were built into the program.

use std::collections::HashMap;
use std::sync::LazyLock;

use axum::body::Bytes;
use axum::http::{HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{Html, IntoResponse, Response};
use include_dir::{Dir, include_dir};
use lafet_texts::{Lang, hub as text};

use super::packed::Lasting;

/// Texts are packed, and end with [`PACKED`] (build.rs).
static CONSOLE: Dir<'_> = include_dir!("$LAFET_CONSOLE");
/// How the names of packed files end.
const PACKED: &str = ".gz";

/// What is shown when the console was not built in.
static MISSING: LazyLock<String> = LazyLock::new(|| {
    let text = |lang: Lang| {
        let (code, what) = (lang.code(), text::ConsoleNotBuilt.str(lang));
        let remedy = text::ConsoleNotBuiltRemedy.str(lang);
        format!("<h1 lang=\"{code}\">{what}</h1>\n<p lang=\"{code}\">{remedy}</p>\n")
    };
    include_str!("no_console.html").replace("<!-- texts -->\n", &Lang::ALL.map(text).concat())
});

/// The files by their paths.
static FILES: LazyLock<HashMap<&str, Lasting>> = LazyLock::new(|| {
    let mut files = HashMap::new();
    let mut folders = vec![&CONSOLE];
    while let Some(folder) = folders.pop() {
        folders.extend(folder.dirs());
        let named = folder.files().filter_map(|file| Some((file.path().to_str()?, file)));
        files.extend(named.map(|(path, file)| {
            let bytes = Bytes::from_static(file.contents());
            match path.strip_suffix(PACKED) {
                Some(path) => (path, Lasting::of_packed(bytes)),
                None => (path, Lasting::new(bytes)),
            }
        }));
    }
    files
});

/// A file of the console; of what is none, its first page, which knows its own addresses.
pub async fn serve(method: Method, uri: Uri) -> Response {
    let path = uri.path().trim_start_matches('/');
    if path.starts_with("api/") || path == "api" || !matches!(method, Method::GET | Method::HEAD) {
        return super::nothing();
    }
    if let Some(file) = FILES.get(path) {
        return answer(path, file);
    }
    let name = path.rsplit('/').next().unwrap_or_default();
    if name.contains('.') {
        return super::nothing();
    }
    match FILES.get("index.html") {
        Some(page) => answer("index.html", page),
        None => (StatusCode::OK, Html(MISSING.as_str())).into_response(),
    }
}

fn answer(path: &str, file: &Lasting) -> Response {
    // Names in assets/ hold a hash of their content.
    let cache =
        if path.starts_with("assets/") { "max-age=31536000, immutable" } else { "no-cache" };
    let mut response = file.answer(kind(path));
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static(cache));
    response
}

fn kind(path: &str) -> &'static str {
    match path.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" | "webmanifest" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "glb" => "model/gltf-binary",
        "wasm" => "application/wasm",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

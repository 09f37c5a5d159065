//! The console: files that were built into the program.

use axum::http::{Method, StatusCode, Uri, header};
use axum::response::{Html, IntoResponse, Response};
use include_dir::{Dir, include_dir};

static CONSOLE: Dir<'_> = include_dir!("$LAFET_CONSOLE");

/// What is shown when the console was not built in.
const MISSING: &str = include_str!("no_console.html");

/// A file of the console; of what is none, its first page, which knows its own addresses.
pub async fn serve(method: Method, uri: Uri) -> Response {
    let path = uri.path().trim_start_matches('/');
    if path.starts_with("api/") || path == "api" || !matches!(method, Method::GET | Method::HEAD) {
        return super::nothing();
    }
    if let Some(file) = CONSOLE.get_file(path) {
        // Names in assets/ hold a hash of their content.
        let cache =
            if path.starts_with("assets/") { "max-age=31536000, immutable" } else { "no-cache" };
        let headers = [(header::CONTENT_TYPE, kind(path)), (header::CACHE_CONTROL, cache)];
        return (headers, file.contents()).into_response();
    }
    let name = path.rsplit('/').next().unwrap_or_default();
    if name.contains('.') {
        return super::nothing();
    }
    match CONSOLE.get_file("index.html") {
        Some(page) => {
            let headers =
                [(header::CONTENT_TYPE, kind("index.html")), (header::CACHE_CONTROL, "no-cache")];
            (headers, page.contents()).into_response()
        }
        None => (StatusCode::OK, Html(MISSING)).into_response(),
    }
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

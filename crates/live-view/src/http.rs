//! What is served where: the page's files, and the connection of a page. Who may ask is `guard.rs`.

use crate::assets;
use crate::connections::Peer;
use crate::guard::{Refusal, admit};
use crate::page::live;
use crate::shared::Shared;
use axum::Router;
use axum::extract::connect_info::IntoMakeServiceWithConnectInfo;
use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::sync::Arc;

/// All that is served.
pub fn router(shared: Arc<Shared>) -> IntoMakeServiceWithConnectInfo<Router, Peer> {
    let guard = middleware::from_fn_with_state(Arc::clone(&shared), guarded);
    Router::new()
        .route("/live", get(live))
        .fallback(get(asset))
        .layer(guard)
        .with_state(shared)
        .into_make_service_with_connect_info()
}

/// Lets requests in, or not, and says to browsers what the page may do: nothing beyond this server.
async fn guarded(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = match admit(request.headers(), shared.port()) {
        Ok(()) => next.run(request).await,
        Err(refusal) => {
            tracing::warn!(?refusal, "a request for the page is refused");
            shared.refuse(|refused| match refusal {
                Refusal::Host => refused.host += 1,
                Refusal::Origin => refused.origin += 1,
            });
            (StatusCode::FORBIDDEN, "refused: this page is for its own address only\n").into_response()
        }
    };
    const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
                          connect-src 'self' ws:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    let headers = response.headers_mut();
    let mut set = |name: HeaderName, value| headers.insert(name, HeaderValue::from_static(value));
    set(header::CONTENT_SECURITY_POLICY, POLICY);
    set(header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    set(header::REFERRER_POLICY, "no-referrer");
    set(header::CACHE_CONTROL, "no-store");
    set(HeaderName::from_static("cross-origin-resource-policy"), "same-origin");
    response
}

async fn asset(uri: Uri) -> Response {
    match assets::find(uri.path()) {
        Some(asset) => ([(header::CONTENT_TYPE, asset.content_type)], asset.bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is nothing here\n").into_response(),
    }
}

//! Zones: their state, reports of detectors, orders of people.

use axum::Json;
use axum::extract::State;
use lafet_site::config::Kind;
use lafet_site::{Bypass, Condition, Hand, Mode, Scope, Signal};
use lafet_texts::{Text as _, hub as text};
use serde::Deserialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::guard::{Body, InTime, Lenient, Path, Sent, Urgent};
use crate::access::{Role, Standing};
use crate::error::ApiError;
use crate::field::view::ModbusView;
use crate::hub::{Caller, Hub};
use crate::zones::view::{Reported, WindReported, ZonesConfigured, ZonesView};

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new()
        .routes(routes!(zones))
        .routes(routes!(modbus))
        .routes(routes!(configured))
        .routes(routes!(report_detector))
        .routes(routes!(report_wind))
        .routes(routes!(bypass_detector))
        .routes(routes!(hold_zone))
        .routes(routes!(abort_zone))
        .routes(routes!(release_zone))
        .routes(routes!(set_zone_mode))
        .routes(routes!(reset_zone))
        .routes(routes!(reset_zones))
        .routes(routes!(silence_zones))
        .routes(routes!(run_pump))
        .routes(routes!(lock_zones))
        .routes(routes!(unlock_zones))
}

/// What a detector sees now.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct DetectorReport {
    /// What it sees.
    signal: Signal,
    /// Whether it can see; left out: it can.
    #[serde(default)]
    condition: Condition,
    /// What it senses: has to be as configured, if it is given.
    kind: Option<Kind>,
    /// Bearing of what it sees, degrees clockwise from north, 0 to 360.
    bearing_deg: Option<f64>,
    /// Elevation of what it sees, degrees, −90 to 90.
    elevation_deg: Option<f64>,
    /// How sure it is, 0 to 1.
    quality: Option<f64>,
}

/// The wind of the site now.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct WindReport {
    /// Bearing that it blows from, degrees clockwise from north, 0 to 360.
    from_deg: f64,
    /// Speed 10 m above the ground, m/s, 0 to 40.
    speed_mps: f64,
}

/// Whether a detector is masked or disabled.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct DetectorBypassing {
    /// What is withheld from it.
    bypass: Bypass,
}

/// Holds the delay before a release.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ZoneHold {
    /// Hold; it has to be repeated every few seconds, and ends 10 s after the last time.
    on: bool,
}

/// Releases a zone.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ZoneRelease {
    /// The zone's id once more.
    confirm: Option<String>,
}

/// Another mode of a zone.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ZoneModeChange {
    /// The mode.
    mode: Mode,
    /// It returns to automatic after so long, s; left out: as configured, a test after 900 s.
    for_s: Option<u32>,
}

/// Starts or stops a pump by hand.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct PumpByHand {
    /// It runs, or it does not, until a reset of all zones.
    on: bool,
}

/// The zones as they are.
#[utoipa::path(get, path = "/api/zones",
    responses((status = 200, body = ZonesView), (status = 401), (status = 404)))]
async fn zones(State(hub): State<Hub>, _: Caller) -> Result<Json<ZonesView>, ApiError> {
    let _turn = hub.turn_at_zones().await;
    Ok(Json(hub.zones_view()?))
}

/// The buses of detectors: their lines, what fails on them, and how each detector is read.
#[utoipa::path(get, path = "/api/modbus", responses((status = 200, body = ModbusView), (status = 401)))]
async fn modbus(State(hub): State<Hub>, _: Caller) -> Json<ModbusView> {
    Json(hub.modbus_view())
}

/// What belongs to each zone.
#[utoipa::path(get, path = "/api/zones/configured",
    responses((status = 200, body = ZonesConfigured), (status = 401), (status = 404)))]
async fn configured(State(hub): State<Hub>, _: Caller) -> Result<Json<ZonesConfigured>, ApiError> {
    Ok(Json(hub.zones_configured()?))
}

/// Takes what a detector sees now.
#[utoipa::path(post, path = "/api/detectors/{id}", params(("id" = String, Path)), request_body = DetectorReport,
    responses((status = 204), (status = 400), (status = 401), (status = 403), (status = 404), (status = 409)))]
async fn report_detector(
    State(hub): State<Hub>,
    caller: Caller,
    Path(id): Path<String>,
    Body(report): Body<DetectorReport>,
) -> Result<axum::http::StatusCode, ApiError> {
    at_least(&caller, Role::Operator)?;
    let kind = hub.detector_kind(&id)?;
    if let Some(bus) = hub.field().bus_of(&id) {
        return Err(ApiError::detector_on_bus(&id, bus));
    }
    report.check(kind)?;
    let DetectorReport { signal, condition, bearing_deg, elevation_deg, quality, .. } = report;
    let (at_ms, by) = (hub.clock().now_ms(), caller.principal.user.clone());
    let heard = hub.now();
    let reported =
        Reported { heard, at_ms, by, signal, condition, bearing_deg, elevation_deg, quality };
    let _turn = hub.turn_at_zones().await;
    hub.detector_reports(&caller, &id, reported)?;
    Ok(axum::http::StatusCode::NO_CONTENT)
}

impl DetectorReport {
    fn check(&self, kind: Kind) -> Result<(), ApiError> {
        if self.kind.is_some_and(|given| given != kind) {
            return Err(ApiError::bad_request(text::DetectorKindDiffers.words()));
        }
        let within = |value: Option<f64>, least: f64, most: f64| {
            value.is_none_or(|value| (least..=most).contains(&value))
        };
        let fine = within(self.bearing_deg, 0.0, 360.0)
            && within(self.elevation_deg, -90.0, 90.0)
            && within(self.quality, 0.0, 1.0);
        match fine {
            true => Ok(()),
            false => Err(ApiError::bad_request(text::DetectorPlaceRange.words())),
        }
    }
}

/// Takes the wind of the site: monitors are assigned to fires by what they reach in it.
#[utoipa::path(post, path = "/api/wind", request_body = WindReport,
    responses((status = 204), (status = 400), (status = 401), (status = 403), (status = 404)))]
async fn report_wind(
    State(hub): State<Hub>,
    caller: Caller,
    Body(WindReport { from_deg, speed_mps }): Body<WindReport>,
) -> Result<axum::http::StatusCode, ApiError> {
    at_least(&caller, Role::Operator)?;
    if !(0.0..=360.0).contains(&from_deg) || !(0.0..=40.0).contains(&speed_mps) {
        return Err(ApiError::bad_request(text::WindRange.words()));
    }
    let (at_ms, by) = (hub.clock().now_ms(), caller.principal.user.clone());
    let wind = WindReported { heard: hub.now(), at_ms, by, from_deg, speed_mps };
    let _turn = hub.turn_at_zones().await;
    hub.wind_reports(wind)?;
    Ok(axum::http::StatusCode::NO_CONTENT)
}

/// Masks or disables a detector, or ends that.
#[utoipa::path(post, path = "/api/detectors/{id}/bypass", params(("id" = String, Path), Sent),
    request_body = DetectorBypassing, responses((status = 200, body = ZonesView), (status = 400), (status = 401),
    (status = 403), (status = 404), (status = 409)))]
async fn bypass_detector(
    State(hub): State<Hub>,
    from: InTime,
    Path(detector): Path<String>,
    Body(DetectorBypassing { bypass }): Body<DetectorBypassing>,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Engineer)?;
    ordered_in_time(&hub, &from, Hand::Bypass { detector, bypass }).await
}

/// Holds the delay before a release, or lets it go on.
#[utoipa::path(post, path = "/api/zones/{id}/hold", params(("id" = String, Path), Sent), request_body = ZoneHold,
    responses((status = 200, body = ZonesView), (status = 400), (status = 401), (status = 403), (status = 404),
    (status = 409)))]
async fn hold_zone(
    State(hub): State<Hub>,
    from: InTime,
    Path(zone): Path<String>,
    Body(ZoneHold { on }): Body<ZoneHold>,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Operator)?;
    ordered_in_time(&hub, &from, Hand::Hold { zone, on }).await
}

/// Ends countdown and water of a zone. Open to every role.
#[utoipa::path(post, path = "/api/zones/{id}/abort", params(("id" = String, Path)),
    request_body = Option<Object>, responses((status = 200, body = ZonesView), (status = 401), (status = 404),
    (status = 409)))]
async fn abort_zone(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
    Path(zone): Path<String>,
    _: Lenient,
) -> Result<Json<ZonesView>, ApiError> {
    not_ended(&caller)?;
    ordered(&hub, &caller, Hand::Abort { zone }).await
}

/// Releases a zone by hand: no votes are needed.
#[utoipa::path(post, path = "/api/zones/{id}/release", params(("id" = String, Path), Sent),
    request_body = ZoneRelease, responses((status = 200, body = ZonesView), (status = 400), (status = 401),
    (status = 403), (status = 404), (status = 409)))]
async fn release_zone(
    State(hub): State<Hub>,
    from: InTime,
    Path(zone): Path<String>,
    Body(ZoneRelease { confirm }): Body<ZoneRelease>,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Operator)?;
    hub.known_zones()?;
    if confirm.as_deref() != Some(&zone) {
        return Err(ApiError::confirm_needed(&zone));
    }
    ordered_in_time(&hub, &from, Hand::Release { zone }).await
}

/// Sets the mode of a zone.
#[utoipa::path(post, path = "/api/zones/{id}/mode", params(("id" = String, Path), Sent),
    request_body = ZoneModeChange, responses((status = 200, body = ZonesView), (status = 400), (status = 401),
    (status = 403), (status = 404), (status = 409)))]
async fn set_zone_mode(
    State(hub): State<Hub>,
    from: InTime,
    Path(zone): Path<String>,
    Body(ZoneModeChange { mode, for_s }): Body<ZoneModeChange>,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Engineer)?;
    ordered_in_time(&hub, &from, Hand::Mode { zone, mode, for_s }).await
}

/// Makes a zone that was ended, and its monitors that were stopped, ready again.
#[utoipa::path(post, path = "/api/zones/{id}/reset", params(("id" = String, Path), Sent),
    responses((status = 200, body = ZonesView), (status = 400), (status = 401), (status = 403), (status = 404), (status = 409)))]
async fn reset_zone(
    State(hub): State<Hub>,
    from: InTime,
    Path(zone): Path<String>,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Operator)?;
    ordered_in_time(&hub, &from, Hand::Reset(Scope::Zone(zone))).await
}

/// Makes all zones and monitors ready again, and forgets troubles that are over.
#[utoipa::path(post, path = "/api/zones/reset", params(Sent),
    responses((status = 200, body = ZonesView), (status = 400), (status = 401), (status = 403), (status = 404), (status = 409)))]
async fn reset_zones(State(hub): State<Hub>, from: InTime) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Operator)?;
    ordered_in_time(&hub, &from, Hand::Reset(Scope::Site)).await
}

/// Silences the sounders until something new. A countdown and a hold go on sounding.
#[utoipa::path(post, path = "/api/zones/silence",
    responses((status = 200, body = ZonesView), (status = 401), (status = 403), (status = 404)))]
async fn silence_zones(
    State(hub): State<Hub>,
    caller: Caller,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&caller, Role::Operator)?;
    ordered(&hub, &caller, Hand::Silence).await
}

/// Starts or stops a pump by hand, whatever the water needs. A reset of all zones ends that.
#[utoipa::path(post, path = "/api/pumps/{id}", params(("id" = String, Path), Sent), request_body = PumpByHand,
    responses((status = 200, body = ZonesView), (status = 400), (status = 401), (status = 403), (status = 404),
    (status = 409)))]
async fn run_pump(
    State(hub): State<Hub>,
    from: InTime,
    Path(pump): Path<String>,
    Body(PumpByHand { on }): Body<PumpByHand>,
) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Operator)?;
    ordered_in_time(&hub, &from, Hand::Pump { pump, on }).await
}

/// Locks all zones: nothing of them opens. Open to every role.
#[utoipa::path(post, path = "/api/zones/lock", request_body = Option<Object>,
    responses((status = 200, body = ZonesView), (status = 401), (status = 404), (status = 409)))]
async fn lock_zones(
    State(hub): State<Hub>,
    Urgent(caller): Urgent,
    _: Lenient,
) -> Result<Json<ZonesView>, ApiError> {
    not_ended(&caller)?;
    ordered(&hub, &caller, Hand::Lockout { on: true }).await
}

/// Releases the lockout of the zones.
#[utoipa::path(post, path = "/api/zones/unlock", params(Sent),
    responses((status = 200, body = ZonesView), (status = 400), (status = 401), (status = 403), (status = 404), (status = 409)))]
async fn unlock_zones(State(hub): State<Hub>, from: InTime) -> Result<Json<ZonesView>, ApiError> {
    at_least(&from.caller, Role::Operator)?;
    ordered_in_time(&hub, &from, Hand::Lockout { on: false }).await
}

/// Carries an order out, and says whether it is on the disk.
async fn ordered(hub: &Hub, caller: &Caller, order: Hand) -> Result<Json<ZonesView>, ApiError> {
    let view = hub.order_zones_in_turn(caller, order).await?;
    let stored = hub.zones_are_stored().await;
    Ok(Json(ZonesView { stored, ..view }))
}

/// The same of an order that a no undoes which has come since it was sent.
async fn ordered_in_time(
    hub: &Hub,
    from: &InTime,
    order: Hand,
) -> Result<Json<ZonesView>, ApiError> {
    let sent = from.sent(hub)?;
    if sent.is_some_and(|sent| hub.known_zones().is_ok_and(|it| it.is_undone_since(&order, sent))) {
        return Err(ApiError::void());
    }
    ordered(hub, &from.caller, order).await
}

fn at_least(caller: &Caller, role: Role) -> Result<(), ApiError> {
    if caller.principal.role < role { Err(ApiError::role(role)) } else { Ok(()) }
}

/// Who was signed out by others does not shut the water of a fire.
fn not_ended(caller: &Caller) -> Result<(), ApiError> {
    match caller.principal.standing {
        Standing::Ended => Err(ApiError::ended()),
        Standing::Good | Standing::Expired => Ok(()),
    }
}

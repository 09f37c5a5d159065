//! The installation as it is configured: what `lafet site test` holds against its plan.

use axum::Json;
use axum::extract::State;
use lafet_site::config::{ContactKind, Kind, Mode, OutputKind};
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::config::ZonesConfig;
use crate::error::ApiError;
use crate::hub::{Caller, Hub};

pub fn routes() -> OpenApiRouter<Hub> {
    OpenApiRouter::new().routes(routes!(installation))
}

/// What belongs to the zones besides `/api/zones/configured`. It does not change while the hub runs.
#[derive(Debug, Serialize, ToSchema)]
struct Installation {
    /// Zones, in the configured order.
    zones: Vec<InstalledZone>,
    /// How each monitor aims at its zones.
    aims: Vec<InstalledAim>,
    /// Detectors.
    detectors: Vec<InstalledDetector>,
    /// Contacts.
    inputs: Vec<InstalledInput>,
    /// Zone valves, test outlets, sounders, lamps.
    outputs: Vec<InstalledOutput>,
    /// Pumps, in the order in which they start.
    pumps: Vec<InstalledPump>,
    /// Pumps run on for so long after the water, s.
    run_on_s: u32,
}

/// A zone.
#[derive(Debug, Serialize, ToSchema)]
struct InstalledZone {
    zone: String,
    /// Mode at the first start.
    mode: Mode,
    /// Votes with one failed detector, with two, …: `2oo2`, `alarm`.
    when_failed: Vec<String>,
    /// Monitors at once; null: all.
    #[schema(required)]
    jets: Option<u16>,
    /// A monitor that does not act for so long is replaced, s.
    act_within_s: u32,
    /// Automatic water ends without alarm for so long, s; null: it does not.
    #[schema(required)]
    quiet_ends_s: Option<u32>,
    /// Output of its valve.
    #[schema(required)]
    valve: Option<String>,
    /// Output of its test outlet.
    #[schema(required)]
    test_outlet: Option<String>,
    /// Its water needs the pumps.
    pumps: bool,
}

/// How a monitor aims at a zone.
#[derive(Debug, Serialize, ToSchema)]
struct InstalledAim {
    zone: String,
    monitor: String,
    /// Stored program, 0–7.
    program: i16,
    /// Centre, arc-minutes, positive to the left.
    horizontal: i16,
    /// Centre, arc-minutes, positive up.
    vertical: i16,
    /// Nozzle, mm.
    nozzle: i16,
    /// Valve of the water: `Valve1`, `Valve2`.
    valve: &'static str,
}

/// A detector.
#[derive(Debug, Serialize, ToSchema)]
struct InstalledDetector {
    detector: String,
    kind: Kind,
    zones: Vec<String>,
    /// Silent without a report for so long, s.
    silent_after_s: u32,
    /// It votes with a dirty window too.
    dirty_votes: bool,
    /// East, north and up, m; null: it gives no bearing that counts.
    #[schema(required, min_items = 3, max_items = 3)]
    at: Option<[f64; 3]>,
}

/// A contact.
#[derive(Debug, Serialize, ToSchema)]
struct InstalledInput {
    input: String,
    kind: ContactKind,
    /// Zones that it is for; none: all.
    zones: Vec<String>,
}

/// An output.
#[derive(Debug, Serialize, ToSchema)]
struct InstalledOutput {
    output: String,
    kind: OutputKind,
    /// The zone that it is for; null: the site.
    #[schema(required)]
    zone: Option<String>,
}

/// A pump.
#[derive(Debug, Serialize, ToSchema)]
struct InstalledPump {
    pump: String,
    /// It starts so long after the one before, s.
    start_delay_s: u32,
    /// Contact of its pressure.
    #[schema(required)]
    pressure: Option<String>,
    /// Without pressure for so long it has failed, s.
    start_timeout_s: u32,
    /// It starts in place of one that has failed.
    standby: bool,
}

/// The installation as it is configured.
#[utoipa::path(get, path = "/api/installation",
    responses((status = 200, body = Installation), (status = 401), (status = 404)))]
async fn installation(State(hub): State<Hub>, _: Caller) -> Result<Json<Installation>, ApiError> {
    let zones = hub.config().zones.as_ref().ok_or_else(ApiError::no_zones)?;
    Ok(Json(Installation::from(zones)))
}

impl From<&ZonesConfig> for Installation {
    fn from(config: &ZonesConfig) -> Self {
        let site = &config.site;
        let zones = site.zones.iter().map(|it| InstalledZone {
            zone: it.id.clone(),
            mode: it.mode,
            when_failed: it.when_failed.iter().copied().map(String::from).collect(),
            jets: it.jets,
            act_within_s: it.act_within_s,
            quiet_ends_s: it.quiet_ends_s,
            valve: it.valve.clone(),
            test_outlet: it.test_outlet.clone(),
            pumps: it.pumps,
        });
        let aims = config.aims.values().map(|it| InstalledAim {
            zone: it.zone.clone(),
            monitor: it.monitor.clone(),
            program: it.program,
            horizontal: it.horizontal,
            vertical: it.vertical,
            nozzle: it.nozzle,
            valve: it.outlet().name().unwrap_or_default(),
        });
        let detectors = site.detectors.iter().map(|it| InstalledDetector {
            detector: it.id.clone(),
            kind: it.kind,
            zones: it.zones.clone(),
            silent_after_s: it.silent_after_s,
            dirty_votes: it.dirty_votes,
            at: config.stations.get(&it.id).map(|station| station.at),
        });
        let inputs = site.contacts.iter().map(|it| InstalledInput {
            input: it.id.clone(),
            kind: it.kind,
            zones: it.zones.clone(),
        });
        let outputs = site.outputs.iter().map(|it| InstalledOutput {
            output: it.id.clone(),
            kind: it.kind,
            zone: it.zone.clone(),
        });
        let pumps = site.pumps.iter().map(|it| InstalledPump {
            pump: it.id.clone(),
            start_delay_s: it.start_delay_s,
            pressure: it.pressure.clone(),
            start_timeout_s: it.start_timeout_s,
            standby: it.standby,
        });
        Self {
            zones: zones.collect(),
            aims: aims.collect(),
            detectors: detectors.collect(),
            inputs: inputs.collect(),
            outputs: outputs.collect(),
            pumps: pumps.collect(),
            run_on_s: site.run_on_s,
        }
    }
}

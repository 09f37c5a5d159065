// What entries of the audit log are about. Made from the description of the API:
// LAFET_WRITE=1 cargo test -p lafet-hub --test page

export type Act = { request: string; to: string; type: "request" }
  | { drive: string; end?: JogEnding; toward: string; type: "jog" }
  | { action: string; reason?: string; type: "authority" }
  | { type: "login" }
  | { type: "change_own_password" }
  | { role: Role; type: "add_user"; user: string }
  | { password: boolean; role?: Role; type: "change_user"; user: string }
  | { type: "remove_user"; user: string }
  | { name: string; role: Role; type: "add_token" }
  | { id: number; type: "remove_token" }
  | { session: string; type: "end_session" }
  | { alarm: string; type: "acknowledge" }
  | { alarm: string; minutes: number; reason: string; type: "shelve" }
  | { alarm: string; type: "unshelve" }
  | { type: "export_audit" }
  | { recording: string; type: "start_recording" }
  | { recording: string; type: "remove_recording" }
  | { recording: string; type: "upload_recording" }
  | { scenario: string; seed?: number; type: "sim_scenario" }
  | { act: SimAct; type: "sim" }
  | { type: "end" }
  | { by_ms: number; type: "clock_step" } | (Loss & { type: "state_lost" })
  | { n: number; type: "chain_broken" };

export type Loss = StateFault & { file: StateFile };

export type StateFile = "hub" | "audit" | "events" | "history" | "site";

export type StateFault = { fault: "missing" }
  | { fault: "foreign" }
  | { fault: "older"; found: number; noted: number }
  | { fault: "changed"; n: number }
  | { fault: "emptied" };

export type SimAct = { automatic: boolean }
  | { pause: boolean }
  | { speed: number }
  | { fault: { fault: string; monitor: string; on: boolean } }
  | { fire: { at: number[]; kind: string; size: number } }
  | { ignite: string }
  | { link: { monitor: string; up: boolean } };

export type Role = "observer" | "operator" | "engineer" | "administrator";

export type JogEnding = { how: "stopped"; position: number; reason: string }
  | { how: "standing"; position: number }
  | { error: string; how: "refused" }
  | { how: "replaced" }
  | { by: string; how: "taken_over" }
  | { how: "still_moving"; position: number }
  | { error: string; how: "unknown" };

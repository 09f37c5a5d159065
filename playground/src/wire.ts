// Made of crates/play/src/view.rs: LAFET_WRITE=1 cargo test -p lafet-play wire

export type Words = { en: string; ru: string };
export type Link = "wired" | "radio";
export type Input = {
/**
 * Hexadecimal bytes, not the text form of requests.
 */
bytes: boolean, text: string, };
export type Act = { "kind": "send", link: Link, input: Input, } | { "kind": "race", first: Link, wired: Input, radio: Input, } | { "kind": "break", fault: string, } | { "kind": "repair", fault: string, } | { "kind": "light", azimuth: number, range: number, fuel: boolean, } | { "kind": "sweep", } | { "kind": "power", };
export type Command = { "op": "describe", } | { "op": "start", seed: number, profile: string, wind: [number, number], } | { "op": "open", fragment: string, } | { "op": "advance", ms: number, since: number, } | { "op": "read", input: Input, } | { "op": "act", act: Act, } | { "op": "share", };
export type Part = { at: number, len: number,
/**
 * Number of the record that it belongs to; none for what belongs to the link.
 */
record: number | null, name: string, value: Words, meaning: Words, flags: Array<Flag>, };
export type Flag = { name: string,
/**
 * info, notice, warning, alarm.
 */
severity: string, meaning: Words, remedy: Words, };
export type Anatomy = { bytes: Array<number>, parts: Array<Part>,
/**
 * Each record as text.
 */
text: Array<string>, };
export type Mark = "refused" | "answered" | "passed" | "unasked" | "absent";
export type Station = { name: string, title: Words, mark: Mark, addressed: boolean, };
export type Verdict = { from: string, status: string, success: boolean, meaning: Words, remedy: Words, };
export type Walk = { request: string, stations: Array<Station>,
/**
 * Where it ended, and why there.
 */
end: Words,
/**
 * Flags of the subsystem that refused, as they were then.
 */
because: Array<Flag>, verdicts: Array<Verdict>, };
export type Entry = { index: number, at_ms: number,
/**
 * Through which interface, if it is a frame.
 */
link: Link | null, title: Words, request: Anatomy | null, answer: Anatomy | null, walks: Array<Walk>,
/**
 * Why there is no answer.
 */
silence: Words | null, };
export type Value = { name: string, value: Words, meaning: Words,
/**
 * A flag says that it is not to be relied on.
 */
invalid: boolean, };
export type State = { name: string, title: Words, severity: string, values: Array<Value>, flags: Array<Flag>, };
export type Burning = {
/**
 * Metres forward and left.
 */
at: [number, number], size_m: number,
/**
 * 0 out … 1.
 */
heat: number, };
export type Water = {
/**
 * Distance on the ground and height, m.
 */
arc: Array<[number, number]>,
/**
 * Where it lands, metres forward and left, and the half-axes of the footprint.
 */
at: [number, number], along_m: number, across_m: number,
/**
 * Radians.
 */
heading: number, };
export type Scene = {
/**
 * Degrees; left and up are positive.
 */
azimuth: number, elevation: number, nozzle_mm: number,
/**
 * 0 stowed … 1 deployed.
 */
deployment: number, deployed: boolean,
/**
 * True speeds of elevation, traverse, nozzle, deployment: sign only.
 */
motion: [number, number, number, number],
/**
 * 0 closed … 1 open.
 */
valves: [number, number], pressure_atm: number, flow_lps: number,
/**
 * Of traverse and elevation, degrees: what RetrieveLimits answers.
 */
limits: [number, number, number, number] | null, height_m: number, water: Water | null, fires: Array<Burning>, wind: [number, number], };
export type View = { at_ms: number,
/**
 * Of everything that has happened.
 */
hash: string,
/**
 * Until when recorded actions are repeated, ms.
 */
replay_ms: number | null,
/**
 * The longest time of a session is over.
 */
over: boolean, profile: string, scene: Scene, states: Array<State>, faults: Array<string>, entries: Array<Entry>, count: number, };
export type RequestInfo = { name: string, section: string, title: Words, meaning: Words,
/**
 * None: every subsystem.
 */
addressees: Array<string>, };
export type SubsystemInfo = { name: string, title: Words, parameters: Array<string>, };
export type FaultInfo = { name: string, words: Words, };
export type ExampleInfo = { key: string, fragment: string, };
export type Description = { requests: Array<RequestInfo>, subsystems: Array<SubsystemInfo>, faults: Array<FaultInfo>, profiles: Array<string>, examples: Array<ExampleInfo>, };

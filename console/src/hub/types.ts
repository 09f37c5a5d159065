// The shapes of docs/hub-api.md.
import type { Act, Role } from './acts';

export type { Role } from './acts';
export type Drive = 'Vertical' | 'Horizontal' | 'Nozzle' | 'Deployer';
export type Valve = 'Valve1' | 'Valve2';
export type Toward = 'min' | 'max';
export type Severity = 'info' | 'notice' | 'warning' | 'alarm';
export type Priority = 'fire' | 'high' | 'medium' | 'low';

export interface Text {
  en: string;
  ru: string;
}

export interface Session {
  user: string;
  role: Role;
  kind: 'session' | 'token' | 'certificate' | 'demo';
  csrf: string;
  expires_ms: number;
  seat: string;
}

export interface SitePlace {
  at: [number, number];
  heading: number;
  height: number;
}

export interface Site {
  monitors: Record<string, SitePlace>;
  tanks: { name: string; at: [number, number]; diameter: number; height: number }[];
  walls: { name: string; from: [number, number]; to: [number, number]; height: number }[];
}

export interface Hub {
  name: string;
  version: string;
  api: number;
  demo: boolean;
  simulation: boolean;
  login: boolean;
  started_ms: number;
  now_ms: number;
  site: Site | null;
}

export interface Info {
  id: string;
  name: Text;
  address: number;
}

/**
 * What GetStatus reports of a subsystem; the other fields are those of the dictionary, in units of the wire. They are read
 * by hub/readings.ts, which knows whether a value may be computed with.
 */
export interface SubsystemStatus {
  bits: number;
  flags: string[];
  severity: Severity;
  /** Fields whose values are bad, with the flags that say so. */
  bad?: Record<string, string>;
  [field: string]: unknown;
}

export interface Status {
  at_ms: number | null;
  stale: boolean;
  error: Text | string | null;
  /** While Control is paused: when the program goes on (§3.1/3). Recordings do not have it. */
  resumes_ms?: number | null;
  subsystems: Record<string, SubsystemStatus>;
}

export interface LinkCounts {
  sent: number;
  received: number;
  errors: number;
  retries: number;
  timeouts: number;
  loss_permille: number;
}

export interface LinkState {
  state: 'up' | 'down';
}

/** Of a recording the state alone is known: `linkFigures`. */
export type Link = LinkState | LinkFigures;

export interface LinkFigures extends LinkState, LinkCounts {
  endpoint: string;
  since_ms: number;
  error: Text | string | null;
  poll_ms: number;
  late: number;
  strays: number;
  collisions: number;
  reconnects: number;
  rtt_ms: number | null;
  srtt_ms: number | null;
  last: LinkCounts;
}

export interface Person {
  user: string;
  role: Role;
  seat: string;
  from?: string;
  since_ms?: number;
}

export interface Authority {
  state: 'free' | 'held' | 'lost';
  holder: Person | null;
  request: (Person & { until_ms: number }) | null;
}

export interface Reason {
  code: 'link' | 'stale' | 'flag' | 'wrapped';
  subsystem: string | null;
  flag: string | null;
  severity: Severity;
  what: Text;
  remedy: Text;
}

export interface Readiness {
  ready: boolean;
  reasons: Reason[];
}

export interface Range {
  min: number;
  max: number;
}

export type Limits = Partial<Record<Drive, Range>>;

export interface Hotbed {
  x1: number;
  x2: number;
  y1: number;
  y2: number;
  brightness: number;
}

export interface Hotbeds {
  at_ms: number;
  list: Hotbed[];
}

export interface ParamValue {
  values?: number[];
  error?: Text;
}

export interface Params {
  at_ms: number | null;
  reading: boolean;
  progress: { done: number; total: number } | null;
  values: Record<string, Record<string, ParamValue>>;
}

/** What a monitor carries out by itself. */
export interface Program {
  /** Null: it was not begun through this hub. */
  request: string | null;
  by: string | null;
  since_ms: number;
}

export interface Monitor extends Info {
  status: Status;
  link: Link;
  authority: Authority;
  readiness: Readiness;
  limits: Limits | null;
  hotbeds: Hotbeds | null;
  params_at_ms: number | null;
}

export interface Alarm {
  id: string;
  monitor: string | null;
  subsystem: string;
  flag: string;
  priority: Priority;
  state: 'unack' | 'ack' | 'rtn_unack' | 'shelved';
  active: boolean;
  since_ms: number;
  returned_ms: number | null;
  count: number;
  ack: { user: string; at_ms: number } | null;
  shelved: { user: string; until_ms: number; reason: string } | null;
  what: Text;
  cause: Text;
  consequence: Text;
  remedy: Text;
}

export interface Fire {
  name: string;
  at: [number, number];
  size: number;
  base: number;
  burns: boolean;
  heat_kw: number;
  density: number;
}

export interface Scene {
  t_s: number;
  speed: number;
  wind: [number, number];
  ambient_c: number;
  fires: Fire[];
  jets: Record<string, { lps: number; lands: [number, number]; litres: number }>;
  splashes: { monitor: string; at: [number, number]; litres: number; foam: number }[];
}

export interface Answer {
  from: string;
  status: string;
  code: number;
  success: boolean;
  text: string;
  meaning: Text;
  remedy: Text;
  values: Record<string, unknown>;
}

export interface Result {
  ok: boolean;
  request: string;
  took_ms: number;
  audit: number | null;
  answers: Answer[];
  /** Of a parameter that was waited for. */
  saved?: 'stored' | 'unconfirmed' | 'write_failed';
}

export interface ApiError extends Text {
  code: string;
  [detail: string]: unknown;
}

export interface AuditEntry {
  n: number;
  at_ms: number;
  user: string;
  role: Role | null;
  from: string | null;
  via: 'ws' | 'http' | 'hub';
  seat: string | null;
  monitor: string | null;
  what: string;
  outcome: string;
  details: Record<string, unknown> | null;
  prev: string;
  hash: string;
  /** What it is about; absent in entries of earlier versions of the hub. */
  act?: Act & { v: number };
}

export type JogState = 'armed' | 'moving' | 'stopping' | 'ended';
export type JogEnd =
  | 'stopped'
  | 'standing'
  | 'refused'
  | 'replaced'
  | 'taken_over'
  | 'still_moving'
  | 'unbounded'
  | 'unknown';

/** Topics of the store. */
export type TopicOf<K extends string> = K extends 'hub'
  ? Hub
  : K extends 'scene'
    ? Scene
    : K extends `alarms/${string}`
      ? Alarm
      : K extends `monitors/${string}/info`
        ? Info
        : K extends `monitors/${string}/status`
          ? Status
          : K extends `monitors/${string}/link`
            ? Link
            : K extends `monitors/${string}/authority`
              ? Authority
              : K extends `monitors/${string}/readiness`
                ? Readiness
                : K extends `monitors/${string}/limits`
                  ? Limits | null
                  : K extends `monitors/${string}/hotbeds`
                    ? Hotbeds | null
                    : K extends `monitors/${string}/params`
                      ? Params
                      : K extends `monitors/${string}/params_progress`
                        ? Params['progress']
                        : K extends `monitors/${string}/program`
                          ? Program | null
                          : unknown;

export interface Hello {
  type: 'hello';
  now_ms: number;
  seat: string;
  resume: string;
  user: string;
  role: Role;
  kind: Session['kind'];
  hub: Hub;
  jog: { beat_ms: number; watchdog_ms: number };
}

export interface FrameSeen {
  type: 'frame';
  monitor: string;
  at_ms: number;
  direction: 'out' | 'in';
  verdict: string;
  dst: number;
  src: number;
  bytes: string;
  text: string;
}

export interface JogSeen {
  type: 'jog';
  monitor: string;
  drive: Drive;
  state: JogState;
  end: JogEnd | null;
  text: Text | null;
}

export interface AskedSeen {
  type: 'asked';
  monitor: string;
  by: Person;
  until_ms: number;
}

export interface LostSeen {
  type: 'authority_lost';
  monitor: string;
  how: 'forced' | 'granted' | 'expired';
  by: Person | null;
  reason: string | null;
}

export interface EventSeen {
  type: 'event';
  at_ms: number;
  monitor: string | null;
  what: Text;
}

/** What is known of a Stop, Close or Lockout before its answer. */
export interface ProgressSeen {
  type: 'progress';
  id: number | null;
  monitor: string;
  /** False: it is sent, and there is no answer yet. */
  answered: boolean;
  result?: Result;
  error?: ApiError;
}

/** Messages of the hub that are not topics. */
export interface Messages {
  hello: Hello;
  frame: FrameSeen;
  jog: JogSeen;
  asked: AskedSeen;
  authority_lost: LostSeen;
  authority_denied: { type: 'authority_denied'; monitor: string };
  authority_granted: { type: 'authority_granted'; monitor: string };
  event: EventSeen;
  progress: ProgressSeen;
  missed: { type: 'missed'; count: number };
}

// The types of the hub's API, under the pages' names. They come from its description (api.ts); added is only what the
// description does not contain: fields of the dictionary, recordings, the simulator.
import type * as api from './api';

import type { Act, Updates } from './api';

export type {
  Act,
  MonitorUpdate,
  Role,
  Session,
  Site,
  StartUpdate,
  StoredImage,
  UpdateRun,
  Updates,
} from './api';
export type Drive = 'Vertical' | 'Horizontal' | 'Nozzle' | 'Deployer';
export type Valve = 'Valve1' | 'Valve2';
export type Toward = 'min' | 'max';
export type Severity = api.Severity;
export type Priority = api.Priority;
export type Text = api.Both;
export type SitePlace = api.Place;
export type Hub = api.About;
export type Info = api.Info;

/**
 * What GetStatus reports of a subsystem; the other fields are those of the dictionary, in units of the wire. They are read
 * by hub/readings.ts, which says whether a value may be used for computing.
 */
export interface SubsystemStatus {
  bits: number;
  flags: string[];
  severity: Severity;
  /** Fields whose values are bad, with the flags that mark them. */
  bad?: Record<string, string>;
  [field: string]: unknown;
}

/** A subsystem that has a state, and the flags of it: as the hub's description has them. */
export type SubsystemName = keyof api.Subsystems;
export type FlagOf<S extends SubsystemName> = NonNullable<api.Subsystems[S]>['flags'][number];

/** Some flags of a subsystem. */
export type FlagSet = { [S in SubsystemName]: { subsystem: S; flags: readonly FlagOf<S>[] } }[SubsystemName];

export interface Status extends Omit<api.Status, 'subsystems' | 'resumes_ms'> {
  subsystems: Record<string, SubsystemStatus>;
  /** While Control is paused: when the program resumes (§3.1/3). Not in recordings. */
  resumes_ms?: number | null;
}

export type LinkCounts = api.Second;

export type LinkState = Pick<api.Link, 'state'>;

export type LinkFigures = api.Link;

/** A recording has only the state: `linkFigures`. */
export type Link = LinkState | LinkFigures;

export type Person = api.Seat & { since_ms?: number };
export type Authority = api.Control;
export type Reason = api.ReadinessReason;
export type Readiness = api.Readiness;
export type Range = api.Bounds;
export type Limits = Partial<Record<Drive, Range>>;
export type Hotbed = api.Spot;
export type Hotbeds = api.Hotbeds;

/** One of them. */
export interface ParamValue {
  values?: number[];
  error?: Text;
}

export interface Params extends Omit<api.Params, 'values'> {
  values: Record<string, Record<string, ParamValue>>;
}

/** What a monitor executes by itself. */
export type Program = api.Program;

/** A drive that is being tuned, or was. */
export type Tune = api.Tune;
export type TunePair = api.TunePair;

export interface Monitor extends Info {
  status: Status;
  link: Link;
  authority: Authority;
  readiness: Readiness;
  limits: Limits | null;
  hotbeds: Hotbeds | null;
  params_at_ms: number | null;
}

export type Alarm = api.Alarm;

export type Fire = api.SceneFire;
export type Scene = api.Scene;

export type Answer = api.Answered;
export type Result = api.Outcome;

export interface ApiError extends Text {
  code: string;
  [detail: string]: unknown;
}

export type AuditEntry = Omit<api.Entry, 'act'> & {
  /** The typed act; absent in entries of earlier versions of the hub. */
  act?: Act & { v: number };
};

export type JogState = api.MotionWord;
export type JogEnd = api.MotionEnd;

/** Topics of the store. */
export type TopicOf<K extends string> = K extends 'hub'
  ? Hub
  : K extends `cameras/${string}`
    ? api.CameraView
    : K extends 'scene'
      ? Scene
      : K extends 'updates'
        ? Updates
        : K extends 'zones'
          ? api.ZonesView
          : K extends 'zones/configured'
            ? api.ZonesConfigured
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
                                  : K extends `monitors/${string}/tune`
                                    ? Tune
                                    : K extends `monitors/${string}/urgent`
                                      ? api.UrgentCounts
                                      : unknown;

type Message = api.Message;
type Of<K extends Message['type']> = Extract<Message, { type: K }>;

export type Hello = Of<'hello'>;
export type FrameSeen = Of<'frame'>;
export type JogSeen = Of<'jog'>;
export type AskedSeen = Of<'asked'>;
export type LostSeen = Of<'authority_lost'>;
export type EventSeen = Of<'event'>;
/** The progress of a Stop, Close or Lockout before its answer. */
export type ProgressSeen = Of<'progress'>;

/** Messages of the hub that are not topics. */
export type Messages = { [K in Exclude<Message['type'], 'state' | 'change' | 'answer'>]: Of<K> };

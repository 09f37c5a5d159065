// GET /api/dictionary: names of subsystems, flags, parameters, requests and statuses.
import { http } from './http';
import type { Severity, Text } from './types';

export interface DictFlag {
  name: string;
  bit: number;
  shift: number;
  width: number;
  severity: Severity;
  meaning: Text;
  cause: Text;
  remedy: Text;
}

export interface DictField {
  name: string;
  type: string;
  text: Text;
  unit: Text;
}

export interface DictData {
  name: string;
  least: number;
  most: number | null;
  fields: DictField[];
  prefix: DictField[];
  repeated: DictField[];
}

export interface DictParam {
  name: string;
  subsystem: string;
  id: number;
  access: 'read-write' | 'read-only' | string;
  default: number;
  min: number;
  max: number;
  len: { min: number; max: number; step: number };
  elements: { min: number; max: number; unit: Text }[];
  unit: Text;
  quantity: string;
  effect: 'at-once' | 'after-restart';
  storage: 'stored' | 'volatile' | string;
  placement: 'local' | 'remote' | string;
  required: boolean;
  text: Text;
}

export interface DictSubsystem extends Text {
  name: string;
  id: number;
  flags: string | null;
  meaning: Text;
}

export interface DictRequest {
  name: string;
  id: number;
  section: string;
  origin: string;
  addressees: string[];
  title: Text;
  meaning: Text;
  data: DictData[];
}

export interface DictStatus {
  name: string;
  value: number;
  success: boolean;
  meaning: Text;
  remedy: Text;
}

export interface Dictionary {
  subsystems: DictSubsystem[];
  flags: Record<string, DictFlag[]>;
  params: DictParam[];
  requests: DictRequest[];
  statuses: DictStatus[];
  severities: Text[];
  button_states: { name: string; value: number; text: Text }[];
  answers: Record<string, DictData[] | Record<string, DictData[]>>;
  protocol: Record<string, unknown>;
}

let loaded: Promise<Dictionary> | null = null;
let known: Dictionary | null = null;

/** The dictionary, fetched once. */
export function dictionary(): Promise<Dictionary> {
  loaded ??= http.get<Dictionary>('/api/dictionary').then(
    (answer) => (known = answer),
    (error: unknown) => {
      loaded = null;
      throw error;
    },
  );
  return loaded;
}

/** The dictionary; null until it has been fetched. */
export function dictionaryNow(): Dictionary | null {
  return known;
}

export function subsystem(name: string): DictSubsystem | undefined {
  return known?.subsystems.find((s) => s.name === name);
}

/** A flag as a status names it: `Move`, `LeftButtonState=Pressed`. */
export function flag(subsystemName: string, flagName: string): DictFlag | undefined {
  const table = subsystem(subsystemName)?.flags;
  const bare = flagName.split('=')[0];
  return table ? known?.flags[table]?.find((f) => f.name === bare) : undefined;
}

export function param(subsystemName: string, name: string): DictParam | undefined {
  return known?.params.find((p) => p.subsystem === subsystemName && p.name === name);
}

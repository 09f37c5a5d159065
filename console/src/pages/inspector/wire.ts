// Frames as the dictionary reads them: records, their headers, their data field by field.
import type { DictData, DictField, DictFlag, Dictionary } from '../../hub/dictionary';
import type { Text } from '../../hub/types';

/** A record's header: request, device, status, data_size. */
export const HEADER = 4;

export interface WireField {
  name: string;
  text: Text | null;
  unit: Text | null;
  type: string;
  /** Position of its bytes in the frame. */
  from: number;
  to: number;
  value: number;
  /** Names of what the value means: flags that are set, a parameter, a status. */
  names: string[];
}

export interface WireRecord {
  from: number;
  to: number;
  request: number;
  requestName: string;
  device: number;
  deviceName: string;
  status: number;
  statusName: string;
  size: number;
  /** The layout that fits; null: none does. */
  layout: string | null;
  fields: WireField[];
  /** Bytes that are in no layout. */
  rest: { from: number; to: number } | null;
  /** Truncated. */
  broken: boolean;
}

const SIZES: Record<string, number> = { U8: 1, I8: 1, U16: 2, I16: 2, Key: 2, ParamId: 2, U32: 4, I32: 4, Flags: 4 };

export function bytesOf(hex: string): number[] {
  return hex
    .trim()
    .split(/\s+/)
    .filter(Boolean)
    .map((byte) => parseInt(byte, 16));
}

export function hexOf(value: number, digits = 2): string {
  return `0x${(value >>> 0).toString(16).padStart(digits, '0')}`;
}

/** The records of a frame. `out`: requests, otherwise answers. */
export function decode(bytes: number[], out: boolean, dict: Dictionary): WireRecord[] {
  const records: WireRecord[] = [];
  for (let at = 0; at < bytes.length; ) {
    const [request = 0, device = 0, status = 0, size = 0] = bytes.slice(at, at + HEADER);
    const end = Math.min(at + HEADER + size, bytes.length);
    const info = dict.requests.find((r) => r.id === request);
    const sub = dict.subsystems.find((s) => s.id === device);
    const record: WireRecord = {
      from: at,
      to: Math.max(end, Math.min(at + HEADER, bytes.length)),
      request,
      requestName: info?.name ?? hexOf(request),
      device,
      deviceName: sub?.name ?? hexOf(device),
      status,
      statusName: dict.statuses.find((s) => s.value === status)?.name ?? hexOf(status),
      size,
      layout: null,
      fields: [],
      rest: null,
      broken: at + HEADER + size > bytes.length,
    };
    if (!record.broken && size > 0) {
      const layouts = out ? (info?.data ?? []) : answerLayouts(dict, record.requestName, record.deviceName);
      explain(record, bytes, layouts, dict);
    }
    records.push(record);
    at = record.to;
  }
  return records;
}

function answerLayouts(dict: Dictionary, request: string, device: string): DictData[] {
  const known = dict.answers[request];
  if (!known) return [];
  return Array.isArray(known) ? known : (known[device] ?? []);
}

/** The first layout whose size and prefix fit. */
function explain(record: WireRecord, bytes: number[], layouts: DictData[], dict: Dictionary): void {
  const from = record.from + HEADER;
  for (const layout of layouts) {
    const prefix = layout.prefix as unknown as number[];
    if (prefix.some((byte, index) => bytes[from + index] !== byte)) continue;
    const fixed = sizeOf(layout.fields);
    const each = sizeOf(layout.repeated);
    const left = record.size - fixed;
    const times = each > 0 ? left / each : 0;
    if (left < 0 || !Number.isInteger(times) || (each === 0 && left !== 0)) continue;
    if (times < layout.least || (layout.most !== null && times > layout.most)) continue;
    record.layout = layout.name;
    let at = from;
    const take = (field: DictField, index: number | null) => {
      const read = readField(field, bytes, at, record.deviceName, dict);
      record.fields.push(index === null ? read : { ...read, name: `${read.name}[${index}]` });
      at = read.to;
    };
    for (const field of layout.fields) take(field, null);
    for (let index = 0; index < times; index += 1) {
      for (const field of layout.repeated) take(field, index);
    }
    return;
  }
  record.rest = { from, to: record.to };
}

function sizeOf(fields: DictField[]): number {
  return fields.reduce((sum, field) => sum + (SIZES[field.type] ?? 1), 0);
}

function readField(field: DictField, bytes: number[], at: number, device: string, dict: Dictionary): WireField {
  const size = SIZES[field.type] ?? 1;
  let value = 0;
  for (let index = size - 1; index >= 0; index -= 1) value = value * 256 + (bytes[at + index] ?? 0);
  if (field.type.startsWith('I') && value >= 2 ** (size * 8 - 1)) value -= 2 ** (size * 8);
  return {
    name: field.name,
    text: field.text,
    unit: field.unit,
    type: field.type,
    from: at,
    to: at + size,
    value,
    names: namesOf(field.type, value, device, dict),
  };
}

function namesOf(type: string, value: number, device: string, dict: Dictionary): string[] {
  if (type === 'Flags') {
    const table = dict.subsystems.find((s) => s.name === device)?.flags;
    return flagNames(value, (table && dict.flags[table]) || [], dict);
  }
  if (type === 'ParamId') {
    const param =
      dict.params.find((p) => p.id === value && p.subsystem === device) ?? dict.params.find((p) => p.id === value);
    return [param?.name ?? hexOf(value, 4)];
  }
  if (type === 'Key') {
    const keys = dict.protocol.keys as Record<string, number> | undefined;
    const name = Object.entries(keys ?? {}).find(([, key]) => key === value)?.[0];
    return [name ?? hexOf(value, 4)];
  }
  return [];
}

/** Flags that are set; of a field of several bits `Name=State`. */
export function flagNames(bits: number, flags: DictFlag[], dict: Dictionary): string[] {
  return flags.flatMap((flag) => {
    const value = Math.floor((bits >>> 0) / 2 ** flag.shift) % 2 ** flag.width;
    if (value === 0) return [];
    if (flag.width === 1) return [flag.name];
    const state = dict.button_states.find((s) => s.value === value)?.name ?? String(value);
    return [`${flag.name}=${state}`];
  });
}

/** A frame that only asks for the state, or its answer: the hub's poll. */
export function isPoll(bytes: number[], dict: Dictionary): boolean {
  const poll = dict.requests.find((r) => r.name === 'GetStatus')?.id;
  for (let at = 0; at < bytes.length; ) {
    if (bytes[at] !== poll) return false;
    at += HEADER + (bytes[at + 3] ?? 0);
  }
  return bytes.length > 0;
}

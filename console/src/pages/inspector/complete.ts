// Completing a request while it is written, from the dictionary. The text form is that of
// `lafet send`: name, addressee, data.
import type { Dictionary, DictParam, DictRequest } from '../../hub/dictionary';
import type { Role, Text } from '../../hub/types';

export interface Offer {
  /** The replacement of the word being typed. */
  insert: string;
  text: Text | null;
  /** A space may follow: more words are expected. */
  more: boolean;
}

export interface Completed {
  offers: Offer[];
  /** Where the word being typed starts. */
  from: number;
}

const WORDS: Record<string, string[]> = {
  Lockout: ['on', 'off'],
  SwitchLimits: ['on', 'off', 'reject'],
  StartQuench: ['program=', 'centre=', 'nozzle=', 'sector=', 'step=', 'distance=', 'corrections='],
  StartTrajectory: ['ballistics', 'repeat', 'stored=', 'point='],
  SetupCorrectionTable: ['first=', 'corrections='],
  GetLog: ['first=', 'count='],
};

/** The format of a request's data; shown where nothing can be completed. */
const SHAPES: Record<string, string> = {
  Move: '1200',
  SetParam: '-900',
  StartSeek: '-1800 1800 -300 900 analyse',
};

const MOST = 60;

export function requestOf(text: string, dict: Dictionary): DictRequest | undefined {
  const name = text.trim().split(/\s+/)[0]?.toLowerCase();
  return dict.requests.find((r) => r.name.toLowerCase() === name);
}

export function complete(
  text: string,
  caret: number,
  dict: Dictionary,
  has: (subsystem: string) => boolean,
): Completed {
  const before = text.slice(0, caret);
  const from = before.search(/\S*$/);
  const word = before.slice(from);
  const words = before.slice(0, from).trim().split(/\s+/).filter(Boolean);
  const offers = candidates(words, dict, has);
  return { offers: ranked(offers, word).slice(0, MOST), from };
}

function candidates(words: string[], dict: Dictionary, has: (subsystem: string) => boolean): Offer[] {
  if (words.length === 0) {
    return dict.requests
      .filter((r) => r.name !== 'AccessGranted')
      .map((r) => ({ insert: r.name, text: r.title, more: true }));
  }
  const request = requestOf(words[0]!, dict);
  if (!request) return [];
  if (words.length === 1) return addressees(request, dict, has);
  const to = words[1]!;
  if (request.name === 'GetParam' || request.name === 'SetParam') {
    return words.length === 2 ? params(request.name, to, dict) : values(words, dict);
  }
  const used = new Set(words.slice(2).map((word) => word.split('=')[0] + (word.includes('=') ? '=' : '')));
  const offered = (WORDS[request.name] ?? []).filter((w) => w === 'point=' || !used.has(w));
  const alone = ['Lockout', 'SwitchLimits'].includes(request.name) && words.length > 2;
  if (!alone && offered.length > 0) {
    return offered.map((insert) => ({ insert, text: fieldText(request, insert), more: !insert.endsWith('=') }));
  }
  const shape = SHAPES[request.name];
  return shape && words.length === 2 ? [{ insert: shape, text: fieldText(request, 'destination'), more: false }] : [];
}

function addressees(request: DictRequest, dict: Dictionary, has: (subsystem: string) => boolean): Offer[] {
  // A request without a list may go to any subsystem, one for a parameter to those that have parameters.
  const own = new Set(dict.params.map((p) => p.subsystem));
  const named = request.addressees.length > 0 ? new Set(request.addressees) : null;
  const asks = request.name === 'GetParam' || request.name === 'SetParam';
  const more = request.data.some((data) => data.name !== 'Empty' && data.name !== 'Key');
  return dict.subsystems
    .filter((s) => (named ? named.has(s.name) : asks ? own.has(s.name) : true))
    .filter((s) => s.flags === null || has(s.name))
    .map((s) => ({ insert: s.name, text: { en: s.en, ru: s.ru }, more: more || request.name === 'Lockout' }));
}

function params(request: string, to: string, dict: Dictionary): Offer[] {
  const writable = (p: DictParam) => request === 'GetParam' || p.access !== 'read-only';
  return dict.params
    .filter((p) => p.subsystem.toLowerCase() === to.toLowerCase() && writable(p))
    .map((p) => ({ insert: p.name, text: p.text, more: request === 'SetParam' }));
}

function values(words: string[], dict: Dictionary): Offer[] {
  const [request, to, name] = words;
  if (request?.toLowerCase() !== 'setparam' || words.length !== 3) return [];
  const param = dict.params.find((p) => p.subsystem === to && p.name === name);
  if (!param) return [];
  const { min, max, unit, default: usual } = param;
  const range = (l: 'en' | 'ru') => `${min} … ${max}${unit[l] ? ` ${unit[l]}` : ''}`;
  return [{ insert: String(usual), text: { en: range('en'), ru: range('ru') }, more: false }];
}

function fieldText(request: DictRequest, word: string): Text | null {
  const bare = word.replace(/=$/, '');
  for (const data of request.data) {
    for (const field of [...data.fields, ...data.repeated]) {
      if (field.name === bare || bare.startsWith(field.name) || field.name.startsWith(bare)) return field.text;
    }
  }
  return null;
}

/** Entries that start with the word first, then those that contain it; case-insensitively. */
function ranked(offers: Offer[], word: string): Offer[] {
  const wanted = word.toLowerCase();
  if (!wanted) return offers;
  const at = (offer: Offer) => offer.insert.toLowerCase().indexOf(wanted);
  return offers
    .filter((offer) => at(offer) >= 0 && offer.insert.toLowerCase() !== wanted)
    .sort((a, b) => Number(at(a) > 0) - Number(at(b) > 0));
}

export interface Needs {
  role: Role;
  authority: boolean;
  /** The monitor's id has to be typed. */
  confirm: boolean;
  /** It works during a lockout. */
  lockedOut: boolean;
}

const READS = new Set([
  'GetStatus',
  'GetParam',
  'RetrieveLimits',
  'GetHotbed',
  'GetCrashData',
  'GetNetworkStatus',
  'GetLog',
]);
const OPERATES = new Set(['Move', 'Open', 'Deploy', 'Wrap', 'StartSeek', 'StartQuench', 'StartTrajectory']);

/** What the hub requires for a request (docs/hub-api.md, Access), to show it before it is sent. */
export function needsOf(text: string, dict: Dictionary): Needs {
  const words = text.trim().split(/\s+/);
  const name = requestOf(text, dict)?.name ?? words[0] ?? '';
  const off = words.some((word) => word.toLowerCase() === 'off');
  if (READS.has(name)) return { role: 'observer', authority: false, confirm: false, lockedOut: true };
  if (name === 'Stop' || name === 'Close' || (name === 'Lockout' && !off)) {
    return { role: 'observer', authority: false, confirm: false, lockedOut: true };
  }
  if (name === 'Lockout') return { role: 'operator', authority: true, confirm: true, lockedOut: true };
  if (OPERATES.has(name)) return { role: 'operator', authority: true, confirm: false, lockedOut: false };
  if (name === 'CleanFlash') return { role: 'administrator', authority: true, confirm: true, lockedOut: false };
  return { role: 'engineer', authority: true, confirm: name === 'Restart', lockedOut: false };
}

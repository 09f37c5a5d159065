// Units of displayed values. On the wire angles are arc-minutes, pressure is 0.1 atm, flow l/s,
// the nozzle mm, currents 0.1 A, temperatures 0.1 °C.
import { lang, num } from './i18n';

export type Quantity =
  | 'angle'
  | 'pressure'
  | 'flow'
  | 'length'
  | 'nozzle'
  | 'current'
  | 'voltage'
  | 'temperature'
  | 'percent'
  | 'duration_ms'
  | 'speed_angle'
  | 'speed_nozzle'
  | 'heat'
  | 'litres';

interface Unit {
  en: string;
  ru: string;
  /** Shown = wire × factor. */
  factor: number;
  digits: number;
}

const ATM_MPA = 0.101325;

const UNITS = {
  angle: {
    deg: { en: '°', ru: '°', factor: 1 / 60, digits: 1 },
    mil: { en: 'mil', ru: 'д.у.', factor: 6000 / 21600, digits: 0 },
    arcmin: { en: '′', ru: '′', factor: 1, digits: 0 },
  },
  pressure: {
    mpa: { en: 'MPa', ru: 'МПа', factor: ATM_MPA / 10, digits: 2 },
    bar: { en: 'bar', ru: 'бар', factor: ATM_MPA, digits: 1 },
    psi: { en: 'psi', ru: 'psi', factor: 1.46959, digits: 0 },
    atm: { en: 'atm', ru: 'атм', factor: 0.1, digits: 1 },
  },
  flow: {
    lps: { en: 'l/s', ru: 'л/с', factor: 1, digits: 0 },
    m3h: { en: 'm³/h', ru: 'м³/ч', factor: 3.6, digits: 0 },
    gpm: { en: 'gpm', ru: 'гал/мин', factor: 15.8503, digits: 0 },
  },
  length: {
    m: { en: 'm', ru: 'м', factor: 1, digits: 1 },
    ft: { en: 'ft', ru: 'фут', factor: 3.28084, digits: 0 },
  },
  nozzle: { mm: { en: 'mm', ru: 'мм', factor: 1, digits: 0 } },
  current: { a: { en: 'A', ru: 'А', factor: 0.1, digits: 1 } },
  voltage: { v: { en: 'V', ru: 'В', factor: 1, digits: 0 } },
  temperature: { c: { en: '°C', ru: '°C', factor: 0.1, digits: 1 } },
  percent: { p: { en: '%', ru: '%', factor: 1, digits: 0 } },
  duration_ms: { ms: { en: 'ms', ru: 'мс', factor: 1, digits: 1 } },
  speed_angle: { dps: { en: '°/s', ru: '°/с', factor: 1, digits: 0 } },
  speed_nozzle: { mmps: { en: 'mm/s', ru: 'мм/с', factor: 1, digits: 0 } },
  heat: { kw: { en: 'kW', ru: 'кВт', factor: 1, digits: 0 } },
  litres: { l: { en: 'l', ru: 'л', factor: 1, digits: 0 } },
} satisfies Record<Quantity, Record<string, Unit>>;

export interface Measured {
  value: string;
  unit: string;
}

const KEY = 'lafet.units';
let chosen: Partial<Record<Quantity, string>> = read();

/** Called after a unit has changed. */
export const unitsChanged = new EventTarget();

/** The quantities with selectable units, and these units. */
export function choices(): { quantity: Quantity; units: { id: string; text: string }[] }[] {
  return (Object.keys(UNITS) as Quantity[])
    .map((quantity) => ({
      quantity,
      units: Object.entries<Unit>(UNITS[quantity]).map(([id, u]) => ({ id, text: u[lang()] })),
    }))
    .filter(({ units }) => units.length > 1);
}

export function chosenUnit(quantity: Quantity): string {
  const all: Record<string, Unit> = UNITS[quantity];
  const wanted = chosen[quantity];
  return wanted && wanted in all ? wanted : Object.keys(all)[0]!;
}

export function setUnit(quantity: Quantity, id: string): void {
  chosen = { ...chosen, [quantity]: id };
  globalThis.localStorage?.setItem(KEY, JSON.stringify(chosen));
  unitsChanged.dispatchEvent(new Event('change'));
}

/** `measured('angle', 754)` → {value: '12.6', unit: '°'}; null and undefined are a dash. */
export function measured(quantity: Quantity, wire: number | null | undefined): Measured {
  const unit = unitOf(quantity);
  if (wire === null || wire === undefined || !Number.isFinite(wire)) {
    return { value: '—', unit: unit[lang()] };
  }
  const shown = wire * unit.factor;
  // −0 would jump between "0.0" and "−0.0".
  const clean = Math.abs(shown) < 0.5 * 10 ** -unit.digits ? 0 : shown;
  return { value: num(clean, unit.digits), unit: unit[lang()] };
}

/** In one piece: 12.6°, 0.84 MPa. */
export function show(quantity: Quantity, wire: number | null | undefined): string {
  const { value, unit } = measured(quantity, wire);
  return inUnit(value, unit, '\u202f');
}

/** A text with its unit: 12.6°, 8 A. */
export function inUnit(text: string, unit: string, space = ' '): string {
  return unit === '' || /^[°′%]$/.test(unit) ? text + unit : text + space + unit;
}

/** From the shown unit to that of the wire, whole. */
export function toWire(quantity: Quantity, shown: number): number {
  return Math.round(shown / unitOf(quantity).factor);
}

export function fromWire(quantity: Quantity, wire: number): number {
  return wire * unitOf(quantity).factor;
}

export function unitText(quantity: Quantity): string {
  return unitOf(quantity)[lang()];
}

export function digitsOf(quantity: Quantity): number {
  return unitOf(quantity).digits;
}

/** Parses typed text, with a comma or a point; null if it is not a number. */
export function parse(quantity: Quantity, text: string): number | null {
  const clean = text.trim().replace(',', '.').replace('−', '-');
  if (clean === '' || !Number.isFinite(Number(clean))) return null;
  return toWire(quantity, Number(clean));
}

function unitOf(quantity: Quantity): Unit {
  return (UNITS[quantity] as Record<string, Unit>)[chosenUnit(quantity)]!;
}

function read(): Partial<Record<Quantity, string>> {
  try {
    return JSON.parse(globalThis.localStorage?.getItem(KEY) ?? '{}');
  } catch {
    return {};
  }
}

// The text of each request, put together from fields: the text is what counts, so that a user who fills in a form learns
// how to write it.
import type { Key } from './i18n';

export interface FormField {
  name: string;
  label: Key;
  /** A number within bounds, one of some words, or free text such as a list of numbers. */
  kind: 'number' | 'choice' | 'text' | 'parameter';
  initial: string;
  min?: number;
  max?: number;
  choices?: readonly string[];
}

export interface Form {
  fields: readonly FormField[];
  /** What follows name and addressee. */
  text(values: Record<string, string>): string;
}

const number = (name: string, label: Key, initial: number, min: number, max: number): FormField => ({
  name,
  label,
  kind: 'number',
  initial: String(initial),
  min,
  max,
});
const I16 = [-32768, 32767] as const;
const EMPTY: Form = { fields: [], text: () => '' };
const choice = (choices: readonly string[]): Form => ({
  fields: [{ name: 'state', label: 'field.state', kind: 'choice', initial: choices[0]!, choices }],
  text: (values) => values.state!,
});

/** By request; requests that are not here have no data. */
const FORMS: Record<string, Form> = {
  Move: {
    fields: [number('to', 'field.destination', 1200, ...I16)],
    text: (values) => values.to!,
  },
  GetParam: {
    fields: [{ name: 'parameter', label: 'field.parameter', kind: 'parameter', initial: '' }],
    text: (values) => values.parameter!,
  },
  SetParam: {
    fields: [
      { name: 'parameter', label: 'field.parameter', kind: 'parameter', initial: '' },
      { name: 'values', label: 'field.values', kind: 'text', initial: '5' },
    ],
    text: (values) => `${values.parameter} ${values.values}`,
  },
  Lockout: choice(['on', 'off']),
  SwitchLimits: choice(['off', 'on', 'reject']),
  StartSeek: {
    fields: [
      number('left', 'field.from_h', -600, ...I16),
      number('right', 'field.to_h', 600, ...I16),
      number('low', 'field.from_v', -300, ...I16),
      number('high', 'field.to_v', 300, ...I16),
    ],
    text: (values) => `${values.left} ${values.right} ${values.low} ${values.high}`,
  },
  StartQuench: {
    fields: [
      number('h', 'field.centre_h', 1200, ...I16),
      number('v', 'field.centre_v', 300, ...I16),
      number('nozzle', 'field.nozzle', 60, ...I16),
      number('width', 'field.width', 600, ...I16),
      number('height', 'field.height', 300, ...I16),
      number('step', 'field.step', 2, -128, 127),
      number('distance', 'field.distance', 25, -128, 127),
    ],
    text: (v) =>
      `centre=${v.h},${v.v} nozzle=${v.nozzle} sector=${v.width},${v.height} step=${v.step} distance=${v.distance}`,
  },
  StartTrajectory: {
    fields: [{ name: 'points', label: 'field.points', kind: 'text', initial: '1200,300,25,10 1300,300,25,10' }],
    text: (values) =>
      values
        .points!.split(/\s+/)
        .filter((it) => it !== '')
        .map((point) => `point=${point}`)
        .join(' '),
  },
  SetupCorrectionTable: {
    fields: [
      number('first', 'field.first', 0, 0, 255),
      { name: 'corrections', label: 'field.corrections', kind: 'text', initial: '0,0,1,1,2' },
    ],
    text: (values) => `first=${values.first} corrections=${values.corrections}`,
  },
};

export function formOf(request: string): Form {
  return FORMS[request] ?? EMPTY;
}

/** The text form of a request. */
export function textOf(request: string, addressee: string, values: Record<string, string>): string {
  return [request, addressee, formOf(request).text(values)].filter((part) => part !== '').join(' ');
}

import { expect, test } from 'vitest';
import { formOf, textOf } from '../../src/forms';
import en from '../../src/i18n/en';
import ru from '../../src/i18n/ru';
import type { Anatomy, Description } from '../../src/wire';
import { engine } from '../module';

test('each request of the list, to each of its addressees, is read as it is written', async () => {
  const here = await engine();
  const { requests, subsystems } = here.call<Description>({ op: 'describe' });
  expect(requests.length).toBe(21);
  for (const request of requests) {
    const addressees = request.addressees.length > 0 ? request.addressees : subsystems.map((one) => one.name);
    for (const to of addressees) {
      const parameter = subsystems.find((one) => one.name === to)!.parameters[0] ?? '0x0000';
      const fields = formOf(request.name).fields;
      const values = Object.fromEntries(
        fields.map((field) => [field.name, field.kind === 'parameter' ? parameter : field.initial]),
      );
      const text = textOf(request.name, to, values);
      const anatomy = here.call<Anatomy>({ op: 'read', input: { bytes: false, text } });
      expect(anatomy.text.length, text).toBe(1);
      expect(
        anatomy.parts.some((part) => part.name === 'request' && part.value.en === request.name),
        text,
      ).toBe(true);
    }
  }
});

test('bounds of the fields are those of the grammar', async () => {
  const here = await engine();
  const { requests } = here.call<Description>({ op: 'describe' });
  for (const request of requests) {
    const { fields } = formOf(request.name);
    const initial = Object.fromEntries(fields.map((field) => [field.name, field.initial]));
    for (const field of fields) {
      if (field.kind !== 'number') continue;
      const ask = (value: number): string => {
        const text = textOf(request.name, request.addressees[0]!, { ...initial, [field.name]: String(value) });
        return here.ask({ op: 'read', input: { bytes: false, text } });
      };
      expect(ask(field.max!), `${request.name} ${field.name}`).toContain('"ok"');
      expect(ask(field.max! + 1), `${request.name} ${field.name}`).toContain('"error"');
      expect(ask(field.min! - 1), `${request.name} ${field.name}`).toContain('"error"');
    }
  }
});

test('every text is in both languages, with the same arguments', () => {
  expect(Object.keys(ru).sort()).toEqual(Object.keys(en).sort());
  const named = (text: string): string[] => [...text.matchAll(/\{(\w+)\}/g)].map((it) => it[1]!).sort();
  for (const key of Object.keys(en) as (keyof typeof en)[]) {
    expect(named(ru[key]), key).toEqual(named(en[key]));
    // Labels of fields are the same letters at most by chance.
    expect(ru[key], key).not.toBe(en[key]);
  }
});

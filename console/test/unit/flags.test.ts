import { readFileSync } from 'node:fs';
import { expect, it } from 'vitest';
import type { Dictionary } from '../../src/hub/dictionary';
import { has } from '../../src/hub/session';

it('knows only flags that the dictionary has', () => {
  // The type checker (npm run check) refuses these lines if they are not wrong.
  // @ts-expect-error There is no flag of this name.
  expect(has('M1', 'Valve1', 'Opened')).toBe(false);
  // @ts-expect-error It is a flag of another subsystem.
  expect(has('M1', 'General', 'Deployed')).toBe(false);
  // @ts-expect-error There is no subsystem of this name.
  expect(has('M1', 'Valve3', 'Open')).toBe(false);
  const file = readFileSync(new URL('files/dictionary.json', import.meta.url), 'utf8');
  const { flags, subsystems } = JSON.parse(file) as Dictionary;
  const of = (name: string) =>
    flags[subsystems.find((one) => one.name === name)?.flags ?? '']?.map((flag) => flag.name);
  expect(of('Deployer')).toContain('Deployed');
});

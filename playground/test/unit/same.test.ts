// The simulator as WebAssembly and the same code built for this machine (LAFET_REPLIES, a program that reads commands
// and prints answers) say the same, letter by letter: every figure, every byte, every text.
import { spawnSync } from 'node:child_process';
import { expect, test } from 'vitest';
import type { Command, Description } from '../../src/wire';
import { engine } from '../module';

const advance = (seconds: number): Command[] =>
  Array.from({ length: seconds }, () => ({ op: 'advance', ms: 1000, since: 0 }) as const);
const send = (link: 'wired' | 'radio', text: string): Command => ({
  op: 'act',
  act: { kind: 'send', link, input: { bytes: false, text } },
});
const act = (act: Extract<Command, { op: 'act' }>['act']): Command => ({ op: 'act', act });

/** Gusts of everything: wind, a fire that goes out or not, faults, a search, extinguishing, a power cut. */
function long(profile: string, seed: number): Command[] {
  return [
    { op: 'start', seed, profile, wind: [4, -3] },
    ...advance(1),
    act({ kind: 'light', azimuth: 15, range: 28, fuel: false }),
    act({ kind: 'light', azimuth: -40, range: 33, fuel: true }),
    send('wired', 'Deploy'),
    ...advance(13),
    send('radio', 'StartSeek -1800 1800 -300 300 analyse'),
    ...advance(20),
    send('wired', 'Stop All; StartQuench centre=900,300 nozzle=60 sector=600,300 step=2 distance=28'),
    send('wired', 'Open Valve1'),
    ...advance(30),
    act({ kind: 'break', fault: 'horizontal-encoder-noise' }),
    act({ kind: 'break', fault: 'pressure-drift' }),
    ...advance(10),
    send('radio', 'Close Valve1; SetParam Vertical Speed 9; GetStatus All; GetParam Detector Hotbeds'),
    ...advance(5),
    act({ kind: 'power' }),
    ...advance(5),
    { op: 'share' },
  ];
}

test('WebAssembly and the native program answer the same', async () => {
  const program = process.env.LAFET_REPLIES;
  if (!program) throw new Error('LAFET_REPLIES is not set: cargo xtask playground --check');
  const { examples } = (await engine()).call<Description>({ op: 'describe' });
  const sequences: Command[][] = examples.map(({ fragment }) => [
    { op: 'open', fragment },
    ...advance(60),
    { op: 'share' },
  ]);
  for (const profile of ['full', 'remote', 'mini', 'ex', 'limit-switch']) sequences.push(long(profile, 4711));
  sequences.push([{ op: 'describe' }, { op: 'open', fragment: '1.AAAA' }, send('wired', 'Opn Valve1')]);

  const run = spawnSync(program, { input: JSON.stringify(sequences), maxBuffer: 1 << 30, encoding: 'utf8' });
  expect(run.status, run.stderr).toBe(0);
  const native = JSON.parse(run.stdout) as string[][];
  expect(native.length).toBe(sequences.length);
  for (const [index, commands] of sequences.entries()) {
    // Each in a new module: as a page that has just been opened.
    const here = await engine();
    for (const [place, command] of commands.entries()) {
      expect(here.ask(command), `sequence ${index}, command ${place}: ${JSON.stringify(command)}`).toBe(
        native[index]![place],
      );
    }
  }
});

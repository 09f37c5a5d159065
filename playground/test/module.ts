import { readFile } from 'node:fs/promises';
import { Engine } from '../src/engine';

/** The simulator as the page gets it. */
export async function engine(): Promise<Engine> {
  return Engine.of(await readFile(new URL('../src/lafet.wasm', import.meta.url)));
}

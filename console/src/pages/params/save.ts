// Writing parameters: the hub waits until each is stored (§3.5/9). A busy monitor is asked again; values
// held back by an incomplete set are written once more at the end.
import { commands } from '../../hub/commands';
import type { DictParam } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import type { Answer, Result } from '../../hub/types';
import { same, titleOf } from './model';

/** Outcome of writing a value. */
export type Saved =
  /** It is in non-volatile memory. */
  | 'stored'
  /** It is in force; that it is stored is unconfirmed. */
  | 'unconfirmed'
  /** It is in force until the next reset: the memory rejects writes. */
  | 'write_failed'
  /** In RAM until the subsystem's set is complete. */
  | 'incomplete';

/** The functions of the console that writing needs; tests use their own. */
export interface Ways {
  send: (text: string) => Promise<Result>;
  /** Sets a parameter; resolves when it is stored. */
  save: (text: string) => Promise<Result>;
  pause: (ms: number) => Promise<void>;
}

const AGAIN_MS = 500;
const AGAIN_MOST = 20;

export function waysTo(monitor: string): Ways {
  return {
    send: (text) => commands.request(monitor, text, { quiet: true }),
    save: (text) => commands.request(monitor, text, { quiet: true, save: true }),
    pause: (ms) => new Promise((resolve) => setTimeout(resolve, ms)),
  };
}

export function requestOf(param: DictParam, values: readonly number[]): string {
  return ['SetParam', param.subsystem, param.name, ...values].join(' ');
}

/** Writes a parameter and waits until it is stored. Rejects if it was refused. */
export async function save(ways: Ways, param: DictParam, values: readonly number[]): Promise<Saved> {
  const text = requestOf(param, values);
  for (let tries = 1; ; tries += 1) {
    try {
      const { saved, answers } = await ways.save(text);
      return answers[0]?.status === 'IncompleteConfig' ? 'incomplete' : (saved ?? 'unconfirmed');
    } catch (cause) {
      const error = HubError.of(cause);
      if (refusal(error) === 'IncompleteConfig') return 'incomplete';
      if (!passes(error) || tries >= AGAIN_MOST) throw error;
      await ways.pause(pauseOf(error));
    }
  }
}

/** Reads a parameter from the monitor; null: it has no value. */
export async function read(ways: Ways, param: DictParam): Promise<number[] | null> {
  const text = `GetParam ${param.subsystem} ${param.name}`;
  for (let tries = 1; ; tries += 1) {
    try {
      const values = (await ways.send(text)).answers[0]?.values;
      const found = values?.values ?? values?.value;
      return Array.isArray(found) ? (found as number[]) : [];
    } catch (cause) {
      const error = HubError.of(cause);
      if (refusal(error) === 'IncompleteConfig') return null;
      if (!passes(error) || tries >= AGAIN_MOST) throw error;
      await ways.pause(pauseOf(error));
    }
  }
}

function refusal(error: HubError): string {
  const answers = error.details.answers as Answer[] | undefined;
  return error.code === 'refused' ? (answers?.[0]?.status ?? '') : '';
}

/** Setting a value twice is harmless: these may be tried again. */
function passes(error: HubError): boolean {
  const codes = ['no_answer', 'outcome_unknown', 'not_sent', 'slow_down'];
  return codes.includes(error.code) || ['Busy', 'NotCached', 'Cached'].includes(refusal(error));
}

function pauseOf(error: HubError): number {
  const wanted = error.details.retry_after_ms;
  return typeof wanted === 'number' ? wanted : AGAIN_MS;
}

export interface Item {
  param: DictParam;
  wanted: number[];
  /** The previous value; undefined: unset. */
  before: number[] | undefined;
}

export type Outcome =
  | { state: 'waiting' | 'writing' }
  | { state: 'saved'; saved: Saved }
  | { state: 'other'; values: number[] | null }
  | { state: 'failed'; error: HubError };

/** Parameters that could cut the connection come last. */
export function inOrder(items: readonly Item[]): Item[] {
  const last = ['General.Address', 'General.Chain', 'ExternalConn.Check', 'Radio.Check'];
  return [...items].sort((a, b) => last.indexOf(titleOf(a.param)) - last.indexOf(titleOf(b.param)));
}

/**
 * Writes parameters one after another and reads them again. `tell` is called with the outcome of each;
 * `stopped` ends it before the next one.
 */
export async function saveAll(
  ways: Ways,
  items: readonly Item[],
  tell: (title: string, outcome: Outcome) => void,
  stopped: () => boolean = () => false,
): Promise<void> {
  const held: Item[] = [];
  const taken: { item: Item; saved: Saved }[] = [];
  const write = async (item: Item, again: boolean): Promise<boolean> => {
    const title = titleOf(item.param);
    tell(title, { state: 'writing' });
    try {
      const saved = await save(ways, item.param, item.wanted);
      if (saved === 'incomplete' && !again) held.push(item);
      else taken.push({ item, saved });
      tell(title, { state: 'saved', saved });
      return true;
    } catch (cause) {
      const error = HubError.of(cause);
      tell(title, { state: 'failed', error });
      // The monitor or the hub is unreachable: further writes would fail.
      return !['not_linked', 'no_authority', 'not_connected', 'role'].includes(error.code);
    }
  };
  for (const item of inOrder(items)) {
    if (stopped() || !(await write(item, false))) break;
  }
  // The monitor has them in RAM, and stores them with the last one of the set (§3.5/6).
  for (const item of held) {
    if (stopped() || !(await write(item, true))) break;
  }
  for (const { item, saved } of taken) {
    if (saved === 'incomplete') continue;
    const title = titleOf(item.param);
    try {
      const values = await read(ways, item.param);
      if (!same(values ?? undefined, item.wanted)) tell(title, { state: 'other', values });
    } catch (cause) {
      tell(title, { state: 'failed', error: HubError.of(cause) });
    }
  }
}

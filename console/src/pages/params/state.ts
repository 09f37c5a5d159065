// The values being edited, by monitor: they outlive the page, so that nothing is lost on another page.
import { type DictParam, dictionaryNow } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import type { Params } from '../../hub/types';
import { check, fromField, fromList, isKept, type Problem, same, titleOf } from './model';
import { type Item, type Outcome, saveAll, waysTo } from './save';
import { scaleFor, textOf } from './words';

export type Typed = { values: number[] } | { problem: Problem };

export class Editing extends EventTarget {
  /** Typed values by title, as whole numbers of the wire if valid. */
  private readonly edits = new Map<string, { text: string; typed: Typed }>();
  /** Read back after writing; the hub's own read follows a little later. */
  private readonly fresh = new Map<string, { values: number[]; at_ms: number }>();
  readonly outcomes = new Map<string, Outcome>();
  /** Written, and in force only after a restart. */
  readonly restart = new Set<string>();
  busy: 'reading' | 'writing' | null = null;
  progress: { done: number; total: number } | null = null;
  readError: HubError | null = null;
  private stop = false;

  constructor(readonly monitor: string) {
    super();
  }

  params(): Params | undefined {
    return store.get(`monitors/${this.monitor}/params`);
  }

  /** The monitor's value, as last read. */
  value(param: DictParam): number[] | undefined {
    const params = this.params();
    const fresh = this.fresh.get(titleOf(param));
    if (fresh && fresh.at_ms > (params?.at_ms ?? 0)) return fresh.values;
    return params?.values[param.subsystem]?.[param.name]?.values;
  }

  /** Content of the field. */
  text(param: DictParam): string {
    return this.edits.get(titleOf(param))?.text ?? textOf(param, this.value(param));
  }

  typed(param: DictParam): Typed | null {
    return this.edits.get(titleOf(param))?.typed ?? null;
  }

  isChanged(param: DictParam): boolean {
    return this.edits.has(titleOf(param));
  }

  type(param: DictParam, text: string): void {
    const title = titleOf(param);
    const typed = parse(param, text);
    this.outcomes.delete(title);
    if ('values' in typed && same(typed.values, this.value(param))) this.edits.delete(title);
    else this.edits.set(title, { text, typed });
    this.changed();
  }

  set(param: DictParam, values: readonly number[]): void {
    this.type(param, textOf(param, values));
  }

  discard(param?: DictParam): void {
    if (param) {
      this.edits.delete(titleOf(param));
      this.outcomes.delete(titleOf(param));
    } else this.edits.clear();
    this.changed();
  }

  /** Shows typed values in the units that are selected now. */
  reshow(): void {
    for (const param of this.edited()) {
      const edit = this.edits.get(titleOf(param))!;
      if ('values' in edit.typed) edit.text = textOf(param, edit.typed.values);
    }
    this.changed();
  }

  edited(): DictParam[] {
    const all = dictionaryNow()?.params ?? [];
    return all.filter((param) => isKept(param) && this.edits.has(titleOf(param)));
  }

  /** All known values of the monitor, by title. */
  read(title: string): number[] | undefined {
    const param = dictionaryNow()?.params.find((p) => titleOf(p) === title);
    return param && this.value(param);
  }

  async readAll(): Promise<void> {
    if (this.busy) return;
    this.begin('reading');
    const path = `/api/monitors/${encodeURIComponent(this.monitor)}/params`;
    const topic = `monitors/${this.monitor}/params_progress` as const;
    const end = store.subscribe(topic, () => {
      this.progress = store.get(topic) ?? this.progress;
      this.changed();
    });
    try {
      await http.post<Params>(`${path}/read`);
      this.fresh.clear();
    } catch (cause) {
      this.readError = HubError.of(cause);
    } finally {
      end();
      this.end();
    }
  }

  /** Writes typed values: one parameter, or all that are changed and valid. */
  async write(params: readonly DictParam[]): Promise<void> {
    const items: Item[] = [];
    for (const param of params) {
      const typed = this.typed(param);
      if (typed && 'values' in typed) {
        items.push({ param, wanted: typed.values, before: this.value(param) });
      }
    }
    await this.save(items);
  }

  /** Writes given values; `tell` is called for each. */
  async save(items: readonly Item[], tell: (title: string, outcome: Outcome) => void = () => {}): Promise<void> {
    if (this.busy || !items.length) return;
    this.begin('writing');
    this.progress = { done: 0, total: items.length };
    for (const { param } of items) this.outcomes.set(titleOf(param), { state: 'waiting' });
    const wanted = new Map(items.map((item) => [titleOf(item.param), item]));
    const heard = (title: string, outcome: Outcome) => {
      this.outcomes.set(title, outcome);
      if (outcome.state === 'saved') this.took(wanted.get(title)!);
      if (outcome.state === 'other' && outcome.values) this.know(title, outcome.values);
      const left = items.filter(({ param }) => {
        const state = this.outcomes.get(titleOf(param))?.state;
        return state === 'waiting' || state === 'writing';
      });
      this.progress = { done: items.length - left.length, total: items.length };
      tell(title, outcome);
      this.changed();
    };
    try {
      await saveAll(waysTo(this.monitor), items, heard, () => this.stop);
    } finally {
      for (const [title, outcome] of this.outcomes) {
        if (outcome.state === 'waiting' || outcome.state === 'writing') this.outcomes.delete(title);
      }
      this.end();
    }
  }

  /** Ends a writing before its next parameter. */
  cancel(): void {
    this.stop = true;
  }

  changed(): void {
    this.dispatchEvent(new Event('change'));
  }

  private took({ param, wanted }: Item): void {
    const title = titleOf(param);
    this.know(title, wanted);
    this.edits.delete(title);
    if (param.effect === 'after-restart') this.restart.add(title);
  }

  private know(title: string, values: number[]): void {
    this.fresh.set(title, { values, at_ms: store.now() });
  }

  private begin(what: 'reading' | 'writing'): void {
    this.busy = what;
    this.stop = false;
    this.progress = null;
    this.readError = null;
    this.changed();
  }

  private end(): void {
    this.busy = null;
    this.progress = null;
    this.changed();
  }
}

function parse(param: DictParam, text: string): Typed {
  if (param.len.max !== 1) {
    const values = fromList(text);
    if (!values) return { problem: { kind: 'number', at: 0 } };
    return checked(param, values);
  }
  const value = fromField(text, scaleFor(param));
  return value === null ? { problem: { kind: 'number', at: 0 } } : checked(param, [value]);
}

function checked(param: DictParam, values: number[]): Typed {
  const problem = check(param, values);
  return problem ? { problem } : { values };
}

const all = new Map<string, Editing>();

export function editing(monitor: string): Editing {
  let found = all.get(monitor);
  if (!found) all.set(monitor, (found = new Editing(monitor)));
  return found;
}

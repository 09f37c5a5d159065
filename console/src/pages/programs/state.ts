// Programs that are being edited, by monitor; they outlive the page.
import { param } from '../../hub/dictionary';
import { store } from '../../hub/store';
import type { Range } from '../../hub/types';
import { lang, t } from '../../i18n';
import type { DriveLimits } from '../../parts/raster';
import { digitsOf, fromWire, unitText } from '../../units';
import { type Scale, same as sameValues } from '../params/model';
import { editing } from '../params/state';
import { COUNT, type Kind, titleFor, type Which } from './model';

export class Drafts {
  private readonly drafts = new Map<string, number[]>();

  constructor(readonly monitor: string) {}

  stored(which: Which): number[] | undefined {
    const found = param('Control', titleFor(which).split('.')[1]!);
    return found && editing(this.monitor).value(found);
  }

  /** The edited values, else the stored ones, else empty. */
  values(which: Which): number[] {
    const empty = which.kind === 'Program' ? new Array<number>(7).fill(0) : [];
    return this.drafts.get(titleFor(which)) ?? this.stored(which) ?? empty;
  }

  set(which: Which, values: number[]): void {
    if (sameValues(values, this.stored(which))) this.drafts.delete(titleFor(which));
    else this.drafts.set(titleFor(which), values);
  }

  revert(which: Which): void {
    this.drafts.delete(titleFor(which));
  }

  isUnsaved(which: Which): boolean {
    const draft = this.drafts.get(titleFor(which));
    return draft !== undefined && !sameValues(draft, this.stored(which));
  }

  unsaved(): Which[] {
    return every().filter((which) => this.isUnsaved(which));
  }
}

/** All programs, then all trajectories. */
export function every(): Which[] {
  const of = (kind: Kind) => Array.from({ length: COUNT }, (_, number) => ({ kind, number }));
  return [...of('Program'), ...of('Trajectory')];
}

export function titleText({ kind, number }: Which): string {
  return t(kind === 'Program' ? 'programs.program' : 'programs.trajectory', { n: number });
}

const all = new Map<string, Drafts>();

export function drafts(monitor: string): Drafts {
  let found = all.get(monitor);
  if (!found) all.set(monitor, (found = new Drafts(monitor)));
  return found;
}

export function limitsOf(monitor: string): (DriveLimits & { Nozzle?: Range }) | null {
  return store.get(`monitors/${monitor}/limits`) ?? null;
}

/** Scales of the fields; one more digit than elsewhere, so that nothing is lost. */
export const scales = {
  angle: (): Scale => {
    const factor = fromWire('angle', 1);
    const digits = factor === 1 ? 0 : factor < 0.1 ? 2 : 1;
    return { factor, digits, unit: unitText('angle') };
  },
  nozzle: (): Scale => ({ factor: 1, digits: 0, unit: unitText('nozzle') }),
  step: (): Scale => ({ factor: 1, digits: 0, unit: '°' }),
  length: (): Scale => {
    const factor = fromWire('length', 1);
    return { factor, digits: factor === 1 ? 0 : Math.max(1, digitsOf('length')), unit: unitText('length') };
  },
  dwell: (): Scale => ({ factor: 0.1, digits: 1, unit: lang() === 'ru' ? 'с' : 's' }),
};

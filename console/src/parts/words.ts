// Texts of parts in the operator's language and units; a part that shows any renders again when
// these change.
import type { ReactiveController, ReactiveControllerHost } from 'lit';
import { langChanged, num, t } from '../i18n';
import { fromWire, show, unitsChanged, unitText } from '../units';

export class Words implements ReactiveController {
  constructor(private readonly host: ReactiveControllerHost) {
    host.addController(this);
  }

  hostConnected(): void {
    langChanged.addEventListener('change', this.changed);
    unitsChanged.addEventListener('change', this.changed);
  }

  hostDisconnected(): void {
    langChanged.removeEventListener('change', this.changed);
    unitsChanged.removeEventListener('change', this.changed);
  }

  private readonly changed = (): void => this.host.requestUpdate();
}

/** 10 m, 4.5 m, 33 ft: tenths only where they matter. */
export function lengthText(metres: number): string {
  const shown = fromWire('length', metres);
  const digits = shown >= 20 || Math.abs(shown - Math.round(shown)) < 0.05 ? 0 : 1;
  return `${num(shown, digits)}\u202f${unitText('length')}`;
}

/** 28–46 m: from the nearest to the farthest, rounded outwards. */
export function spanText(near_m: number, far_m: number): string {
  const [near, far] = [fromWire('length', near_m), fromWire('length', far_m)];
  return `${num(Math.floor(near), 0)}–${num(Math.ceil(far), 0)}\u202f${unitText('length')}`;
}

/** A position of a drive, arc-minutes. */
export function angleText(arcmin: number): string {
  return show('angle', arcmin);
}

/** A bearing: always degrees, three digits. */
export function bearingText(degrees: number): string {
  return `${String(Math.round(degrees) % 360).padStart(3, '0')}°`;
}

/** An opening in degrees. */
export function openingText(degrees: number): string {
  return `${num(degrees, degrees < 10 ? 1 : 0)}°`;
}

/** The size of a file: 12 kB, 1.5 MB. */
export function sizeText(bytes: number): string {
  const large = bytes >= 1e6;
  return `${num(bytes / (large ? 1e6 : 1e3), large ? 1 : 0)}\u202f${t(large ? 'replay.mb' : 'replay.kb')}`;
}

// The session of this page.
import type { Session } from './types';

let now: Session | null = null;

export function session(): Session | null {
  return now;
}

export function setSession(given: Session | null): void {
  now = given;
}

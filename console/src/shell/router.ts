// The current page: `#/overview`, `#/m/M1/operate`. A page is a file in src/pages; it is loaded when it
// is first opened, and only existing files are listed.

import type { Role } from '../hub/types';
import type { IconName } from '../parts/icons';

export interface PageInfo {
  name: string;
  icon: IconName;
  scope: 'site' | 'monitor';
  /** The lowest role that can use it. */
  role?: Role;
  /** Only where the hub simulates the site. */
  demo?: boolean;
  /** Only where the hub has zones. */
  zones?: boolean;
}

export interface Route {
  page: string;
  monitor: string | null;
}

const KNOWN: PageInfo[] = [
  { name: 'overview', icon: 'overview', scope: 'site' },
  { name: 'zones', icon: 'zones', scope: 'site', zones: true },
  { name: 'alarms', icon: 'alarms', scope: 'site' },
  { name: 'events', icon: 'events', scope: 'site' },
  { name: 'replay', icon: 'replay', scope: 'site' },
  { name: 'updates', icon: 'updates', scope: 'site' },
  { name: 'training', icon: 'training', scope: 'site', demo: true },
  { name: 'admin', icon: 'admin', scope: 'site', role: 'administrator' },
  { name: 'operate', icon: 'operate', scope: 'monitor' },
  { name: 'programs', icon: 'programs', scope: 'monitor' },
  { name: 'params', icon: 'params', scope: 'monitor' },
  { name: 'commissioning', icon: 'commissioning', scope: 'monitor', role: 'engineer' },
  { name: 'diagnosis', icon: 'diagnosis', scope: 'monitor' },
  { name: 'inspector', icon: 'inspector', scope: 'monitor' },
];

const modules = import.meta.glob('../pages/*.ts');

/** All pages, in order. */
export const PAGES = KNOWN.filter((page) => `../pages/${page.name}.ts` in modules);

export function loadPage(name: string): Promise<unknown> {
  return modules[`../pages/${name}.ts`]?.() ?? Promise.reject(new Error(`no page ${name}`));
}

const FETCH_AFTER_MS = 3000;
let fetched = false;

/** Loads the other pages while idle: without a link none could be opened. */
export function fetchPages(): void {
  if (fetched) return;
  fetched = true;
  const left = PAGES.map((page) => page.name);
  const next = () => {
    const name = left.shift();
    if (name)
      loadPage(name)
        .catch(() => {})
        .finally(() => later(next));
  };
  setTimeout(next, FETCH_AFTER_MS);
}

function later(act: () => void): void {
  if ('requestIdleCallback' in window) requestIdleCallback(act);
  else setTimeout(act, 500);
}

export function hrefOf(page: string, monitor?: string | null): string {
  return monitor ? `#/m/${encodeURIComponent(monitor)}/${page}` : `#/${page}`;
}

export function parseRoute(hash: string): Route {
  const parts = hash.replace(/^#\/?/, '').split('?')[0]!.split('/').filter(Boolean);
  const known = (name: string | undefined, scope: PageInfo['scope']) =>
    PAGES.some((page) => page.name === name && page.scope === scope);
  if (parts[0] === 'm' && parts[1]) {
    const page = known(parts[2], 'monitor') ? parts[2]! : 'operate';
    return { page, monitor: decoded(parts[1]) ?? parts[1] };
  }
  return { page: known(parts[0], 'site') ? parts[0]! : 'overview', monitor: null };
}

/** A part of an address; null: its escapes are malformed. */
export function decoded(part: string): string | null {
  try {
    return decodeURIComponent(part);
  } catch {
    return null;
  }
}

class Router extends EventTarget {
  route = parseRoute(location.hash);
  /** The monitor that was shown last. */
  lastMonitor: string | null = this.route.monitor;

  constructor() {
    super();
    window.addEventListener('hashchange', () => {
      this.route = parseRoute(location.hash);
      this.lastMonitor = this.route.monitor ?? this.lastMonitor;
      this.dispatchEvent(new Event('change'));
    });
  }

  go(page: string, monitor?: string | null): void {
    location.hash = hrefOf(page, monitor);
  }
}

export const router = new Router();

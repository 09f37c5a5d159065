// Which file of the project becomes which page of the site, and where a link from one file to another leads.
import { readdirSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

export const WEBSITE = fileURLToPath(new URL('..', import.meta.url));
export const ROOT = path.join(WEBSITE, '..');
/** The staged pages, which VitePress reads; checks of the sources skip folders of this name. */
export const PAGES = path.join(WEBSITE, 'target/pages');

/** Pages whose sources are not in docs/. */
const ELSEWHERE = {
  'ARCHITECTURE.md': 'architecture.md',
  'CONTRIBUTING.md': 'contributing.md',
  'bindings/c/README.md': 'c.md',
  'bindings/python/README.md': 'python.md',
  'bindings/python/README.ru.md': 'ru/python.md',
  'conformance/scenarios/README.md': 'conformance-scenarios.md',
  'website/content/index.md': 'index.md',
  'website/content/index.ru.md': 'ru/index.md',
};
/** Files with the same content as the first page, for links to them. */
const SAME = { 'README.md': 'index.md', 'README.ru.md': 'ru/index.md' };
/** Folders that a page describes. */
const FOLDERS = {
  'bindings/python': 'python.md',
  'bindings/c': 'c.md',
  'conformance/scenarios': 'conformance-scenarios.md',
};
/** Folders of docs/ that are copied as they are. */
export const FILES = ['docs/schema', 'docs/examples'];

/** The page of a file in docs/, `client.ru.md` → `ru/client.md`. */
function pageOf(name) {
  const russian = name.endsWith('.ru.md');
  return russian ? `ru/${name.slice(0, -'.ru.md'.length)}.md` : name;
}

/** Source (from the root of the project) → page (below `pages`). */
export function sources() {
  const docs = readdirSync(path.join(ROOT, 'docs')).filter((name) => name.endsWith('.md'));
  const pages = docs.map((name) => [`docs/${name}`, pageOf(name)]);
  return new Map([...pages, ...Object.entries(ELSEWHERE)].sort());
}

/**
 * Where a relative link in a source leads.
 *
 * `page` with its anchor, `file` (copied), or `repository` (there, but not in the site); null for an address that is
 * not relative.
 */
export function target(known, source, href) {
  if (/^[a-z][a-z0-9+.-]*:|^\/\//i.test(href) || href.startsWith('/')) return null;
  const [file, anchor] = href.split('#');
  if (file === '') return { page: known.get(source), anchor };
  const inside = path.posix.normalize(path.posix.join(path.posix.dirname(source), decodeURI(file)));
  const page = known.get(inside) ?? SAME[inside] ?? FOLDERS[inside];
  if (page) return { page, anchor };
  if (FILES.some((folder) => inside.startsWith(`${folder}/`))) return { file: inside.slice('docs/'.length) };
  return { repository: inside };
}

/** A relative address from one page to another, or to a file. */
export function between(from, to) {
  const relative = path.posix.relative(path.posix.dirname(from), to);
  return relative.startsWith('.') ? relative : `./${relative}`;
}

/** The anchor of a heading as code-hosting sites make it: letters of every alphabet, in lower case. */
export function slug(text) {
  const kept = [...text.trim()].filter((c) => /[\p{L}\p{M}\p{N}\p{Pc} -]/u.test(c));
  return kept.join('').replaceAll(' ', '-').toLowerCase();
}

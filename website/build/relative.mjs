// Makes the built site independent of the folder that it is served from: VitePress writes one base address into every
// file, here a mark; pages get the way up from where they are, programs what the page says.
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseAst } from 'rollup/parseAst';
import { labelled } from '../site/labels.mjs';

/** The base address with which the site is built. */
export const PLACE = '/LAFET-SITE-BASE/';
const BASE = 'globalThis.lafetBase';

/** A page: addresses from where it is. `depth` is the number of folders above it. */
export function pageAt(html, depth) {
  const up = depth === 0 ? './' : '../'.repeat(depth);
  const script = `<script>${BASE}=new URL(${JSON.stringify(up)},location.href).pathname</script>`;
  const inline = /(<script(?![^>]*\bsrc=)[^>]*>)(.*?)(<\/script>)/gs;
  const lang = /<html lang="([a-z]+)"/.exec(html)?.[1];
  const kept = labelled(html, lang).replace(inline, (_all, open, text, close) => open + program(text) + close);
  return kept.replace('<head>', `<head>${script}`).replaceAll(PLACE, up);
}

/** A program: each string with the mark becomes a sum with what the page says. */
export function program(text) {
  if (!text.includes(PLACE)) return text;
  let out = '';
  let done = 0;
  for (const { start, end, quote } of strings(parseAst(text))) {
    const inside = text.slice(start, end);
    if (!inside.includes(PLACE)) continue;
    const mark = quote ? quote(inside) : `\${${BASE}}`;
    const sum = inside.replaceAll(PLACE, mark);
    out += text.slice(done, start) + (quote ? `(${sum})` : sum);
    done = end;
  }
  return out + text.slice(done);
}

/** The literals of a program in their order; those in quotes are interrupted by `quote`. */
function strings(tree) {
  const found = [];
  const walk = (node) => {
    if (node.type === 'Literal' && typeof node.value === 'string') {
      found.push({ start: node.start, end: node.end, quote: (all) => `${all[0]}+${BASE}+${all[0]}` });
    } else if (node.type === 'TemplateElement') {
      found.push({ start: node.start, end: node.end, quote: null });
    }
    for (const value of Object.values(node)) {
      for (const one of Array.isArray(value) ? value : [value]) if (typeof one?.type === 'string') walk(one);
    }
  };
  walk(tree);
  return found.sort((a, b) => a.start - b.start);
}

function files(folder) {
  return readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => path.join(entry.parentPath, entry.name));
}

function run(dist) {
  for (const file of files(dist)) {
    const inside = path.relative(dist, file);
    if (inside.startsWith('playground/')) continue;
    const depth = inside.split(path.sep).length - 1;
    const change = {
      '.html': (text) => pageAt(text, depth),
      '.js': program,
      '.css': (text) => text.replaceAll(PLACE, '../'.repeat(depth)),
    }[path.extname(file)];
    if (!change) continue;
    const text = readFileSync(file, 'utf8');
    if (!text.includes(PLACE)) {
      if (path.extname(file) === '.html') writeFileSync(file, change(text));
      continue;
    }
    const changed = change(text);
    if (changed.includes(PLACE)) throw new Error(`${inside}: an address could not be made relative`);
    writeFileSync(file, changed);
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) run(fileURLToPath(new URL('../dist', import.meta.url)));

// Assembles the pages of the site below `pages`: the sources as they are, the reference, and a page for each that has
// no Russian form.
import { cpSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { GROUPS } from '../site/navigation.mjs';
import { api } from './api.mjs';
import { cli } from './cli.mjs';
import { parameters } from './parameters.mjs';
import { schema } from './schema.mjs';
import { FILES, PAGES, ROOT, sources, WEBSITE } from './sources.mjs';

rmSync(PAGES, { recursive: true, force: true });
/** Name → text. */
const written = new Map();

function put(name, text) {
  const file = path.join(PAGES, name);
  mkdirSync(path.dirname(file), { recursive: true });
  writeFileSync(file, text);
  written.set(name, text);
}

for (const [source, page] of sources()) put(page, readFileSync(path.join(ROOT, source), 'utf8'));
for (const [name, text] of [...cli(), ...api(), ...schema(), ...parameters()]) put(name, text);
const listed = GROUPS.flatMap((group) => group.pages);
for (const { path: name, title } of listed) {
  if (!written.has(`${name}.md`)) throw new Error(`site/navigation.mjs: there is no page ${name}`);
  if (!written.has(`ru/${name}.md`)) put(`ru/${name}.md`, inEnglish(name, title));
}
// Those that only another page leads to have their own title, which is English.
for (const [file, text] of [...written]) {
  if (file.startsWith('ru/') || written.has(`ru/${file}`)) continue;
  const title = /^# (.+)$/m.exec(text)[1];
  put(`ru/${file}`, inEnglish(file.replace(/\.md$/, ''), { en: title, ru: title }));
}

cpSync(path.join(ROOT, 'docs/images'), path.join(PAGES, 'images'), { recursive: true });
for (const folder of FILES) {
  const name = path.basename(folder);
  cpSync(path.join(ROOT, folder), path.join(PAGES, 'public', name), { recursive: true });
}
const playground = path.join(ROOT, 'playground/dist');
if (existsSync(playground)) cpSync(playground, path.join(PAGES, 'public/playground'), { recursive: true });
cpSync(path.join(ROOT, 'console/public'), path.join(PAGES, 'public'), { recursive: true });
console.log(`   ${path.relative(WEBSITE, PAGES)}: ${written.size} pages`);

/** What the Russian site has in place of a page that is only in English. */
function inEnglish(name, { en, ru }) {
  const up = '../'.repeat(name.split('/').length);
  return `---\nonlyEnglish: true\nprev: false\nnext: false\n---\n\n# ${ru}\n\nЭта страница есть только по-английски: [${en}](${up}${name}.md).\n`;
}

// The parts of the build, each by itself.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createMarkdownRenderer } from 'vitepress';
import { api } from '../build/api.mjs';
import { cli, commandsIn } from '../build/cli.mjs';
import { reader } from '../build/markdown.mjs';
import { parameters } from '../build/parameters.mjs';
import { PLACE, pageAt, program } from '../build/relative.mjs';
import { between, ROOT, slug, sources, target } from '../build/sources.mjs';
import { structure, table, type } from '../build/structures.mjs';
import { LABELS, labelled } from '../site/labels.mjs';
import { term } from '../site/search.mjs';
import { WORDS } from '../site/words.mjs';

test('anchors are those of code-hosting sites, in every alphabet', () => {
  assert.equal(slug('§3.1 Move: a drive'), '31-move-a-drive');
  assert.equal(slug('Удерживаемое движение'), 'удерживаемое-движение');
  // й and ё are letters of their own: nothing is taken apart.
  assert.equal(slug('Ещё: который'), 'ещё-который');
  assert.equal(slug('GET /api/monitors/{id}'), 'get-apimonitorsid');
});

test('a link leads to the page of its file, wherever that file is', () => {
  const known = sources();
  const leads = (source, href) => target(known, source, href);
  assert.deepEqual(leads('docs/hub.md', 'client.md#a-motion'), { page: 'client.md', anchor: 'a-motion' });
  assert.deepEqual(leads('docs/hub.ru.md', 'hub.md'), { page: 'hub.md', anchor: undefined });
  assert.deepEqual(leads('docs/hub.md', 'hub.ru.md'), { page: 'ru/hub.md', anchor: undefined });
  assert.deepEqual(leads('docs/hub.md', '../README.ru.md'), { page: 'ru/index.md', anchor: undefined });
  assert.deepEqual(leads('CONTRIBUTING.md', 'docs/hub.md'), { page: 'hub.md', anchor: undefined });
  assert.deepEqual(leads('docs/hub.md', '../bindings/c'), { page: 'c.md', anchor: undefined });
  assert.deepEqual(leads('docs/hub.md', 'schema/hub-1.json'), { file: 'schema/hub-1.json' });
  assert.deepEqual(leads('docs/hub.md', '../crates/hub'), { repository: 'crates/hub' });
  assert.equal(leads('docs/hub.md', 'https://example.org/a.md'), null);
  assert.equal(leads('docs/hub.md', 'mailto:a@example.org'), null);
  assert.equal(between('ru/hub.md', 'client.md'), '../client.md');
  assert.equal(between('hub.md', 'ru/hub.md'), './ru/hub.md');
});

test('what names a file in the sources names a page on the site', async () => {
  const md = await createMarkdownRenderer(ROOT, { config: reader(sources()) });
  const shown = (page, text) =>
    md
      .render(text, { relativePath: page })
      .replaceAll(/<[^>]*>/g, '')
      .trim();
  assert.equal(shown('hub.md', 'see [hub-api.md](hub-api.md#errors)'), 'see The hub’s API');
  assert.equal(shown('ru/hub.md', 'в [hub-api.ru.md](hub-api.ru.md)'), 'в «API сервера объекта»');
  assert.equal(shown('ru/hub.md', 'в [hub.md](hub.md#limits)'), 'в «Сервер объекта» (по-английски)');
  assert.equal(shown('ru/hub.md', '[In English](hub.md)'), 'In English');
  assert.equal(shown('console.md', '[console.ru.md](console.ru.md)'), 'Пульт');
  assert.equal(shown('hub.md', '[the API](hub-api.md)'), 'the API');
});

test('strings of a program become sums, in every kind of quotes, and nothing else changes', () => {
  globalThis.lafetBase = '/a/b/';
  const run = (text) => Function(`return ${program(`(${text})`)}`)();
  assert.equal(run(`"${PLACE}x.js"`), '/a/b/x.js');
  assert.equal(run(`'say "${PLACE}"'.length`), 'say "/a/b/"'.length);
  assert.equal(run(`\`\${1+1}${PLACE}\``), '2/a/b/');
  assert.equal(run(`JSON.parse("{\\"base\\":\\"${PLACE}\\"}").base`), '/a/b/');
  // A quote in a regular expression opens no string.
  assert.equal(run(`["'".replace(/["']/, ''), "${PLACE}"].join('')`), '/a/b/');
  assert.equal(run(`"${PLACE}" + "${PLACE}"`), '/a/b//a/b/');
  assert.equal(program('const a = "/other/";'), 'const a = "/other/";');
  delete globalThis.lafetBase;
});

test('a page names its files from where it is', () => {
  const html = `<html lang="ru"><head></head><a href="${PLACE}x.html" aria-label="Main Navigation">x</a></html>`;
  assert.match(pageAt(html, 0), /href="\.\/x\.html" aria-label="Разделы сайта"/);
  assert.match(pageAt(html, 2), /<script>globalThis\.lafetBase=new URL\("\.\.\/\.\.\/"/);
  assert.match(pageAt(html, 2), /href="\.\.\/\.\.\/x\.html"/);
});

test('words are compared without endings, in both languages', () => {
  for (const form of ['лафетный', 'лафетного', 'Лафетными', 'ЛАФЕТНЫЕ']) assert.equal(term(form), term('лафетный'));
  for (const form of ['ствола', 'стволы', 'стволами', 'Ствол']) assert.equal(term(form), 'ствол');
  assert.equal(term('счётчик'), term('счетчики'));
  assert.equal(term('monitors'), term('monitor'));
  assert.notEqual(term('затвор'), term('ствол'));
  // Names of the protocol are not words of a language.
  assert.equal(term('GetStatus2'), 'getstatus2');
  assert.ok(term('а'.repeat(100_000)).length <= 64);
  // Neither indexed nor asked for.
  for (const common of ['не', 'Как', 'the', 'Not']) assert.equal(term(common), '');
});

const HELP = `About it\n\nUsage: lafet [COMMAND]\n\nCommands:\n  status  Shows | it\n          in full\n  sim     Simulates\n\nOptions:\n  -h  Help\n`;

test('commands are read from the help', () => {
  assert.deepEqual(commandsIn(HELP, 'Commands:'), [
    { name: 'status', about: 'Shows | it in full' },
    { name: 'sim', about: 'Simulates' },
  ]);
  assert.deepEqual(commandsIn('Usage: lafet status\n', 'Commands:'), []);
});

test('every command has its help, those below it as well', () => {
  const asked = [];
  const ask = (lang, words) => {
    asked.push(`${lang} ${words.join(' ')}`.trim());
    const heading = lang === 'en' ? 'Commands:' : 'Команды:';
    if (words.length === 0) return HELP.replace('Commands:', heading);
    return words.join() === 'sim' ? `${heading}\n  run  Runs <FILE>\n` : 'no more\n';
  };
  const pages = new Map(cli(ask));
  assert.deepEqual([...pages.keys()].sort(), [
    'cli/index.md',
    'cli/sim.md',
    'cli/status.md',
    'ru/cli/index.md',
    'ru/cli/sim.md',
    'ru/cli/status.md',
  ]);
  assert.ok(asked.includes('ru sim run') && asked.includes('en status'));
  assert.match(pages.get('cli/index.md'), /`lafet status`\]\(\.\/status\.md\) \| Shows \\\| it in full \|/);
  assert.match(pages.get('cli/sim.md'), /## lafet sim run/);
  assert.throws(() => cli(() => 'nothing'), /lists no command/);
  assert.throws(() => cli((lang) => `${lang === 'en' ? 'Commands:' : 'Команды:'}\n  again  Forever\n`), /too deeply/);
});

test('types are said in words', () => {
  const link = (name) => `<${name}>`;
  assert.equal(type({ type: 'integer', minimum: 0, maximum: 9 }, link), 'integer 0 … 9');
  assert.equal(type({ oneOf: [{ $ref: '#/a/B' }, { type: 'null' }] }, link), '<B> or null');
  assert.equal(type({ type: 'array', items: { enum: ['a', 'b'] } }, link), 'array of `"a"`, `"b"`');
  assert.equal(type({ type: ['string', 'null'] }, link), 'string or null');
  assert.match(structure({ properties: { a: { type: 'string' } }, required: ['a'] }, link), /\| `a` \| string \|/);
  assert.equal(table(['a', 'b'], [['1', '']]), '| a |\n|---|\n| 1 |');
});

test('the API has a place for each operation, and a link to each structure', () => {
  const pages = new Map(api());
  const structures = pages.get('api/structures.md');
  for (const [name, text] of pages) {
    for (const [, anchor] of text.matchAll(/structures\.md#([^)]+)\)/g)) {
      const heading = structures.split('\n').some((line) => line.startsWith('## ') && slug(line.slice(3)) === anchor);
      assert.ok(heading, `${name}: ${anchor}`);
    }
  }
  assert.match(pages.get('api/monitors.md'), /## POST \/api\/monitors\/\{id\}\/stop/);
  const strange = { paths: { '/api/a': { query: {} } }, components: { schemas: {} }, info: { description: '' } };
  assert.throws(() => api(strange), /no method known/);
});

test('parameters have words in both languages, or the build says which lack them', () => {
  const [[en], [ru]] = parameters();
  assert.deepEqual([en, ru], ['parameters.md', 'ru/parameters.md']);
  const params = [
    {
      subsystem: 'S',
      name: 'N',
      text: { en: '' },
      unit: { en: '' },
      elements: [],
      effect: 'new',
      access: 'read-write',
    },
  ];
  assert.throws(() => parameters({ params, subsystems: [{ name: 'S', en: 's' }] }), /`new` has no words/);
});

test('the frame has the same texts in both languages', () => {
  const keys = (of) =>
    Object.entries(of).flatMap(([key, value]) => (typeof value === 'object' ? [key, ...keys(value)] : [key]));
  assert.deepEqual(keys(WORDS.ru), keys(WORDS.en));
  assert.equal(labelled('<i title="Copy Code">', 'en'), '<i title="Copy Code">');
  assert.equal(labelled('<i title="Copy Code">', 'ru'), `<i title="${LABELS.ru['Copy Code']}">`);
});

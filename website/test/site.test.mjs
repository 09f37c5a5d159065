// The built site as files: what a server without any cleverness hands out.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync, statSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import MiniSearch from 'minisearch';
import { PLACE } from '../build/relative.mjs';
import { DIST } from '../build/server.mjs';
import { sources } from '../build/sources.mjs';
import { GROUPS, IN_ENGLISH, READERS } from '../site/navigation.mjs';
import { MINI_SEARCH } from '../site/search.mjs';

const files = readdirSync(DIST, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile())
  .map((entry) => path.relative(DIST, path.join(entry.parentPath, entry.name)));
const ours = files.filter((file) => !file.startsWith('playground/'));
const pages = ours.filter((file) => file.endsWith('.html') && file !== '404.html');
const text = (file) => readFileSync(path.join(DIST, file), 'utf8');
const html = new Map(pages.map((file) => [file, text(file)]));
/** A page has this; the message does not repeat the page. */
function has(file, pattern, wanted = true) {
  assert.equal(pattern.test(html.get(file)), wanted, `${file}: ${pattern}`);
}
const decoded = (value) => value.replaceAll('&amp;', '&').replaceAll('&quot;', '"').replaceAll('&#39;', "'");

test('every source has its page, every page of the navigation is there', () => {
  for (const [source, page] of sources()) assert.ok(html.has(page.replace(/\.md$/, '.html')), source);
  const all = GROUPS.flatMap((group) => group.pages);
  for (const { path: name } of all) {
    assert.ok(html.has(`${name}.html`) && html.has(`ru/${name}.html`), name);
  }
  assert.ok(pages.length > 150, `${pages.length}`);
});

test('every link of every page leads to a file that is there, and to an anchor in it', () => {
  const anchors = new Map(
    [...html].map(([file, page]) => [file, new Set([...page.matchAll(/ id="([^"]+)"/g)].map((it) => decoded(it[1])))]),
  );
  const broken = [];
  let seen = 0;
  for (const [file, page] of html) {
    for (const [, raw] of page.matchAll(/<a [^>]*href="([^"]*)"/g)) {
      const href = decoded(raw);
      if (/^[a-z]+:/i.test(href)) continue;
      seen += 1;
      const [address, anchor] = href.split('#');
      const place = address === '' ? file : path.normalize(path.join(path.dirname(file), decodeURI(address)));
      const named = address.endsWith('/') || place === '.' ? path.join(place, 'index.html') : place;
      if (!existsSync(path.join(DIST, named)) || statSync(path.join(DIST, named)).isDirectory()) {
        broken.push(`${file}: ${href}`);
      } else if (anchor && anchors.has(named) && !anchors.get(named).has(decodeURIComponent(anchor))) {
        broken.push(`${file}: ${href}: no such anchor`);
      }
    }
  }
  assert.deepEqual(broken, []);
  assert.ok(seen > 5000, `${seen}`);
});

test('nothing names the folder of the build or another server', () => {
  for (const file of ours.filter((name) => /\.(html|js|css)$/.test(name))) {
    assert.ok(!text(file).includes(PLACE), file);
  }
  for (const [file, page] of html) {
    const assets = [...page.matchAll(/<(?:script|link|img|source|iframe)[^>]*(?:src|href)="([^"]*)"/g)].map(
      (it) => it[1],
    );
    assert.ok(assets.length > 0, file);
    for (const asset of assets) assert.match(asset, /^\.{1,2}\/|^data:/, `${file}: ${asset}`);
  }
  for (const file of ours.filter((name) => name.endsWith('.css'))) {
    for (const [, address] of text(file).matchAll(/url\(["']?([^"')]+)/g)) assert.match(address, /^data:|^\.|^#/, file);
  }
});

test('a page reads without scripts: its text and its links are in the file', () => {
  has('ru/operator.html', /<html lang="ru"/);
  has('ru/operator.html', /<h1[^>]*>Оператору: начните здесь/);
  has('ru/operator.html', /href="\.\.\/ru\/console\.html"|href="\.\/console\.html"/);
  has('index.html', /<h1[^>]*>lafet/);
});

test('each reader has a start page in both languages, one link from the first page', () => {
  for (const name of READERS) {
    has('index.html', new RegExp(`href="\\./${name}\\.html"`));
    has('ru/index.html', new RegExp(`href="(\\./|\\.\\./ru/)${name}\\.html"`));
  }
});

test('what is only in English is marked so, in the side bar and in the text', () => {
  const [english] = /<a [^>]*href="\.\.\/design\.html"[^>]*>.*?<\/a>/s.exec(html.get('ru/protocol.html'));
  assert.ok(english.includes(IN_ENGLISH), english);
  has('ru/developer.html', /href="(?:\.\/)?\.\.\/performance\.html"[^>]*>Измерения<\/a> \(по-английски\)/);
  has('ru/developer.html', />Управляющая сторона<\/a> \(по-английски\)/, false);
  has('ru/design.html', /Эта страница есть только по-английски/);
});

test('a link of the repository without a page is text, not dead', () => {
  has('evidence.html', /<span title="crates\/device\/src\/cause\.rs" class="in-repository">/);
  has('evidence.html', /href="[^"]*crates\//, false);
});

test('code is as it was written: nothing in braces or angle brackets is taken for a template', () => {
  assert.ok(text('footprint.html').length > 1000);
  has('api/monitors.html', /GET \/api\/monitors\/\{id\}/);
  has('ru/cli/param.html', /lafet param/);
  has('protocol.html', /&lt;TAB&gt;/);
});

/** The search as the site has it: its index, its options. */
async function searchOf(language) {
  globalThis.lafetBase = '/';
  const [name] = readdirSync(path.join(DIST, 'assets/chunks')).filter((file) =>
    file.startsWith(`@localSearchIndex${language}.`),
  );
  const { default: index } = await import(pathToFileURL(path.join(DIST, 'assets/chunks', name)));
  const fields = { fields: ['title', 'titles', 'text'], storeFields: ['title', 'titles'] };
  const found = MiniSearch.loadJSON(index, {
    ...fields,
    ...MINI_SEARCH.options,
    searchOptions: MINI_SEARCH.searchOptions,
  });
  return (words) => found.search(words).map((one) => one.id);
}

test('the search finds Russian words in every form', async () => {
  const search = await searchOf('ru');
  const first = (words, count = 16) => search(words).slice(0, count);
  const same = (a, b) => assert.deepEqual(first(a, 5), first(b, 5), `${a} / ${b}`);
  same('лафетного ствола', 'лафетный ствол');
  same('АВАРИЙНОЙ БЛОКИРОВКИ', 'аварийная блокировка');
  same('счётчики', 'счетчик');
  assert.ok(first('лафетного ствола').length > 3);
  assert.ok(
    first('удерживаемых движений').some((id) => id.startsWith('/ru/client.html')),
    `${first('удерживаемых движений')}`,
  );
  assert.ok(first('юстировку извещателя').length > 0);
  assert.deepEqual(search('бетономешалка'), []);
});

test('the search finds English words, names of the protocol and commands', async () => {
  const search = await searchOf('root');
  const finds = (words, page) =>
    assert.ok(
      search(words)
        .slice(0, 16)
        .some((id) => id.startsWith(page)),
      `${words}: ${search(words).slice(0, 8)}`,
    );
  finds('deploying a barrel', '/');
  finds('held motions', '/client.html');
  finds('lafet doctor', '/');
  finds('AmperageOverload', '/');
  assert.deepEqual(search('xylophonist'), []);
});

import { existsSync } from 'node:fs';
import path from 'node:path';
import { defineConfig } from 'vitepress';
import { permalink, reader } from '../build/markdown.mjs';
import { PLACE } from '../build/relative.mjs';
import { PAGES, slug, sources, WEBSITE } from '../build/sources.mjs';
import { GROUPS, IN_ENGLISH, LANGUAGES, READERS } from '../site/navigation.mjs';
import { MINI_SEARCH, term } from '../site/search.mjs';
import { WORDS } from '../site/words.mjs';

// VitePress hands the search's functions to the browser as text, so they may use nothing but what is global there:
// theme/index.mjs provides the same word.
globalThis.lafetTerm = term;

const known = sources();
const pages = new Set(known.values());
const made = new Set([...pages].map((page) => page.replace(/\.md$/, '')));
/** Whether a page has a Russian form; the generated reference has one where `build` makes it. */
const inRussian = (name) => made.has(`ru/${name}`) || ['cli/index', 'parameters'].includes(name);
const ALL_PAGES = GROUPS.flatMap((group) => group.pages);
const hasPlayground = existsSync(path.join(PAGES, 'public/playground/index.html'));

function item({ path: name, title }, { id, folder }) {
  const address = name.replace(/index$/, '');
  if (id === 'en') return { text: title.en, link: `/${address}` };
  if (inRussian(name)) return { text: title.ru, link: `/${folder}${address}` };
  return { text: `${title.ru} ${IN_ENGLISH}`, link: `/${address}` };
}

function locale(language) {
  const { id, folder } = language;
  const words = WORDS[id];
  const reader = (name) => ALL_PAGES.find((page) => page.path === name);
  const group = (name) => GROUPS.find((one) => one.pages.some((page) => page.path === name)).title[id];
  const readers = READERS.map((name) => ({ ...item(reader(name), language), text: group(name) }));
  const reference = GROUPS.at(-1).pages.map((page) => item(page, language));
  const playground = hasPlayground ? [{ text: words.playground, link: '/playground/', target: '_self' }] : [];
  return {
    label: words.label,
    lang: words.lang,
    link: `/${folder}`,
    title: words.title,
    description: words.description,
    themeConfig: {
      nav: [...playground, { text: words.readers, items: readers }, { text: words.reference, items: reference }],
      // A group leads to its first page: that of its reader, where it has one.
      sidebar: GROUPS.map(({ title, pages: all }) => ({
        text: title[id],
        link: item(all[0], language).link,
        collapsed: true,
        items: all.filter(({ path: name }) => !READERS.includes(name)).map((page) => item(page, language)),
      })),
      outline: { level: [2, 3], label: words.outline },
      docFooter: { prev: words.previous, next: words.next },
      darkModeSwitchLabel: words.appearance,
      lightModeSwitchTitle: words.light,
      darkModeSwitchTitle: words.dark,
      sidebarMenuLabel: words.menu,
      returnToTopLabel: words.top,
      langMenuLabel: words.languages,
      skipToContentLabel: words.skip,
      footer: { message: words.footer },
      notFound: words.missing,
    },
  };
}

export default defineConfig({
  srcDir: path.relative(WEBSITE, PAGES),
  outDir: 'dist',
  // Any file server finds `page.html`; build/relative.mjs makes the addresses independent of the folder.
  cleanUrls: false,
  base: PLACE,
  ignoreDeadLinks: false,
  lastUpdated: false,
  appearance: true,
  head: [['link', { rel: 'icon', href: `${PLACE}icon.svg`, type: 'image/svg+xml' }]],
  locales: Object.fromEntries(LANGUAGES.map((one) => [one.id === 'en' ? 'root' : one.id, locale(one)])),
  themeConfig: {
    logo: '/icon.svg',
    externalLinkIcon: false,
    search: {
      provider: 'local',
      options: {
        locales: {
          root: { translations: WORDS.en.search },
          ru: { translations: WORDS.ru.search },
        },
        miniSearch: {
          options: { processTerm: (word) => globalThis.lafetTerm(word) },
          searchOptions: MINI_SEARCH.searchOptions,
        },
      },
    },
  },
  markdown: {
    attrs: { disable: true },
    toc: { slugify: slug },
    anchor: { slugify: slug, permalink },
    headers: { slugify: slug },
    theme: { light: 'github-light-high-contrast', dark: 'github-dark-high-contrast' },
    config: reader(known),
  },
  vite: { publicDir: path.join(PAGES, 'public'), logLevel: 'warn', build: { chunkSizeWarningLimit: 6000 } },
});

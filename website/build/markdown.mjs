// How the Markdown of the project is read: links between files become links between pages.
import { GROUPS, IN_ENGLISH } from '../site/navigation.mjs';
import { between, target } from './sources.mjs';

/** Page (without its ending) → its title in both languages. */
const TITLES = new Map(GROUPS.flatMap((group) => group.pages).map((page) => [page.path, page.title]));

/** Languages of code that are coloured; the grammars of lafet's own (`send`, `ebnf`) are text. */
const COLOURED = new Set(['sh', 'toml', 'json', 'c', 'rust', 'python', 'py', 'yaml', 'html', 'text']);

/** What `markdown.config` of VitePress takes; `known` is source → page. */
export function reader(known) {
  const pages = new Map([...known].map(([source, page]) => [page, source]));
  const russian = (page) => known.size > 0 && pages.has(`ru/${page}`);
  return (md) => {
    // `:name:` is text in these pages.
    md.core.ruler.disable('emoji', true);
    md.core.ruler.push('links', (state) => {
      const page = state.env.relativePath;
      const source = pages.get(page);
      if (!source) return;
      for (const token of state.tokens) {
        if (token.type === 'fence' && !COLOURED.has(token.info.trim())) token.info = 'text';
        if (token.type === 'inline') token.children = rewritten(token.children, { known, source, page, russian });
      }
    });
    const text = md.renderer.rules.text;
    md.renderer.rules.text = (...all) => text(...all).replaceAll('{{', '&#123;&#123;');
    md.renderer.rules.table_open = () => '<div class="table"><table>\n';
    md.renderer.rules.table_close = () => '</table></div>\n';
    // A column without a title has no heading that a screen reader could announce.
    const empty = (tokens, index) => tokens[index].content === '';
    md.renderer.rules.th_open = (tokens, index, options, _env, self) => {
      if (empty(tokens, index + 1)) tokens[index].tag = 'td';
      return self.renderToken(tokens, index, options);
    };
    md.renderer.rules.th_close = (tokens, index, options, _env, self) => {
      if (empty(tokens, index - 1)) tokens[index].tag = 'td';
      return self.renderToken(tokens, index, options);
    };
  };
}

/** The link to a heading behind it, named in the language of the page. */
export function permalink(anchor, _options, state, index) {
  const title = state.tokens[index + 1].children.map((token) => token.content).join('');
  const link = new state.Token('link_open', 'a', 1);
  const label = state.env.relativePath.startsWith('ru/') ? `Ссылка на «${title}»` : `Link to “${title}”`;
  link.attrs = [
    ['class', 'header-anchor'],
    ['href', `#${anchor}`],
    ['aria-label', label],
  ];
  const sign = new state.Token('html_inline', '', 0);
  sign.content = '&ZeroWidthSpace;';
  state.tokens[index + 1].children.push(link, sign, new state.Token('link_close', 'a', -1));
}

function rewritten(tokens, { known, source, page, russian }) {
  const out = [];
  let closing = null;
  for (const [index, token] of tokens.entries()) {
    if (token.type === 'image') picture(token, { source, page });
    if (token.type === 'link_open') {
      closing = open(token, { known, source, page, russian, after: textAfter(tokens, index) });
      if (closing?.title && tokens[index + 2]?.type === 'link_close' && isFile(tokens[index + 1], closing.file)) {
        tokens[index + 1].content = closing.title;
        // The name of the file said which language it is in.
        closing.mark ||= closing.english;
      }
      out.push(token);
    } else if (token.type === 'link_close') {
      out.push(token);
      if (closing?.tag) token.tag = closing.tag;
      if (closing?.mark) out.push(word(token, ` ${IN_ENGLISH}`));
      closing = null;
    } else {
      out.push(token);
    }
  }
  return out;
}

/** Changes a link; what its end needs. */
function open(token, { known, source, page, russian, after }) {
  const href = token.attrGet('href');
  const leads = target(known, source, href);
  if (!leads) return null;
  if (leads.repository !== undefined) {
    // There is no page of it: its place in the repository is a hint.
    token.type = 'span_open';
    token.tag = 'span';
    token.attrs = [
      ['title', leads.repository],
      ['class', 'in-repository'],
    ];
    return { tag: 'span' };
  }
  if (leads.file) {
    token.attrSet('href', between(page, leads.file));
    token.attrSet('target', '_self');
    return null;
  }
  const address = leads.page === page ? '' : between(page, leads.page);
  token.attrSet('href', leads.anchor === undefined ? address : `${address}#${leads.anchor}`);
  const english = page.startsWith('ru/') && !leads.page.startsWith('ru/') && !/по-английски|английск/.test(after);
  const mark = english && !russian(leads.page);
  return { mark, english, title: titleOf(leads.page, page), file: href.split('#')[0] };
}

/** What a page calls another one where its source names a file: readers of the site have no files. */
function titleOf(leads, page) {
  const title = TITLES.get(leads.replace(/^ru\//, '').replace(/\.md$/, ''));
  if (!title) return null;
  if (page.startsWith('ru/')) return `«${title.ru}»`;
  return leads.startsWith('ru/') ? title.ru : title.en;
}

function isFile(token, file) {
  return token.type === 'text' && token.content.endsWith('.md') && `/${file}`.endsWith(`/${token.content}`);
}

/** The pictures are in one folder for both languages. */
function picture(token, { source, page }) {
  const src = token.attrGet('src');
  const leads = target(new Map(), source, src);
  if (leads?.repository?.startsWith('docs/images/')) {
    token.attrSet('src', between(page, leads.repository.slice('docs/'.length)));
  }
}

/** The text around the link's end: a page that says itself that it is English needs no mark. */
function textAfter(tokens, index) {
  const end = tokens.findIndex((token, at) => at > index && token.type === 'link_close');
  const near = tokens.slice(index, end + 2).map((token) => token.content);
  return near.join(' ').slice(0, 200);
}

function word(like, content) {
  const token = new like.constructor('text', '', 0);
  token.content = content;
  return token;
}

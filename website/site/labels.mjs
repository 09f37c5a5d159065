// What VitePress itself says in English, for pages in other languages: labels for screen readers, and titles.
export const LABELS = {
  ru: {
    'Main Navigation': 'Разделы сайта',
    'Sidebar Navigation': 'Страницы',
    'mobile navigation': 'Меню',
    'extra navigation': 'Ещё',
    'toggle section': 'Развернуть или свернуть раздел',
    'Copy Code': 'Копировать',
    'Table of Contents for current page': 'Содержание страницы',
    Pager: 'Соседние страницы',
  },
};
const ATTRIBUTES = ['aria-label', 'title'];

/** In a page as text. */
export function labelled(html, lang) {
  let text = html;
  for (const [en, other] of Object.entries(LABELS[lang] ?? {})) {
    for (const name of ATTRIBUTES) text = text.replaceAll(`${name}="${en}"`, `${name}="${other}"`);
    text = text.replaceAll(new RegExp(`>\\s*${en}\\s*<`, 'g'), `>${other}<`);
  }
  return text;
}

/** In a page that is open. */
export function relabel(root, lang) {
  const words = LABELS[lang] ?? {};
  for (const name of ATTRIBUTES) {
    for (const one of root.querySelectorAll(`[${name}]`)) {
      const other = words[one.getAttribute(name)];
      if (other) one.setAttribute(name, other);
    }
  }
  for (const one of root.querySelectorAll('.visually-hidden')) {
    if (one.childElementCount === 0 && words[one.textContent.trim()]) one.textContent = words[one.textContent.trim()];
  }
}

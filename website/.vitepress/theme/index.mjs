import { useData, useRoute } from 'vitepress';
import Theme from 'vitepress/theme-without-fonts';
import { h, nextTick, onMounted, watch } from 'vue';
import { relabel } from '../../site/labels.mjs';
import { term } from '../../site/search.mjs';
import { absolute } from './absolute.mjs';
import { followSearch } from './accessible.mjs';
import { speak } from './playground.mjs';
import { scrollable } from './scrollable.mjs';
import './style.css';
import './print.css';

// The search's options come from the configuration as text: this is the word that they use.
globalThis.lafetTerm = term;

/** What is shown at an address that has no page. */
function missing() {
  const { theme, site, localeIndex } = useData();
  const { title, quote, linkText } = theme.value.notFound;
  const first = site.value.base + (localeIndex.value === 'root' ? '' : `${localeIndex.value}/`);
  return h('main', { class: 'missing' }, [h('h1', title), h('p', quote), h('a', { href: first }, linkText)]);
}

export default {
  extends: Theme,
  Layout: () => h(Theme.Layout, null, { 'not-found': () => h(missing) }),
  setup() {
    const route = useRoute();
    const { isDark, lang } = useData();
    const reach = async () => {
      await nextTick();
      scrollable(document);
      relabel(document.body, lang.value);
    };
    onMounted(() => {
      absolute(document);
      followSearch();
      speak(document, () => lang.value);
      reach();
      window.addEventListener('resize', reach);
    });
    watch(() => [route.path, isDark.value], reach);
  },
};

// Words as the search compares them: without endings, in lower case, ё as е. Used when the index is built and when it
// is asked.
import { stemmer as english } from '@orama/stemmers/english';
import { stemmer as russian } from '@orama/stemmers/russian';

/** Longer than any word of the pages: what is pasted into the field is bounded. */
const WORD_MAX = 64;

/** The stem of a word; its script decides the language. */
export function term(word) {
  const plain = word.slice(0, WORD_MAX).toLowerCase().replaceAll('ё', 'е');
  if (/^[а-я]+$/.test(plain)) return russian(plain);
  return /^[a-z]+$/.test(plain) ? english(plain) : plain;
}

/** The options of MiniSearch. */
export const MINI_SEARCH = {
  options: { processTerm: term },
  searchOptions: {
    // Half-typed words are found; mistyped ones too, if they are long enough.
    prefix: (word) => word.length > 2,
    fuzzy: (word) => (word.length > 4 ? 0.2 : false),
    boost: { title: 4, text: 2, titles: 1 },
  },
};

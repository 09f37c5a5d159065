/** Where the playground, on the same server, looks for its language (playground/src/i18n). */
const KEY = 'lafet.lang';

/** The playground opens in the language of the page that leads to it; `language` asks for that. */
export function speak(root, language) {
  root.addEventListener('click', ({ target }) => {
    const link = target.closest?.('a[href]');
    if (!link || !new URL(link.href).pathname.endsWith('/playground/')) return;
    try {
      localStorage.setItem(KEY, language());
    } catch {
      // Where nothing is kept, it follows the browser.
    }
  });
}

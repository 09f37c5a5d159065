/**
 * The built pages have addresses relative to where they are (build/relative.mjs). The frame stays while the page in it
 * changes, so what it has must not depend on the page that was opened first.
 */
export function absolute(root) {
  for (const link of root.querySelectorAll('a[href], link[rel=icon]')) {
    const written = link.getAttribute('href');
    if (/^([a-z][a-z0-9+.-]*:|\/|#)/i.test(written)) continue;
    const { pathname, search, hash } = new URL(link.href);
    link.setAttribute('href', pathname + search + hash);
  }
  for (const picture of root.querySelectorAll('img[src]')) picture.src = new URL(picture.src).href;
}

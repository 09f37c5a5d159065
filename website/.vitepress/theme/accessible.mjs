/** What VitePress gives the box of the search in addition is contradictory: it is a dialog with a list of links. */
function asDialog(box) {
  box.setAttribute('role', 'dialog');
  for (const name of ['aria-expanded', 'aria-haspopup', 'aria-owns']) box.removeAttribute(name);
  for (const list of box.querySelectorAll('[role=listbox]')) list.removeAttribute('role');
  for (const row of box.querySelectorAll('li')) {
    for (const name of ['role', 'aria-selected']) row.removeAttribute(name);
  }
  for (const link of box.querySelectorAll('a.result')) link.removeAttribute('aria-label');
  for (const key of box.querySelectorAll('kbd[aria-label]')) key.setAttribute('role', 'img');
  for (const input of box.querySelectorAll('input')) {
    for (const name of ['aria-activedescendant', 'aria-autocomplete', 'aria-controls']) input.removeAttribute(name);
  }
}

/** Follows the box of the search from its opening on. */
export function followSearch() {
  const changes = { childList: true, subtree: true, attributes: true };
  new MutationObserver(() => {
    const box = document.querySelector('.VPLocalSearchBox');
    if (box) asDialog(box);
  }).observe(document.body, { ...changes, attributeFilter: ['aria-selected', 'aria-activedescendant'] });
}

/** What scrolls sideways can be reached with the keyboard, and only that. */
export function scrollable(root) {
  for (const box of root.querySelectorAll('.table')) {
    if (box.scrollWidth > box.clientWidth) box.setAttribute('tabindex', '0');
    else box.removeAttribute('tabindex');
  }
}

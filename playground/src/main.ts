import '../../console/src/theme/tokens.css';
import '../../console/src/theme/base.css';
import './app';

// As the system has it, until the button is pressed.
const dark = matchMedia('(prefers-color-scheme: dark)');
const follow = (): void => {
  document.documentElement.dataset.theme = dark.matches ? 'night' : 'day';
};
dark.addEventListener('change', follow);
follow();

import './theme/tokens.css';
import './theme/base.css';
import { loadLang } from './i18n';
import { LfApp } from './shell/app';

await loadLang();
customElements.define('lf-app', LfApp);

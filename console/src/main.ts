import './theme/tokens.css';
import './theme/base.css';
import { applyDisplay } from './theme/display';
import { loadLang } from './i18n';
import { LfApp } from './shell/app';
import { loadPage, router } from './shell/router';
import { applyTheme } from './shell/settings';

applyTheme();
applyDisplay();
// Its code comes while the texts do.
loadPage(router.route.page).catch(() => {});
await loadLang();
customElements.define('lf-app', LfApp);

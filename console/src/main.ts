import './theme/tokens.css';
import './theme/base.css';
import { http } from './hub/http';
import { loadLang } from './i18n';
import { LfApp } from './shell/app';
import { loadPage, router } from './shell/router';
import { applyTheme } from './shell/settings';
import { applyDisplay } from './theme/display';

applyTheme();
applyDisplay();
// The session, the page's code and the texts are loaded at the same time.
http.early();
loadPage(router.route.page).catch(() => {});
await loadLang();
customElements.define('lf-app', LfApp);

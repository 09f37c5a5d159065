// Icons of our own: 24 × 24, one line, the colour of the text.
import { html, type SVGTemplateResult, svg, type TemplateResult } from 'lit';
import { styled } from './styled';

const STILL = styled({ flex: 'none', display: 'block' });

const PATHS = {
  overview: svg`<rect x="4" y="4" width="7" height="7" rx="1.5"/><rect x="13" y="4" width="7" height="7" rx="1.5"/><rect x="4" y="13" width="7" height="7" rx="1.5"/><rect x="13" y="13" width="7" height="7" rx="1.5"/>`,
  operate: svg`<path d="M5 20h9M7 20v-4h5v4M9.5 16l7-9 2.6 2-6 7"/><path d="M19.5 3.5v2M22 6h-1.5"/>`,
  camera: svg`<rect x="3" y="7" width="12" height="10" rx="2"/><path d="m15 11 6-3.5v9L15 13"/>`,
  zones: svg`<path d="M4 9V5.5A1.500 1.500 0 0 1 5.500 4H9M15 4h3.500A1.500 1.500 0 0 1 20 5.500V9M20 15v3.500a1.500 1.500 0 0 1-1.500 1.500H15M9 20H5.500A1.500 1.500 0 0 1 4 18.500V15"/><path d="M12 7.500c.4 2 3 3.200 3 6a3 3 0 0 1-6 0c0-1.300.7-2.200 1.400-3 .2.700.5 1.200 1 1.500-.3-1.500-.4-3 .6-4.500Z"/>`,
  alarms: svg`<path d="M12 4 2.8 20h18.4L12 4Z"/><path d="M12 10v4.5M12 17.3v.2"/>`,
  events: svg`<path d="M8 6h12M8 12h12M8 18h12"/><path d="M4 6h.01M4 12h.01M4 18h.01"/>`,
  params: svg`<path d="M4 7h9M17 7h3M4 17h3M11 17h9"/><circle cx="15" cy="7" r="2"/><circle cx="9" cy="17" r="2"/>`,
  programs: svg`<path d="M4 18c4 0 4-11 8-11s4 11 8 11"/><circle cx="4" cy="18" r="1.6"/><circle cx="12" cy="7" r="1.6"/><circle cx="20" cy="18" r="1.6"/>`,
  commissioning: svg`<path d="M14.5 6.5a4 4 0 0 0-5.3 5.3L4 17v3h3l5.2-5.2a4 4 0 0 0 5.3-5.3l-2.6 2.6-2.4-.6-.6-2.4 2.6-2.6Z"/>`,
  diagnosis: svg`<path d="M3 12h4l2.5-6 5 12L17 12h4"/>`,
  inspector: svg`<path d="m8 7-5 5 5 5M16 7l5 5-5 5M13.5 5l-3 14"/>`,
  replay: svg`<path d="M4 12a8 8 0 1 0 2.6-5.9"/><path d="M4 4v4.5h4.5M10.5 9v6l5-3-5-3Z"/>`,
  training: svg`<path d="M2.5 9.5 12 5l9.5 4.5L12 14 2.5 9.5Z"/><path d="M6.5 11.7V16c1.5 1.6 3.3 2.4 5.5 2.4s4-.8 5.5-2.4v-4.3"/>`,
  admin: svg`<circle cx="9" cy="8.5" r="3.5"/><path d="M3 19.5c.6-3.5 2.8-5.3 6-5.3s5.4 1.8 6 5.3M16 5.3a3.5 3.5 0 0 1 0 6.4M18 14.8c1.6.8 2.6 2.4 3 4.7"/>`,
  updates: svg`<rect x="7" y="7" width="10" height="10" rx="1.5"/><path d="M10 3.500V7M14 3.500V7M10 17v3.500M14 17v3.500M3.500 10H7M3.500 14H7M17 10h3.500M17 14h3.500"/>`,
  stop: svg`<path d="M8.3 3h7.4L21 8.3v7.4L15.7 21H8.3L3 15.7V8.3L8.3 3Z" fill="currentColor" stroke="none"/><rect x="8" y="8" width="8" height="8" rx="1" fill="var(--stop)" stroke="none"/>`,
  lock: svg`<rect x="5" y="11" width="14" height="9" rx="2"/><path d="M8 11V8a4 4 0 0 1 8 0v3M12 14.5v2"/>`,
  unlock: svg`<rect x="5" y="11" width="14" height="9" rx="2"/><path d="M8 11V8a4 4 0 0 1 7.6-1.8M12 14.5v2"/>`,
  menu: svg`<path d="M4 7h16M4 12h16M4 17h16"/>`,
  close: svg`<path d="m6 6 12 12M18 6 6 18"/>`,
  check: svg`<path d="m5 12.5 4.5 4.5L19 7.5"/>`,
  info: svg`<circle cx="12" cy="12" r="8.5"/><path d="M12 11v5M12 7.7v.2"/>`,
  warning: svg`<path d="M12 4 2.8 20h18.4L12 4Z"/><path d="M12 10v4.5M12 17.3v.2"/>`,
  alarm: svg`<path d="M8.3 3h7.4L21 8.3v7.4L15.7 21H8.3L3 15.7V8.3L8.3 3Z"/><path d="M12 7.5v5.5M12 16.3v.2"/>`,
  link: svg`<path d="M2.5 9.5a14 14 0 0 1 19 0M5.8 13a9.2 9.2 0 0 1 12.4 0M9 16.4a4.5 4.5 0 0 1 6 0M12 19.7v.1"/>`,
  unlinked: svg`<path d="M2.5 9.5a14 14 0 0 1 5.4-3.2M12 5.6a14 14 0 0 1 9.5 3.9M5.8 13a9.2 9.2 0 0 1 5-2.5M15 11.1a9 9 0 0 1 3.2 1.9M12 19.7v.1M4 3l16 17"/>`,
  user: svg`<circle cx="12" cy="8" r="4"/><path d="M4.5 20c.8-4 3.4-6 7.5-6s6.7 2 7.5 6"/>`,
  hand: svg`<path d="M8 12V5.5a1.5 1.5 0 0 1 3 0V11M11 10.500V4a1.500 1.500 0 0 1 3 0v7M14 11V5.500a1.500 1.500 0 0 1 3 0V14c0 4-2 6.500-5.500 6.500-3 0-4.300-1.300-5.700-4L3.900 13c-.6-1.300 1-2.400 2-1.300L8 14"/>`,
  help: svg`<circle cx="12" cy="12" r="8.5"/><path d="M9.500 9.700c.2-1.400 1.200-2.200 2.600-2.200 1.500 0 2.600.9 2.600 2.300 0 2-2.600 2.100-2.600 4M12.100 16.600v.2"/>`,
  settings: svg`<circle cx="12" cy="12" r="2.6"/><circle cx="12" cy="12" r="6.3"/><circle cx="12" cy="12" r="8.2" stroke-width="2.8" stroke-linecap="butt" stroke-dasharray="3.22 3.22"/>`,
  logout: svg`<path d="M10 4H6a2 2 0 0 0-2 2v12a2 2 0 0 0 2 2h4M15 8l4 4-4 4M19 12H9"/>`,
  sun: svg`<circle cx="12" cy="12" r="4"/><path d="M12 2.500v2M12 19.500v2M2.500 12h2M19.500 12h2M5.300 5.300l1.400 1.400M17.300 17.300l1.400 1.400M18.700 5.300l-1.400 1.400M6.700 17.300l-1.400 1.400"/>`,
  moon: svg`<path d="M20 14.500A8.500 8.500 0 1 1 9.500 4a7 7 0 0 0 10.500 10.500Z"/>`,
  water: svg`<path d="M12 3.500c3.500 4.300 5.500 7.300 5.500 10.300a5.500 5.500 0 0 1-11 0c0-3 2-6 5.500-10.300Z"/>`,
  foam: svg`<circle cx="9" cy="14" r="5"/><circle cx="16" cy="9" r="3.500"/><circle cx="17.500" cy="16.500" r="2.500"/>`,
  fire: svg`<path d="M12 3c.5 3.500 5.500 5.500 5.500 11a5.500 5.500 0 0 1-11 0c0-2.500 1.300-4 2.500-5.500.3 1.500 1 2.500 2 3C11.500 8.500 10.500 6 12 3Z"/>`,
  search: svg`<circle cx="10.500" cy="10.500" r="6"/><path d="m15 15 5.500 5.500"/>`,
  sector: svg`<path d="M12 20 4 7.500A15 15 0 0 1 20 7.500L12 20Z"/><path d="M8 14h8M6 10.500h12"/>`,
  deploy: svg`<path d="M5 20h14M12 20v-8M12 12 6 5M6 9V5h4"/>`,
  wrap: svg`<path d="M5 20h14M12 20v-8M12 12H5M8 9l-3 3 3 3"/>`,
  nozzle: svg`<path d="M3 9h7l4-2v10l-4-2H3V9ZM17 8l4-2M17.500 12H22M17 16l4 2"/>`,
  up: svg`<path d="m6 15 6-6 6 6"/>`,
  down: svg`<path d="m6 9 6 6 6-6"/>`,
  left: svg`<path d="m15 6-6 6 6 6"/>`,
  right: svg`<path d="m9 6 6 6-6 6"/>`,
  wide: svg`<path d="M4 12h4M8 12l12-7M8 12l12 7M8 12h12"/>`,
  narrow: svg`<path d="M4 12h16M8 10.500 20 9M8 13.500 20 15"/>`,
  plus: svg`<path d="M12 5v14M5 12h14"/>`,
  minus: svg`<path d="M5 12h14"/>`,
  play: svg`<path d="M8 5v14l11-7L8 5Z"/>`,
  pause: svg`<path d="M8 5v14M16 5v14"/>`,
  download: svg`<path d="M12 4v11M7 11l5 5 5-5M5 20h14"/>`,
  upload: svg`<path d="M12 16V5M7 9l5-5 5 5M5 20h14"/>`,
  refresh: svg`<path d="M19.500 9A8 8 0 0 0 5 8.500M4.500 15A8 8 0 0 0 19 15.500M5 4v4.500h4.500M19 20v-4.500h-4.500"/>`,
  trash: svg`<path d="M5 7h14M10 7V4.500h4V7M7 7l1 13h8l1-13M10.500 11v5.500M13.500 11v5.500"/>`,
  edit: svg`<path d="M4 20h4L19.500 8.500l-4-4L4 16v4ZM13 7l4 4"/>`,
  target: svg`<circle cx="12" cy="12" r="7.500"/><circle cx="12" cy="12" r="2"/><path d="M12 2v4M12 18v4M2 12h4M18 12h4"/>`,
  cube: svg`<path d="M12 3 4 7.500v9L12 21l8-4.500v-9L12 3ZM4 7.500l8 4.500 8-4.500M12 12v9"/>`,
  map: svg`<path d="M3.500 6.500 9 4l6 2.500L20.500 4v13.500L15 20l-6-2.500L3.500 20V6.500ZM9 4v13.500M15 6.500V20"/>`,
  clock: svg`<circle cx="12" cy="12" r="8.500"/><path d="M12 7v5.200l3.500 2"/>`,
  keyboard: svg`<rect x="2.500" y="6" width="19" height="12" rx="2"/><path d="M6 10h.01M9 10h.01M12 10h.01M15 10h.01M18 10h.01M8 14h8"/>`,
  gamepad: svg`<path d="M7 8h10a4.500 4.500 0 0 1 4.400 5.300l-.4 2.200a2.500 2.500 0 0 1-4.400 1L15 14.500H9l-1.600 2a2.500 2.500 0 0 1-4.400-1l-.4-2.200A4.500 4.500 0 0 1 7 8ZM8 10v3M6.500 11.500h3M15.500 10.500h.01M17.500 12.500h.01"/>`,
  simulation: svg`<path d="M9 3h6M10 3v6L4.500 18.500A1.700 1.700 0 0 0 6 21h12a1.700 1.700 0 0 0 1.500-2.500L14 9V3M7.500 15h9"/>`,
  table: svg`<rect x="3.500" y="5" width="17" height="14" rx="2"/><path d="M3.500 10h17M3.500 14.500h17M9.500 10v9"/>`,
  sound: svg`<path d="M4 9.500v5h3.500L12 18.500v-13L7.500 9.500H4Z"/><path d="m16 9.500 5 5M21 9.500l-5 5"/>`,
  dot: svg`<circle cx="12" cy="12" r="4" fill="currentColor" stroke="none"/>`,
} satisfies Record<string, SVGTemplateResult>;

export type IconName = keyof typeof PATHS;

/** An icon; it is decoration: the text beside it says what it means. */
export function icon(name: IconName, size = 20): TemplateResult {
  return html`<svg
    class="icon"
    width=${size}
    height=${size}
    viewBox="0 0 24 24"
    fill="none"
    stroke="currentColor"
    stroke-width="1.8"
    stroke-linecap="round"
    stroke-linejoin="round"
    aria-hidden="true"
    ${STILL}
  >
    ${PATHS[name]}
  </svg>`;
}

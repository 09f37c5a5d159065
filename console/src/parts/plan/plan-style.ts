import { css } from 'lit';

export const planStyle = css`
  :host {
    display: block;
    position: relative;
    min-height: 120px;
    overflow: hidden;
    background: var(--p-surface);
    border-radius: var(--radius, 8px);
    contain: content;
  }
  :host > svg {
    position: absolute;
    inset: 0;
    width: 100%;
    height: 100%;
    touch-action: none;
    user-select: none;
    -webkit-user-select: none;
    outline-offset: -3px;
    border-radius: inherit;
  }
  :host([mode='mini']) {
    background: none;
    min-height: 80px;
  }
  :host([mode='mini']) > svg {
    touch-action: auto;
    pointer-events: none;
  }
  :host(:not([mode='mini'])) > svg {
    cursor: grab;
  }
  :host([tool='sector']) > svg,
  :host([tool='aim']) > svg {
    cursor: crosshair;
  }
  svg:focus:not(:focus-visible) {
    outline: none;
  }
  svg:focus-visible,
  button:focus-visible {
    outline: 3px solid var(--p-focus);
  }
  text {
    font: 500 12px system-ui, sans-serif;
    fill: var(--p-text);
    text-anchor: middle;
  }
  .grid {
    stroke: var(--p-line);
    stroke-width: 1;
    opacity: 0.4;
    fill: none;
  }
  .tank {
    fill: var(--p-raised);
    stroke: var(--p-line-strong);
    stroke-width: 1.5;
  }
  .roof {
    fill: none;
    stroke: var(--p-line);
  }
  .tank-name {
    fill: var(--p-dim);
    paint-order: stroke;
    stroke: var(--p-raised);
    stroke-width: 5px;
    stroke-linejoin: round;
  }
  .wall {
    stroke: var(--p-line-strong);
    stroke-width: 5;
    stroke-linecap: square;
  }
  .ring {
    fill: none;
    stroke: var(--p-line-strong);
    stroke-opacity: 0.45;
    stroke-width: 1;
  }
  .reach {
    fill: none;
    stroke: var(--p-dim);
    stroke-width: 1.25;
    stroke-dasharray: 6 5;
  }
  .ring-name {
    fill: var(--p-dim);
    font-size: 11px;
    paint-order: stroke;
    stroke: var(--p-surface);
    stroke-width: 4px;
    stroke-linejoin: round;
  }
  .ring-name.strong {
    font-weight: 600;
  }
  .hatch {
    stroke: var(--p-line-strong);
    stroke-width: 2;
    opacity: 0.45;
  }
  .forbidden {
    fill: url(#hatch);
    stroke: var(--p-line-strong);
    stroke-opacity: 0.5;
  }
  .fire-area {
    fill: var(--p-fire);
    fill-opacity: 0.22;
    stroke: var(--p-fire);
    stroke-width: 1.5;
  }
  .flame {
    fill: var(--p-fire);
    stroke: var(--p-surface);
    stroke-width: 1.5;
    paint-order: stroke;
  }
  .drop {
    fill: var(--p-water);
  }
  .drop.foam {
    fill: var(--p-line-strong);
  }
  .jet {
    fill: var(--p-water);
    fill-opacity: 0.42;
  }
  .landing {
    fill: none;
    stroke: var(--p-water);
    stroke-width: 2;
  }
  .jet.foam {
    fill: var(--p-dim);
    fill-opacity: 0.35;
  }
  .jet.stale,
  .landing.stale {
    opacity: 0.35;
  }
  .aim {
    stroke: var(--p-text);
    stroke-width: 1.25;
    stroke-opacity: 0.55;
  }
  .aim.stale {
    stroke-dasharray: 2 6;
  }
  .goal {
    stroke: var(--p-accent);
    stroke-width: 1.25;
    stroke-dasharray: 3 5;
  }
  .goal-mark {
    fill: var(--p-surface);
    stroke: var(--p-accent);
    stroke-width: 1.75;
  }
  .hotbed-way {
    fill: var(--p-fire);
    fill-opacity: 0.08;
    stroke: var(--p-fire);
    stroke-opacity: 0.45;
    stroke-dasharray: 4 4;
  }
  .hotbed line {
    stroke: var(--p-fire);
    stroke-width: 2;
  }
  .hotbed path {
    fill: var(--p-surface);
    stroke: var(--p-fire);
    stroke-width: 2;
  }
  .hotbed text {
    font-weight: 700;
    font-size: 11px;
  }
  .monitor {
    cursor: pointer;
  }
  .hit {
    fill: transparent;
  }
  .halo {
    fill: var(--p-accent);
    fill-opacity: 0.16;
  }
  .travel {
    fill: none;
    stroke: var(--p-line-strong);
    stroke-width: 1.5;
  }
  .stop {
    stroke: var(--p-dim);
    stroke-width: 3;
  }
  .body,
  .barrel {
    fill: var(--p-dim);
    stroke: var(--p-surface);
    stroke-width: 2;
    paint-order: stroke;
  }
  .pin {
    fill: var(--p-surface);
  }
  .selected .body,
  .selected .barrel {
    fill: var(--p-accent);
  }
  .selected .travel {
    stroke: var(--p-accent);
    stroke-opacity: 0.7;
  }
  .monitor.warning .body {
    fill: var(--p-medium);
  }
  .monitor.alarm .body {
    fill: var(--p-high);
  }
  .sign {
    stroke: var(--p-surface);
    stroke-width: 2.6;
    stroke-linecap: round;
    fill: none;
  }
  .monitor.stale .body,
  .monitor.stale .barrel {
    fill: var(--p-surface);
    stroke: var(--p-line-strong);
    stroke-width: 1.5;
    stroke-dasharray: 3 2.5;
  }
  .monitor.stale .pin {
    fill: var(--p-line-strong);
  }
  .monitor.stale .sign {
    stroke: var(--p-dim);
  }
  .name {
    font-weight: 650;
  }
  :host([mode='mini']) .name {
    font-size: 11px;
    fill: var(--p-dim);
    paint-order: stroke;
    stroke: var(--p-surface);
    stroke-width: 3px;
  }
  .name-box {
    fill: var(--p-surface);
    stroke: var(--p-line);
  }
  .selected .name-box {
    fill: var(--p-accent);
    stroke: var(--p-accent);
  }
  .selected .name {
    fill: var(--p-on-accent);
  }
  :host([mode='mini']) .selected .name {
    fill: var(--p-text);
  }
  .sector {
    stroke-width: 2;
    fill-opacity: 0.16;
    fill: var(--p-accent);
    stroke: var(--p-accent);
  }
  .sector.running {
    fill: var(--p-water);
    fill-opacity: 0.08;
    stroke: var(--p-water);
    stroke-dasharray: 7 4;
    stroke-width: 1.5;
  }
  .sector.bad {
    stroke: var(--p-medium);
    fill: var(--p-medium);
    stroke-dasharray: 7 4;
  }
  .grip {
    cursor: grab;
    outline: none;
  }
  .grip.left,
  .grip.right {
    cursor: col-resize;
  }
  .knob {
    fill: var(--p-surface);
    stroke: var(--p-accent);
    stroke-width: 2.5;
  }
  .grip.move .knob {
    fill: var(--p-accent);
    stroke: var(--p-surface);
  }
  .grip:focus-visible .knob {
    stroke: var(--p-focus);
    stroke-width: 6;
    paint-order: stroke;
  }
  .sector-label {
    pointer-events: none;
  }
  .sector-label rect {
    fill: var(--p-surface);
    stroke: var(--p-accent);
    filter: drop-shadow(0 1px 3px rgb(0 0 0 / 20%));
  }
  .sector-label text {
    text-anchor: start;
    font-variant-numeric: tabular-nums;
    font-weight: 600;
  }
  .sector-label.bad rect {
    stroke: var(--p-medium);
  }
  .sector-label.bad text:last-of-type {
    fill: var(--p-medium);
  }
  .scale path {
    fill: none;
    stroke: var(--p-dim);
    stroke-width: 1.5;
  }
  .scale text,
  .wind-speed {
    fill: var(--p-dim);
    paint-order: stroke;
    stroke: var(--p-surface);
    stroke-width: 4px;
  }
  .compass circle {
    fill: var(--p-surface);
    stroke: var(--p-line);
  }
  .needle {
    fill: var(--p-text);
  }
  .compass text {
    font-weight: 700;
    font-size: 12px;
  }
  .compass .wind-speed {
    text-anchor: end;
    font-weight: 500;
  }
  .wind {
    fill: none;
    stroke: var(--p-dim);
    stroke-width: 2;
    stroke-linecap: round;
    stroke-linejoin: round;
  }
  .zoom {
    position: absolute;
    right: 12px;
    bottom: 12px;
    display: grid;
    border: 1px solid var(--p-line);
    border-radius: 8px;
    overflow: hidden;
    background: var(--p-surface);
  }
  .zoom button {
    width: 48px;
    height: 48px;
    padding: 0;
    border: 0;
    background: none;
    color: var(--p-text);
    cursor: pointer;
    display: grid;
    place-items: center;
  }
  .zoom button + button {
    border-top: 1px solid var(--p-line);
  }
  .zoom button:hover {
    background: var(--p-raised);
  }
  .zoom button:focus-visible {
    outline-offset: -3px;
  }
  .zoom svg {
    width: 20px;
    height: 20px;
    fill: none;
    stroke: currentcolor;
    stroke-width: 2;
    stroke-linecap: round;
  }
  .hint {
    position: absolute;
    left: 12px;
    top: var(--lf-plan-hint, 12px);
    max-width: min(60%, 420px);
    margin: 0;
    padding: 8px 12px;
    font-size: 13px;
    border-radius: 6px;
    background: var(--p-surface);
    border: 1px solid var(--p-line);
    color: var(--p-dim);
    pointer-events: none;
  }
  .route {
    fill: none;
    stroke: var(--p-accent);
    stroke-width: 2.5;
    stroke-linejoin: round;
    pointer-events: none;
  }
  .route-point {
    cursor: pointer;
  }
  .route-point .hit {
    fill: transparent;
  }
  .route-point .knob {
    fill: var(--p-surface);
    stroke: var(--p-accent);
    stroke-width: 2;
  }
  .route-point text {
    font-weight: 650;
    pointer-events: none;
  }
  .route-point.selected .knob {
    fill: var(--p-accent);
  }
  .route-point.selected text {
    fill: var(--p-on-accent);
  }
`;

import { css } from 'lit';

export const planStyle = css`
  :host {
    display: block;
    position: relative;
    min-height: 120px;
    overflow: hidden;
    background: var(--surface);
    border-radius: var(--radius);
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
    outline: 3px solid var(--focus);
  }
  text {
    font: 500 var(--t-small) system-ui, sans-serif;
    fill: var(--text);
    text-anchor: middle;
  }
  .grid {
    stroke: var(--line);
    stroke-width: 1;
    opacity: 0.4;
    fill: none;
  }
  .tank {
    fill: var(--surface-2);
    stroke: var(--line-strong);
    stroke-width: 1.5;
  }
  .roof {
    fill: none;
    stroke: var(--line);
  }
  .tank-name {
    fill: var(--dim);
    paint-order: stroke;
    stroke: var(--surface-2);
    stroke-width: 5px;
    stroke-linejoin: round;
  }
  .wall {
    stroke: var(--line-strong);
    stroke-width: 5;
    stroke-linecap: square;
  }
  .ring {
    fill: none;
    stroke: var(--line-strong);
    stroke-opacity: 0.45;
    stroke-width: 1;
  }
  .reach {
    fill: none;
    stroke: var(--dim);
    stroke-width: 1.25;
    stroke-dasharray: 6 5;
  }
  .landing-area {
    pointer-events: none;
  }
  .landing-area path {
    fill: none;
    stroke: var(--water);
    stroke-width: 1.5;
  }
  .landing-area .area {
    fill: var(--water);
    fill-opacity: 0.2;
    stroke-dasharray: 2 4;
  }
  .landing-area .outermost {
    stroke-dasharray: 7 4;
  }
  .landing-area.stale {
    opacity: 0.45;
  }
  .ring-name {
    fill: var(--dim);
    font-size: var(--t-tiny);
    paint-order: stroke;
    stroke: var(--surface);
    stroke-width: 4px;
    stroke-linejoin: round;
  }
  .ring-name.strong {
    font-weight: 600;
  }
  .hatch {
    stroke: var(--line-strong);
    stroke-width: 2;
    opacity: 0.45;
  }
  .forbidden {
    fill: url(#hatch);
    stroke: var(--line-strong);
    stroke-opacity: 0.5;
  }
  .keep-out path {
    fill: url(#hatch);
    stroke: var(--high);
    stroke-width: 1.5;
    stroke-dasharray: 6 4;
  }
  .keep-out text,
  .located text {
    fill: var(--text);
    font-size: var(--t-tiny);
    font-weight: 600;
    text-anchor: middle;
    paint-order: stroke;
    stroke: var(--surface);
    stroke-width: 4px;
    stroke-linejoin: round;
  }
  .located ellipse {
    fill: none;
    stroke: var(--line-strong);
    stroke-width: 1.5;
    stroke-dasharray: 4 3;
  }
  .located.sure ellipse {
    fill: var(--fire);
    fill-opacity: 0.22;
    stroke: var(--fire);
    stroke-dasharray: none;
  }
  .fire-area {
    fill: var(--fire);
    fill-opacity: 0.22;
    stroke: var(--fire);
    stroke-width: 1.5;
  }
  .flame {
    fill: var(--fire);
    stroke: var(--surface);
    stroke-width: 1.5;
    paint-order: stroke;
  }
  .drop {
    fill: var(--water);
  }
  .drop.foam {
    fill: var(--line-strong);
  }
  .jet {
    fill: var(--water);
    fill-opacity: 0.42;
  }
  .landing {
    fill: none;
    stroke: var(--water);
    stroke-width: 2;
  }
  .jet.foam {
    fill: var(--dim);
    fill-opacity: 0.35;
  }
  .jet.stale,
  .landing.stale {
    opacity: 0.35;
  }
  .aim {
    stroke: var(--text);
    stroke-width: 1.25;
    stroke-opacity: 0.55;
  }
  .aim.stale {
    stroke-dasharray: 2 6;
  }
  .goal {
    stroke: var(--accent);
    stroke-width: 1.25;
    stroke-dasharray: 3 5;
  }
  .goal-mark {
    fill: var(--surface);
    stroke: var(--accent);
    stroke-width: 1.75;
  }
  .hotbed-way {
    fill: var(--fire);
    fill-opacity: 0.08;
    stroke: var(--fire);
    stroke-opacity: 0.45;
    stroke-dasharray: 4 4;
  }
  .hotbed line {
    stroke: var(--fire);
    stroke-width: 2;
  }
  .hotbed path {
    fill: var(--surface);
    stroke: var(--fire);
    stroke-width: 2;
  }
  .hotbed text {
    font-weight: 700;
    font-size: var(--t-tiny);
  }
  .monitor {
    cursor: pointer;
  }
  .hit {
    fill: transparent;
  }
  .halo {
    fill: var(--accent);
    fill-opacity: 0.16;
  }
  .travel {
    fill: none;
    stroke: var(--line-strong);
    stroke-width: 1.5;
  }
  .stop {
    stroke: var(--dim);
    stroke-width: 3;
  }
  .body,
  .barrel {
    fill: var(--dim);
    stroke: var(--surface);
    stroke-width: 2;
    paint-order: stroke;
  }
  .pin {
    fill: var(--surface);
  }
  .selected .body,
  .selected .barrel {
    fill: var(--accent);
  }
  .selected .travel {
    stroke: var(--accent);
    stroke-opacity: 0.7;
  }
  .monitor.warning .body {
    fill: var(--medium);
  }
  .monitor.alarm .body {
    fill: var(--high);
  }
  .sign {
    stroke: var(--surface);
    stroke-width: 2.6;
    stroke-linecap: round;
    fill: none;
  }
  .monitor.stale .body,
  .monitor.stale .barrel {
    fill: var(--surface);
    stroke: var(--line-strong);
    stroke-width: 1.5;
    stroke-dasharray: 3 2.5;
  }
  .monitor.stale .pin {
    fill: var(--line-strong);
  }
  .monitor.stale .sign {
    stroke: var(--dim);
  }
  .name {
    font-weight: 650;
  }
  :host([mode='mini']) .name {
    font-size: var(--t-tiny);
    fill: var(--dim);
    paint-order: stroke;
    stroke: var(--surface);
    stroke-width: 3px;
  }
  .name-box {
    fill: var(--surface);
    stroke: var(--line);
  }
  .selected .name-box {
    fill: var(--accent);
    stroke: var(--accent);
  }
  .selected .name {
    fill: var(--on-accent);
  }
  :host([mode='mini']) .selected .name {
    fill: var(--text);
  }
  .sector {
    stroke-width: 2;
    fill-opacity: 0.16;
    fill: var(--accent);
    stroke: var(--accent);
  }
  .sector.running {
    fill: var(--water);
    fill-opacity: 0.08;
    stroke: var(--water);
    stroke-dasharray: 7 4;
    stroke-width: 1.5;
  }
  .sector.bad {
    stroke: var(--medium);
    fill: var(--medium);
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
    fill: var(--surface);
    stroke: var(--accent);
    stroke-width: 2.5;
  }
  .grip.move .knob {
    fill: var(--accent);
    stroke: var(--surface);
  }
  .grip:focus-visible .knob {
    stroke: var(--focus);
    stroke-width: 6;
    paint-order: stroke;
  }
  .sector-label {
    pointer-events: none;
  }
  .sector-label rect {
    fill: var(--surface);
    stroke: var(--accent);
    filter: drop-shadow(var(--shadow-knob));
  }
  .sector-label text {
    text-anchor: start;
    font-variant-numeric: tabular-nums;
    font-weight: 600;
  }
  .sector-label.bad rect {
    stroke: var(--medium);
  }
  .sector-label.bad text:last-of-type {
    fill: var(--medium);
  }
  .scale path {
    fill: none;
    stroke: var(--dim);
    stroke-width: 1.5;
  }
  .scale text,
  .wind-speed {
    fill: var(--dim);
    paint-order: stroke;
    stroke: var(--surface);
    stroke-width: 4px;
  }
  .compass circle {
    fill: var(--surface);
    stroke: var(--line);
  }
  .needle {
    fill: var(--text);
  }
  .compass text {
    font-weight: 700;
    font-size: var(--t-small);
  }
  .compass .wind-speed {
    text-anchor: end;
    font-weight: 500;
  }
  .wind {
    fill: none;
    stroke: var(--dim);
    stroke-width: 2;
    stroke-linecap: round;
    stroke-linejoin: round;
  }
  :host([listed]) {
    box-sizing: border-box;
    padding-bottom: var(--listed);
    --listed: calc(var(--touch) + 2 * var(--s1));
  }
  :host([listed]) > svg {
    height: calc(100% - var(--listed));
  }
  :host([listed]) .zoom {
    bottom: calc(var(--listed) + 12px);
  }
  .unplaced {
    position: absolute;
    inset: auto 0 0 0;
    height: var(--listed);
    box-sizing: border-box;
    display: flex;
    align-items: center;
    gap: var(--s1);
    padding: var(--s1) var(--s25);
    overflow-x: auto;
    white-space: nowrap;
    border-top: 1px solid var(--line);
    background: var(--surface-2);
    color: var(--dim);
    font-size: var(--t-note);
  }
  .unplaced button {
    flex: none;
    min-width: var(--touch);
    height: var(--touch);
    padding: 0 var(--s2);
    border: 1px solid var(--line-strong);
    border-radius: var(--radius);
    background: var(--surface);
    color: var(--text);
    font: inherit;
    font-weight: 650;
    cursor: pointer;
  }
  .zoom {
    position: absolute;
    right: 12px;
    bottom: 12px;
    display: grid;
    border: 1px solid var(--line);
    border-radius: var(--radius);
    overflow: hidden;
    background: var(--surface);
  }
  .zoom button {
    width: 48px;
    height: 48px;
    padding: 0;
    border: 0;
    background: none;
    color: var(--text);
    cursor: pointer;
    display: grid;
    place-items: center;
  }
  .zoom button + button {
    border-top: 1px solid var(--line);
  }
  .zoom button:hover {
    background: var(--surface-2);
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
    margin: 0;
    padding: var(--s2) var(--s25);
    font-size: var(--t-note);
    border-radius: var(--radius);
    background: var(--surface);
    border: 1px solid var(--line);
    color: var(--dim);
  }
  .route {
    fill: none;
    stroke: var(--accent);
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
    fill: var(--surface);
    stroke: var(--accent);
    stroke-width: 2;
  }
  .route-point text {
    font-weight: 650;
    pointer-events: none;
  }
  .route-point.selected .knob {
    fill: var(--accent);
  }
  .route-point.selected text {
    fill: var(--on-accent);
  }
`;

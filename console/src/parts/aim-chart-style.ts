import { css } from 'lit';

export const chartStyle = css`
  :host {
    display: block;
    position: relative;
    min-height: 180px;
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
    cursor: grab;
  }
  :host([adding]) > svg {
    cursor: crosshair;
  }
  text {
    font: 500 var(--t-small) system-ui, sans-serif;
    fill: var(--dim);
    text-anchor: middle;
    font-variant-numeric: tabular-nums;
    pointer-events: none;
  }
  text.side {
    text-anchor: start;
  }
  .grid,
  .axis {
    stroke: var(--line);
    fill: none;
    opacity: 0.55;
  }
  .axis {
    stroke: var(--line-strong);
    opacity: 0.7;
  }
  .hatch {
    stroke: var(--line);
    stroke-width: 2;
  }
  .beyond {
    fill: url(#hatch);
    opacity: 0.7;
  }
  .limits {
    fill: none;
    stroke: var(--line-strong);
    stroke-dasharray: 6 4;
  }
  .sector {
    fill: var(--accent);
    fill-opacity: 0.1;
    stroke: var(--accent);
    stroke-dasharray: 3 4;
    cursor: move;
  }
  .way {
    fill: none;
    stroke: var(--water);
    stroke-width: 2.5;
    stroke-linejoin: round;
    pointer-events: none;
  }
  .route {
    stroke: var(--accent);
    stroke-width: 2.5;
  }
  .arrow,
  .begin {
    fill: var(--water);
    pointer-events: none;
  }
  .grip,
  .point {
    cursor: pointer;
    outline: none;
  }
  .hit {
    fill: transparent;
  }
  .grip .knob {
    fill: var(--surface);
    stroke: var(--accent);
    stroke-width: 2.5;
  }
  .grip.move .knob {
    fill: var(--accent);
    stroke: var(--surface);
  }
  .point .knob {
    fill: var(--surface);
    stroke: var(--accent);
    stroke-width: 2;
  }
  .point text {
    fill: var(--text);
    font-weight: 650;
  }
  .point.selected .knob {
    fill: var(--accent);
  }
  .point.selected text {
    fill: var(--on-accent);
  }
  .point.bad .knob {
    stroke: var(--medium);
    stroke-dasharray: 4 3;
  }
  .grip:focus-visible .hit,
  .point:focus-visible .hit {
    stroke: var(--focus);
    stroke-width: 3;
  }
  .barrel {
    pointer-events: none;
  }
  .barrel circle,
  .barrel path {
    fill: none;
    stroke: var(--text);
    stroke-width: 2;
  }
  .barrel text {
    fill: var(--text);
    font-weight: 600;
    paint-order: stroke;
    stroke: var(--surface);
    stroke-width: 4px;
  }
  .barrel.stale {
    opacity: 0.45;
  }
  .zoom {
    position: absolute;
    right: 8px;
    top: 8px;
    display: flex;
    border: 1px solid var(--line);
    border-radius: var(--radius);
    background: var(--surface);
    overflow: hidden;
  }
  .zoom button {
    width: 48px;
    height: 48px;
    border: 0;
    border-left: 1px solid var(--line);
    background: none;
    color: var(--text);
    cursor: pointer;
    display: grid;
    place-items: center;
  }
  .zoom button:first-child {
    border-left: 0;
  }
  .zoom button:hover {
    background: var(--surface-2);
  }
  .zoom button:focus-visible {
    outline: 3px solid var(--focus);
    outline-offset: -3px;
  }
  .zoom svg {
    width: 22px;
    height: 22px;
    fill: none;
    stroke: currentColor;
    stroke-width: 2;
    stroke-linecap: round;
    stroke-linejoin: round;
  }
`;

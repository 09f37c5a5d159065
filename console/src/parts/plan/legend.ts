// Where the water of the chosen monitor lands, in words and figures: on the plan and on the picture in three dimensions.
import { css, html, nothing, type TemplateResult } from 'lit';
import { t } from '../../i18n';
import { lengthText, spanText } from '../words';
import { type LandingArea, strikesText } from './landing';
import { flows, type PlanMonitor, type PlanScene, type PlanSite } from './model';

export const legendStyle = css`
  .landing-legend {
    margin: 0;
    padding: var(--s1) var(--s2);
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    gap: 0 var(--s2);
    font-size: var(--t-small);
    font-variant-numeric: tabular-nums;
    border-radius: var(--radius);
    background: var(--surface);
    border: 1px solid var(--line);
    color: var(--dim);
  }
  .landing-legend strong {
    color: var(--text);
    font-weight: 600;
  }
  .swatch {
    width: 18px;
    height: 12px;
    border: 1.5px dashed var(--water);
    background: color-mix(in srgb, var(--water) 20%, transparent);
  }
  .notes {
    position: absolute;
    left: var(--lf-plan-hint-left, 12px);
    top: var(--lf-plan-hint, 12px);
    /* The wind is beside it. */
    max-width: min(calc(100% - 178px - var(--lf-plan-hint-left, 12px)), 420px);
    display: grid;
    justify-items: start;
    gap: var(--s1);
    pointer-events: none;
  }
  /* The figure is enough where there is no room for more. */
  @media (max-width: 720px) {
    .landing-legend .more {
      display: none;
    }
  }
`;

/** Figures of the landing area, or why it is not shown. */
export function landingLegend(landing: PlanMonitor['landing']): TemplateResult | typeof nothing {
  if (!landing) return nothing;
  if (typeof landing === 'string') {
    const why = t(`parts.plan.landing_${landing}`);
    return html`<p class="landing-legend unknown">${t('parts.plan.landing_unknown', { why })}</p>`;
  }
  const { middle_m, greatest_m, with_wind, strikes } = landing;
  const parts = t('parts.plan.landing_parts', { middle: lengthText(middle_m), greatest: lengthText(greatest_m) });
  return html`<p class="landing-legend">
    <span class="swatch" aria-hidden="true"></span>
    <strong>${landingText(landing)}</strong>
    ${strikes ? html`<span class="strikes">${strikesText(strikes)}</span>` : nothing}
    <span class="more">${parts}</span>
    <span class="more">${t(with_wind ? 'parts.plan.landing_wind' : 'parts.plan.landing_still')}</span>
  </p>`;
}

export function landingText({ near_m, far_m }: LandingArea): string {
  return t('parts.plan.landing', { d: spanText(near_m, far_m) });
}

/** Monitors whose water the picture cannot show as it flows: it says so of each. */
export function unshown(monitors: readonly PlanMonitor[], scene: PlanScene | null): string[] {
  return monitors
    .filter((monitor) => flows(monitor, scene))
    .flatMap(({ id, stale, flight, landing }) => {
      if (stale) return [t('parts.scene.water_old', { id })];
      return !flight && typeof landing === 'string' ? [t('parts.scene.water_unknown', { id })] : [];
    });
}

/** That places are not to scale. */
export function schematicNote(site: PlanSite | null): TemplateResult | typeof nothing {
  if (!site?.schematic) return nothing;
  const [alone = ''] = Object.keys(site.monitors);
  const text = site.unplaced ? t('parts.plan.alone', { id: alone }) : t('parts.plan.schematic');
  return html`<p class="landing-legend schematic">${text}</p>`;
}

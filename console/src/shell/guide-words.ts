// What the guide says of the site that is loaded: every scenario has other monitors, tanks, fires and wind. Pure.
import { plural, t } from '../i18n';
import { distanceTo, type Place, type Tank } from '../parts/geometry';

export interface GuideSite {
  monitors: number;
  tanks: readonly Tank[];
  fires: readonly { at: Place; burns: boolean }[];
  /** East and north, m/s. */
  wind: Place;
}

export type GuideStep = 'welcome' | 'fire' | 'auto';

/** Less wind than this bends no jet to speak of, m/s. */
const AIR_MPS = 0.5;

/** Where the water is to go. */
type Aim = 'tank_fire' | 'fire' | 'tank' | 'place';

function aimOf({ tanks, fires }: GuideSite): Aim {
  const burning = fires.filter(({ burns }) => burns);
  const on = (place: Place) => tanks.some(({ at, diameter }) => distanceTo(at, place) <= diameter / 2);
  if (burning.some(({ at }) => on(at))) return 'tank_fire';
  if (burning.length) return 'fire';
  return tanks.length ? 'tank' : 'place';
}

/** Title and text of a step that speaks of the site. */
export function guideWords(step: GuideStep, site: GuideSite): { title: string; text: string } {
  const aim = aimOf(site);
  const burns = aim === 'tank_fire' || aim === 'fire';
  switch (step) {
    case 'welcome':
      return {
        title: t(`guide.welcome_${aim}_title`),
        text: `${plural(site.monitors, 'guide.monitors')} ${t(burns ? 'guide.welcome_fire' : 'guide.welcome_calm')}`,
      };
    case 'fire': {
      const windy = Math.hypot(...site.wind) >= AIR_MPS;
      const more = windy ? 'guide.fire_wind' : 'guide.fire_still';
      return { title: t(`guide.fire_${aim}_title`), text: `${t(`guide.fire_${aim}`)} ${t(more)}` };
    }
    case 'auto':
      return { title: t('guide.auto_title'), text: `${t(`guide.auto_${aim}`)} ${t('guide.auto_goes')}` };
  }
}

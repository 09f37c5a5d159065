// Computed sizes and places. They are set one by one: the page's policy allows no style attribute.
import { noChange, nothing } from 'lit';
import { Directive, directive, type ElementPart, type PartInfo, PartType } from 'lit/directive.js';

type Styles = Readonly<Record<string, string>>;

class Styled extends Directive {
  private set: Styles = {};

  constructor(part: PartInfo) {
    super(part);
    if (part.type !== PartType.ELEMENT) throw new Error('styled() must be in a tag, outside of attributes');
  }

  override render(_styles: Styles) {
    return nothing;
  }

  override update(part: ElementPart, [styles]: [Styles]) {
    const { style } = part.element as HTMLElement | SVGElement;
    for (const name in this.set) if (!(name in styles)) style.removeProperty(name);
    for (const name in styles) if (styles[name] !== this.set[name]) style.setProperty(name, styles[name]!);
    this.set = styles;
    return noChange;
  }
}

/** `<div ${styled({ left: '3px' })}>` */
export const styled = directive(Styled);

// Names in the picture: small textures of text that keep their size on the screen.
import { CanvasTexture, LinearFilter, Sprite, SpriteMaterial, SRGBColorSpace } from 'three';

export interface LabelLook {
  text: string;
  colour: string;
  back: string;
  line: string;
}

const HIGH = 56;
const FONT = '600 30px system-ui, sans-serif';

export class Label {
  readonly sprite: Sprite;
  private readonly canvas = document.createElement('canvas');
  private texture: CanvasTexture;
  private known = '';
  private aspect = 1;

  constructor(hideable: boolean) {
    this.texture = this.newTexture();
    this.sprite = new Sprite(new SpriteMaterial({ map: this.texture, depthTest: hideable, sizeAttenuation: false }));
    this.sprite.renderOrder = 10;
    this.sprite.center.set(0.5, 0);
  }

  set(look: LabelLook): void {
    const known = Object.values(look).join('|');
    if (known === this.known) return;
    this.known = known;
    const drawing = this.canvas.getContext('2d')!;
    drawing.font = FONT;
    const wide = Math.ceil(drawing.measureText(look.text).width) + 32;
    this.canvas.width = wide;
    this.canvas.height = HIGH;
    drawing.font = FONT;
    drawing.fillStyle = look.back;
    drawing.strokeStyle = look.line;
    drawing.lineWidth = 2;
    drawing.beginPath();
    drawing.roundRect(2, 4, wide - 4, HIGH - 12, 10);
    drawing.fill();
    drawing.stroke();
    drawing.fillStyle = look.colour;
    drawing.textAlign = 'center';
    drawing.textBaseline = 'middle';
    drawing.fillText(look.text, wide / 2, HIGH / 2 - 1);
    this.texture.dispose();
    this.texture = this.newTexture();
    this.sprite.material.map = this.texture;
    this.aspect = wide / HIGH;
  }

  /** Height in the units of the camera at distance 1. */
  set size(size: number) {
    this.sprite.scale.set(size * this.aspect, size, 1);
  }

  dispose(): void {
    this.texture.dispose();
    this.sprite.material.dispose();
  }

  private newTexture(): CanvasTexture {
    const texture = new CanvasTexture(this.canvas);
    texture.colorSpace = SRGBColorSpace;
    texture.minFilter = LinearFilter;
    texture.generateMipmaps = false;
    return texture;
  }
}

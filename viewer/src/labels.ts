// SPDX-License-Identifier: BSD-3-Clause
// Words that stand in the scene, always as large on the screen.
import { CanvasTexture, LinearFilter, Sprite, SpriteMaterial, Vector3 } from 'three';

const PIXELS = 28;

/// @param options  size: of a line, as a share of the screen's height; stacked: what commas part stands one below the other
export function textSprite(text: string, at: Vector3, options: { size?: number; ink?: string; paper?: string; stacked?: boolean } = {}): Sprite {
  const lines = options.stacked ? text.split(', ') : [text];
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d')!;
  const font = `600 ${PIXELS}px system-ui, sans-serif`;
  context.font = font;
  canvas.width = Math.ceil(Math.max(...lines.map((line) => context.measureText(line).width))) + 20;
  canvas.height = (PIXELS + 14) * lines.length;
  context.font = font;
  context.fillStyle = options.paper ?? 'rgba(20, 24, 32, 0.82)';
  context.beginPath();
  context.roundRect(0, 0, canvas.width, canvas.height, 10);
  context.fill();
  context.fillStyle = options.ink ?? '#ffffff';
  context.textBaseline = 'middle';
  lines.forEach((line, i) => context.fillText(line, 10, (PIXELS + 14) * (i + 0.5) + 1));
  const map = new CanvasTexture(canvas);
  map.minFilter = LinearFilter;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, transparent: true }));
  const height = (options.size ?? 0.03) * lines.length;
  sprite.scale.set((height * canvas.width) / canvas.height, height, 1);
  sprite.position.copy(at);
  sprite.renderOrder = 10;
  sprite.userData = { text, height };
  return sprite;
}

/// A plan has no distance: there, what is always as large on the screen grows with what the screen shows.
/// @param flatHeightM  how much of the world stands on the screen's height; none: in perspective
export function fitSprite(sprite: Sprite, flatHeightM: number | null): void {
  const height = (sprite.userData.height as number) * (flatHeightM ?? 1);
  sprite.scale.set((height * sprite.scale.x) / sprite.scale.y, height, 1);
}

export function disposeSprite(sprite: Sprite): void {
  sprite.material.map?.dispose();
  sprite.material.dispose();
}

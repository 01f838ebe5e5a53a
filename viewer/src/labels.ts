// SPDX-License-Identifier: BSD-3-Clause
// Words that stand in the scene, always as large on the screen.
import { CanvasTexture, LinearFilter, Sprite, SpriteMaterial, Vector3 } from 'three';

const PIXELS = 28;

export function textSprite(text: string, at: Vector3, options: { size?: number; ink?: string; paper?: string } = {}): Sprite {
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d')!;
  const font = `600 ${PIXELS}px system-ui, sans-serif`;
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 20;
  canvas.height = PIXELS + 14;
  context.font = font;
  context.fillStyle = options.paper ?? 'rgba(20, 24, 32, 0.82)';
  context.beginPath();
  context.roundRect(0, 0, canvas.width, canvas.height, 10);
  context.fill();
  context.fillStyle = options.ink ?? '#ffffff';
  context.textBaseline = 'middle';
  context.fillText(text, 10, canvas.height / 2 + 1);
  const map = new CanvasTexture(canvas);
  map.minFilter = LinearFilter;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false, transparent: true }));
  const height = options.size ?? 0.03;
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

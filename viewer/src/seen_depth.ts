// SPDX-License-Identifier: BSD-3-Clause
// How far the camera of the picture saw, by the regions: what lies behind them was not in the picture.
import { Camera, DepthTexture, DoubleSide, MeshBasicMaterial, Scene, WebGLRenderer, WebGLRenderTarget } from 'three';

/// The layer of what hides other things from the robot's camera.
export const SOLID_LAYER = 2;
const WIDTH = 512;
const HEIGHT = 384;

export class SeenDepth {
  private readonly target = new WebGLRenderTarget(WIDTH, HEIGHT, { depthTexture: new DepthTexture(WIDTH, HEIGHT) });
  private readonly material = new MeshBasicMaterial({ side: DoubleSide });

  /// The depth buffer, over the same coordinates as the picture.
  get texture(): DepthTexture {
    return this.target.depthTexture!;
  }

  /// @param eye  the robot's camera; its layers are put back
  render(renderer: WebGLRenderer, scene: Scene, eye: Camera): void {
    const { background, overrideMaterial } = scene;
    const layers = eye.layers.mask;
    scene.background = null;
    scene.overrideMaterial = this.material;
    eye.layers.set(SOLID_LAYER);
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(scene, eye);
    renderer.setRenderTarget(null);
    eye.layers.mask = layers;
    scene.overrideMaterial = overrideMaterial;
    scene.background = background;
  }
}

// SPDX-License-Identifier: BSD-3-Clause
// The scene: draws a model, and says what is where.
import {
  Box3, BufferGeometry, Color, GridHelper, Line, LineBasicMaterial, OrthographicCamera, Raycaster, Scene, Sprite, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { Cameras } from './cameras';
import { Mode } from './colouring';
import { Detail } from './detail';
import { Footsteps } from './footsteps';
import { Inset } from './inset';
import { disposeSprite, fitSprite, textSprite } from './labels';
import { Model } from './model';
import { CameraPath } from './path';
import { Region } from './region';
import { Staircases } from './staircases';
import { Surfaces } from './surfaces';
import { Truth } from './truth';
import { VoxelCloud } from './voxels';

export const LAYERS = [
  'surfaces', 'outlines', 'edges', 'predicted', 'staircases', 'path', 'covariance', 'camera', 'footsteps', 'voxels', 'points', 'truth',
  'true surfaces', 'grid', 'image', 'disparity', 'texture',
] as const;
export type Layer = (typeof LAYERS)[number];
const OFF_AT_FIRST: readonly Layer[] = ['points', 'true surfaces', 'disparity', 'texture'];

/// What has to be sent for a layer, beside what is sent to everybody; `image` for the picture and for the texture.
const WANTED: Partial<Record<Layer, string>> = { image: 'image', texture: 'image', disparity: 'disparity', voxels: 'cells', points: 'points' };

export function wantsOf(shown: Map<Layer, boolean>): string[] {
  const wants = LAYERS.filter((layer) => shown.get(layer)).map((layer) => WANTED[layer]).filter((want) => want !== undefined);
  return [...new Set(wants)];
}

export function isShownAtFirst(layer: Layer): boolean {
  return !OFF_AT_FIRST.includes(layer);
}

/// Whether the processor draws: smooth edges would cost it more than all else.
function drawsInSoftware(): boolean {
  const context = document.createElement('canvas').getContext('webgl2');
  const names = context?.getExtension('WEBGL_debug_renderer_info');
  const renderer = names ? String(context!.getParameter(names.UNMASKED_RENDERER_WEBGL)) : '';
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(renderer);
}

export interface Hit {
  region: Region;
  point: Vector3;
}

export class View3d {
  readonly surfaces = new Surfaces();
  readonly staircases = new Staircases();
  readonly path = new CameraPath();
  readonly footsteps = new Footsteps();
  readonly truth = new Truth();
  readonly voxels = new VoxelCloud('#9e8cb8');
  readonly points = new VoxelCloud('#c07f4a');
  readonly inset = new Inset(() => this.invalidate());
  readonly cameras: Cameras;
  readonly shown = new Map<Layer, boolean>(LAYERS.map((layer) => [layer, isShownAtFirst(layer)]));
  onDrawn: () => void = () => {};
  private readonly detail = new Detail();
  private readonly scene = new Scene();
  private readonly renderer: WebGLRenderer;
  private readonly pixelRatio: number;
  private readonly grid = new GridHelper(40, 40);
  private readonly raycaster = new Raycaster();
  private measure: { line: Line; text: Sprite } | null = null;
  private stale = true;
  private framed = false;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly insetFrame: HTMLElement, private readonly model: Model) {
    const software = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !software, powerPreference: 'high-performance' });
    this.pixelRatio = software ? 1 : Math.min(2, window.devicePixelRatio);
    this.renderer.setPixelRatio(this.pixelRatio);
    this.cameras = new Cameras(canvas);
    this.cameras.controls.addEventListener('change', () => this.invalidate());
    this.grid.rotateX(Math.PI / 2);
    this.scene.add(this.surfaces.group, this.staircases.group, this.path.line, this.path.covariance, this.path.camera, this.footsteps.group, this.truth.group,
      this.voxels.points, this.points.points, this.grid);
    for (const layer of LAYERS) this.applyLayer(layer, this.shown.get(layer)!);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  invalidate(): void {
    this.stale = true;
  }

  /// Takes over what the model has learnt; cheap when that is nothing.
  update(): void {
    if (this.model.touched.size > 0) {
      if (this.surfaces.mode === 'height' && this.rescale()) this.surfaces.recolour(this.model.regions);
      this.surfaces.update(this.model.regions, this.model.touched);
      this.model.touched.clear();
    }
    this.staircases.update(this.model.staircases, this.model.regions);
    this.path.update(this.model);
    this.footsteps.update(this.model.plan);
    this.truth.update(this.model);
    this.inset.update(this.model, this.shown.get('disparity')!);
    const pose = this.model.cameraPose();
    if (pose) this.cameras.moveRobot(pose.position);
    for (const [cloud, cubes] of [[this.voxels, this.model.cells], [this.points, this.model.points]] as const) {
      cloud.update(cubes, pose?.position ?? new Vector3());
      cloud.draw(this.detail.share);
    }
    if (!this.framed && this.model.regions.size > 0) this.frameAll();
    this.invalidate();
  }

  colourBy(mode: Mode): void {
    this.surfaces.mode = mode;
    this.rescale();
    this.surfaces.recolour(this.model.regions);
    this.invalidate();
  }

  select(id: number | null): void {
    this.surfaces.selected = id;
    this.surfaces.recolour(this.model.regions);
    this.invalidate();
  }

  setLayer(layer: Layer, on: boolean): void {
    this.shown.set(layer, on);
    this.applyLayer(layer, on);
    this.invalidate();
  }

  private applyLayer(layer: Layer, on: boolean): void {
    switch (layer) {
      case 'surfaces': this.surfaces.show('fill', on); break;
      case 'outlines': this.applyDetail(); break;
      case 'edges': this.surfaces.show('bands', on); break;
      case 'predicted': this.surfaces.showPredicted(on); break;
      case 'staircases': this.staircases.group.visible = on; break;
      case 'path': this.path.line.visible = on; break;
      case 'covariance': this.path.covariance.visible = on; break;
      case 'camera': this.path.camera.visible = on; break;
      case 'footsteps': this.footsteps.group.visible = on; break;
      case 'voxels': this.voxels.points.visible = on; break;
      case 'points': this.points.points.visible = on; break;
      case 'truth': this.truth.showOutlines(on); break;
      case 'true surfaces': this.truth.surfaces.show('fill', on); break;
      case 'grid': this.grid.visible = on; break;
      case 'image':
      case 'disparity':
        this.insetFrame.hidden = !this.shown.get('image') && !this.shown.get('disparity');
        this.inset.update(this.model, this.shown.get('disparity')!);
        break;
      case 'texture': break;
    }
  }

  setTheme(paper: string, gridColour: string): void {
    this.scene.background = new Color(paper);
    for (const material of [this.grid.material].flat()) material.dispose();
    this.grid.material = new LineBasicMaterial({ color: gridColour, transparent: true, opacity: 0.5 });
    this.invalidate();
  }

  /// @param x, y  in pixels of the page
  pick(x: number, y: number): Hit | null {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    this.raycaster.setFromCamera(at, this.cameras.active);
    const { origin, direction } = this.raycaster.ray;
    let best: Hit | null = null;
    let nearest = Infinity;
    for (const region of this.model.regions.values()) {
      if (region.predicted && !this.shown.get('predicted')) continue;
      const distance = region.hit(origin, direction);
      if (distance === null || distance >= nearest) continue;
      nearest = distance;
      best = { region, point: direction.clone().multiplyScalar(distance).add(origin) };
    }
    return best;
  }

  /// Where a point of the world is on the page.
  project(p: Vector3): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    const q = p.clone().project(this.cameras.active);
    return { x: box.left + ((q.x + 1) / 2) * box.width, y: box.top + ((1 - q.y) / 2) * box.height };
  }

  showMeasure(points: Vector3[], text: string): void {
    if (this.measure) {
      this.scene.remove(this.measure.line, this.measure.text);
      this.measure.line.geometry.dispose();
      disposeSprite(this.measure.text);
      this.measure = null;
    }
    if (points.length > 0) {
      const line = new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: 0xd55e00, depthTest: false }));
      line.renderOrder = 9;
      const middle = points.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(points.length);
      this.measure = { line, text: textSprite(text, middle, { paper: 'rgba(213, 94, 0, 0.9)' }) };
      this.scene.add(line, this.measure.text);
    }
    this.invalidate();
  }

  extent(): { centre: Vector3; sizeM: number; low: Vector3; high: Vector3 } {
    const box = new Box3();
    const p = new Vector3();
    for (const region of this.model.regions.values()) {
      const ring = region.rings[0];
      for (let i = 0; i < ring.length; i += 2) box.expandByPoint(region.toWorld(ring[i], ring[i + 1], 0, p));
    }
    for (const point of this.model.path) box.expandByPoint(point.body.position);
    if (box.isEmpty()) box.set(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
    const size = box.getSize(new Vector3());
    return { centre: box.getCenter(new Vector3()), sizeM: Math.max(size.x, size.y, size.z), low: box.min, high: box.max };
  }

  frameAll(): void {
    const { centre, low, high } = this.extent();
    this.cameras.frame(centre, low.distanceTo(high));
    this.framed = true;
  }

  /// The place was given: nothing is to be framed.
  keepPlace(): void {
    this.framed = true;
  }

  /// To be called at every turn of the screen: draws when something has changed.
  turn(nowMs: number): void {
    if (this.detail.tick(nowMs)) this.applyDetail();
    if (this.stale) this.draw();
  }

  draw(): void {
    this.stale = false;
    this.detail.drawn();
    const size = this.renderer.getSize(new Vector2());
    this.updateTexture();
    const camera = this.cameras.active;
    const pixelsPerRad = 0.5 * size.y * this.renderer.getPixelRatio() * camera.projectionMatrix.elements[5];
    for (const cloud of [this.voxels, this.points]) cloud.setPixelsPerRad(pixelsPerRad);
    const flatHeightM = camera instanceof OrthographicCamera ? (camera.top - camera.bottom) / camera.zoom : null;
    this.surfaces.thinBands(camera.position, this.detail.thinsBands && flatHeightM === null ? pixelsPerRad : null);
    this.scene.traverse((object) => { if (object instanceof Sprite) fitSprite(object, flatHeightM); });
    this.renderer.setViewport(0, 0, size.x, size.y);
    this.renderer.render(this.scene, this.cameras.active);
    this.drawInset(size);
    this.onDrawn();
  }

  /// Everything and at full sharpness, also while the picture moves.
  drawWhole(): void {
    this.detail.restore();
    this.applyDetail();
    this.draw();
  }

  private applyDetail(): void {
    for (const cloud of [this.voxels, this.points]) cloud.draw(this.detail.share);
    this.renderer.setPixelRatio(this.pixelRatio * this.detail.sharpness);
    // What a drop is stays; outlines are the next to be missed least.
    this.surfaces.show('lines', this.shown.get('outlines')! && this.detail.level < 2);
    this.invalidate();
  }

  private drawInset(size: Vector2): void {
    if (this.insetFrame.hidden || !this.inset.texture) return;
    const box = this.insetFrame.getBoundingClientRect();
    const canvas = this.canvas.getBoundingClientRect();
    const rect = { x: box.left - canvas.left, y: size.y - (box.bottom - canvas.top), w: box.width, h: box.height };
    const background = this.scene.background;
    this.scene.background = null;
    this.inset.render(this.renderer, this.scene, this.model.camera, rect, (opacity) => this.surfaces.setOpacity(opacity));
    this.scene.background = background;
  }

  private updateTexture(): void {
    const wanted = this.shown.get('texture')!;
    this.surfaces.setTexture(wanted ? this.inset.projected(this.renderer, this.scene, this.model.camera) : null);
  }

  /// Heights and ages run over what is there; true when the scale has changed.
  private rescale(): boolean {
    const { low, high } = this.extent();
    const before = this.surfaces.scale;
    this.surfaces.scale = { nowUtime: this.model.terrain?.utime ?? 0, lowM: low.z, highM: high.z };
    return before.lowM !== low.z || before.highM !== high.z;
  }

  private resize(): void {
    const width = Math.max(1, this.canvas.clientWidth);
    const height = Math.max(1, this.canvas.clientHeight);
    this.renderer.setSize(width, height, false);
    this.cameras.resize(width, height);
    this.invalidate();
  }
}

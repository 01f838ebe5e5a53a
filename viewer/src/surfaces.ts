// SPDX-License-Identifier: BSD-3-Clause
// The regions as triangles, outlines and bands along drops and rises. Neighbouring ids share one geometry, so that thousands of
// regions take few draw calls, and a region that changes has only its neighbours made anew.
import {
  BufferAttribute, BufferGeometry, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, ShaderMaterial, ShapeUtils, Texture,
  Matrix4, Vector2, Vector3,
} from 'three';
import { colourFor, Mode, Scale } from './colouring';
import { Colour, colourOf, DROP, EDGE_COLOURS, RISE } from './palette';
import { Region } from './region';
import { SOLID_LAYER } from './seen_depth';

/// What is drawn over the camera's image, too.
export const OVERLAY_LAYER = 1;
const REGIONS_A_CHUNK = 64;
const BAND_M = 0.03;        // along drops and rises
const BAND_LIFT_M = 0.002;  // so that the band wins over its own region
const LIGHT = new Vector3(0.35, 0.2, 0.9).normalize();
const EDGES = EDGE_COLOURS.map(colourOf);
const SELECTED: Colour = [255, 255, 255];

const VERTEX = `
attribute vec4 tint;
attribute vec2 place;
varying vec4 vTint;
varying vec2 vPlace;
#ifdef TEXTURED
varying vec4 vImage;
uniform mat4 imageFromWorld;
#endif
void main() {
  vTint = tint;
  vPlace = place;
#ifdef TEXTURED
  vImage = imageFromWorld * vec4(position, 1.0);
#endif
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const FRAGMENT = `
varying vec4 vTint;
varying vec2 vPlace;
#ifdef TEXTURED
varying vec4 vImage;
uniform sampler2D image;
uniform sampler2D seenDepth;
uniform vec2 nearFarM;
/// Whether nothing nearer hid this place from the camera of the image, give or take the noise of surfaces.
bool wasSeen(vec2 at, float depthM) {
  float inBuffer = texture2D(seenDepth, at).r;
  float nearestM = nearFarM.x * nearFarM.y / (nearFarM.y - inBuffer * (nearFarM.y - nearFarM.x));
  return depthM < 1.01 * nearestM + 0.02;
}
#endif
uniform float showPredicted;
uniform float opacity;
void main() {
  if (vTint.a < 0.5 && (showPredicted < 0.5 || fract((vPlace.x + vPlace.y) * 14.0) < 0.45)) discard;
  vec3 colour = gl_FrontFacing ? vTint.rgb : 0.55 * vTint.rgb;
#ifdef TEXTURED
  vec2 at = vImage.xy / vImage.z;
  if (vImage.z > 0.0 && at.x > 0.0 && at.x < 1.0 && at.y > 0.0 && at.y < 1.0 && wasSeen(at, vImage.z)) {
    colour = mix(texture2D(image, at).rgb, colour, 0.25);
  }
#endif
  gl_FragColor = vec4(colour, opacity);
}`;

/// A picture, and what of the world is in it.
export interface ProjectedImage {
  image: Texture;
  imageFromWorld: Matrix4;  // to coordinates of the picture, times depth
  seenDepth: Texture;       // depth buffer of a projection with the two planes
  nearM: number;
  farM: number;
}

interface Chunk {
  ids: Set<number>;
  fill: Mesh;
  bands: Mesh;
  lines: LineSegments;
}

class Vertices {
  positions: number[] = [];
  tints: number[] = [];
  places: number[] = [];
  indices: number[] = [];

  add(p: Vector3, colour: Colour, solid: boolean, x = 0, y = 0): number {
    this.positions.push(p.x, p.y, p.z);
    this.tints.push(colour[0], colour[1], colour[2], solid ? 255 : 0);
    this.places.push(x, y);
    return this.positions.length / 3 - 1;
  }

  writeTo(geometry: BufferGeometry, three: boolean): void {
    geometry.dispose();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(this.positions), 3));
    const tints = new Uint8Array(this.tints);
    geometry.setAttribute(three ? 'tint' : 'color', new BufferAttribute(tints, 4, true));
    if (three) {
      geometry.setAttribute('place', new BufferAttribute(new Float32Array(this.places), 2));
      geometry.setIndex(new BufferAttribute(new Uint32Array(this.indices), 1));
    }
    if (this.positions.length > 0) geometry.computeBoundingSphere();
  }
}

export class Surfaces {
  readonly group = new Group();
  mode: Mode = 'label';
  scale: Scale = { nowUtime: 0, lowM: 0, highM: 1 };
  selected: number | null = null;
  private readonly chunks = new Map<number, Chunk>();
  private readonly layers = { fill: true, bands: true, lines: true };
  private readonly uniforms = {
    image: { value: new Texture() }, seenDepth: { value: new Texture() }, nearFarM: { value: new Vector2() }, imageFromWorld: { value: new Matrix4() }, showPredicted: { value: 1 }, opacity: { value: 1 },
  };
  private readonly fillMaterial = new ShaderMaterial({
    vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms, side: DoubleSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
  private readonly bandMaterial = new ShaderMaterial({
    vertexShader: VERTEX, fragmentShader: FRAGMENT, side: DoubleSide,
    uniforms: { ...this.uniforms, opacity: { value: 1 } },
  });
  private readonly lineMaterial = new LineBasicMaterial({ vertexColors: true });

  /// @param outline  colour of all outlines; none: by the kind of each edge
  constructor(private readonly outline: Colour | null = null) {}

  /// Makes anew what holds these regions.
  update(regions: Map<number, Region>, touched: Iterable<number>): void {
    const stale = new Set<number>();
    for (const id of touched) {
      const key = Math.floor(id / REGIONS_A_CHUNK);
      const chunk = this.chunks.get(key) ?? this.addChunk(key);
      if (regions.has(id)) chunk.ids.add(id);
      else chunk.ids.delete(id);
      stale.add(key);
    }
    for (const key of stale) this.rebuild(key, regions);
  }

  /// After another mode, scale or selection.
  recolour(regions: Map<number, Region>): void {
    for (const key of this.chunks.keys()) this.rebuild(key, regions);
  }

  show(layer: 'fill' | 'bands' | 'lines', on: boolean): void {
    this.layers[layer] = on;
    for (const chunk of this.chunks.values()) chunk[layer].visible = on;
  }

  /// Leaves out bands that are farther away than half a pixel can show.
  /// @param pixelsPerRad  of the picture; null: all are shown
  thinBands(eye: Vector3, pixelsPerRad: number | null): void {
    const LEAST_PX = 0.5;
    for (const { bands } of this.chunks.values()) {
      const ball = bands.geometry.boundingSphere;
      const farM = pixelsPerRad === null || !ball ? 0 : ball.distanceToPoint(eye);
      bands.visible = this.layers.bands && farM * LEAST_PX <= BAND_M * (pixelsPerRad ?? Infinity);
    }
  }

  showPredicted(on: boolean): void {
    this.uniforms.showPredicted.value = on ? 1 : 0;
  }

  /// The camera image on the regions that it shows; null: none.
  setTexture(projected: ProjectedImage | null): void {
    const textured = projected !== null;
    if (textured !== 'TEXTURED' in this.fillMaterial.defines) {
      this.fillMaterial.defines = textured ? { TEXTURED: '' } : {};
      this.fillMaterial.needsUpdate = true;
    }
    if (!projected) return;
    this.uniforms.image.value = projected.image;
    this.uniforms.imageFromWorld.value = projected.imageFromWorld;
    this.uniforms.seenDepth.value = projected.seenDepth;
    this.uniforms.nearFarM.value.set(projected.nearM, projected.farM);
  }

  setOpacity(opacity: number): void {
    this.uniforms.opacity.value = opacity;
    this.fillMaterial.transparent = opacity < 1;
  }

  get numTriangles(): number {
    let sum = 0;
    for (const chunk of this.chunks.values()) sum += (chunk.fill.geometry.getIndex()?.count ?? 0) / 3;
    return sum;
  }

  private addChunk(key: number): Chunk {
    const chunk = {
      ids: new Set<number>(),
      fill: new Mesh(new BufferGeometry(), this.fillMaterial),
      bands: new Mesh(new BufferGeometry(), this.bandMaterial),
      lines: new LineSegments(new BufferGeometry(), this.lineMaterial),
    };
    for (const layer of ['fill', 'bands', 'lines'] as const) chunk[layer].visible = this.layers[layer];
    for (const object of [chunk.fill, chunk.bands, chunk.lines]) object.layers.enable(OVERLAY_LAYER);
    if (!this.outline) chunk.fill.layers.enable(SOLID_LAYER);  // truth hides nothing
    this.group.add(chunk.fill, chunk.bands, chunk.lines);
    this.chunks.set(key, chunk);
    return chunk;
  }

  private rebuild(key: number, regions: Map<number, Region>): void {
    const chunk = this.chunks.get(key)!;
    if (chunk.ids.size === 0) {
      this.group.remove(chunk.fill, chunk.bands, chunk.lines);
      for (const layer of ['fill', 'bands', 'lines'] as const) chunk[layer].geometry.dispose();
      this.chunks.delete(key);
      return;
    }
    const fill = new Vertices();
    const bands = new Vertices();
    const lines = new Vertices();
    for (const id of [...chunk.ids].sort((a, b) => a - b)) {
      const region = regions.get(id)!;
      this.addFill(region, fill);
      region.rings.forEach((ring, i) => {
        this.addLines(region, ring, i, lines);
        this.addBands(region, ring, i, bands);
      });
    }
    fill.writeTo(chunk.fill.geometry, true);
    bands.writeTo(chunk.bands.geometry, true);
    lines.writeTo(chunk.lines.geometry, false);
  }

  private addFill(region: Region, out: Vertices): void {
    const shade = 0.78 + 0.22 * region.normal.dot(LIGHT);
    const chosen = region.id === this.selected;
    const points: Vector2[][] = region.rings.map((ring) => {
      const ringPoints: Vector2[] = [];
      for (let i = 0; i < ring.length; i += 2) ringPoints.push(new Vector2(ring[i], ring[i + 1]));
      return ringPoints;
    });
    const first = out.positions.length / 3;
    const p = new Vector3();
    for (const ring of points) {
      for (const { x, y } of ring) {
        region.toWorld(x, y, 0, p);
        const plain = colourFor(this.mode, region, p.z, this.scale);
        const colour = plain.map((v, i) => shade * (chosen ? 0.5 * v + 0.5 * SELECTED[i] : v)) as Colour;
        out.add(p, colour, !region.predicted, x, y);
      }
    }
    for (const triangle of ShapeUtils.triangulateShape(points[0], points.slice(1))) {
      out.indices.push(...triangle.map((i) => first + i));
    }
  }

  private addLines(region: Region, ring: Float32Array, ringIndex: number, out: Vertices): void {
    const n = ring.length / 2;
    for (let i = 0; i < n; ++i) {
      const j = (i + 1) % n;
      const colour = region.id === this.selected ? SELECTED : this.outline ?? EDGES[region.edges[ringIndex][i].kind] ?? EDGES[0];
      out.add(region.toWorld(ring[2 * i], ring[2 * i + 1], BAND_LIFT_M), colour, true);
      out.add(region.toWorld(ring[2 * j], ring[2 * j + 1], BAND_LIFT_M), colour, true);
    }
  }

  /// A band inside the region along each drop and rise: the region lies to the left of every edge.
  private addBands(region: Region, ring: Float32Array, ringIndex: number, out: Vertices): void {
    const n = ring.length / 2;
    for (let i = 0; i < n; ++i) {
      const kind = region.edges[ringIndex][i].kind;
      if (kind !== DROP && kind !== RISE) continue;
      const j = (i + 1) % n;
      const [ax, ay, bx, by] = [ring[2 * i], ring[2 * i + 1], ring[2 * j], ring[2 * j + 1]];
      const length = Math.hypot(bx - ax, by - ay);
      if (length < 1e-6) continue;
      const width = kind === DROP ? BAND_M : BAND_M / 3;
      const [nx, ny] = [(-(by - ay) / length) * width, ((bx - ax) / length) * width];
      const corners = [[ax, ay], [bx, by], [bx + nx, by + ny], [ax + nx, ay + ny]].map(([x, y]) => (
        out.add(region.toWorld(x, y, BAND_LIFT_M), EDGES[kind], !region.predicted, x, y)));
      out.indices.push(corners[0], corners[1], corners[2], corners[0], corners[2], corners[3]);
    }
  }
}

// SPDX-License-Identifier: BSD-3-Clause
// The camera image or its disparity, with the regions drawn over it as the robot's own camera would see them.
import {
  LinearFilter, Matrix4, Mesh, MeshBasicMaterial, OrthographicCamera, PerspectiveCamera, PlaneGeometry, Scene, SRGBColorSpace, Texture, WebGLRenderer,
} from 'three';
import { CameraInfo, DisparityPicture, Model, Picture } from './model';
import { matrixOf, Pose } from './space';
import { SeenDepth } from './seen_depth';
import { OVERLAY_LAYER, ProjectedImage } from './surfaces';

const NEAR_M = 0.05;
const FAR_M = 60;
const OPACITY = 0.4;

/// Maps the world to texture coordinates (times depth) of the camera's image.
function imageFromWorld(camera: CameraInfo, T_world_left: Pose): Matrix4 {
  const { width: w, height: h, fx, fy, cx, cy } = camera;
  const K = new Matrix4().set(fx / w, 0, (cx + 0.5) / w, 0, 0, -fy / h, 1 - (cy + 0.5) / h, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  return K.multiply(matrixOf(T_world_left).invert());
}

function projectionOf(camera: CameraInfo): Matrix4 {
  const { width: w, height: h, fx, fy, cx, cy } = camera;
  const [left, right] = [(-(cx + 0.5) / fx) * NEAR_M, ((w - cx - 0.5) / fx) * NEAR_M];
  const [top, bottom] = [((cy + 0.5) / fy) * NEAR_M, (-(h - cy - 0.5) / fy) * NEAR_M];
  return new Matrix4().makePerspective(left, right, top, bottom, NEAR_M, FAR_M);
}

export class Inset {
  texture: Texture | null = null;
  picturePose: Pose | null = null;  // of the frame that is shown; none: not known, and nothing is drawn over it
  overlay = true;
  private readonly paper = new Scene();
  private readonly paperCamera = new OrthographicCamera(-0.5, 0.5, 0.5, -0.5, -1, 1);
  private readonly paperMaterial = new MeshBasicMaterial({ depthTest: false, depthWrite: false });
  private readonly eye = new PerspectiveCamera();
  private readonly seenDepth = new SeenDepth();
  private picture: Picture | null = null;  // that is the texture
  private shown: Picture | null = null;    // that is the texture or will be
  private decoding = false;

  constructor(private readonly onPicture: () => void) {
    this.paper.add(new Mesh(new PlaneGeometry(1, 1), this.paperMaterial));
    this.eye.matrixAutoUpdate = false;
    this.eye.layers.set(OVERLAY_LAYER);
  }

  /// Decodes the newest picture beside the drawing; one at a time, so that a fast source cannot pile them up.
  /// @param disparity  shows the disparity in the image's place, where there is one
  update(model: Model, disparity: boolean): void {
    const picture = (disparity ? model.disparity : null) ?? model.picture;
    if (!picture || picture === this.shown || this.decoding) return;
    this.shown = picture;
    this.decoding = true;
    const point = sameFrame(model, picture.utime);
    const pose = point ? model.cameraPoseAt(point) : null;
    const blob = new Blob([picture.jpeg as BlobPart], { type: 'image/jpeg' });
    void createImageBitmap(blob, { imageOrientation: 'flipY' }).then((bitmap) => this.take(bitmap, pose, picture)).finally(() => {
      this.decoding = false;
      this.update(model, disparity);
    });
  }

  /// The picture in words; empty: there is none.
  caption(camera: CameraInfo | null): string {
    if (!this.picture) return '';
    if ('leastPx' in this.picture) {
      const { leastPx, greatestPx } = this.picture as DisparityPicture;
      return `disparity, ${leastPx.toFixed(1)} to ${greatestPx.toFixed(1)} px`;
    }
    return `left camera, ${camera?.width ?? '?'}×${camera?.height ?? '?'}`;
  }

  private take(bitmap: ImageBitmap, pose: Pose | null, picture: Picture): void {
    this.picture = picture;
    this.texture?.dispose();
    (this.texture?.image as ImageBitmap | undefined)?.close();
    this.texture = new Texture(bitmap);
    this.texture.flipY = false;
    this.texture.colorSpace = SRGBColorSpace;
    this.texture.minFilter = LinearFilter;
    this.texture.generateMipmaps = false;
    this.texture.needsUpdate = true;
    this.picturePose = pose;
    this.onPicture();
  }

  /// The picture as it lies on the world; null where it is not known from where it was taken, or it is no image of the camera.
  projected(renderer: WebGLRenderer, scene: Scene, camera: CameraInfo | null): ProjectedImage | null {
    if (!this.texture || !this.picturePose || !camera || !this.picture || 'leastPx' in this.picture) return null;
    this.aim(camera, this.picturePose);
    this.seenDepth.render(renderer, scene, this.eye);
    return {
      image: this.texture, imageFromWorld: imageFromWorld(camera, this.picturePose), seenDepth: this.seenDepth.texture, nearM: NEAR_M, farM: FAR_M,
    };
  }

  private aim(camera: CameraInfo, pose: Pose): void {
    this.eye.projectionMatrix.copy(projectionOf(camera));
    this.eye.projectionMatrixInverse.copy(this.eye.projectionMatrix).invert();
    // three.js looks along -z with y up, a camera of ours along z with y down.
    this.eye.matrix.copy(matrixOf(pose)).multiply(new Matrix4().makeRotationX(Math.PI));
    this.eye.matrixWorldNeedsUpdate = true;
  }

  /// Into a rectangle of the canvas, in its pixels from the lower left corner.
  render(renderer: WebGLRenderer, scene: Scene, camera: CameraInfo | null, rect: { x: number; y: number; w: number; h: number },
         setOpacity: (opacity: number) => void): void {
    if (!this.texture) return;
    renderer.setViewport(rect.x, rect.y, rect.w, rect.h);
    renderer.setScissor(rect.x, rect.y, rect.w, rect.h);
    renderer.setScissorTest(true);
    this.paperMaterial.map = this.texture;
    renderer.render(this.paper, this.paperCamera);
    if (this.overlay && camera && this.picturePose) {
      this.aim(camera, this.picturePose);
      renderer.autoClear = false;
      renderer.clearDepth();
      setOpacity(OPACITY);
      renderer.render(scene, this.eye);
      setOpacity(1);
      renderer.autoClear = true;
    }
    renderer.setScissorTest(false);
  }
}

/// The pose that belongs to a picture: of the same frame, or none.
function sameFrame(model: Model, utime: number) {
  const SAME_FRAME_US = 2000;
  let best = null;
  for (let i = model.path.length - 1; i >= 0; --i) {
    const point = model.path[i];
    if (Math.abs(point.utime - utime) <= SAME_FRAME_US) best = point;
    if (point.utime < utime - SAME_FRAME_US) break;
  }
  return best;
}

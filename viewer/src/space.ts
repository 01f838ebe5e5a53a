// SPDX-License-Identifier: BSD-3-Clause
// Poses and planes as three.js has them. Messages carry quaternions as w,x,y,z.
import { Matrix3, Matrix4, Quaternion, Vector3 } from 'three';

export interface Pose {
  position: Vector3;
  rotation: Quaternion;
}

export function vectorOf(values: number[], at = 0): Vector3 {
  return new Vector3(values[at], values[at + 1], values[at + 2]);
}

/// None when the quaternion is zero, which says that nothing is known.
export function poseOf(position: number[], wxyz: number[]): Pose | null {
  const [w, x, y, z] = wxyz;
  if (w * w + x * x + y * y + z * z < 0.5) return null;
  return { position: vectorOf(position), rotation: new Quaternion(x, y, z, w).normalize() };
}

/// T_a_c = T_a_b * T_b_c.
export function compose(a: Pose, b: Pose): Pose {
  return {
    position: b.position.clone().applyQuaternion(a.rotation).add(a.position),
    rotation: a.rotation.clone().multiply(b.rotation),
  };
}

export function inverse(pose: Pose): Pose {
  const rotation = pose.rotation.clone().invert();
  return { position: pose.position.clone().negate().applyQuaternion(rotation), rotation };
}

export function matrixOf(pose: Pose): Matrix4 {
  return new Matrix4().compose(pose.position, pose.rotation, new Vector3(1, 1, 1));
}

/// A matrix that turns the unit ball into the ellipsoid of `sigmas` standard deviations of a 3x3 covariance (row-major), by
/// its Cholesky factor; the ball where it has none.
export function ellipsoidOf(covariance: number[], sigmas: number): Matrix3 {
  const [xx, , , yx, yy, , zx, zy, zz] = covariance;
  const a = Math.sqrt(Math.max(xx, 0));
  const b = a > 0 ? yx / a : 0;
  const c = Math.sqrt(Math.max(yy - b * b, 0));
  const d = a > 0 ? zx / a : 0;
  const e = c > 0 ? (zy - d * b) / c : 0;
  const f = Math.sqrt(Math.max(zz - d * d - e * e, 0));
  return new Matrix3().set(a, 0, 0, b, c, 0, d, e, f).multiplyScalar(sigmas);
}

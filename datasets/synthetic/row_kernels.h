// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "datasets/synthetic/texture.h"

namespace terrace::synthetic {

/// Directions of the rays of one image row. Their component along the optical axis is 1, so that the distance
/// along a ray is the depth z. Pixel (u, v) at offset (du, dv) looks along across * (u + du) + down * (v +
/// dv) + base, in the world.
struct RowRays {
  float base[3];
  float across[3];
  float down[3];
  int row = 0;
  int width = 0;
  /// Where in the pixel, as fractions of 2^32 from its corner, before each pixel turns the digits over in its
  /// own way.
  std::uint32_t sample_u = 0;
  std::uint32_t sample_v = 0;
  bool jitter = false;  ///< false: the middle of the pixel
  std::uint32_t seed = 0;
};
void GenerateRays(const RowRays& rays, float* dx, float* dy, float* dz);

/// A plane as a row of rays sees it that come from one point.
struct PlaneView {
  float normal[3];
  float axis_u[3];
  float axis_v[3];
  float distance = 0.0F;  ///< offset - normal . origin: depth = distance / (normal . direction)
  float origin_u = 0.0F;  ///< of the rays' origin along the axes
  float origin_v = 0.0F;
  float inverse_focal = 0.0F;  ///< 1 / sqrt(fx fy)
};
/// Where `n` rays meet the plane, and how much of it a pixel covers there.
void MeetPlane(const PlaneView& plane, const float* dx, const float* dy, const float* dz, int n, float* u_m,
               float* v_m, float* footprint_m, float* depth_m);

/// Brightness baked on a surface: nodes every texel_m from (u0, v0) on.
struct LightGrid {
  float u0 = 0.0F;
  float v0 = 0.0F;
  float per_texel = 1.0F;  ///< 1 / texel_m
  int nu = 0;              ///< at least 2
  int nv = 0;
  const float* values = nullptr;  ///< values[v * nu + u]
};
/// radiance[i] += weight * albedo[i] * light(u, v), interpolated bilinearly.
void AddLit(const LightGrid& grid, const float* u_m, const float* v_m, const float* albedo, int n,
            float weight, float* radiance);

}  // namespace terrace::synthetic

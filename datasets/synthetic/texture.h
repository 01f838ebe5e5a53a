// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "datasets/synthetic/scene.h"

namespace terrace::synthetic {

/// Arrays that the row kernels read and write may be overrun by this many floats; what lies there is ignored.
inline constexpr int kRowPadding = 16;

/// Brightness (albedo, 0..1) of `n` points of one surface. Detail finer than the pixel fades to its mean, so
/// that a few samples a pixel suffice.
/// @param u_m, v_m     where, along the axes of the surface
/// @param footprint_m  side of the pixel there: the square root of the area of surface that it covers
/// @param seed         tells surfaces of one material apart
void EvaluateTexture(const Material& material, std::uint32_t seed, const float* u_m, const float* v_m,
                     const float* footprint_m, int n, float* albedo);

}  // namespace terrace::synthetic

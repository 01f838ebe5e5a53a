// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "stereo/stereo_frame.h"

namespace terrace {

/// A texture that can be sampled anywhere exactly: a sum of waves between 4 and 24 pixels long.
class WaveTexture {
 public:
  explicit WaveTexture(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 40; ++i) {
      const double direction = 2 * std::numbers::pi * unit(random);
      const double frequency = 2 * std::numbers::pi / (4.0 * std::pow(6.0, unit(random)));
      waves_.push_back({frequency * std::cos(direction), frequency * std::sin(direction),
                        2 * std::numbers::pi * unit(random)});
    }
  }
  /// Mean 0, standard deviation about 1.
  double operator()(double x, double y) const {
    double sum = 0.0;
    for (const Wave& w : waves_) sum += std::sin(w.fx * x + w.fy * y + w.phase);
    return sum / std::sqrt(0.5 * static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    double fx, fy, phase;
  };
  std::vector<Wave> waves_;
};

/// A pair that shows one slanted plane: disparity d0 + du u + dv v at the left image's pixel (u, v).
struct SlantedPlane {
  double d0 = 10.0, du = 0.0, dv = 0.0;
  double At(double u, double v) const { return d0 + du * u + dv * v; }
};

struct Photometry {
  double contrast = 35.0;
  double mean = 120.0;
  double gain_right = 1.0;
  double offset_right = 0.0;
  double noise = 1.0;  ///< standard deviation, grey levels
};

inline StereoFrame RenderPlane(int width, int height, const SlantedPlane& plane, const Photometry& light = {},
                               unsigned seed = 1) {
  const WaveTexture texture(seed);
  std::mt19937 random(seed + 1000);
  std::normal_distribution<double> noise(0.0, light.noise);
  StereoFrame frame;
  frame.left.create(height, width);
  frame.right.create(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      // Pixel u of the right image shows the left image's u_left with u_left - d(u_left, v) = u.
      const double u_left = (u + plane.d0 + plane.dv * v) / (1.0 - plane.du);
      const double left = light.mean + light.contrast * texture(u, v);
      const double right =
          (light.mean + light.contrast * texture(u_left, v)) * light.gain_right + light.offset_right;
      frame.left(v, u) = cv::saturate_cast<std::uint8_t>(left + noise(random));
      frame.right(v, u) = cv::saturate_cast<std::uint8_t>(right + noise(random));
    }
  return frame;
}

}  // namespace terrace

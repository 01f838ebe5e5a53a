// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/disparity_truth.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/file_bytes.h"
#include "evaluation/planar_shape.h"

namespace terrace {
namespace {

/// Two disparities of one point may differ by this through rounding and slant.
constexpr float kSamePoint_px = 1.0F;
constexpr std::uint8_t kMaskVisible = 255;
constexpr std::uint8_t kMaskHidden = 128;
/// How far a plane may be from the depth image to be what it shows: its half millimetre, and the rounding of
/// poses, which grows with the distance.
constexpr double kDepthRounding_m = 0.001;
constexpr double kDepthShare = 1e-3;

}  // namespace

DisparityTruth ByForwardWarping(FloatImage disparity_px) {
  DisparityTruth truth;
  truth.pixels.assign(disparity_px.data.size(), PixelTruth::kNotKnown);
  const int width = disparity_px.width;
  std::vector<float> nearest(static_cast<std::size_t>(width));
  for (int v = 0; v < disparity_px.height; ++v) {
    std::fill(nearest.begin(), nearest.end(), -1.0F);
    for (int u = 0; u < width; ++u) {
      const float d = disparity_px.At(u, v);
      if (std::isnan(d)) continue;
      const float x = static_cast<float>(u) - d;
      for (const float column : {std::floor(x), std::ceil(x)}) {
        if (column < 0.0F || column >= static_cast<float>(width)) continue;
        float& here = nearest[static_cast<std::size_t>(column)];
        here = std::max(here, d);
      }
    }
    for (int u = 0; u < width; ++u) {
      const float d = disparity_px.At(u, v);
      if (std::isnan(d)) continue;
      const float column = std::round(static_cast<float>(u) - d);
      const bool outside = column < 0.0F || column >= static_cast<float>(width);
      const bool hidden = outside || nearest[static_cast<std::size_t>(column)] > d + kSamePoint_px;
      truth.pixels[disparity_px.Index(u, v)] = hidden ? PixelTruth::kHidden : PixelTruth::kVisible;
    }
  }
  truth.disparity_px = std::move(disparity_px);
  return truth;
}

DisparityTruth ByRightTruth(FloatImage left_px, const FloatImage& right_px) {
  if (left_px.width != right_px.width || left_px.height != right_px.height) {
    throw FileError("left and right truth differ in size");
  }
  DisparityTruth truth;
  truth.pixels.assign(left_px.data.size(), PixelTruth::kNotKnown);
  for (int v = 0; v < left_px.height; ++v) {
    for (int u = 0; u < left_px.width; ++u) {
      const float d = left_px.At(u, v);
      if (std::isnan(d)) continue;
      const float column = std::round(static_cast<float>(u) - d);
      PixelTruth& pixel = truth.pixels[left_px.Index(u, v)];
      if (column < 0.0F || column >= static_cast<float>(left_px.width)) {
        pixel = PixelTruth::kHidden;
        continue;
      }
      const float back = right_px.At(static_cast<int>(column), v);
      if (std::isnan(back)) continue;
      pixel = std::abs(back - d) <= kSamePoint_px ? PixelTruth::kVisible : PixelTruth::kHidden;
    }
  }
  truth.disparity_px = std::move(left_px);
  return truth;
}

DisparityTruth ByMask(FloatImage disparity_px, const GrayImage& mask) {
  if (disparity_px.width != mask.width || disparity_px.height != mask.height) {
    throw FileError("truth and mask differ in size");
  }
  DisparityTruth truth;
  truth.pixels.assign(disparity_px.data.size(), PixelTruth::kNotKnown);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (std::isnan(disparity_px.data[i])) continue;
    if (mask.data[i] == kMaskVisible) truth.pixels[i] = PixelTruth::kVisible;
    if (mask.data[i] == kMaskHidden) truth.pixels[i] = PixelTruth::kHidden;
  }
  truth.disparity_px = std::move(disparity_px);
  return truth;
}

DisparityTruth LoadPairTruth(const std::filesystem::path& truth, std::optional<double> scale,
                             const std::optional<std::filesystem::path>& mask) {
  FloatImage disparity_px = ReadDisparityFile(truth, scale);
  if (mask) return ByMask(std::move(disparity_px), ReadGrayImage(*mask));
  const std::filesystem::path folder = truth.parent_path();
  const std::filesystem::path mask_beside = folder / "mask0nocc.png";
  if (truth.filename() == "disp0GT.pfm" && std::filesystem::exists(mask_beside)) {
    return ByMask(std::move(disparity_px), ReadGrayImage(mask_beside));
  }
  const std::filesystem::path right_beside = folder / "disp6.png";
  if (truth.filename() == "disp2.png" && std::filesystem::exists(right_beside)) {
    return ByRightTruth(std::move(disparity_px), ReadDisparityFile(right_beside, scale));
  }
  return ByForwardWarping(std::move(disparity_px));
}

DisparityPlane DisparityPlaneOf(const Plane& plane_left, const StereoCamera& camera) {
  // n . ((u - cx) / fx, (v - cy) / fy, 1) * z = offset and disparity = fx * baseline / z.
  const double k = camera.fx * camera.baseline_m / plane_left.offset_m;
  const Eigen::Vector3d& n = plane_left.normal;
  const double a = k * n.x() / camera.fx;
  const double b = k * n.y() / camera.fy;
  return {a, b, k * n.z() - a * camera.cx - b * camera.cy};
}

Plane PlaneOf(const DisparityPlane& disparity, const StereoCamera& camera) {
  const Eigen::Vector3d scaled(disparity.a * camera.fx, disparity.b * camera.fy,
                               disparity.a * camera.cx + disparity.b * camera.cy + disparity.c);
  const double length = scaled.norm();
  return {scaled / length, camera.fx * camera.baseline_m / length};
}

RenderedTruth LoadRenderedTruth(const std::filesystem::path& depth_png,
                                const std::optional<std::filesystem::path>& labels_png,
                                const TrueScene& scene, const StereoCamera& camera,
                                const Eigen::Isometry3d& T_world_left) {
  const Gray16Image depth_mm = ReadGray16Png(depth_png);
  if (depth_mm.width != camera.width || depth_mm.height != camera.height) {
    throw FileError(depth_png.string() + ": is not of the size of the rectified camera");
  }
  RenderedTruth truth;
  if (labels_png) truth.labels = ReadGray16Png(*labels_png);
  const bool labelled =
      truth.labels.width == depth_mm.width && truth.labels.height == depth_mm.height && labels_png;
  std::map<int, DisparityPlane> planes;
  for (const TruePolygon& polygon : scene.polygons) {
    planes[polygon.id] = DisparityPlaneOf(Moved(T_world_left.inverse(), polygon.plane_world), camera);
  }
  FloatImage disparity_px(depth_mm.width, depth_mm.height);
  for (int v = 0; v < depth_mm.height; ++v) {
    for (int u = 0; u < depth_mm.width; ++u) {
      const std::size_t i = disparity_px.Index(u, v);
      if (depth_mm.data[i] == 0) continue;
      const double z_m = 1e-3 * depth_mm.data[i];
      double d = camera.Disparity(z_m);
      const auto plane = labelled ? planes.find(truth.labels.data[i]) : planes.end();
      if (plane != planes.end()) {
        const double exact = plane->second.At(u, v);
        if (exact > 0.0 && std::abs(camera.Depth(exact) - z_m) <= kDepthRounding_m + kDepthShare * z_m)
          d = exact;
      }
      disparity_px.data[i] = static_cast<float>(d);
    }
  }
  truth.disparity = ByForwardWarping(std::move(disparity_px));
  return truth;
}

}  // namespace terrace

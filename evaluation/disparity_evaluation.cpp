// SPDX-License-Identifier: BSD-3-Clause
// What whole surfaces say: planes fitted inside true masks, and where depth steps beside true edges.
#include "evaluation/disparity_evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>

#include "core/angles.h"
#include "evaluation/planar_shape.h"
#include "evaluation/statistics.h"

namespace terrace {
namespace {

constexpr int kErosion_px = 3;
constexpr std::size_t kMinMaskPixels = 400;
/// More say no more: every n-th pixel of larger masks is enough, and quick.
constexpr std::size_t kMaxFitPixels = 8000;
/// A residual of this many robust sigmas halves a pixel's weight (Cauchy); the sigma is never taken for less
/// than the floor, so that a perfect image keeps equal weights.
constexpr double kCauchyWidth = 2.0;
constexpr double kSigmaFloor_px = 0.02;
constexpr int kFitIterations = 10;

constexpr double kMinStep_px = 2.0;
constexpr int kEdgeWindow_px = 8;
constexpr int kMinEdgeSide = 3;
constexpr double kNearClip_m = 0.05;

struct Pixel {
  int u;
  int v;
  double d;
};

/// Pixels with a value whose neighbours within `kErosion_px` all carry the same label, by label.
std::map<int, std::vector<Pixel>> ErodedMasks(const FloatImage& disparity_px, const Gray16Image& labels) {
  const int width = labels.width, height = labels.height;
  // How far the label reaches to the left and right of each pixel, then the same up and down over those that
  // reach far enough: erosion by a square in two passes.
  std::vector<std::uint8_t> wide(labels.data.size(), 0);
  const auto index = [&](int u, int v) { return disparity_px.Index(u, v); };
  for (int v = 0; v < height; ++v) {
    for (int begin = 0; begin < width;) {
      int end = begin + 1;
      while (end < width && labels.data[index(end, v)] == labels.data[index(begin, v)]) ++end;
      for (int u = begin + kErosion_px; u < end - kErosion_px; ++u) wide[index(u, v)] = 1;
      begin = end;
    }
  }
  std::map<int, std::vector<Pixel>> masks;
  for (int u = 0; u < width; ++u) {
    for (int begin = 0; begin < height;) {
      const std::uint16_t label = labels.data[index(u, begin)];
      int end = begin + 1;
      while (end < height && labels.data[index(u, end)] == label &&
             wide[index(u, end)] == wide[index(u, begin)]) {
        ++end;
      }
      if (wide[index(u, begin)] && label != 0) {
        for (int v = begin + kErosion_px; v < end - kErosion_px; ++v) {
          const float d = disparity_px.At(u, v);
          if (!std::isnan(d)) masks[label].push_back({u, v, d});
        }
      }
      begin = end;
    }
  }
  return masks;
}

/// Iteratively reweighted least squares with Cauchy weights, from equal ones.
DisparityPlane FitRobustly(const std::vector<Pixel>& pixels) {
  double mean_u = 0.0, mean_v = 0.0;
  for (const Pixel& p : pixels) {
    mean_u += p.u;
    mean_v += p.v;
  }
  mean_u /= static_cast<double>(pixels.size());
  mean_v /= static_cast<double>(pixels.size());
  Eigen::Vector3d abc = Eigen::Vector3d::Zero();
  double width_px = 0.0;  // 0: equal weights
  for (int iteration = 0; iteration < kFitIterations; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d y = Eigen::Vector3d::Zero();
    for (const Pixel& p : pixels) {
      const Eigen::Vector3d x(p.u - mean_u, p.v - mean_v, 1.0);
      const double residual = width_px > 0.0 ? (p.d - abc.dot(x)) / width_px : 0.0;
      const double weight = 1.0 / (1.0 + residual * residual);
      A += weight * x * x.transpose();
      y += weight * p.d * x;
    }
    abc = A.ldlt().solve(y);
    std::vector<double> sizes;
    sizes.reserve(pixels.size());
    for (const Pixel& p : pixels) {
      sizes.push_back(std::abs(p.d - abc.dot(Eigen::Vector3d(p.u - mean_u, p.v - mean_v, 1.0))));
    }
    constexpr double kSigmaPerMedian = 1.4826;  // of a normal distribution
    width_px = kCauchyWidth * std::max(kSigmaPerMedian * QuantileOf(std::move(sizes), 0.5), kSigmaFloor_px);
  }
  return {abc.x(), abc.y(), abc.z() - abc.x() * mean_u - abc.y() * mean_v};
}

PlaneFit Compare(const std::vector<Pixel>& pixels, const DisparityPlane& fitted, const Plane& plane_left,
                 const StereoCamera& camera) {
  double u = 0.0, v = 0.0;
  for (const Pixel& p : pixels) {
    u += p.u;
    v += p.v;
  }
  u /= static_cast<double>(pixels.size());
  v /= static_cast<double>(pixels.size());
  const double true_px = DisparityPlaneOf(plane_left, camera).At(u, v);
  PlaneFit fit;
  fit.depth_m = camera.Depth(true_px);
  fit.offset_px = fitted.At(u, v) - true_px;
  const Eigen::Vector3d p_left = camera.Triangulate(u, v, fitted.At(u, v));
  // Planes are seen from the side their normal points to, so a nearer point lies on that side.
  fit.offset_mm = 1e3 * plane_left.SignedDistance(p_left);
  const double cosine = std::abs(PlaneOf(fitted, camera).normal.dot(plane_left.normal));
  fit.angle_deg = Degrees(std::acos(std::min(cosine, 1.0)));
  return fit;
}

/// The image of one edge, cut where it would come too near to the camera.
struct ImageSegment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};
std::optional<ImageSegment> ProjectEdge(Eigen::Vector3d a, Eigen::Vector3d b, const StereoCamera& camera) {
  if (a.z() < kNearClip_m && b.z() < kNearClip_m) return std::nullopt;
  if (a.z() > b.z()) std::swap(a, b);
  if (a.z() < kNearClip_m) a += (kNearClip_m - a.z()) / (b.z() - a.z()) * (b - a);
  return ImageSegment{camera.Project(a), camera.Project(b)};
}

/// Walks along a row or a column of an image: position k is pixel (u, v).
struct Line {
  bool along_row;
  int fixed;

  int u(int k) const { return along_row ? k : fixed; }
  int v(int k) const { return along_row ? fixed : k; }
};

/// The edge crosses the line between pixels `before` and `before + 1`, at `crossing`. Of the two one must
/// show the near polygon and the other something at least kMinStep_px behind it.
std::optional<EdgeFit> FitStep(const FloatImage& disparity_px, const RenderedTruth& truth, const Line& line,
                               double crossing, int near_id, const DisparityPlane& near_plane,
                               const StereoCamera& camera) {
  const int length = line.along_row ? disparity_px.width : disparity_px.height;
  const int before = static_cast<int>(std::floor(crossing));
  if (before - kEdgeWindow_px + 1 < 0 || before + kEdgeWindow_px >= length) return std::nullopt;
  const auto label = [&](int k) { return truth.labels.data[disparity_px.Index(line.u(k), line.v(k))]; };
  const bool near_before = label(before) == near_id;
  const bool near_after = label(before + 1) == near_id;
  if (near_before == near_after) return std::nullopt;
  const int far_k = near_before ? before + 1 : before;
  const double far_px = truth.disparity.disparity_px.At(line.u(far_k), line.v(far_k));
  const double near_px = near_plane.At(line.u(before), line.v(before));
  if (!(near_px - far_px >= kMinStep_px)) return std::nullopt;

  // step = -1: the near side lies towards smaller k. Position s says that the near side begins after s pixels
  // from the far end of the window.
  const int towards_near = near_before ? -1 : 1;
  const int far_end = near_before ? before + kEdgeWindow_px : before - kEdgeWindow_px + 1;
  constexpr int kWindow = 2 * kEdgeWindow_px;
  int num_near = 0, num_far = 0;
  std::array<int, kWindow> side{};  // 1 near, -1 far, 0 unknown
  for (int s = 0; s < kWindow; ++s) {
    const int k = far_end + towards_near * s;
    const float d = disparity_px.At(line.u(k), line.v(k));
    if (std::isnan(d)) continue;
    const bool near = d > 0.5 * (near_plane.At(line.u(k), line.v(k)) + far_px);
    side[static_cast<std::size_t>(s)] = near ? 1 : -1;
    ++(near ? num_near : num_far);
  }
  if (num_near < kMinEdgeSide || num_far < kMinEdgeSide) return std::nullopt;
  // Fewest pixels on the wrong side; of equal ones that with the smaller near side, for what is hidden beside
  // an edge, and rightly unknown, belongs to the far side.
  int wrong = num_near;  // with everything far; s = kWindow
  int fewest = wrong, best = kWindow;
  for (int s = kWindow - 1; s >= 0; --s) {
    wrong -= side[static_cast<std::size_t>(s)];
    if (wrong < fewest) {
      fewest = wrong;
      best = s;
    }
  }
  const double step_at = far_end + towards_near * (best - 0.5);
  return EdgeFit{std::abs(step_at - crossing), camera.Depth(near_px)};
}

}  // namespace

std::vector<PlaneFit> FitPlanes(const FloatImage& disparity_px, const RenderedTruth& truth,
                                const TrueScene& scene, const StereoCamera& camera,
                                const Eigen::Isometry3d& T_world_left) {
  std::vector<PlaneFit> fits;
  if (truth.labels.empty()) return fits;
  const std::map<int, std::vector<Pixel>> masks = ErodedMasks(disparity_px, truth.labels);
  for (const TruePolygon& polygon : scene.polygons) {
    const auto mask = masks.find(polygon.id);
    if (mask == masks.end() || mask->second.size() < kMinMaskPixels) continue;
    std::vector<Pixel> pixels;
    const std::size_t step = mask->second.size() / kMaxFitPixels + 1;
    for (std::size_t i = 0; i < mask->second.size(); i += step) pixels.push_back(mask->second[i]);
    const Plane plane_left = Moved(T_world_left.inverse(), polygon.plane_world);
    PlaneFit fit = Compare(pixels, FitRobustly(pixels), plane_left, camera);
    fit.num_pixels = static_cast<int>(mask->second.size());
    fit.polygon_id = polygon.id;
    fit.label = polygon.label;
    fits.push_back(fit);
  }
  return fits;
}

std::vector<EdgeFit> FitEdges(const FloatImage& disparity_px, const RenderedTruth& truth,
                              const TrueScene& scene, const StereoCamera& camera,
                              const Eigen::Isometry3d& T_world_left) {
  std::vector<EdgeFit> fits;
  if (truth.labels.empty()) return fits;
  const Eigen::Isometry3d T_left_world = T_world_left.inverse();
  const auto fit_ring = [&](const Ring& ring, int polygon_id, const DisparityPlane& plane) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const auto edge = ProjectEdge(T_left_world * ring[j], T_left_world * ring[i], camera);
      if (!edge) continue;
      const Eigen::Vector2d along = edge->b - edge->a;
      const bool steep = std::abs(along.y()) >= std::abs(along.x());
      const int across = steep ? 1 : 0;  // the coordinate that runs over whole numbers
      const int limit = steep ? disparity_px.height : disparity_px.width;
      const double low = std::min(edge->a[across], edge->b[across]);
      const double high = std::max(edge->a[across], edge->b[across]);
      const int begin = static_cast<int>(std::clamp(std::ceil(low), 0.0, static_cast<double>(limit)));
      const int end = static_cast<int>(std::clamp(std::floor(high) + 1.0, 0.0, static_cast<double>(limit)));
      for (int at = begin; at < end; ++at) {
        const double share = (at - edge->a[across]) / along[across];
        const double crossing = edge->a[1 - across] + share * along[1 - across];
        if (!(crossing > -1.0 && crossing < std::max(disparity_px.width, disparity_px.height))) continue;
        const auto fit = FitStep(disparity_px, truth, {steep, at}, crossing, polygon_id, plane, camera);
        if (fit) fits.push_back(*fit);
      }
    }
  };
  for (const TruePolygon& polygon : scene.polygons) {
    const DisparityPlane plane = DisparityPlaneOf(Moved(T_left_world, polygon.plane_world), camera);
    fit_ring(polygon.outline_world, polygon.id, plane);
    for (const Ring& hole : polygon.holes_world) fit_ring(hole, polygon.id, plane);
  }
  return fits;
}

double DisparityEvaluation::edge_median_px() const {
  std::vector<double> distances;
  for (const EdgeFit& edge : edges) distances.push_back(edge.distance_px);
  return QuantileOf(std::move(distances), 0.5);
}

PlaneFigures DisparityEvaluation::Planes(const std::vector<std::string>& labels, double max_depth_m) const {
  std::vector<double> offsets_px, offsets_mm, angles_deg;
  for (const PlaneFit& plane : planes) {
    if (plane.depth_m > max_depth_m) continue;
    if (!labels.empty() && std::find(labels.begin(), labels.end(), plane.label) == labels.end()) continue;
    offsets_px.push_back(std::abs(plane.offset_px));
    offsets_mm.push_back(std::abs(plane.offset_mm));
    angles_deg.push_back(plane.angle_deg);
  }
  return {static_cast<int>(offsets_px.size()), QuantileOf(offsets_px, 0.5), QuantileOf(offsets_mm, 0.5),
          QuantileOf(angles_deg, 0.5)};
}

}  // namespace terrace

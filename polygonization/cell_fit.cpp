// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/cell_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

namespace terrace {
namespace {

/// Neighbouring pixels err alike; this many of them say as much as one alone.
constexpr float kCorrelatedPoints = 4.0F;
/// Share of the error that all points of a frame have in common (the pose), per frame.
constexpr float kFrameSigma_m = 0.002F;
/// A leaf that stands across a plane has a spread of size / sqrt(12) along the normal; one that lies in it
/// has only noise. Half the variance tells them apart.
constexpr float kAcross = 0.18F / 12.0F;
/// A plane known before is preferred to a new one that explains hardly more.
constexpr float kHintBonus = 1.05F;
constexpr int kRefits = 3;

/// 1 / variance of a leaf's mean along the normal.
float Information(const Surfel& s, float facing) {
  const float noise = s.sigma_view_m * facing;
  return 1.0F /
         (noise * noise * kCorrelatedPoints / s.num_points + kFrameSigma_m * kFrameSigma_m / s.num_frames);
}

/// Points spread evenly over a rectangle have a standard deviation of half its edge / sqrt(3): so the
/// spread of a leaf's points tells how far the surface reaches into the leaf, more finely than the leaf
/// itself.
Footprint FootprintOf(const Surfel& s, const CellPlane& plane, const Eigen::Matrix<float, 3, 2>& basis) {
  const Eigen::Matrix2f c = basis.transpose() * s.covariance * basis;
  const float mean = 0.5F * (c(0, 0) + c(1, 1));
  const float half_difference = 0.5F * (c(0, 0) - c(1, 1));
  const float root = std::sqrt(half_difference * half_difference + c(0, 1) * c(0, 1));
  // The longer axis lies at half the angle of (half_difference, c01).
  const float cosine = root > 0.0F ? half_difference / root : 1.0F;
  const Eigen::Vector2f major(std::sqrt(std::max(0.0F, 0.5F * (1.0F + cosine))),
                              std::copysign(std::sqrt(std::max(0.0F, 0.5F * (1.0F - cosine))), c(0, 1)));
  const Eigen::Vector2f minor(-major.y(), major.x());
  const auto half = [&](float variance) {
    // Each point stands for the half pixel around it, too.
    const float extent = std::sqrt(3.0F * std::max(0.0F, variance)) + 0.5F * s.spacing_m;
    return std::min(extent, 0.75F * s.size_m);
  };
  Footprint footprint;
  footprint.centre = s.mean - (plane.normal.dot(s.mean) - plane.offset_m) * plane.normal;
  footprint.half_x = basis * major * half(mean + root);
  footprint.half_y = basis * minor * half(mean - root);
  return footprint;
}

}  // namespace

CellFit::CellFit(const ModellingConfig& config, const std::vector<Surfel>& surfels, double cell_size_m,
                 std::vector<CellPlane> hints, std::uint64_t seed)
    : config_(config),
      surfels_(surfels),
      limits_{static_cast<float>(config.inlier_distance_m), static_cast<float>(config.max_inlier_distance_m),
              static_cast<float>(cell_size_m)},
      hints_(std::move(hints)),
      random_state_(seed) {}

std::vector<Patch> CellFit::Run() {
  std::vector<Patch> patches;
  std::vector<int> rest(surfels_.size()), inliers, left;
  std::iota(rest.begin(), rest.end(), 0);
  for (int k = 0; k < config_.max_planes && rest.size() >= 3; ++k) {
    std::optional<CellPlane> plane = BestHypothesis(rest);
    if (!plane) break;
    PlaneMoments moments;
    for (int refit = 0; refit < kRefits && plane; ++refit) plane = Refit(rest, *plane, &moments);
    if (!plane) break;
    inliers.clear();
    left.clear();
    for (const int i : rest)
      (Belongs(surfel(i), PlaceOf(surfel(i), *plane), *plane) ? inliers : left).push_back(i);
    if (inliers.empty()) break;
    Patch patch = MakePatch(*plane, moments, inliers);
    if (patch.area_m2 < config_.min_patch_area_m2) break;
    std::swap(rest, left);
    // A bad plane's leaves are not looked at again either.
    if (RmsShare(inliers, *plane) < config_.max_rms_share) patches.push_back(std::move(patch));
  }
  return patches;
}

CellFit::Place CellFit::PlaceOf(const Surfel& s, const CellPlane& plane) const {
  const float facing = -plane.normal.dot(s.view);
  if (facing < kLeastFacing) return {facing, 1.0F};
  const float distance = plane.normal.dot(s.mean) - plane.offset_m;
  const float allowed = std::max(plane.scale * Allowed_m(s, facing, limits_), limits_.least_m);
  return {facing, std::min(1.0F, distance * distance / (allowed * allowed))};
}

bool CellFit::Belongs(const Surfel& s, const Place& place, const CellPlane& plane) const {
  if (place.cost >= 1.0F) return false;
  const float noise = s.sigma_view_m * place.facing;
  const float spread = plane.normal.dot(s.covariance * plane.normal);
  return spread < 2.0F * (noise * noise + kFrameSigma_m * kFrameSigma_m) + kAcross * s.size_m * s.size_m;
}

float CellFit::RmsShare(const std::vector<int>& inliers, const CellPlane& plane) const {
  // By points: the many leaves that the noise of a far surface spills into hold few.
  float cost = 0.0F, num_points = 0.0F;
  for (const int i : inliers) {
    cost += surfel(i).num_points * PlaceOf(surfel(i), plane).cost;
    num_points += surfel(i).num_points;
  }
  return std::sqrt(cost / num_points);
}

/// A number below `count`, the same on every system (SplitMix64, Steele et al. 2014).
int CellFit::AnyOf(int count) {
  random_state_ += 0x9E3779B97F4A7C15ULL;
  std::uint64_t z = random_state_;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  z ^= z >> 31;
  return static_cast<int>((z >> 33) % static_cast<std::uint64_t>(count));
}

std::optional<CellPlane> CellFit::Through(int a, int b, int c) const {
  const Eigen::Vector3f& p = surfel(a).mean;
  const Eigen::Vector3f cross = (surfel(b).mean - p).cross(surfel(c).mean - p);
  const float length = cross.norm();
  const float least = 0.5F * surfel(a).size_m * surfel(a).size_m;
  if (!(length > least)) return std::nullopt;
  CellPlane plane;
  plane.normal = cross / length;
  if (plane.normal.dot(surfel(a).view) > 0.0F) plane.normal = -plane.normal;
  plane.offset_m = plane.normal.dot(p);
  return plane;
}

/// Hypotheses are tried on a few leaves; only the most promising on all. A leaf counts by its area.
std::optional<CellPlane> CellFit::BestHypothesis(const std::vector<int>& rest) {
  const int n = static_cast<int>(rest.size());
  const auto any = [&] { return rest[static_cast<std::size_t>(AnyOf(n))]; };
  std::vector<int> sample;
  if (n > config_.num_pretest)
    for (int i = 0; i < config_.num_pretest; ++i) sample.push_back(any());
  sample_columns_.Assign(surfels_, n > config_.num_pretest ? sample : rest);
  // How much each explains; sorted by minus that.
  std::vector<std::pair<float, CellPlane>> tried;
  const auto try_out = [&](CellPlane plane, float bonus) {
    const float explained = bonus * Explained(sample_columns_, limits_, &plane);
    tried.emplace_back(-explained, plane);
  };
  for (const CellPlane& hint : hints_) try_out(hint, kHintBonus);
  const std::size_t num_hints = tried.size();
  for (int h = 0; h < config_.num_hypotheses; ++h)
    if (const std::optional<CellPlane> plane = Through(any(), any(), any())) try_out(*plane, 1.0F);
  if (tried.empty()) return std::nullopt;
  const auto explains_more = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::stable_sort(tried.begin(), tried.begin() + static_cast<std::ptrdiff_t>(num_hints), explains_more);
  std::stable_sort(tried.begin() + static_cast<std::ptrdiff_t>(num_hints), tried.end(), explains_more);
  // The best two of the hints and of the new ones go into the final.
  constexpr std::size_t kFinalists = 2;
  rest_columns_.Assign(surfels_, rest);
  std::optional<CellPlane> best;
  float best_score = 0.0F;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const bool hint = i < num_hints;
    if ((hint ? i : i - num_hints) >= kFinalists) continue;
    CellPlane plane = tried[i].second;
    const float score = Explained(rest_columns_, limits_, &plane) * (hint ? kHintBonus : 1.0F);
    if (best && score <= best_score) continue;
    best = plane;
    best_score = score;
  }
  return best;
}

std::optional<CellPlane> CellFit::Refit(const std::vector<int>& rest, const CellPlane& plane,
                                        PlaneMoments* moments) const {
  *moments = {};
  int num = 0;
  for (const int i : rest) {
    const Surfel& s = surfel(i);
    const Place place = PlaceOf(s, plane);
    if (!Belongs(s, place, plane)) continue;
    const float robust = (1.0F - place.cost) * (1.0F - place.cost);
    moments->Add(static_cast<double>(robust * Information(s, place.facing)), s.mean.cast<double>());
    ++num;
  }
  if (num < 3 || !(moments->weight > 0.0)) return std::nullopt;
  const Plane fit = moments->Fit(plane.normal.cast<double>());
  if (!(fit.normal.dot(plane.normal.cast<double>()) > 0.5)) return std::nullopt;
  return CellPlane{fit.normal.cast<float>(), static_cast<float>(fit.offset_m), plane.scale};
}

Patch CellFit::MakePatch(const CellPlane& plane, const PlaneMoments& moments,
                         const std::vector<int>& inliers) const {
  Patch patch;
  patch.plane_world = {plane.normal.cast<double>().normalized(), static_cast<double>(plane.offset_m)};
  patch.moments = moments;
  const PlaneAxes axes = AxesOf(patch.plane_world.normal);
  Eigen::Matrix<float, 3, 2> basis;
  basis << axes.x.cast<float>(), axes.y.cast<float>();
  double information = 0.0, noise2 = 0.0;
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  patch.footprints.reserve(inliers.size());
  for (const int i : inliers) {
    const Surfel& s = surfel(i);
    const float facing = -plane.normal.dot(s.view);
    const double weight = static_cast<double>(Information(s, facing));
    const double noise = static_cast<double>(s.sigma_view_m * facing);
    information += weight;
    noise2 += weight * noise * noise;
    const Footprint footprint = FootprintOf(s, plane, basis);
    patch.area_m2 += static_cast<double>(4.0F * footprint.half_x.norm() * footprint.half_y.norm());
    const Eigen::Vector3f extent = footprint.half_x.cwiseAbs() + footprint.half_y.cwiseAbs();
    low = low.cwiseMin(footprint.centre - extent);
    high = high.cwiseMax(footprint.centre + extent);
    patch.footprints.push_back(footprint);
    patch.num_frames += static_cast<double>(s.num_frames);
  }
  patch.low = low;
  patch.high = high;
  patch.num_frames /= static_cast<double>(inliers.size());
  patch.most_noise_m = std::sqrt(noise2 / information);
  patch.noise_m = static_cast<double>(plane.scale) * patch.most_noise_m;
  return patch;
}

}  // namespace terrace

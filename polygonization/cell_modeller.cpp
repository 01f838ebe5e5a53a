// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/cell_modeller.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "core/check.h"
#include "core/parallel_for.h"

namespace terrace {
namespace {

/// A surface is not seen from behind, and hardly edge on: cosine between the normal and the way to the
/// camera.
constexpr float kLeastFacing = 0.03F;
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
/// What a leaf on a plane counts for, however loose the plane; for each factor of e that it is tighter than
/// the cell; and how much less at three standard deviations.
constexpr float kLoose = 1.9F;
constexpr float kTight = 0.5F;
constexpr float kDistance = 4.5F;
/// The noise of a leaf is what it may be at worst; a plane is also tried at these shares of it.
constexpr std::array<float, 3> kScales = {1.0F, 0.5F, 0.25F};
constexpr std::array<float, 3> kLogScales = {0.0F, -0.693147F, -1.386294F};

/// A small generator with the same numbers on every system (SplitMix64, Steele et al. 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  int Below(int limit) {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    z ^= z >> 31;
    return static_cast<int>((z >> 33) % static_cast<std::uint64_t>(limit));
  }

 private:
  std::uint64_t state_;
};

std::uint64_t SeedOf(const CellKey& key) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(key.x)) << 42) ^
         (static_cast<std::uint64_t>(static_cast<std::uint32_t>(key.y)) << 21) ^
         static_cast<std::uint64_t>(static_cast<std::uint32_t>(key.z));
}

/// A plane relative to the centre of the cell.
struct CellPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float offset = 0.0F;
  /// The share of what the noise of its leaves allows within which they lie.
  float scale = 1.0F;
};

/// Fits the planes of one cell, one after the other, each to what the ones before left over.
class CellFit {
 public:
  CellFit(const ModellingConfig& config, const std::vector<Surfel>& surfels, double cell_size_m,
          std::vector<CellPlane> hints, std::uint64_t seed)
      : config_(config),
        surfels_(surfels),
        cell_size_m_(static_cast<float>(cell_size_m)),
        hints_(std::move(hints)),
        random_(seed) {}

  std::vector<Patch> Run() {
    std::vector<Patch> patches;
    std::vector<int> rest(surfels_.size());
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = static_cast<int>(i);
    for (int k = 0; k < config_.max_planes && rest.size() >= 3; ++k) {
      std::optional<CellPlane> plane = BestHypothesis(rest);
      if (!plane) break;
      std::vector<int> inliers;
      PlaneMoments moments;
      for (int refit = 0; refit < kRefits && plane; ++refit) plane = Refit(rest, *plane, &moments);
      if (!plane) break;
      std::vector<int> left;
      for (const int i : rest) (Belongs(surfels_[i], *plane) ? inliers : left).push_back(i);
      if (inliers.empty()) break;
      Patch patch = MakePatch(*plane, moments, inliers);
      if (patch.area_m2 < config_.min_patch_area_m2) break;
      rest = std::move(left);
      // A bad plane's leaves are not looked at again either.
      if (RmsShare(inliers, *plane) < config_.max_rms_share) patches.push_back(std::move(patch));
    }
    return patches;
  }

 private:
  float Facing(const Surfel& s, const CellPlane& plane) const { return -plane.normal.dot(s.view); }

  /// Squared distance of the mean, in units of what is allowed.
  float Cost(const Surfel& s, const CellPlane& plane) const {
    const float facing = Facing(s, plane);
    if (facing < kLeastFacing) return 1.0F;
    const float distance = plane.normal.dot(s.mean) - plane.offset;
    const float allowed =
        std::max(plane.scale * Allowed(s, facing), static_cast<float>(config_.inlier_distance_m));
    return std::min(1.0F, distance * distance / (allowed * allowed));
  }
  float Allowed(const Surfel& s, float facing) const {
    return std::clamp(3.0F * s.sigma_view_m * facing, static_cast<float>(config_.inlier_distance_m),
                      static_cast<float>(config_.max_inlier_distance_m));
  }
  bool Belongs(const Surfel& s, const CellPlane& plane) const {
    if (Cost(s, plane) >= 1.0F) return false;
    const float noise = s.sigma_view_m * Facing(s, plane);
    const float spread = plane.normal.dot(s.covariance * plane.normal);
    return spread < 2.0F * (noise * noise + kFrameSigma_m * kFrameSigma_m) + kAcross * s.size_m * s.size_m;
  }
  float RmsShare(const std::vector<int>& inliers, const CellPlane& plane) const {
    // By points: the many leaves that the noise of a far surface spills into hold few.
    float cost = 0.0F, num_points = 0.0F;
    for (const int i : inliers) {
      cost += surfels_[i].num_points * Cost(surfels_[i], plane);
      num_points += surfels_[i].num_points;
    }
    return std::sqrt(cost / num_points);
  }
  /// 1 / variance of the leaf's mean along the normal.
  float Information(const Surfel& s, float facing) const {
    const float noise = s.sigma_view_m * facing;
    return 1.0F /
           (noise * noise * kCorrelatedPoints / s.num_points + kFrameSigma_m * kFrameSigma_m / s.num_frames);
  }

  std::optional<CellPlane> Through(int a, int b, int c) const {
    const Eigen::Vector3f& p = surfels_[a].mean;
    const Eigen::Vector3f cross = (surfels_[b].mean - p).cross(surfels_[c].mean - p);
    const float length = cross.norm();
    const float least = 0.5F * surfels_[a].size_m * surfels_[a].size_m;
    if (!(length > least)) return std::nullopt;
    CellPlane plane;
    plane.normal = cross / length;
    if (plane.normal.dot(surfels_[a].view) > 0.0F) plane.normal = -plane.normal;
    plane.offset = plane.normal.dot(p);
    return plane;
  }

  /// RMSAC: hypotheses are tried on a few leaves; only the most promising on all. A leaf counts by its area.
  std::optional<CellPlane> BestHypothesis(const std::vector<int>& rest) {
    const int n = static_cast<int>(rest.size());
    std::vector<int> sample;
    if (n <= config_.num_pretest) {
      sample = rest;
    } else {
      for (int i = 0; i < config_.num_pretest; ++i) sample.push_back(rest[random_.Below(n)]);
    }
    // How much each explains; sorted by minus that.
    std::vector<std::pair<float, CellPlane>> tried;
    for (CellPlane hint : hints_) {
      const float explained = kHintBonus * Explained(sample, &hint);
      tried.emplace_back(-explained, hint);
    }
    const std::size_t num_hints = tried.size();
    for (int h = 0; h < config_.num_hypotheses; ++h) {
      std::optional<CellPlane> plane =
          Through(rest[random_.Below(n)], rest[random_.Below(n)], rest[random_.Below(n)]);
      if (!plane) continue;
      const float explained = Explained(sample, &*plane);
      tried.emplace_back(-explained, *plane);
    }
    if (tried.empty()) return std::nullopt;
    const auto explains_more = [](const auto& a, const auto& b) { return a.first < b.first; };
    std::stable_sort(tried.begin(), tried.begin() + static_cast<std::ptrdiff_t>(num_hints), explains_more);
    std::stable_sort(tried.begin() + static_cast<std::ptrdiff_t>(num_hints), tried.end(), explains_more);
    // The best two of the hints and of the new ones go into the final.
    constexpr std::size_t kFinalists = 2;
    std::optional<CellPlane> best;
    float best_score = 0.0F;
    for (std::size_t i = 0; i < tried.size(); ++i) {
      const bool hint = i < num_hints;
      if ((hint ? i : i - num_hints) >= kFinalists) continue;
      CellPlane plane = tried[i].second;
      const float score = Explained(rest, &plane) * (hint ? kHintBonus : 1.0F);
      if (best && score <= best_score) continue;
      best = plane;
      best_score = score;
    }
    return best;
  }
  /// How much better a plane explains the leaves than nothing does, by area: a share of what their distances
  /// leave of what is allowed, and a share for how tight it is, as the logarithm of the likelihood has it
  /// (MLESAC, Torr and Zisserman 2000; half of it here, since leaves are no points and their noise is a
  /// guess). So a plane across the steps of a flight far away, which is loose because it is seen from the
  /// front, does not pass for the treads, which are tight because they are seen flat. How tight it is shows
  /// in the leaves, too: their noise is a guess, so the plane takes that share of it which explains them best
  /// (`plane->scale`).
  float Explained(const std::vector<int>& indices, CellPlane* plane) const {
    std::array<float, kScales.size()> sums{};
    const float per_tightest = 1.0F / static_cast<float>(config_.inlier_distance_m);
    const float log_tightest = Log(cell_size_m_ * per_tightest);
    for (const int i : indices) {
      const Surfel& s = surfels_[i];
      const float facing = Facing(s, *plane);
      if (facing < kLeastFacing) continue;
      const float distance = plane->normal.dot(s.mean) - plane->offset;
      const float allowed = Allowed(s, facing);  // three standard deviations
      if (std::abs(distance) >= allowed) continue;
      const float per_allowed = 1.0F / allowed;
      const float squared = kDistance * distance * distance;
      const float loss = squared * per_allowed * per_allowed;
      const float most_loss = squared * per_tightest * per_tightest;
      const float log_allowed = Log(cell_size_m_ * per_allowed);
      const float area = s.size_m * s.size_m;
      for (std::size_t k = 0; k < kScales.size(); ++k) {
        const float tight = kTight * std::min(log_allowed - kLogScales[k], log_tightest);
        const float loss_k = std::min(loss / (kScales[k] * kScales[k]), most_loss);
        sums[k] += area * std::max(0.0F, kLoose + tight - loss_k);
      }
    }
    const auto best = std::max_element(sums.begin(), sums.end());
    plane->scale = kScales[static_cast<std::size_t>(best - sums.begin())];
    return *best;
  }
  /// Natural logarithm of a positive number, within 0.06: straight between the powers of two.
  static float Log(float x) {
    constexpr float kLog2 = 0.693147F;
    const auto bits = static_cast<float>(std::bit_cast<std::int32_t>(x) - std::bit_cast<std::int32_t>(1.0F));
    return kLog2 / static_cast<float>(1 << 23) * bits;
  }

  /// Weighted least squares; Tukey's weight lets go of what lies near the limit.
  std::optional<CellPlane> Refit(const std::vector<int>& rest, const CellPlane& plane,
                                 PlaneMoments* moments) const {
    *moments = {};
    int num = 0;
    for (const int i : rest) {
      const Surfel& s = surfels_[i];
      const float cost = Cost(s, plane);
      if (cost >= 1.0F || !Belongs(s, plane)) continue;
      const float robust = (1.0F - cost) * (1.0F - cost);
      moments->Add(static_cast<double>(robust * Information(s, Facing(s, plane))), s.mean.cast<double>());
      ++num;
    }
    if (num < 3 || !(moments->weight > 0.0)) return std::nullopt;
    const Plane fit = moments->Fit(plane.normal.cast<double>());
    if (!(fit.normal.dot(plane.normal.cast<double>()) > 0.5)) return std::nullopt;
    return CellPlane{fit.normal.cast<float>(), static_cast<float>(fit.offset_m), plane.scale};
  }

  Patch MakePatch(const CellPlane& plane, const PlaneMoments& moments,
                  const std::vector<int>& inliers) const {
    Patch patch;
    patch.plane_world = {plane.normal.cast<double>().normalized(), static_cast<double>(plane.offset)};
    patch.moments = moments;
    const PlaneAxes axes = AxesOf(patch.plane_world.normal);
    Eigen::Matrix<float, 3, 2> basis;
    basis << axes.x.cast<float>(), axes.y.cast<float>();
    double information = 0.0, noise2 = 0.0;
    Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (const int i : inliers) {
      const Surfel& s = surfels_[i];
      const float facing = Facing(s, plane);
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

  /// Points spread evenly over a rectangle have a standard deviation of half its edge / sqrt(3): so the
  /// spread of a leaf's points tells how far the surface reaches into the leaf, more finely than the leaf
  /// itself.
  static Footprint FootprintOf(const Surfel& s, const CellPlane& plane,
                               const Eigen::Matrix<float, 3, 2>& basis) {
    const Eigen::Matrix2f c = basis.transpose() * s.covariance * basis;
    const float mean = 0.5F * (c(0, 0) + c(1, 1));
    const float half_difference = 0.5F * (c(0, 0) - c(1, 1));
    const float root = std::sqrt(half_difference * half_difference + c(0, 1) * c(0, 1));
    const float angle = 0.5F * std::atan2(c(0, 1), half_difference);
    const Eigen::Vector2f major(std::cos(angle), std::sin(angle));
    const Eigen::Vector2f minor(-major.y(), major.x());
    const auto half = [&](float variance) {
      // Each point stands for the half pixel around it, too.
      const float extent = std::sqrt(3.0F * std::max(0.0F, variance)) + 0.5F * s.spacing_m;
      return std::min(extent, 0.75F * s.size_m);
    };
    Footprint footprint;
    footprint.centre = s.mean - (plane.normal.dot(s.mean) - plane.offset) * plane.normal;
    footprint.half_x = basis * major * half(mean + root);
    footprint.half_y = basis * minor * half(mean - root);
    return footprint;
  }

  const ModellingConfig& config_;
  const std::vector<Surfel>& surfels_;
  const float cell_size_m_;
  const std::vector<CellPlane> hints_;
  Random random_;
};

}  // namespace

std::vector<std::string> ModellingConfig::Problems() const {
  std::vector<std::string> problems;
  if (!(inlier_distance_m > 0.0)) problems.push_back("inlier_distance_m must be above 0");
  if (!(max_inlier_distance_m >= inlier_distance_m))
    problems.push_back("max_inlier_distance_m must be at least inlier_distance_m");
  if (!(max_rms_share > 0.0 && max_rms_share <= 1.0))
    problems.push_back("max_rms_share must be above 0 and at most 1");
  if (!(min_patch_area_m2 >= 0.0)) problems.push_back("min_patch_area_m2 must not be negative");
  if (max_planes < 1 || max_planes > 100) problems.push_back("max_planes must be between 1 and 100");
  if (num_hypotheses < 1 || num_hypotheses > 10000)
    problems.push_back("num_hypotheses must be between 1 and 10000");
  if (num_pretest < 3) problems.push_back("num_pretest must be at least 3");
  return problems;
}

CellModeller::CellModeller(const ModellingConfig& config) : config_(config) {
  TERRACE_CHECK(config.Problems().empty());
}

/// Planes of the cell itself first, then those of its neighbours that pass through it, each direction once.
std::vector<Plane> CellModeller::HintsFor(const CellKey& key, const Eigen::Vector3d& centre_world,
                                          double cell_size_m) const {
  const double kSameCosine = std::cos(0.05);
  constexpr double kSameOffset_m = 0.005;
  std::vector<Plane> hints;
  const auto add_from = [&](const CellKey& from) {
    const auto found = planes_world_.find(from);
    if (found == planes_world_.end()) return;
    for (const Plane& plane : found->second) {
      const double offset = plane.SignedDistance(centre_world);
      if (std::abs(offset) > 0.5 * cell_size_m * plane.normal.cwiseAbs().sum()) continue;
      const bool known = std::any_of(hints.begin(), hints.end(), [&](const Plane& other) {
        return plane.normal.dot(other.normal) > kSameCosine &&
               std::abs(offset - other.SignedDistance(centre_world)) < kSameOffset_m;
      });
      if (!known) hints.push_back(plane);
    }
  };
  add_from(key);
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz)
        if (dx != 0 || dy != 0 || dz != 0) add_from({key.x + dx, key.y + dy, key.z + dz});
  return hints;
}

PatchUpdate CellModeller::Fit(const TerrainOctree& octree, const ChangedCells& cells) {
  PatchUpdate update{cells.frame_id, cells.t_capture, {}};
  update.cells.resize(cells.keys.size());
  ParallelForPieces(cells.keys.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<Surfel> surfels;
    for (std::size_t i = begin; i < end; ++i) {
      PatchUpdate::CellPatches& cell = update.cells[i];
      cell.key = cells.keys[i];
      cell.centre_world = octree.CellCentre(cell.key);
      octree.CollectSurfels(cell.key, &surfels);
      std::vector<CellPlane> hints;
      for (const Plane& plane : HintsFor(cell.key, cell.centre_world, octree.cell_size_m()))
        hints.push_back(
            {plane.normal.cast<float>(), static_cast<float>(-plane.SignedDistance(cell.centre_world))});
      cell.patches =
          CellFit(config_, surfels, octree.cell_size_m(), std::move(hints), SeedOf(cell.key)).Run();
      for (Patch& patch : cell.patches)
        patch.plane_world.offset_m += patch.plane_world.normal.dot(cell.centre_world);
    }
  });
  for (const PatchUpdate::CellPatches& cell : update.cells) {
    if (cell.patches.empty()) {
      planes_world_.erase(cell.key);
      continue;
    }
    std::vector<Plane>& planes = planes_world_[cell.key];
    planes.clear();
    for (const Patch& patch : cell.patches) planes.push_back(patch.plane_world);
  }
  return update;
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/predicted_regions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace terrace {
namespace {

/// Nobody steps otherwise for less.
bool NearlyEqual(const TerrainRegion& a, const TerrainRegion& b) {
  constexpr double kPlace = 0.005, kShareOfSigma = 0.3, kConfidence = 0.1;
  const double sigma_a = std::sqrt(a.plane_covariance(2, 2)), sigma_b = std::sqrt(b.plane_covariance(2, 2));
  if (a.outline_world.size() != b.outline_world.size() ||
      std::abs(a.confidence - b.confidence) > kConfidence ||
      std::abs(sigma_a - sigma_b) > kShareOfSigma * sigma_a)
    return false;
  for (std::size_t i = 0; i < a.outline_world.size(); ++i)
    if ((a.outline_world[i] - b.outline_world[i]).norm() > kPlace) return false;
  return true;
}

bool SameLaw(const FlightModel& a, const FlightModel& b) {
  return a.spiral == b.spiral && a.direction == b.direction && a.origin == b.origin && a.foot_z == b.foot_z &&
         a.rise_m == b.rise_m && a.run_m == b.run_m && a.lateral.low == b.lateral.low &&
         a.lateral.high == b.lateral.high;
}

TerrainRegion RegionOf(const InferredStep& step, const TrackedStaircase& staircase,
                       const Eigen::Matrix3d& R_level_world, double cap) {
  constexpr double kTiltSigma = 0.02;  // treads are sloped for water, and worn
  constexpr double kLessAStep = 0.02;  // of confidence
  TerrainRegion region;
  region.source = RegionSource::kPredicted;
  region.label = step.riser ? TerrainLabel::kStairRiser : TerrainLabel::kStairTread;
  region.confidence = std::min(cap, staircase.published.confidence * std::exp(-kLessAStep * step.step_index));
  const Eigen::Matrix3d R_world_level = R_level_world.transpose();
  region.plane_world = {R_world_level * step.plane.normal, step.plane.offset_m};
  for (const Eigen::Vector3d& p : step.outline) {
    region.outline_world.push_back(region.plane_world.Project(R_world_level * p));
    region.centroid_world += region.outline_world.back() / static_cast<double>(step.outline.size());
  }
  region.area_m2 = SignedArea(region.outline_world, region.plane_world.normal);
  const double offset_sigma = step.riser ? step.place_sigma_m : step.height_sigma_m;
  region.plane_covariance.diagonal() =
      Eigen::Vector3d(kTiltSigma * kTiltSigma, kTiltSigma * kTiltSigma, offset_sigma * offset_sigma);
  region.first_seen = region.last_seen = staircase.published.last_seen;
  region.staircase_id = staircase.id;
  region.step_index = step.step_index;
  return region;
}

}  // namespace

bool PredictedRegions::Rests(const TrackedStaircase& staircase, const ShapeTable& table) const {
  const auto basis = bases_.find(staircase.id);
  if (basis == bases_.end()) return false;
  const Basis& known = basis->second;
  bool looked_at = false;
  for (const StepPlace& place : staircase.places) {
    const int i = table.IndexOf(place.region);
    if (i < 0) continue;
    looked_at = true;
    // Within so much of a step lies what decides about its neighbours.
    if (table.Touched(*table.shapes()[i], Eigen::Vector3d::Constant(0.3))) return false;
  }
  return !looked_at ||
         (SameLaw(known.model, staircase.found.model) && known.num_risers == staircase.found.num_risers &&
          known.num_places == staircase.places.size() && known.confidence == staircase.published.confidence);
}

void PredictedRegions::Infer(const TrackedStaircase& staircase, const ShapeTable& table, double cap) {
  std::set<Key> demanded;
  for (const InferredStep& step : InferSteps(staircase, table.shapes())) {
    const Key key(staircase.id, step.step_index, step.riser);
    demanded.insert(key);
    TerrainRegion region = RegionOf(step, staircase, table.R_level_world(), cap);
    RegionPtr& told = told_[key];
    if (told && NearlyEqual(*told, region)) continue;
    region.id = told ? told->id : ++last_id_;
    region.revision = told ? told->revision + 1 : 1;
    if (told) region.first_seen = told->first_seen;
    told = std::make_shared<const TerrainRegion>(std::move(region));
    changes_[told->id] = told;
  }
  ForgetOthers(staircase.id, demanded);
  bases_[staircase.id] = {staircase.found.model, staircase.found.num_risers, staircase.places.size(),
                          staircase.published.confidence};
}

void PredictedRegions::ForgetOthers(std::int64_t staircase, const std::set<Key>& demanded) {
  for (auto it = told_.lower_bound(Key(staircase, std::numeric_limits<int>::min(), false));
       it != told_.end() && std::get<0>(it->first) == staircase;) {
    if (demanded.contains(it->first)) {
      ++it;
      continue;
    }
    changes_[it->second->id] = nullptr;
    it = told_.erase(it);
  }
}

void PredictedRegions::Update(const StaircaseTracker& tracker, const ShapeTable& table, double cap) {
  changes_.clear();
  for (const std::int64_t id : tracker.removed()) {
    ForgetOthers(id, {});
    bases_.erase(id);
  }
  for (const TrackedStaircase* staircase : tracker.looked_at())
    if (!Rests(*staircase, table)) Infer(*staircase, table, cap);
}

std::vector<std::int64_t> PredictedRegions::IdsOf(std::int64_t staircase) const {
  std::vector<std::int64_t> ids;
  for (auto it = told_.lower_bound(Key(staircase, std::numeric_limits<int>::min(), false));
       it != told_.end() && std::get<0>(it->first) == staircase; ++it)
    ids.push_back(it->second->id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace terrace

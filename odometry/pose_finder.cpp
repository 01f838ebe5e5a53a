// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/pose_finder.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "odometry/covariance.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

/// Of the usual share: what a pose must explain to be believed at once.
constexpr double kUsual = 0.55;
/// Of the trust in all that was looked for: what a pose that explains less needs instead.
constexpr double kDoubtful = 0.8;
/// Frames that agreed with a landmark: from then on it is known to stand still, as long as it is seen.
constexpr int kKnownFrames = 3;
constexpr double kKnownTrust = 0.3;
/// Variance of residuals over what the patches claim, at most.
constexpr double kMaxNoiseScale = 30.0;

/// On which single patches are searched for widely when nothing at all was found: it takes longest.
constexpr int kLastResort = 1;

/// On which the image is compared as a whole.
constexpr int kSmallLevel = ImagePyramid::kNumLevels - 1;

/// Normalised correlation of what two images of one size have in common when the second is shifted by (du,
/// dv).
double Likeness(const cv::Mat1b& first, const cv::Mat1b& second, int du, int dv) {
  const int u0 = std::max(0, -du), u1 = std::min(first.cols, first.cols - du);
  const int v0 = std::max(0, -dv), v1 = std::min(first.rows, first.rows - dv);
  std::int64_t sum_a = 0, sum_b = 0, square_a = 0, square_b = 0, cross = 0;
  for (int v = v0; v < v1; ++v) {
    const std::uint8_t* const a = first[v];
    const std::uint8_t* const b = second[v + dv] + du;
    std::int32_t row_a = 0, row_b = 0, row_aa = 0, row_bb = 0, row_ab = 0;
    for (int u = u0; u < u1; ++u) {
      row_a += a[u];
      row_b += b[u];
      row_aa += a[u] * a[u];
      row_bb += b[u] * b[u];
      row_ab += a[u] * b[u];
    }
    sum_a += row_a;
    sum_b += row_b;
    square_a += row_aa;
    square_b += row_bb;
    cross += row_ab;
  }
  const double n = static_cast<double>(u1 - u0) * (v1 - v0);
  const auto Central = [n](std::int64_t product, std::int64_t a, std::int64_t b) {
    return static_cast<double>(product) - static_cast<double>(a) * static_cast<double>(b) / n;
  };
  const double variances = Central(square_a, sum_a, sum_a) * Central(square_b, sum_b, sum_b);
  return Central(cross, sum_a, sum_b) / std::sqrt(std::max(variances, 1.0));
}

bool Known(const Landmark& landmark) {
  return !landmark.missed_last && landmark.num_tracked >= kKnownFrames && landmark.trust() >= kKnownTrust;
}

}  // namespace

PoseFinder::PoseFinder(const StereoCamera& camera, const FeatureGrid& grid, int min_inliers)
    : camera_(camera), tracker_(camera, grid), min_inliers_(min_inliers) {}

std::optional<PoseFinder::Found> PoseFinder::Find(const Window& window, const ImagePyramid& left,
                                                  const ImagePyramid& right, const Expectation& expected) {
  only_strangers_ = false;
  const std::vector<Found> candidates = FindRoughly(window, left, right, expected);
  if (candidates.empty()) return std::nullopt;
  const Found* rough = &candidates.front();

  PosePrior prior = expected.prior;
  if (!expected.measured) prior.information *= 0.01;  // only against what the images leave open
  for (const int start_level : {0, 2}) {
    Found fine = SolveAtItsNoise(window,
                                 tracker_.Track(window, left, right, rough->solution.T_world_left,
                                                expected.vertical_px, {start_level, 0, 2, true}),
                                 prior, expected.seed);
    constexpr double kMinInlierShare = 0.35;
    if (!Enough(fine, expected) ||
        fine.solution.num_inliers < kMinInlierShare * static_cast<double>(fine.matches.size()))
      continue;
    // Floors and walls repeat themselves: beside where the camera is, a third of what should be there may
    // agree.
    if (expected.lost && 2 * static_cast<std::size_t>(fine.solution.num_inliers) < fine.tried.size())
      continue;
    // A pose that only new landmarks believe in is that of something that moves through the view.
    if (fine.mean_trust <
        (rough->share < kUsual * usual_share_ ? kDoubtful : kUsual) * fine.mean_trust_expected)
      continue;
    only_strangers_ = FollowsStrangers(fine, expected);
    if (only_strangers_) continue;
    noise_scale_ = fine.noise_scale;
    UpdateNoiseScale(fine.solution);
    last_small_ = left[kSmallLevel];
    fine.doubt = Doubt(fine, candidates, expected);
    return fine;
  }
  // What stays different becomes usual.
  constexpr double kForget = 0.75;
  usual_share_ *= kForget;
  return std::nullopt;
}

/// With a few landmarks on coarse levels, from where the motion is expected to have taken the camera; at a
/// foot strike that is wrong, so that standing still and a wide search compete with it.
std::vector<PoseFinder::Found> PoseFinder::FindRoughly(const Window& window, const ImagePyramid& left,
                                                       const ImagePyramid& right,
                                                       const Expectation& expected) {
  const SearchOptions rough{3, 0, 1, false};
  std::vector<Found> candidates;  // best first
  // True as soon as a pose explains about as much as poses do in these surroundings.
  const auto Believed = [&] {
    return !candidates.empty() && Enough(candidates.front(), expected) &&
           candidates.front().share > kUsual * usual_share_ &&
           !FollowsStrangers(candidates.front(), expected);
  };
  const auto Consider = [&](Found found) {
    candidates.push_back(std::move(found));
    Found& added = candidates.back();
    Found& best = candidates.front();
    // Whatever the strangers' number, those who have stood still before decide.
    const bool rivals = Enough(added, expected) && Enough(best, expected);
    const bool best_is_strange = FollowsStrangers(best, expected);
    const bool better = rivals && FollowsStrangers(added, expected) != best_is_strange
                            ? best_is_strange
                            : added.score > best.score;
    if (better) std::swap(added, best);
  };
  const auto TrackFrom = [&](const Eigen::Isometry3d& from) {
    return tracker_.Track(window, left, right, from, expected.vertical_px, rough);
  };
  // Far from the truth a search finds only some of what it could: once more, from where these lead.
  const auto Follow = [&](const Eigen::Isometry3d& from) {
    constexpr int kMaxRounds = 2;
    constexpr double kGain = 1.2;
    PosePrior weak = expected.prior;
    weak.T_world_left = from;
    double score = 0.0;
    for (int round = 0; round < kMaxRounds; ++round) {
      Found found = Solve(window, TrackFrom(weak.T_world_left), weak, expected.seed, noise_scale_);
      const bool better = found.score > kGain * score;
      score = found.score;
      weak.T_world_left = found.solution.T_world_left;
      Consider(std::move(found));
      if (Believed() || !better) break;
    }
  };
  // What moves through the view may be the largest group that agrees, but it is not the one known best.
  const auto FollowGroups = [&](Matches matches, const PosePrior& prior) {
    constexpr int kMaxGroups = 3;
    constexpr int kMinGroup = 6;
    for (int group = 0; group < kMaxGroups; ++group) {
      const Found found = Solve(window, matches, prior, expected.seed, noise_scale_);
      if (found.solution.num_inliers < kMinGroup) return;
      Follow(found.solution.T_world_left);
      if (Believed()) return;
      matches.found.clear();
      for (std::size_t i = 0; i < found.matches.size(); ++i)
        if (!found.solution.inlier[i]) matches.found.push_back(found.matches[i]);
    }
  };

  const Eigen::Isometry3d& T_expected = expected.prior.T_world_left;
  for (const Eigen::Isometry3d& from : {T_expected, expected.T_world_seen}) {
    PosePrior weak = expected.prior;
    weak.T_world_left = from;
    Matches matches = TrackFrom(from);
    Consider(Solve(window, matches, weak, expected.seed, noise_scale_));
    if (!Believed()) FollowGroups(std::move(matches), weak);
    if (Believed()) break;
  }
  if (!Believed()) {
    // How much of it is a turn, and how much a step past what is near, shows by trying.
    const auto shift_px = ShiftOfImage(left);
    for (const double share : {0.25, 0.5, 0.75, 1.0}) {
      if (!shift_px || Believed()) break;
      const Eigen::Vector2d turn_rad =
          share * shift_px->cwiseQuotient(Eigen::Vector2d(camera_.fx, camera_.fy));
      Eigen::Isometry3d turned = T_expected;
      turned.linear() = expected.T_world_seen.linear() * ExpRotation({turn_rad.y(), -turn_rad.x(), 0.0});
      Follow(turned);
    }
  }
  if (!Believed()) {
    PosePrior vague = expected.prior;
    vague.information *= 0.1;
    const double turn_rad = std::sqrt(Inverse(expected.prior.information).topLeftCorner<3, 3>().trace());
    const double reach_px = std::max(camera_.width / 6.0, camera_.fx * std::min(turn_rad, 1.0));
    // Coarsely first; what stands in front leaves only small patches of the rest.
    for (const int level : {3, 2, 1}) {
      const bool any = !candidates.empty() && Enough(candidates.front(), expected);
      if (Believed() || (level == kLastResort && any)) break;
      FollowGroups(tracker_.SearchWide(window, left, T_expected, reach_px, level), vague);
    }
  }
  if (candidates.empty() || !Enough(candidates.front(), expected)) return {};
  constexpr double kRate = 0.1;
  usual_share_ += kRate * (candidates.front().share - usual_share_);
  return candidates;
}

/// Texture that repeats itself misleads a search for single patches, but the image as a whole fits in one
/// place only.
/// @return what the image of the last tracked frame moved by since
std::optional<Eigen::Vector2d> PoseFinder::ShiftOfImage(const ImagePyramid& left) const {
  const cv::Mat1b& image = left[kSmallLevel];
  if (last_small_.size() != image.size()) return std::nullopt;
  constexpr double kMinLikeness = 0.5;
  const int reach = image.cols / 5;
  double best = kMinLikeness;
  std::optional<Eigen::Vector2d> shift_px;
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      const double likeness = Likeness(last_small_, image, du, dv);
      if (likeness <= best) continue;
      best = likeness;
      shift_px = Eigen::Vector2d(du, dv) * (1 << kSmallLevel);
    }
  }
  return shift_px;
}

/// With two motions of which one is the true one, the covariance about the believed one is the square of
/// their distance by the probability of the other: of its share in the trust. An IMU knows which one is true.
std::optional<Matrix6d> PoseFinder::Doubt(const Found& fine, const std::vector<Found>& rough,
                                          const Expectation& expected) const {
  constexpr double kStrong = 0.5;  // of the score of the best
  constexpr double kCommon = 0.5;  // share of the rival's landmarks that agree with the best, too: no rival
  if (expected.measured) return std::nullopt;
  std::set<int> agreeing;
  for (std::size_t i = 0; i < fine.matches.size(); ++i)
    if (fine.solution.inlier[i]) agreeing.insert(fine.matches[i].landmark);
  std::optional<Matrix6d> doubt;
  double strongest = kStrong * rough.front().score;
  for (const Found& rival : rough) {
    if (rival.score < strongest || !Enough(rival, expected)) continue;
    int num_common = 0;
    for (std::size_t i = 0; i < rival.matches.size(); ++i)
      num_common += rival.solution.inlier[i] && agreeing.contains(rival.matches[i].landmark);
    if (num_common > kCommon * rival.solution.num_inliers) continue;
    strongest = rival.score;
    const Vector6d apart = StepBetween(fine.solution.T_world_left, rival.solution.T_world_left);
    doubt = rival.score / (rival.score + rough.front().score) * apart * apart.transpose();
  }
  return doubt;
}

/// True when what agrees is new and what has stood still before does not agree: it may be a thing that moves
/// through the view, or all looks different now. An IMU knows better.
bool PoseFinder::FollowsStrangers(const Found& found, const Expectation& expected) {
  constexpr int kEnoughKnown = 8;
  constexpr double kMuchLess = 0.5;
  const double of_known = static_cast<double>(found.num_known) / std::max(found.num_known_tried, 1);
  const double of_all =
      found.solution.num_inliers / std::max<double>(1.0, static_cast<double>(found.tried.size()));
  return !expected.measured && found.num_known_tried >= kEnoughKnown && of_known < kMuchLess * of_all;
}

/// With an IMU the turn is known and the step nearly so: half as many will do. Places look alike: who is lost
/// needs twice as many.
bool PoseFinder::Enough(const Found& found, const Expectation& expected) const {
  const int enough = expected.lost       ? 2 * min_inliers_
                     : expected.measured ? (min_inliers_ + 1) / 2
                                         : min_inliers_;
  return found.solution.num_inliers >= enough;
}

/// A rolling shutter or a bad lens makes nearly everything disagree a little: then few agree, and these not
/// well. Where something moves, the rest agrees as well as ever. Raises the noise until most agree.
PoseFinder::Found PoseFinder::SolveAtItsNoise(const Window& window, const Matches& matches,
                                              const PosePrior& prior, std::uint32_t seed) const {
  constexpr double kMostAgree = 0.6;
  constexpr double kBadly = 1.4;  // mean chi2 of a component, of those that agree
  constexpr double kStep = 2.0;
  Found found = Solve(window, matches, prior, seed, noise_scale_);
  const double all = static_cast<double>(found.matches.size());
  for (double scale = kStep * noise_scale_; scale <= kMaxNoiseScale && found.solution.mean_chi2 > kBadly &&
                                            found.solution.num_inliers < kMostAgree * all;
       scale *= kStep)
    found = Solve(window, matches, prior, seed, scale);
  return found;
}

PoseFinder::Found PoseFinder::Solve(const Window& window, Matches matches, const PosePrior& prior,
                                    std::uint32_t seed, double noise_scale) const {
  Found found;
  found.noise_scale = noise_scale;
  found.matches = std::move(matches.found);
  found.solution = SolvePose(Constraints(window, found.matches, noise_scale), prior, camera_, seed);
  for (std::size_t i = 0; i < found.matches.size(); ++i) {
    if (!found.solution.inlier[i]) continue;
    const Landmark& landmark = window.landmarks[static_cast<std::size_t>(found.matches[i].landmark)];
    found.score += landmark.trust();
    found.num_known += Known(landmark);
  }
  for (const int i : matches.tried)
    found.num_known_tried += Known(window.landmarks[static_cast<std::size_t>(i)]);
  found.share = std::min(1.0, found.score / std::max(matches.trust_expected, 1.0));
  found.mean_trust = found.score / std::max(found.solution.num_inliers, 1);
  found.tried = std::move(matches.tried);
  found.mean_trust_expected = matches.trust_expected / std::max(matches.num_expected, 1);
  return found;
}

std::vector<PoseConstraint> PoseFinder::Constraints(const Window& window, const std::vector<Match>& matches,
                                                    double noise_scale) const {
  std::vector<PoseConstraint> constraints;
  constraints.reserve(matches.size());
  for (const Match& match : matches) {
    const Landmark& landmark = window.landmarks[static_cast<std::size_t>(match.landmark)];
    const Eigen::Isometry3d& T_world_host = window.at(landmark.host).T_world_left;
    PoseConstraint c;
    c.point_world =
        T_world_host.linear() * landmark.ray_host + landmark.inverse_depth * T_world_host.translation();
    c.inverse_depth = landmark.inverse_depth;
    c.uvd = match.measurement.uvd;
    c.whitening =
        Whitening(match.measurement, match.predicted.uvd_by_inverse_depth, landmark.inverse_depth_sigma);
    c.whitening /= std::sqrt(noise_scale);
    c.trust = landmark.trust();
    constraints.push_back(c);
  }
  return constraints;
}

/// Real lenses and calibrations are worse than their patches claim: learns by how much, from the median.
void PoseFinder::UpdateNoiseScale(const PoseSolution& solution) {
  constexpr double kMedianChi2 = 2.37;  // of three components
  constexpr double kRate = 0.05;
  std::vector<double> chi2 = solution.chi2;
  const auto middle = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 2);
  std::nth_element(chi2.begin(), middle, chi2.end());
  noise_scale_ = std::clamp(noise_scale_ * (1.0 + kRate * (std::min(*middle / kMedianChi2, 3.0) - 1.0)), 1.0,
                            kMaxNoiseScale);
}

}  // namespace terrace

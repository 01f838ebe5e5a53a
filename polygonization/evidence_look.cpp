// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/evidence_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace terrace {
namespace {

/// A plane is not seen from behind, and hardly edge on: least cosine between its normal and the way to the
/// camera.
constexpr float kLeastCosine = 0.05F;
constexpr double kNearest_m = 0.1;
/// What plane and pose are wrong by, along the normal.
constexpr float kPlaneError_m = 0.004F;
/// A pixel lies on the plane within so many sigmas and what matching errs by together; it sees through it
/// only this much farther on.
constexpr float kSigmas = 2.0F;
constexpr float kMatching_px = 0.1F;
constexpr float kThroughFactor = 1.5F;
/// A look counts by how finely its pixels lie in the plane: the number of halvings from this spacing on.
constexpr float kCoarsest_m = 0.04F;
constexpr int kMostWeight = 4;
/// Looks of one weight do not count for more than this many of them.
constexpr int kMostLooks = 8;
/// What speaks against what was seen before counts so many times.
constexpr int kAgainst = 2;
/// What was only ever seen more coarsely than a look sees it, and shows nothing in it, fades by this: the sky
/// beyond an edge says no more against the surface than this.
constexpr int kUnseen = 2;
/// How far below zero seeing nothing takes what was not known before.
constexpr int kNothingSeen = -2;
/// Near the border of either image matching leaves some pixels out that it could give.
constexpr int kBorder_px = 40;
/// So does what lies hidden behind another surface, nearer to it than this: the plane that runs through the
/// steps of a flight, as they were seen from afar.
constexpr float kJustBehind_m = 0.12F;
constexpr float kSearchedShare = 0.9F;
constexpr float kRightMargin_px = 16.0F;
/// In every look a quarter of the cells has its turn, except in blocks that are new or where much has
/// changed.
constexpr int kNewLooks = 4;
constexpr int kManyContradictions = 6;
/// A block that is well known and has not changed is looked at in every second frame only.
constexpr int kSettledLooks = 24;
/// Agreement that reaches farther along the normal than this, and so many times the noise of the surface, is
/// none.
constexpr float kMostReach_m = 0.02F;
constexpr float kReachNoise = 3.5F;

}  // namespace

/// A plane as the left camera sees it, in floats.
struct EvidenceLook::PlaneInView {
  Eigen::Vector3f origin, step_x, step_y;  // corner of cell (0, 0) and one cell on, left frame
  Eigen::Vector3f disparity;               // of the plane at pixel (u, v): dot with (u, v, 1)
  float error_share;                       // of a disparity, for the error of the plane
  float distance_m;                        // of the camera from the plane
  float reach_m;
  float cell_m;
  float fb;  // focal length times baseline
  FrameId frame_id;
};

/// One look at one block.
class EvidenceLook::BlockLook {
 public:
  BlockLook(const FrameView& view, const PlaneInView& plane, EvidenceGrid::Block* block)
      : view_(view), plane_(plane), block_(*block) {}

  void Run(const EvidenceGrid::BlockKey& key, LookResult* result) {
    const Eigen::Vector3f corner = plane_.origin +
                                   (static_cast<float>(key.first * kCells) + 0.5F) * plane_.step_x +
                                   (static_cast<float>(key.second * kCells) + 0.5F) * plane_.step_y;
    const Eigen::Vector3f middle = corner + 7.5F * (plane_.step_x + plane_.step_y);
    const float range = middle.norm();
    const float facing = plane_.distance_m / range;
    if (middle.z() < static_cast<float>(kNearest_m) || facing < kLeastCosine) return;
    const float spacing = range / static_cast<float>(view_.camera.fx);
    for (float s = spacing / facing; weight_ < kMostWeight && s <= 0.5F * kCoarsest_m; s *= 2.0F) ++weight_;
    // Where cells are finer than pixels, one in the middle asks for all around it.
    while (group_ < EvidenceGrid::kGroupCells && 2.0F * static_cast<float>(group_) * plane_.cell_m <= spacing)
      group_ *= 2;
    FindPixels(corner);
    for (int i = 0; i < num_pixels_; ++i) Judge(pixels_[static_cast<std::size_t>(i)]);
    block_.contradicted = num_contradictions_ >= kManyContradictions;
    if (result_.num_on > 0) block_.on_frame = plane_.frame_id;
    result->num_on += result_.num_on;
    result->num_through += result_.num_through;
    result->num_flipped += result_.num_flipped;
  }

 private:
  static constexpr int kCells = EvidenceGrid::kBlockCells;

  /// The pixel that shows a cell, or the middle of a group of cells from this one on.
  struct Pixel {
    int x, y;  // of the cell
    int column, row;
    float inverse_z;
  };

  /// The pixels whose turn it is. They are asked for before any is judged: they lie scattered over the image,
  /// and memory takes longer than all the rest.
  void FindPixels(const Eigen::Vector3f& corner) {
    const bool all = block_.num_looks < kNewLooks || block_.contradicted;
    const int turn = block_.num_looks % 4;
    block_.num_looks = static_cast<std::uint8_t>(block_.num_looks < 200 ? block_.num_looks + 1 : 100);
    const StereoCamera& c = view_.camera;
    const auto fx = static_cast<float>(c.fx), fy = static_cast<float>(c.fy);
    const auto cx = static_cast<float>(c.cx) + 0.5F, cy = static_cast<float>(c.cy) + 0.5F;
    const float to_middle = 0.5F * static_cast<float>(group_ - 1);
    const int step = all ? group_ : 2 * group_;
    for (int y = all ? 0 : (turn >> 1) * group_; y < kCells; y += step) {
      for (int x = all ? 0 : (turn & 1) * group_; x < kCells; x += step) {
        if (!block_.IsOpen(x, y)) continue;
        const Eigen::Vector3f p = corner + (static_cast<float>(x) + to_middle) * plane_.step_x +
                                  (static_cast<float>(y) + to_middle) * plane_.step_y;
        if (p.z() < static_cast<float>(kNearest_m)) continue;
        const float inverse_z = 1.0F / p.z();
        const float u = fx * p.x() * inverse_z + cx, v = fy * p.y() * inverse_z + cy;
        if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(c.width) && v < static_cast<float>(c.height)))
          continue;
        const Pixel pixel{x, y, static_cast<int>(u), static_cast<int>(v), inverse_z};
        __builtin_prefetch(&view_.disparity->disparity_px(pixel.row, pixel.column));
        __builtin_prefetch(&view_.disparity->sigma_px(pixel.row, pixel.column));
        pixels_[static_cast<std::size_t>(num_pixels_++)] = pixel;
      }
    }
  }

  void Judge(const Pixel& pixel) {
    const float seen = view_.disparity->disparity_px(pixel.row, pixel.column);
    const int before = block_.At(pixel.x, pixel.y);
    // Of the plane at the very pixel, not at the cell: no rounding comes between them.
    const float expected = plane_.disparity.x() * static_cast<float>(pixel.column) +
                           plane_.disparity.y() * static_cast<float>(pixel.row) + plane_.disparity.z();
    if (!(seen > 0.0F)) {
      // What is nearer than was searched is not seen either, nor what the right image does not show.
      const bool could_be_seen =
          expected<kSearchedShare * view_.disparity->range_px&& static_cast<float>(pixel.column)> expected +
          kRightMargin_px;
      if (could_be_seen && before <= 0)
        SeeNothing(pixel, before, expected);
      else if (could_be_seen)
        Fade(pixel, before);
      return;
    }
    const float tolerance = kSigmas * view_.disparity->sigma_px(pixel.row, pixel.column) + kMatching_px +
                            plane_.fb * pixel.inverse_z * plane_.error_share;
    const int most = weight_ * kMostLooks;
    if (std::abs(seen - expected) <= tolerance) {
      if (tolerance * plane_.distance_m > plane_.reach_m * expected) return;
      ++result_.num_on;
      num_contradictions_ += before <= EvidenceGrid::kThrough;
      if (before < most) Set(pixel, std::min(before + (before < 0 ? kAgainst : 1) * weight_, most));
    } else if (seen < expected - kThroughFactor * tolerance) {
      ++result_.num_through;
      num_contradictions_ += before >= EvidenceGrid::kOn;
      if (before > -most) Set(pixel, std::max(before - (before > 0 ? kAgainst : 1) * weight_, -most));
    } else if (seen > expected + kThroughFactor * tolerance &&
               (seen - expected) * plane_.distance_m < kJustBehind_m * seen) {
      Fade(pixel, before);
    }
  }

  /// The image shows the place, and nothing in it: that says less than looking through the plane.
  void SeeNothing(const Pixel& pixel, int before, float expected) {
    const StereoCamera& c = view_.camera;
    const bool inside = static_cast<float>(pixel.column) > expected + kBorder_px &&
                        pixel.column < c.width - kBorder_px && pixel.row >= kBorder_px &&
                        pixel.row < c.height - kBorder_px;
    if (inside && before > kNothingSeen) Set(pixel, before - 1);
  }

  /// Only what was never seen as finely as this look sees it.
  void Fade(const Pixel& pixel, int before) {
    if (before > 0 && before <= kMostLooks * (weight_ - 1)) Set(pixel, std::max(before - kUnseen, 0));
  }

  void Set(const Pixel& pixel, int now) {
    const int before = block_.At(pixel.x, pixel.y);
    for (int y = pixel.y; y < pixel.y + group_; ++y)
      for (int x = pixel.x; x < pixel.x + group_; ++x) block_.At(x, y) = static_cast<std::int8_t>(now);
    if ((before >= EvidenceGrid::kOn) != (now >= EvidenceGrid::kOn)) result_.num_flipped += group_ * group_;
  }

  const FrameView& view_;
  const PlaneInView& plane_;
  EvidenceGrid::Block& block_;
  int weight_ = 1;
  int group_ = 1;  // cells along the edge of what one pixel stands for
  int num_contradictions_ = 0;
  LookResult result_;
  std::array<Pixel, static_cast<std::size_t>(kCells) * kCells> pixels_;
  int num_pixels_ = 0;
};

EvidenceLook::EvidenceLook(const FrameView& view) : view_(view), T_left_world_(view.T_world_left.inverse()) {
  const StereoCamera& c = view.camera;
  const double left = -c.cx / c.fx, right = (c.width - 1 - c.cx) / c.fx;
  const double top = -c.cy / c.fy, bottom = (c.height - 1 - c.cy) / c.fy;
  sides_ = {Eigen::Vector3d(1, 0, -left).normalized(), Eigen::Vector3d(-1, 0, right).normalized(),
            Eigen::Vector3d(0, 1, -top).normalized(), Eigen::Vector3d(0, -1, bottom).normalized()};
}

bool EvidenceLook::MayShow(const Eigen::Vector3d& centre_world, double radius_m) const {
  const Eigen::Vector3d centre = T_left_world_ * centre_world;
  if (centre.z() + radius_m < kNearest_m) return false;
  return std::none_of(sides_.begin(), sides_.end(),
                      [&](const Eigen::Vector3d& side) { return side.dot(centre) < -radius_m; });
}

LookResult EvidenceLook::At(const Plane& plane_world, const PlaneFrame& frame, double noise_m,
                            EvidenceGrid* grid) const {
  LookResult result;
  const Eigen::AlignedBox2d extent = grid->extent();
  if (extent.isEmpty() || !MayShow(frame.ToWorld(extent.center()), 0.6 * extent.diagonal().norm()))
    return result;
  const double distance = plane_world.SignedDistance(view_.T_world_left.translation());
  if (distance < kNearest_m * static_cast<double>(kLeastCosine)) return result;
  const StereoCamera& c = view_.camera;
  const Eigen::Matrix3d R = T_left_world_.linear();
  // n . z (x, y, 1) = -distance in the left frame, so that f b / z is linear in the pixel.
  const Eigen::Vector3d n = R * plane_world.normal * (-c.fx * c.baseline_m / distance);
  PlaneInView plane;
  plane.origin = (T_left_world_ * frame.origin).cast<float>();
  plane.step_x = (R * frame.x * grid->cell_m()).cast<float>();
  plane.step_y = (R * frame.y * grid->cell_m()).cast<float>();
  plane.disparity =
      Eigen::Vector3d(n.x() / c.fx, n.y() / c.fy, n.z() - n.x() * c.cx / c.fx - n.y() * c.cy / c.fy)
          .cast<float>();
  plane.error_share = kPlaneError_m / static_cast<float>(distance);
  plane.distance_m = static_cast<float>(distance);
  plane.reach_m = kMostReach_m + kReachNoise * static_cast<float>(noise_m);
  plane.cell_m = static_cast<float>(grid->cell_m());
  plane.fb = static_cast<float>(c.fx * c.baseline_m);
  plane.frame_id = view_.disparity->frame_id;

  const double radius = 0.75 * grid->block_m();
  for (auto& [key, block] : grid->blocks()) {
    const Eigen::Vector2d middle = grid->block_m() * Eigen::Vector2d(key.first + 0.5, key.second + 0.5);
    const bool settled = block.num_looks >= kSettledLooks && !block.contradicted;
    if (settled && ((key.first + key.second + plane.frame_id) & 1) != 0) continue;
    if (block.open == 0 || !MayShow(frame.ToWorld(middle), radius)) continue;
    BlockLook(view_, plane, &block).Run(key, &result);
  }
  return result;
}

}  // namespace terrace

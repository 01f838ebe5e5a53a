// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/polygon_merger.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/check.h"
#include "polygonization/evidence_look.h"
#include "polygonization/polygon_revision.h"
#include "polygonization/shadows.h"
#include "polygonization/sleeping_ids.h"
#include "polygonization/surface_grower.h"
#include "polygonization/surface_pieces.h"
#include "polygonization/surface_store.h"
#include "polygonization/surface_window.h"

namespace terrace {
namespace {

/// Tracing costs as much as the surface is large, while its plane follows every frame. Where cells of the
/// evidence came or went by as many as these, a surface is traced again after a few frames, more where it is
/// large; where less has changed, it waits longer.
constexpr FrameId kLeastPatience = 3;
constexpr FrameId kCellsPerFrame = 24;
constexpr FrameId kLargePatience = 6;
constexpr FrameId kMostPatience = 10;
constexpr int kFlippedCells = 24;
constexpr int kFlippedPerCell = 4;

/// Whether the evidence differs from what was traced by as much as is worth tracing anew.
bool HasOtherShape(const Surface& surface) {
  return surface.num_flipped >= kFlippedCells + kFlippedPerCell * static_cast<int>(surface.cells.size());
}

bool MayWait(const Surface& surface, FrameId frame_id) {
  if (surface.trace_now || surface.cells.empty()) return false;
  const auto num_cells = static_cast<FrameId>(surface.cells.size());
  const FrameId patience = HasOtherShape(surface)
                               ? std::min(kLargePatience, kLeastPatience + num_cells / kCellsPerFrame)
                               : kMostPatience;
  return frame_id - surface.traced_frame < patience;
}

/// The first revision of a polygon that comes back, greater than any it had: a frame makes no more than two,
/// one by what it shows and one by what it says of the staircase that the polygon belongs to.
int FirstRevisionAgain(FrameId frame_id) { return static_cast<int>(2 * (frame_id + 1)); }

/// Whether a frame saw the surface on it in the box around a piece.
bool ShowsIn(const TracedPiece& piece, const EvidenceGrid& evidence, FrameId frame_id) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : piece.outline) box.extend(p);
  return std::any_of(evidence.blocks().begin(), evidence.blocks().end(), [&](const auto& item) {
    if (item.second.on_frame != frame_id) return false;
    const Eigen::Vector2d corner = evidence.block_m() * Eigen::Vector2d(item.first.first, item.first.second);
    const Eigen::Vector2d far_corner = corner + Eigen::Vector2d::Constant(evidence.block_m());
    return box.intersects(Eigen::AlignedBox2d(corner, far_corner));
  });
}

}  // namespace

class PolygonMerger::Impl {
 public:
  Impl(const MergingConfig& config, const MapReach& reach)
      : config_(config), store_(config.outline_resolution_m), window_(reach), grower_(config_, &store_) {}

  PolygonUpdate Merge(const PatchUpdate& patches, const FrameView& view) {
    PolygonUpdate update;
    update.frame_id = patches.frame_id;
    update.t_capture = patches.t_capture;
    for (const PolygonId id : window_.Move(view.T_world_left.translation(), late_, polygons_, &store_))
      Remove(id, &update);
    store_.touched().clear();
    grower_.Grow(patches);
    Look(view);
    Publish(&update);
    SeeAgain(&update);
    return update;
  }

  PolygonUpdate SeeNothingNew(FrameId frame_id, Timestamp t_capture) {
    PolygonUpdate update;
    update.frame_id = frame_id;
    update.t_capture = t_capture;
    store_.touched().clear();
    for (const SurfaceId id : late_)
      if (const auto found = store_.surfaces().find(id); found != store_.surfaces().end())
        found->second.trace_now = true;
    Publish(&update);
    SeeAgain(&update);
    return update;
  }

  void Fold(const std::vector<CellKey>& cells) {
    for (const CellKey& key : cells) store_.Fold(key);
  }

  const PolygonMap& polygons() const { return polygons_; }
  std::int64_t memory_bytes() const {
    return store_.memory_bytes() + window_.memory_bytes() + polygons_.memory_bytes() +
           sleeping_.memory_bytes();
  }

 private:
  /// Every surface in view gathers evidence; where much has changed it is traced anew.
  void Look(const FrameView& view) {
    in_view_.clear();
    looked_frame_ = view.disparity->frame_id;
    const EvidenceLook look(view);
    for (auto& [id, surface] : store_.surfaces()) {
      const LookResult found =
          look.At(surface.plane_world, surface.Frame(), surface.noise_m, &surface.evidence);
      surface.num_flipped += found.num_flipped;
      if (HasOtherShape(surface)) store_.touched().insert(id);
      if (found.num_on > 0) in_view_.push_back(id);
    }
  }

  void Publish(PolygonUpdate* update) {
    std::vector<SurfacePiece> pieces;
    std::set<PolygonId> free_ids;
    std::vector<SurfaceId> traced;
    std::set<SurfaceId> due = std::exchange(late_, {});
    due.insert(store_.touched().begin(), store_.touched().end());
    for (const SurfaceId id : due) {
      const auto found = store_.surfaces().find(id);
      if (found == store_.surfaces().end()) continue;
      Surface& surface = found->second;
      // It grows into a polygon, or goes.
      if (surface.polygons.empty() && !surface.cells.empty() && surface.area_m2 < config_.min_area_m2)
        continue;
      if (MayWait(surface, update->frame_id)) {
        late_.insert(id);
        for (std::size_t i = 0; i < surface.pieces.size(); ++i)
          Revise(surface.polygons[i], surface, surface.pieces[i], update);
        continue;
      }
      if (surface.cells.empty()) {
        free_ids.insert(surface.polygons.begin(), surface.polygons.end());
        store_.surfaces().erase(found);
        continue;
      }
      traced.push_back(id);
      surface.trace_now = false;
      surface.traced_frame = update->frame_id;
      surface.num_flipped = 0;
      if (IsShadow(id, store_)) continue;
      const Neighbours neighbours = store_.NeighboursOf(id);
      store_.Reopen(id);
      CutPieces(id, neighbours, store_, config_, &pieces);
    }
    // Only now: surfaces that are traced in one frame are neighbours of each other, too.
    for (const SurfaceId id : traced) {
      Surface& surface = store_.surfaces().at(id);
      free_ids.insert(surface.polygons.begin(), surface.polygons.end());
      surface.polygons.clear();
      surface.pieces.clear();
    }
    PublishPieces(std::move(pieces), std::move(free_ids), update);
  }

  void PublishPieces(std::vector<SurfacePiece> pieces, std::set<PolygonId> free_ids, PolygonUpdate* update) {
    const std::vector<PolygonId> old_ids = ClaimIds(pieces, &free_ids);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      Surface& surface = store_.surfaces().at(pieces[i].surface);
      PolygonId id = old_ids[i];
      if (id != 0)
        Revise(id, surface, pieces[i].traced, update);
      else
        id = Add(surface, pieces[i].traced, update);
      for (const MemberRef& ref : pieces[i].members) store_.At(ref).polygon = id;
      surface.polygons.push_back(id);
      surface.pieces.push_back(std::move(pieces[i].traced));
    }
    for (const PolygonId id : free_ids) {
      const PolygonMap::Entry& gone = *polygons_.FindEntry(id);
      sleeping_.Sleep(*gone.polygon, gone.num_observations);
      Remove(id, update);
    }
    std::sort(update->removed.begin(), update->removed.end());
    for (std::vector<PolygonId>* ids : {&update->added, &update->revised}) {
      std::sort(ids->begin(), ids->end());
      for (const PolygonId id : *ids) update->changed.push_back(polygons_.Find(id));
    }
    std::sort(update->changed.begin(), update->changed.end(),
              [](const PolygonPtr& a, const PolygonPtr& b) { return a->id < b->id; });
  }

  void Remove(PolygonId id, PolygonUpdate* update) {
    polygons_.Erase(id);
    update->removed.push_back(id);
  }

  /// Polygons that this frame showed, and that did not change by it.
  void SeeAgain(PolygonUpdate* update) {
    const auto is_new = [&](PolygonId id) {
      return std::binary_search(update->added.begin(), update->added.end(), id) ||
             std::binary_search(update->revised.begin(), update->revised.end(), id);
    };
    for (const SurfaceId id : in_view_) {
      const auto found = store_.surfaces().find(id);
      if (found == store_.surfaces().end()) continue;
      const Surface& surface = found->second;
      for (std::size_t i = 0; i < surface.pieces.size(); ++i) {
        if (is_new(surface.polygons[i])) continue;
        if (surface.pieces.size() > 1 && !ShowsIn(surface.pieces[i], surface.evidence, looked_frame_))
          continue;
        polygons_.Seen(surface.polygons[i], update->t_capture);
        update->seen.push_back(surface.polygons[i]);
      }
    }
    std::sort(update->seen.begin(), update->seen.end());
  }

  /// A new revision where it changed enough.
  void Revise(PolygonId id, const Surface& surface, const TracedPiece& piece, PolygonUpdate* update) {
    Polygon polygon = MakePolygon(id, surface, piece, update->t_capture);
    const PolygonMap::Entry& before = *polygons_.FindEntry(id);
    if (!HasChanged(*before.polygon, polygon, config_.min_change_m)) return;
    polygon.revision = before.polygon->revision + 1;
    polygon.num_observations = before.num_observations + 1;
    polygon.first_seen = before.polygon->first_seen;
    update->revised.push_back(id);
    polygons_.Put(std::make_shared<const Polygon>(std::move(polygon)));
  }

  /// A polygon where none is: one that went comes back, or it is new.
  PolygonId Add(const Surface& surface, const TracedPiece& piece, PolygonUpdate* update) {
    Polygon polygon = MakePolygon(0, surface, piece, update->t_capture);
    if (const std::optional<SleepingIds::Past> past = sleeping_.Wake(polygon)) {
      polygon.id = past->id;
      polygon.revision = FirstRevisionAgain(update->frame_id);
      polygon.num_observations = past->num_observations + 1;
      polygon.first_seen = past->first_seen;
    } else {
      polygon.id = next_polygon_++;
    }
    const PolygonId id = polygon.id;
    update->added.push_back(id);
    polygons_.Put(std::make_shared<const Polygon>(std::move(polygon)));
    return id;
  }

  const MergingConfig config_;
  SurfaceStore store_;    // of the surfaces near the camera
  SurfaceWindow window_;  // keeps the others
  SurfaceGrower grower_;
  PolygonMap polygons_;
  SleepingIds sleeping_;
  PolygonId next_polygon_ = 1;
  std::vector<SurfaceId> in_view_;  // of the last frame that was looked at
  FrameId looked_frame_ = 0;
  std::set<SurfaceId> late_;  // surfaces whose outlines wait to be traced
};

PolygonMerger::PolygonMerger(const MergingConfig& config, const MapReach& reach) {
  TERRACE_CHECK(config.Problems().empty());
  impl_ = std::make_unique<Impl>(config, reach);
}
PolygonMerger::~PolygonMerger() = default;

PolygonUpdate PolygonMerger::Merge(const PatchUpdate& patches, const FrameView& view) {
  return impl_->Merge(patches, view);
}
PolygonUpdate PolygonMerger::SeeNothingNew(FrameId frame_id, Timestamp t_capture) {
  return impl_->SeeNothingNew(frame_id, t_capture);
}
void PolygonMerger::Fold(const std::vector<CellKey>& cells) { impl_->Fold(cells); }
const PolygonMap& PolygonMerger::polygons() const { return impl_->polygons(); }
std::int64_t PolygonMerger::memory_bytes() const { return impl_->memory_bytes(); }

}  // namespace terrace

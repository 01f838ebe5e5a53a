// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/polygon_merger.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>

#include <Eigen/Eigenvalues>

#include "core/angles.h"
#include "core/check.h"
#include "polygonization/outline.h"

namespace terrace {
namespace {

using SurfaceId = std::int64_t;
constexpr SurfaceId kNoSurface = 0;

/// What stays wrong with a patch however many points it has (pixel locking, calibration).
constexpr double kSystematic_m = 0.003;
/// A patch too small to have a direction of its own still has to look roughly the same way.
constexpr double kMaxExtraAngle_rad = 0.5;
/// A member leaves its surface only when it fits this much worse than a newcomer may.
constexpr double kLeaveFactor = 1.5;
/// A surface is traced after one frame more for every so many cells of it, but at the latest after so many
/// frames.
constexpr FrameId kCellsPerFrame = 12;
constexpr FrameId kMostPatience = 10;
/// A polygon is larger than this many times its noise.
constexpr double kCredibleEdge = 6.0;
/// A surface is the shadow of a stronger one that covers it, faces the same way and lies no farther away than
/// this, and so many times its noise.
constexpr double kShadowOffset_m = 0.05;
constexpr double kShadowNoise = 4.0;
constexpr double kShadowAngle_rad = 0.45;
constexpr double kShadowStrength = 4.0;
constexpr double kShadowShare = 0.5;
/// The axes of a surface's outline are laid anew when its normal has turned by this much.
constexpr double kMaxTurn_rad = 0.03;

struct CellKeyHash {
  std::size_t operator()(const CellKey& key) const {
    std::uint64_t h = static_cast<std::uint32_t>(key.x);
    h = h * 0x9E3779B97F4A7C15ULL + static_cast<std::uint32_t>(key.y);
    h = h * 0x9E3779B97F4A7C15ULL + static_cast<std::uint32_t>(key.z);
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

struct Member {
  Patch patch;
  Eigen::Vector3d mean_world;
  Eigen::Vector3d low_world, high_world;  // box around the footprints
  double angle_sigma_rad = 0.0;           // how well its own normal is known
  SurfaceId surface = kNoSurface;
  PolygonId polygon = 0;  // the polygon that it was part of last
};

struct CellMembers {
  Eigen::Vector3d centre_world;
  std::vector<Member> members;
};

struct MemberRef {
  CellKey cell;
  int index = 0;
  friend auto operator<=>(const MemberRef&, const MemberRef&) = default;
};

/// Patches that lie in one plane and hang together; published as one polygon for each connected piece.
struct Surface {
  Plane plane_world;
  PlaneMoments moments;  // relative to `origin_world`
  Eigen::Vector3d origin_world;
  double angle_sigma_rad = 0.0;
  double noise_m = 0.0;  // of single points, as that of patches
  // Outlines are drawn in these axes, which stay when the plane moves a little.
  Eigen::Vector3d anchor_normal;
  PlaneAxes axes;
  std::set<CellKey> cells;
  std::vector<PolygonId> polygons;
  std::vector<PlanarShape> shapes;  // of the polygons, as last traced
  FrameId traced_frame = 0;
  bool trace_now = true;  // the shapes are missing or of other axes
};

/// Standard deviation of the normal that moments alone support, across the narrow side of the patch.
double AngleSigma(const PlaneMoments& moments) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments.Covariance(), Eigen::EigenvaluesOnly);
  const double width2 = std::max(solver.eigenvalues()(1), 1e-8);
  return std::sqrt((1.0 / moments.weight + kSystematic_m * kSystematic_m) / width2);
}

}  // namespace

std::vector<std::string> MergingConfig::Problems() const {
  std::vector<std::string> problems;
  const auto positive = [&](double value, const char* name) {
    if (!(value > 0.0)) problems.push_back(std::string(name) + " must be above 0");
  };
  positive(max_offset_m, "max_offset_m");
  if (!(max_angle_deg > 0.0 && max_angle_deg < 45.0))
    problems.push_back("max_angle_deg must be between 0 and 45");
  positive(max_gap_m, "max_gap_m");
  if (!(min_width_m >= 0.0)) problems.push_back("min_width_m must not be negative");
  positive(min_area_m2, "min_area_m2");
  positive(outline_resolution_m, "outline_resolution_m");
  positive(simplify_m, "simplify_m");
  if (max_vertices < 16 || max_vertices > 5000) {
    problems.push_back("max_vertices = " + std::to_string(max_vertices) + " must lie between 16 and 5000");
  }
  positive(min_change_m, "min_change_m");
  return problems;
}

class PolygonMerger::Impl {
 public:
  explicit Impl(const MergingConfig& config) : config_(config) {}

  PolygonUpdate Merge(const PatchUpdate& update) {
    touched_.clear();
    PolygonUpdate result{update.frame_id, update.t_capture, {}, {}, {}};
    Replace(update);
    for (int round = 0; round < kRounds && (round == 0 || !homeless_.empty()); ++round) {
      FindHomes();
      JoinSurfaces(update);
      RefitTouched();
      EvictMisfits();
    }
    for (const MemberRef& ref : homeless_) FoundSurface(ref);
    homeless_.clear();
    RefitTouched();
    Publish(update.frame_id, update.t_capture, &result);
    for (const auto& [id, polygon] : polygons_) result.polygons.push_back(polygon);
    return result;
  }

  std::int64_t memory_bytes() const {
    std::size_t bytes = 0;
    for (const auto& [key, cell] : cells_) {
      bytes += sizeof(key) + sizeof(cell) + cell.members.capacity() * sizeof(Member);
      for (const Member& member : cell.members)
        bytes += member.patch.footprints.capacity() * sizeof(Footprint);
    }
    for (const auto& [id, surface] : surfaces_)
      bytes += sizeof(surface) + surface.cells.size() * 4 * sizeof(CellKey);
    for (const auto& [id, polygon] : polygons_) {
      bytes += sizeof(Polygon) + polygon->outline_world.capacity() * sizeof(Eigen::Vector3d);
      for (const Ring& hole : polygon->holes_world) bytes += hole.capacity() * sizeof(Eigen::Vector3d);
    }
    return static_cast<std::int64_t>(bytes);
  }

 private:
  static constexpr int kRounds = 2;

  Member& At(const MemberRef& ref) {
    return cells_.at(ref.cell).members[static_cast<std::size_t>(ref.index)];
  }

  // --- patches in and out ---

  /// Puts the new patches in the place of the old ones. A new patch that fits the surface of an old one of
  /// its cell goes straight there.
  void Replace(const PatchUpdate& update) {
    homeless_.clear();
    for (const PatchUpdate::CellPatches& cell : update.cells) {
      std::vector<Member> old;
      if (const auto found = cells_.find(cell.key); found != cells_.end())
        old = std::move(found->second.members);
      for (const Member& member : old) {
        if (member.surface == kNoSurface) continue;
        surfaces_.at(member.surface).cells.erase(cell.key);
        touched_.insert(member.surface);
      }
      if (cell.patches.empty()) {
        cells_.erase(cell.key);
        continue;
      }
      CellMembers& now = cells_[cell.key];
      now = {cell.centre_world, {}};
      for (const Patch& patch : cell.patches) {
        now.members.push_back(MakeMember(patch, cell.centre_world));
        Member& member = now.members.back();
        const MemberRef ref{cell.key, static_cast<int>(now.members.size()) - 1};
        double best = std::numeric_limits<double>::infinity();
        for (const Member& before : old) {
          if (before.surface == kNoSurface) continue;
          const std::optional<double> misfit = Misfit(member, surfaces_.at(before.surface), 1.0);
          if (!misfit || *misfit >= best) continue;
          best = *misfit;
          member.surface = before.surface;
          member.polygon = before.polygon;
        }
        if (member.surface != kNoSurface)
          surfaces_.at(member.surface).cells.insert(cell.key);
        else
          homeless_.push_back(ref);
      }
    }
  }

  static Member MakeMember(const Patch& patch, const Eigen::Vector3d& centre) {
    Member member;
    member.patch = patch;
    member.mean_world = centre + patch.moments.Mean();
    member.low_world.setConstant(std::numeric_limits<double>::infinity());
    member.high_world = -member.low_world;
    for (const Footprint& f : patch.footprints) {
      const Eigen::Vector3d at = centre + f.centre.cast<double>();
      const Eigen::Vector3d extent = (f.half_x.cwiseAbs() + f.half_y.cwiseAbs()).cast<double>();
      member.low_world = member.low_world.cwiseMin(at - extent);
      member.high_world = member.high_world.cwiseMax(at + extent);
    }
    member.angle_sigma_rad = AngleSigma(patch.moments);
    return member;
  }

  // --- what belongs together ---

  /// How badly a patch fits a surface, or nothing when it does not belong there at all.
  std::optional<double> Misfit(const Member& member, const Surface& surface, double slack) const {
    const Plane& plane = surface.plane_world;
    const double angle = std::acos(std::clamp(plane.normal.dot(member.patch.plane_world.normal), -1.0, 1.0));
    const double max_angle =
        Radians(slack * config_.max_angle_deg) +
        std::min(kMaxExtraAngle_rad, 2.0 * (member.angle_sigma_rad + surface.angle_sigma_rad));
    if (angle > max_angle) return std::nullopt;
    const double offset = std::abs(plane.SignedDistance(member.mean_world));
    const double max_offset = slack * (config_.max_offset_m + 2.0 * member.patch.noise_m);
    if (offset > max_offset) return std::nullopt;
    // The farthest end of the patch must not stand off either, where its own direction is known.
    const double reach = 0.5 * (member.high_world - member.low_world).norm();
    const double tilt = std::max(0.0, angle - 2.0 * member.angle_sigma_rad);
    if (offset + reach * std::sin(tilt) > 2.0 * max_offset) return std::nullopt;
    return offset / max_offset + angle / max_angle;
  }

  bool Near(const Member& a, const Member& b) const {
    return ((a.low_world - b.high_world).array() <= config_.max_gap_m).all() &&
           ((b.low_world - a.high_world).array() <= config_.max_gap_m).all();
  }

  /// Calls visit(ref, member) for every patch of the cell and the 26 around it that comes near the given one.
  template <typename Visitor>
  void ForEachNeighbour(const MemberRef& ref, const Visitor& visit) {
    const Member& member = At(ref);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const CellKey key{ref.cell.x + dx, ref.cell.y + dy, ref.cell.z + dz};
          const auto found = cells_.find(key);
          if (found == cells_.end()) continue;
          for (int i = 0; i < static_cast<int>(found->second.members.size()); ++i) {
            const MemberRef other{key, i};
            if (other == ref) continue;
            const Member& neighbour = found->second.members[static_cast<std::size_t>(i)];
            if (Near(member, neighbour)) visit(other, neighbour);
          }
        }
      }
    }
  }

  /// Region growing: each homeless patch joins the neighbouring surface that it fits best, best-known patches
  /// first; one that fits none founds a surface that others may join.
  void FindHomes() {
    std::vector<MemberRef> queue;
    queue.swap(homeless_);
    std::sort(queue.begin(), queue.end(), [&](const MemberRef& a, const MemberRef& b) {
      const double wa = At(a).patch.area_m2, wb = At(b).patch.area_m2;
      return wa != wb ? wa > wb : a < b;
    });
    for (const MemberRef& ref : queue) {
      SurfaceId home = kNoSurface;
      double best = std::numeric_limits<double>::infinity();
      ForEachNeighbour(ref, [&](const MemberRef&, const Member& neighbour) {
        if (neighbour.surface == kNoSurface || neighbour.surface == home) return;
        const std::optional<double> misfit = Misfit(At(ref), surfaces_.at(neighbour.surface), 1.0);
        if (!misfit || *misfit > best || (*misfit == best && neighbour.surface > home)) return;
        best = *misfit;
        home = neighbour.surface;
      });
      if (home == kNoSurface) {
        FoundSurface(ref);
      } else {
        Join(ref, home);
      }
    }
  }

  void Join(const MemberRef& ref, SurfaceId id) {
    Member& member = At(ref);
    member.surface = id;
    surfaces_.at(id).cells.insert(ref.cell);
    touched_.insert(id);
  }

  void FoundSurface(const MemberRef& ref) {
    Member& member = At(ref);
    const SurfaceId id = next_surface_++;
    Surface& surface = surfaces_[id];
    surface.plane_world = member.patch.plane_world;
    surface.angle_sigma_rad = member.angle_sigma_rad;
    surface.noise_m = member.patch.noise_m;
    surface.origin_world = member.mean_world;
    Anchor(&surface);
    Join(ref, id);
  }

  /// Joins neighbouring surfaces whose points one plane explains.
  void JoinSurfaces(const PatchUpdate& update) {
    RefitTouched();
    // Pairs that meet in or beside a cell that changed.
    std::set<std::pair<SurfaceId, SurfaceId>> pairs;
    for (const PatchUpdate::CellPatches& cell : update.cells) {
      for (int i = 0; i < static_cast<int>(cell.patches.size()); ++i) {
        const Member& member = At({cell.key, i});
        if (member.surface == kNoSurface) continue;
        const Surface& surface = surfaces_.at(member.surface);
        ForEachNeighbour({cell.key, i}, [&](const MemberRef&, const Member& neighbour) {
          if (neighbour.surface == kNoSurface || neighbour.surface == member.surface) return;
          if (!Misfit(member, surfaces_.at(neighbour.surface), 1.0) && !Misfit(neighbour, surface, 1.0))
            return;
          pairs.insert(std::minmax(member.surface, neighbour.surface));
        });
      }
    }
    for (const auto& [a, b] : pairs) {
      const SurfaceId first = Survivor(a), second = Survivor(b);
      if (first == second || !OnePlane(surfaces_.at(first), surfaces_.at(second))) continue;
      const bool keep_first = surfaces_.at(first).moments.weight >= surfaces_.at(second).moments.weight;
      Absorb(keep_first ? first : second, keep_first ? second : first);
    }
    absorbed_by_.clear();
  }

  SurfaceId Survivor(SurfaceId id) const {
    for (auto found = absorbed_by_.find(id); found != absorbed_by_.end(); found = absorbed_by_.find(id))
      id = found->second;
    return id;
  }

  bool OnePlane(const Surface& a, const Surface& b) const {
    const double angle = std::acos(std::clamp(a.plane_world.normal.dot(b.plane_world.normal), -1.0, 1.0));
    if (angle > Radians(config_.max_angle_deg) +
                    std::min(kMaxExtraAngle_rad, 2.0 * (a.angle_sigma_rad + b.angle_sigma_rad)))
      return false;
    const bool a_larger = a.moments.weight >= b.moments.weight;
    const Surface &large = a_larger ? a : b, &small = a_larger ? b : a;
    PlaneMoments both = large.moments;
    const Eigen::Vector3d shift = small.origin_world - large.origin_world;
    both.Add(small.moments, shift);
    const Plane plane = both.Fit(large.plane_world.normal);
    PlaneMoments shifted;
    shifted.Add(small.moments, shift);
    const auto explains = [&](const PlaneMoments& moments, double noise_m) {
      const double limit = 0.7 * config_.max_offset_m + 1.5 * noise_m;
      return moments.MeanSquaredDistance(plane) < limit * limit;
    };
    return explains(large.moments, large.noise_m) && explains(shifted, small.noise_m);
  }

  void Absorb(SurfaceId keep, SurfaceId lose) {
    Surface& winner = surfaces_.at(keep);
    Surface& loser = surfaces_.at(lose);
    for (const CellKey& key : loser.cells) {
      winner.cells.insert(key);
      for (Member& member : cells_.at(key).members)
        if (member.surface == lose) member.surface = keep;
    }
    // Its polygons' ids may live on.
    winner.polygons.insert(winner.polygons.end(), loser.polygons.begin(), loser.polygons.end());
    winner.trace_now = true;
    surfaces_.erase(lose);
    touched_.erase(lose);
    touched_.insert(keep);
    absorbed_by_[lose] = keep;
    Refit(&winner, keep);
  }

  // --- planes ---

  void RefitTouched() {
    for (const SurfaceId id : touched_)
      if (const auto found = surfaces_.find(id); found != surfaces_.end()) Refit(&found->second, id);
  }

  /// Sums the moments of all patches anew: cheap, and nothing accumulates.
  void Refit(Surface* surface, SurfaceId id) {
    PlaneMoments moments;
    double noise2 = 0.0;
    for (const CellKey& key : surface->cells) {
      const CellMembers& cell = cells_.at(key);
      for (const Member& member : cell.members) {
        if (member.surface != id) continue;
        moments.Add(member.patch.moments, cell.centre_world - surface->origin_world);
        noise2 += member.patch.moments.weight * member.patch.noise_m * member.patch.noise_m;
      }
    }
    surface->moments = moments;
    if (!(moments.weight > 0.0)) return;
    surface->plane_world = moments.Fit(surface->plane_world.normal);
    surface->plane_world.offset_m += surface->plane_world.normal.dot(surface->origin_world);
    surface->angle_sigma_rad = AngleSigma(moments);
    surface->noise_m = std::sqrt(noise2 / moments.weight);
    if (surface->plane_world.normal.dot(surface->anchor_normal) < std::cos(kMaxTurn_rad)) Anchor(surface);
  }

  static void Anchor(Surface* surface) {
    surface->anchor_normal = surface->plane_world.normal;
    surface->axes = AxesOf(surface->anchor_normal);
    surface->trace_now = true;
  }

  void EvictMisfits() {
    for (const SurfaceId id : std::vector<SurfaceId>(touched_.begin(), touched_.end())) {
      const auto found = surfaces_.find(id);
      if (found == surfaces_.end()) continue;
      Surface& surface = found->second;
      for (const CellKey& key : std::vector<CellKey>(surface.cells.begin(), surface.cells.end())) {
        auto& members = cells_.at(key).members;
        bool still_here = false;
        for (int i = 0; i < static_cast<int>(members.size()); ++i) {
          Member& member = members[static_cast<std::size_t>(i)];
          if (member.surface != id) continue;
          if (Misfit(member, surface, kLeaveFactor)) {
            still_here = true;
          } else {
            member.surface = kNoSurface;
            homeless_.push_back({key, i});
          }
        }
        if (!still_here) surface.cells.erase(key);
      }
    }
  }

  // --- outlines ---

  struct Piece {
    SurfaceId surface = kNoSurface;
    PlanarShape shape;
    std::map<PolygonId, double> votes;  // area that was part of that polygon before
    std::vector<MemberRef> members;
  };

  void Publish(FrameId frame_id, Timestamp t_capture, PolygonUpdate* result) {
    std::vector<Piece> pieces;
    std::set<PolygonId> free_ids;
    touched_.insert(late_.begin(), late_.end());
    late_.clear();
    for (const SurfaceId id : touched_) {
      const auto found = surfaces_.find(id);
      if (found == surfaces_.end()) continue;
      Surface& surface = found->second;
      // Tracing costs as much as the surface is large: a large one is traced in every few frames only, while
      // its plane follows every frame.
      const FrameId patience =
          std::min<FrameId>(kMostPatience, static_cast<FrameId>(surface.cells.size()) / kCellsPerFrame);
      if (!surface.trace_now && !surface.cells.empty() && frame_id - surface.traced_frame < patience) {
        late_.insert(id);
        for (std::size_t i = 0; i < surface.shapes.size(); ++i)
          Update(surface.polygons[i], surface, surface.shapes[i], t_capture, result);
        continue;
      }
      free_ids.insert(surface.polygons.begin(), surface.polygons.end());
      surface.polygons.clear();
      surface.shapes.clear();
      surface.trace_now = false;
      surface.traced_frame = frame_id;
      if (surface.cells.empty()) {
        surfaces_.erase(found);
        continue;
      }
      if (!IsShadow(id, surface)) CutPieces(id, surface, &pieces);
    }
    // Ids go to the pieces that hold most of the old polygon; ties to the older id.
    std::vector<std::tuple<double, PolygonId, std::size_t>> claims;
    for (std::size_t i = 0; i < pieces.size(); ++i)
      for (const auto& [polygon, area] : pieces[i].votes)
        if (free_ids.contains(polygon)) claims.emplace_back(-area, polygon, i);
    std::sort(claims.begin(), claims.end());
    std::vector<PolygonId> ids(pieces.size(), 0);
    for (const auto& [area, polygon, i] : claims) {
      if (ids[i] != 0 || !free_ids.contains(polygon)) continue;
      ids[i] = polygon;
      free_ids.erase(polygon);
    }
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (ids[i] == 0) ids[i] = next_polygon_++;
      Surface& surface = surfaces_.at(pieces[i].surface);
      for (const MemberRef& ref : pieces[i].members) At(ref).polygon = ids[i];
      Update(ids[i], surface, pieces[i].shape, t_capture, result);
      surface.polygons.push_back(ids[i]);
      surface.shapes.push_back(std::move(pieces[i].shape));
    }
    for (const PolygonId id : free_ids) {
      polygons_.erase(id);
      result->removed.push_back(id);
    }
    std::sort(result->changed.begin(), result->changed.end());
  }

  /// Matching errors put thin layers in front of and behind a surface. They are many times weaker than the
  /// surface, noisy, and lie over it.
  bool IsShadow(SurfaceId id, const Surface& surface) {
    const double reach = kShadowOffset_m + kShadowNoise * surface.noise_m;
    double covered = 0.0, all = 0.0;
    for (const CellKey& key : surface.cells) {
      const auto& members = cells_.at(key).members;
      for (int i = 0; i < static_cast<int>(members.size()); ++i) {
        const Member& member = members[static_cast<std::size_t>(i)];
        if (member.surface != id) continue;
        all += member.patch.area_m2;
        const auto covers = [&](const Member& other) {
          if (other.surface == kNoSurface || other.surface == id) return false;
          const Surface& stronger = surfaces_.at(other.surface);
          if (stronger.moments.weight < kShadowStrength * surface.moments.weight) return false;
          if (stronger.plane_world.normal.dot(surface.plane_world.normal) < std::cos(kShadowAngle_rad))
            return false;
          if (std::abs(stronger.plane_world.SignedDistance(member.mean_world)) > reach) return false;
          const Eigen::Vector3d onto = stronger.plane_world.Project(member.mean_world);
          return ((onto - other.low_world).array() > -kShadowOffset_m).all() &&
                 ((other.high_world - onto).array() > -kShadowOffset_m).all();
        };
        if (AnyAround(key, covers)) covered += member.patch.area_m2;
      }
    }
    return covered > kShadowShare * all;
  }

  /// True when the predicate holds for a patch in the cell or the 26 around it.
  template <typename Predicate>
  bool AnyAround(const CellKey& key, const Predicate& predicate) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const auto found = cells_.find({key.x + dx, key.y + dy, key.z + dz});
          if (found == cells_.end()) continue;
          if (std::any_of(found->second.members.begin(), found->second.members.end(), predicate)) return true;
        }
      }
    }
    return false;
  }

  void CutPieces(SurfaceId id, const Surface& surface, std::vector<Piece>* pieces) {
    struct Drawn {
      MemberRef ref;
      std::vector<Eigen::Vector2d> centres;
    };
    std::vector<Drawn> drawn;
    const auto to_plane = [&](const Eigen::Vector3d& v) {
      return Eigen::Vector2d(surface.axes.x.dot(v), surface.axes.y.dot(v));
    };
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector2d high = -low;
    for (const CellKey& key : surface.cells) {
      const CellMembers& cell = cells_.at(key);
      const Eigen::Vector3d centre = cell.centre_world - surface.origin_world;
      for (int i = 0; i < static_cast<int>(cell.members.size()); ++i) {
        const Member& member = cell.members[static_cast<std::size_t>(i)];
        if (member.surface != id) continue;
        drawn.push_back({{key, i}, {}});
        for (const Footprint& f : member.patch.footprints) {
          const Eigen::Vector2d at = to_plane(centre + f.centre.cast<double>());
          const Eigen::Vector2d extent =
              to_plane(f.half_x.cast<double>()).cwiseAbs() + to_plane(f.half_y.cast<double>()).cwiseAbs();
          low = low.cwiseMin(at - extent);
          high = high.cwiseMax(at + extent);
          drawn.back().centres.push_back(at);
        }
      }
    }
    OutlineTracer tracer({config_.outline_resolution_m, config_.max_gap_m, config_.min_width_m,
                          config_.min_area_m2, config_.simplify_m, config_.max_vertices},
                         low, high);
    for (const Drawn& d : drawn) {
      const Member& member = At(d.ref);
      for (std::size_t i = 0; i < d.centres.size(); ++i)
        tracer.Fill(d.centres[i], to_plane(member.patch.footprints[i].half_x.cast<double>()),
                    to_plane(member.patch.footprints[i].half_y.cast<double>()));
    }
    const double credible_edge = kCredibleEdge * surface.noise_m;
    std::vector<int> piece_of;  // of each shape; -1 when it is not published
    for (PlanarShape& shape : tracer.Trace()) {
      if (shape.area_m2 < credible_edge * credible_edge) {
        piece_of.push_back(-1);
        continue;
      }
      piece_of.push_back(static_cast<int>(pieces->size()));
      pieces->emplace_back();
      pieces->back().surface = id;
      pieces->back().shape = std::move(shape);
    }
    // A patch votes for the piece that most of its leaves lie in.
    for (const Drawn& d : drawn) {
      std::map<int, int> hits;
      for (const Eigen::Vector2d& centre : d.centres)
        if (const int shape = tracer.ShapeAt(centre); shape >= 0) ++hits[shape];
      int best = -1, most = 0;
      for (const auto& [shape, count] : hits) {
        if (count <= most) continue;
        best = shape;
        most = count;
      }
      if (best < 0 || piece_of[static_cast<std::size_t>(best)] < 0) continue;
      Piece& piece = (*pieces)[static_cast<std::size_t>(piece_of[static_cast<std::size_t>(best)])];
      const Member& member = At(d.ref);
      if (member.polygon != 0) piece.votes[member.polygon] += member.patch.area_m2;
      piece.members.push_back(d.ref);
    }
  }

  /// A new revision of a polygon, when it changed enough.
  void Update(PolygonId id, const Surface& surface, const PlanarShape& shape, Timestamp t_capture,
              PolygonUpdate* result) {
    auto polygon = std::make_shared<Polygon>();
    polygon->id = id;
    polygon->plane_world = surface.plane_world;
    const auto lift = [&](const Eigen::Vector2d& p) {
      const Eigen::Vector3d at = surface.origin_world + p.x() * surface.axes.x + p.y() * surface.axes.y;
      const Plane& plane = surface.plane_world;
      return Eigen::Vector3d(at - plane.SignedDistance(at) / plane.normal.dot(surface.anchor_normal) *
                                      surface.anchor_normal);
    };
    const auto lift_ring = [&](const Ring2& ring) {
      Ring lifted;
      for (const Eigen::Vector2d& p : ring) lifted.push_back(lift(p));
      return lifted;
    };
    polygon->outline_world = lift_ring(shape.outline);
    for (const Ring2& hole : shape.holes) polygon->holes_world.push_back(lift_ring(hole));
    polygon->area_m2 = shape.area_m2;
    polygon->centroid_world = lift(shape.centroid);
    polygon->support = shape.support;
    const PlaneMoments& moments = surface.moments;
    polygon->rms_m = std::sqrt(moments.MeanSquaredDistance(
        {surface.plane_world.normal,
         surface.plane_world.offset_m - surface.plane_world.normal.dot(surface.origin_world)}));
    polygon->noise_m = surface.noise_m;
    polygon->plane_covariance = PlaneCovariance(surface, polygon->centroid_world);
    polygon->revision = 1;
    polygon->num_observations = 1;
    polygon->first_seen = polygon->last_seen = t_capture;
    const auto found = polygons_.find(id);
    if (found != polygons_.end()) {
      const Polygon& before = *found->second;
      if (!Changed(before, *polygon)) return;
      polygon->revision = before.revision + 1;
      polygon->num_observations = before.num_observations + 1;
      polygon->first_seen = before.first_seen;
    }
    polygons_[id] = std::move(polygon);
    result->changed.push_back(id);
  }

  /// Covariance of tilt about x, tilt about y and offset at the centroid, axes of AxesOf(normal). With the
  /// plane as z = z0 + a x + b y, the tilt about x is b and the tilt about y is -a.
  static Eigen::Matrix3d PlaneCovariance(const Surface& surface, const Eigen::Vector3d& centroid_world) {
    const PlaneAxes axes = AxesOf(surface.plane_world.normal);
    PlaneMoments about;
    about.Add(surface.moments, surface.origin_world - centroid_world);
    const Eigen::Vector3d to_tilt_x = axes.y, to_tilt_y = -axes.x;
    Eigen::Matrix3d information;
    information << to_tilt_x.dot(about.sum_outer * to_tilt_x), to_tilt_x.dot(about.sum_outer * to_tilt_y),
        to_tilt_x.dot(about.sum),  //
        to_tilt_y.dot(about.sum_outer * to_tilt_x), to_tilt_y.dot(about.sum_outer * to_tilt_y),
        to_tilt_y.dot(about.sum),  //
        to_tilt_x.dot(about.sum), to_tilt_y.dot(about.sum), about.weight;
    Eigen::Matrix3d covariance = information.inverse();
    // What more points do not cure.
    const double systematic = kSystematic_m * kSystematic_m;
    const Eigen::Matrix3d spread = about.Covariance();
    covariance(0, 0) += systematic / std::max(1e-8, axes.y.dot(spread * axes.y));
    covariance(1, 1) += systematic / std::max(1e-8, axes.x.dot(spread * axes.x));
    covariance(2, 2) += systematic;
    return covariance;
  }

  bool Changed(const Polygon& before, const Polygon& now) const {
    double perimeter = 0.0;
    const Ring& ring = now.outline_world;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      // The plane as it was and as it is, at the corners.
      if (std::abs(before.plane_world.SignedDistance(ring[i])) > config_.min_change_m) return true;
      perimeter += (ring[(i + 1) % ring.size()] - ring[i]).norm();
    }
    if (before.holes_world.size() != now.holes_world.size()) return true;
    return std::abs(before.area_m2 - now.area_m2) > config_.min_change_m * perimeter;
  }

  const MergingConfig config_;
  std::unordered_map<CellKey, CellMembers, CellKeyHash> cells_;
  std::map<SurfaceId, Surface> surfaces_;
  std::map<PolygonId, PolygonPtr> polygons_;
  SurfaceId next_surface_ = 1;
  PolygonId next_polygon_ = 1;
  std::set<SurfaceId> late_;  // surfaces whose outlines wait to be traced
  // Of the update at hand.
  std::set<SurfaceId> touched_;
  std::vector<MemberRef> homeless_;
  std::map<SurfaceId, SurfaceId> absorbed_by_;
};

PolygonMerger::PolygonMerger(const MergingConfig& config) {
  TERRACE_CHECK(config.Problems().empty());
  impl_ = std::make_unique<Impl>(config);
}
PolygonMerger::~PolygonMerger() = default;

PolygonUpdate PolygonMerger::Merge(const PatchUpdate& update) { return impl_->Merge(update); }
std::int64_t PolygonMerger::memory_bytes() const { return impl_->memory_bytes(); }

}  // namespace terrace

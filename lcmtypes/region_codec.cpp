// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/region_codec.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();

std::optional<double> KnownOrNone(float value) {
  return std::isnan(value) ? std::nullopt : std::optional<double>(value);
}

void AddVertex(const Eigen::Vector2d& xy, const RegionEdge& edge, region_v1_t* message) {
  message->coords.push_back(static_cast<float>(xy.x()));
  message->coords.push_back(static_cast<float>(xy.y()));
  message->edge_kind.push_back(static_cast<std::int8_t>(edge.kind));
  message->edge_step.push_back(edge.step_m ? static_cast<float>(*edge.step_m) : kNotKnown);
  message->edge_sigma.push_back(edge.sigma_m ? static_cast<float>(*edge.sigma_m) : kNotKnown);
}

void CountWhatItHolds(region_v1_t* message) {
  message->n_rings = static_cast<std::int32_t>(message->ring_size.size());
  message->n_coords = static_cast<std::int32_t>(message->coords.size());
  message->n_vertices = message->n_coords / 2;
}

/// Everything but rings, coordinates and edges.
region_v1_t HeadOf(const TerrainRegion& region, const Gravity& gravity) {
  region_v1_t message{};
  message.id = region.id;
  message.revision = region.revision;
  message.source = static_cast<std::int8_t>(region.source);
  message.label = static_cast<std::int8_t>(region.label);
  message.confidence = static_cast<float>(region.confidence);
  message.why = region.why;
  message.first_utime = region.first_seen.utime();
  message.last_utime = region.last_seen.utime();
  message.n_obs = region.num_observations;
  const Eigen::Vector3d& normal = region.plane_world.normal;
  const PlaneAxes axes = AxesOf(normal);
  WriteVector(region.plane_world.Project(region.centroid_world), message.origin);
  Eigen::Matrix3d R_world_plane;
  R_world_plane << axes.x, axes.y, normal;
  WriteQuaternion(R_world_plane, message.quat);
  WriteTriangle<3>(region.plane_covariance, message.plane_cov);
  message.area = static_cast<float>(region.area_m2);
  message.rms = static_cast<float>(region.rms_m);
  message.slope = static_cast<float>(std::acos(std::clamp(normal.dot(gravity.up_world()), -1.0, 1.0)));
  message.support = static_cast<float>(region.support);
  message.staircase_id = region.staircase_id.value_or(0);
  message.step_index = region.step_index.value_or(0);
  message.n_pieces = 1;
  return message;
}

/// Everything but outline, holes and edges; none when a value cannot be meant.
std::optional<TerrainRegion> ReadHead(const region_v1_t& message) {
  const auto source = EnumFrom<RegionSource>(message.source, kNumRegionSources);
  const auto T_world_plane = ReadPose(message.origin, message.quat);
  const auto first_seen = TimeFromMicroseconds(message.first_utime);
  const auto last_seen = TimeFromMicroseconds(message.last_utime);
  const float numbers[] = {message.confidence, message.area, message.rms, message.slope, message.support};
  if (!source || !T_world_plane || !first_seen || !last_seen || message.id <= 0 || message.label < 0 ||
      !AllFinite(numbers) || !AllFinite(message.plane_cov)) {
    return std::nullopt;
  }
  TerrainRegion region;
  region.id = message.id;
  region.revision = message.revision;
  region.source = *source;
  // A later daemon may know more labels than this program.
  region.label = EnumFrom<TerrainLabel>(message.label, kNumTerrainLabels).value_or(TerrainLabel::kUnknown);
  region.confidence = message.confidence;
  region.why = message.why;
  region.plane_world.normal = T_world_plane->linear().col(2);
  region.plane_world.offset_m = region.plane_world.normal.dot(T_world_plane->translation());
  region.plane_covariance = ReadTriangle<3>(message.plane_cov);
  region.centroid_world = T_world_plane->translation();
  region.rms_m = message.rms;
  region.area_m2 = message.area;
  region.support = message.support;
  region.num_observations = message.n_obs;
  region.first_seen = *first_seen;
  region.last_seen = *last_seen;
  if (message.staircase_id != 0) region.staircase_id = message.staircase_id;
  if (message.step_index != 0) region.step_index = message.step_index;
  return region;
}

bool CountsAddUp(const region_v1_t& message) {
  return message.n_rings >= 1 && message.n_coords % 2 == 0 && message.n_vertices == message.n_coords / 2 &&
         AllFinite(message.coords) &&
         std::none_of(message.edge_step.begin(), message.edge_step.end(),
                      [](float step) { return std::isinf(step); });
}

/// Adds the rings of one piece; false when they do not add up.
bool AddRings(const region_v1_t& piece, std::vector<Ring>* rings, std::vector<RegionEdge>* edges) {
  if (!CountsAddUp(piece) || (piece.continues != 0 && rings->empty())) return false;
  const auto T_world_plane = ReadPose(piece.origin, piece.quat);
  if (!T_world_plane) return false;
  const std::size_t num_vertices = piece.coords.size() / 2;
  std::size_t vertex = 0;
  bool goes_on = piece.continues != 0;
  for (const std::int32_t size : piece.ring_size) {
    if (size < 1 || static_cast<std::size_t>(size) > num_vertices - vertex) return false;
    if (!std::exchange(goes_on, false)) rings->emplace_back();
    for (std::int32_t i = 0; i < size; ++i, ++vertex) {
      const auto kind = EnumFrom<EdgeKind>(piece.edge_kind[vertex], kNumEdgeKinds);
      if (!kind) return false;
      edges->push_back({*kind, KnownOrNone(piece.edge_step[vertex]), KnownOrNone(piece.edge_sigma[vertex])});
      rings->back().push_back(*T_world_plane *
                              Eigen::Vector3d(piece.coords[2 * vertex], piece.coords[2 * vertex + 1], 0.0));
    }
  }
  return vertex == num_vertices;
}

}  // namespace

region_v1_t ToMessage(const TerrainRegion& region, const Gravity& gravity) {
  return RegionPieces(region, gravity, std::numeric_limits<std::size_t>::max()).front();
}

std::vector<region_v1_t> RegionPieces(const TerrainRegion& region, const Gravity& gravity,
                                      std::size_t max_bytes) {
  constexpr std::size_t kRingBytes = 4;
  constexpr std::size_t kVertexBytes = 2 * 4 + 1 + 4 + 4;
  const region_v1_t head = HeadOf(region, gravity);
  const auto head_bytes = static_cast<std::size_t>(head._getEncodedSizeNoHash());
  const PlaneAxes axes = AxesOf(region.plane_world.normal);
  const Eigen::Vector3d origin = ReadVector(head.origin);

  std::vector<region_v1_t> pieces = {head};
  std::size_t bytes = head_bytes;
  std::size_t next_edge = 0;
  const auto add_ring = [&](const Ring& ring) {
    bool begun = false;
    for (const Eigen::Vector3d& p : ring) {
      const std::size_t more = kVertexBytes + (begun ? 0 : kRingBytes);
      if (bytes + more > max_bytes && !pieces.back().coords.empty()) {
        pieces.push_back(head);
        pieces.back().continues = begun;
        bytes = head_bytes + (begun ? kRingBytes : 0);
        if (begun) pieces.back().ring_size.push_back(0);
      }
      bytes += more;
      if (!std::exchange(begun, true)) pieces.back().ring_size.push_back(0);
      ++pieces.back().ring_size.back();
      const RegionEdge edge = next_edge < region.edges.size() ? region.edges[next_edge] : RegionEdge{};
      ++next_edge;
      AddVertex({axes.x.dot(p - origin), axes.y.dot(p - origin)}, edge, &pieces.back());
    }
  };
  add_ring(region.outline_world);
  for (const Ring& hole : region.holes_world) add_ring(hole);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    CountWhatItHolds(&pieces[i]);
    pieces[i].piece = static_cast<std::int16_t>(i);
    pieces[i].n_pieces = static_cast<std::int16_t>(pieces.size());
  }
  return pieces;
}

std::optional<TerrainRegion> FromMessage(const region_v1_t& message) {
  const region_v1_t* const whole[] = {&message};
  return RegionFromPieces(whole);
}

std::optional<TerrainRegion> RegionFromPieces(std::span<const region_v1_t* const> pieces) {
  if (pieces.empty()) return std::nullopt;
  std::optional<TerrainRegion> region = ReadHead(*pieces.front());
  if (!region) return std::nullopt;
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const region_v1_t& piece = *pieces[i];
    const bool in_order =
        piece.piece == static_cast<int>(i) && piece.n_pieces == static_cast<int>(pieces.size());
    if (!in_order || piece.id != region->id || piece.revision != region->revision) return std::nullopt;
    if (!AddRings(piece, &rings, &region->edges)) return std::nullopt;
  }
  if (std::any_of(rings.begin(), rings.end(), [](const Ring& ring) { return ring.size() < 3; }))
    return std::nullopt;
  region->outline_world = std::move(rings.front());
  region->holes_world.assign(std::make_move_iterator(rings.begin() + 1),
                             std::make_move_iterator(rings.end()));
  return region;
}

staircase_v1_t ToMessage(const Staircase& staircase) {
  staircase_v1_t message{};
  message.id = staircase.id;
  message.last_utime = staircase.last_seen.utime();
  message.n_risers = staircase.num_risers;
  message.n_treads = staircase.num_treads;
  message.riser = static_cast<float>(staircase.riser_m);
  message.riser_sigma = static_cast<float>(staircase.riser_sigma_m);
  message.tread = static_cast<float>(staircase.tread_m);
  message.tread_sigma = static_cast<float>(staircase.tread_sigma_m);
  message.width = static_cast<float>(staircase.width_m);
  for (int end = 0; end < 2; ++end) {
    WriteVector(staircase.foot_edge_world[end], message.foot_edge + 3 * end);
    WriteVector(staircase.head_edge_world[end], message.head_edge + 3 * end);
  }
  WriteVector(staircase.direction_up_world, message.direction_up);
  message.turn_per_step = static_cast<float>(staircase.turn_per_step_rad);
  message.pitch = static_cast<float>(staircase.pitch_rad);
  message.confidence = static_cast<float>(staircase.confidence);
  return message;
}

std::optional<Staircase> FromMessage(const staircase_v1_t& message) {
  const auto last_seen = TimeFromMicroseconds(message.last_utime);
  if (!last_seen || message.id <= 0 || message.n_risers < 0 || message.n_treads < 0 ||
      !AllFinite(message.foot_edge) || !AllFinite(message.head_edge) || !AllFinite(message.direction_up)) {
    return std::nullopt;
  }
  Staircase staircase;
  staircase.id = message.id;
  staircase.last_seen = *last_seen;
  staircase.num_risers = message.n_risers;
  staircase.num_treads = message.n_treads;
  staircase.riser_m = message.riser;
  staircase.riser_sigma_m = message.riser_sigma;
  staircase.tread_m = message.tread;
  staircase.tread_sigma_m = message.tread_sigma;
  staircase.width_m = message.width;
  for (int end = 0; end < 2; ++end) {
    staircase.foot_edge_world[end] = ReadVector(message.foot_edge + 3 * end);
    staircase.head_edge_world[end] = ReadVector(message.head_edge + 3 * end);
  }
  for (int i = 0; i < 3; ++i) staircase.direction_up_world[i] = message.direction_up[i];
  staircase.turn_per_step_rad = message.turn_per_step;
  staircase.pitch_rad = message.pitch;
  staircase.confidence = message.confidence;
  return staircase;
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/truth.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <nlohmann/json.hpp>

#include "core/file_bytes.h"
#include "core/plane_rings.h"
#include "datasets/npz_file.h"

namespace terrace::synthetic {
namespace {

using Json = nlohmann::ordered_json;

/// What is farther away does not count as seen.
constexpr double kSeenRange_m = 5.0;
constexpr double kCell_m = 0.04;

Json PointJson(const Eigen::Vector3d& p) { return Json::array({p.x(), p.y(), p.z()}); }

Json RingJson(const Ring& ring) {
  Json json = Json::array();
  for (const Eigen::Vector3d& vertex : ring) json.push_back(PointJson(vertex));
  return json;
}

/// Crossings of a ray along +x in the plane's axes.
bool Inside(const Ring& ring, const ObservedCells& cells, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Eigen::Vector2d a(ring[i].dot(cells.axis_x), ring[i].dot(cells.axis_y));
    const Eigen::Vector2d b(ring[j].dot(cells.axis_x), ring[j].dot(cells.axis_y));
    if (CrossesRay(a, b, p)) inside = !inside;
  }
  return inside;
}

Json VisibleJson(const SeenSurface& seen) {
  Json json;
  json["pixels"] = seen.pixels;
  json["frames"] = seen.frames;
  json["nearest_depth"] =
      seen.frames > 0 ? Json(std::round(seen.nearest_depth_m * 1e3) * 1e-3) : Json(nullptr);
  json["observed_fraction"] =
      seen.observed_fraction < 0.0 ? Json(nullptr) : Json(std::round(seen.observed_fraction * 1e3) * 1e-3);
  json["observed_area"] = seen.observed_area_m2;
  return json;
}

Json PolygonJson(const Surface& surface, const SeenSurface& seen) {
  Json json;
  json["id"] = surface.image_id;
  json["name"] = surface.name;
  json["label"] = surface.label;
  json["normal"] = PointJson(surface.plane_world.normal);
  json["offset"] = surface.plane_world.offset_m;
  json["vertices"] = RingJson(surface.outline_world);
  json["holes"] = Json::array();
  for (const Ring& hole : surface.holes_world) json["holes"].push_back(RingJson(hole));
  json["area"] = SignedArea(surface.outline_world, surface.plane_world.normal);
  json["staircase_id"] = surface.staircase_id ? Json(*surface.staircase_id) : Json(nullptr);
  json["step_index"] = surface.step_index ? Json(*surface.step_index) : Json(nullptr);
  json["detail"] = surface.detail;
  json["visible"] = VisibleJson(seen);
  return json;
}

Json StaircaseJson(const SceneStaircase& stairs) {
  const TrueStaircase& truth = stairs.truth;
  Json json;
  json["id"] = truth.id;
  json["n_risers"] = truth.num_risers;
  json["n_treads"] = truth.num_treads;
  json["riser_heights"] = truth.riser_heights_m;
  json["tread_depths"] = truth.tread_depths_m;
  json["riser"] = truth.riser_m;
  json["tread"] = truth.tread_m;
  json["width"] = truth.width_m;
  json["up_direction"] = PointJson(truth.direction_up_world);
  json["foot_edge"] = Json::array({PointJson(truth.foot_edge_world[0]), PointJson(truth.foot_edge_world[1])});
  json["top_edge"] = Json::array({PointJson(truth.head_edge_world[0]), PointJson(truth.head_edge_world[1])});
  json["total_rise"] = truth.num_risers * truth.riser_m;
  json["turn_per_step_deg"] = stairs.turn_per_step_rad * 180.0 / std::numbers::pi;
  json["open_risers"] = stairs.open_risers;
  json["polygon_ids"] = truth.polygon_ids;
  return json;
}

Json MovingJson(const MovingObject& object) {
  Json json;
  json["name"] = object.name;
  json["label"] = "other";
  json["mesh_id"] = object.mesh_id;
  json["polygon_ids"] = Json::array();
  json["obb"] = {{"base_center", PointJson(object.base_center)},
                 {"size", PointJson(object.size_m)},
                 {"yaw", object.yaw_rad}};
  json["moves"] = Json::array();
  for (const MovingObject::Key& key : object.keys) {
    json["moves"].push_back({{"t_s", key.t_s}, {"offset", PointJson(key.offset)}});
  }
  return json;
}

Json MetaJson(const Scene& scene, const SequenceFacts& facts) {
  const Photometry& p = scene.photometry;
  const StereoCamera& c = scene.camera;
  Json json;
  json["sequence"] = scene.name;
  json["generator"] = {{"scene", scene.name}, {"seed", facts.seed}, {"motion", facts.motion}};
  json["parameters"] = Json::object();
  json["camera"] = {{"fx", c.fx},
                    {"fy", c.fy},
                    {"cx", c.cx},
                    {"cy", c.cy},
                    {"baseline", c.baseline_m},
                    {"pitch_deg", scene.mounting.pitch_down_rad * 180.0 / std::numbers::pi},
                    {"cam_height", scene.mounting.body_height_m + scene.mounting.left_in_body.z()}};
  json["photometry"] = {{"full_well", p.full_well},
                        {"read_noise", p.read_noise},
                        {"gain_right", p.gain_right},
                        {"exposure_ms", p.exposure_s * 1e3},
                        {"gamma", "srgb"},
                        {"vignette", p.vignette},
                        {"target", p.target},
                        {"ae_speed", 1.0 - std::exp(-p.exposure_speed_hz / facts.rate_hz)},
                        {"black", p.black}};
  json["frames"] = facts.num_frames;
  json["rate_hz"] = facts.rate_hz;
  json["path_length"] = facts.path_length_m;
  json["conventions"] =
      "world z up, metres; polygon: normal . X = offset, vertices counter-clockwise seen from the visible "
      "side; "
      "labels/*.png hold polygon id (or mesh_id of an object), 0 = sky";
  return json;
}

NpyArray DoublesArray(const std::vector<double>& values) {
  NpyArray array{"<f8", {values.size()}, std::vector<std::uint8_t>(values.size() * sizeof(double))};
  std::memcpy(array.bytes.data(), values.data(), array.bytes.size());
  return array;
}

}  // namespace

SeenSurfaces::SeenSurfaces(const Scene& scene) : scene_(scene), seen_(scene.surfaces.size()) {
  for (std::size_t s = 0; s < seen_.size(); ++s) {
    const SurfaceFrame frame = FrameOf(scene.surfaces[s]);
    ObservedCells& cells = seen_[s].cells;
    cells.axis_x = frame.axis_u;
    cells.axis_y = frame.axis_v;
    cells.origin_m = {frame.min_u, frame.min_v};
    cells.cell_m = kCell_m;
    cells.nx = std::max(1, static_cast<int>(std::ceil((frame.max_u - frame.min_u) / kCell_m - 1e-9)));
    cells.ny = std::max(1, static_cast<int>(std::ceil((frame.max_v - frame.min_v) / kCell_m - 1e-9)));
    cells.seen.assign(static_cast<std::size_t>(cells.nx) * static_cast<std::size_t>(cells.ny), 0);
  }
}

void SeenSurfaces::Add(const TrueView& view, const Eigen::Isometry3d& T_world_left, int first_row,
                       int row_step) {
  std::vector<bool> in_frame(seen_.size(), false);
  for (int v = first_row; v < view.height; v += row_step) {
    for (int u = 0; u < view.width; ++u) {
      const auto i =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(u);
      if (view.surface[i] < 0) continue;
      const auto s = static_cast<std::size_t>(view.surface[i]);
      SeenSurface& seen = seen_[s];
      const double depth = view.depth_m[i];
      seen.pixels += row_step;
      if (!in_frame[s]) ++seen.frames;
      in_frame[s] = true;
      if (seen.nearest_depth_m == 0.0 || depth < seen.nearest_depth_m) seen.nearest_depth_m = depth;
      if (scene_.surfaces[s].moving_object) continue;
      const StereoCamera& c = scene_.camera;
      const Eigen::Vector3d p_left((u - c.cx) / c.fx * depth, (v - c.cy) / c.fy * depth, depth);
      if (p_left.norm() > kSeenRange_m) continue;
      const Eigen::Vector3d p = T_world_left * p_left;
      ObservedCells& cells = seen.cells;
      const int x =
          std::clamp(static_cast<int>((p.dot(cells.axis_x) - cells.origin_m.x()) / kCell_m), 0, cells.nx - 1);
      const int y =
          std::clamp(static_cast<int>((p.dot(cells.axis_y) - cells.origin_m.y()) / kCell_m), 0, cells.ny - 1);
      cells.seen[static_cast<std::size_t>(x) * static_cast<std::size_t>(cells.ny) +
                 static_cast<std::size_t>(y)] = 1;
    }
  }
}

std::vector<SeenSurface> SeenSurfaces::Finish() const {
  std::vector<SeenSurface> result = seen_;
  for (std::size_t s = 0; s < result.size(); ++s) {
    const Surface& surface = scene_.surfaces[s];
    ObservedCells& cells = result[s].cells;
    int on_polygon = 0;
    int seen = 0;
    for (int x = 0; x < cells.nx; ++x) {
      for (int y = 0; y < cells.ny; ++y) {
        const Eigen::Vector2d centre = cells.origin_m + kCell_m * Eigen::Vector2d(x + 0.5, y + 0.5);
        const bool on = Inside(surface.outline_world, cells, centre) &&
                        std::none_of(surface.holes_world.begin(), surface.holes_world.end(),
                                     [&](const Ring& hole) { return Inside(hole, cells, centre); });
        std::uint8_t& cell = cells.seen[static_cast<std::size_t>(x) * static_cast<std::size_t>(cells.ny) +
                                        static_cast<std::size_t>(y)];
        if (!on) cell = 0;
        on_polygon += on ? 1 : 0;
        seen += cell;
      }
    }
    result[s].observed_fraction = on_polygon > 0 ? static_cast<double>(seen) / on_polygon : -1.0;
    result[s].observed_area_m2 = seen * kCell_m * kCell_m;
  }
  return result;
}

void WriteTruth(const Scene& scene, const std::vector<SeenSurface>& seen, const SequenceFacts& facts,
                const std::filesystem::path& folder) {
  Json json;
  json["meta"] = MetaJson(scene, facts);
  json["polygons"] = Json::array();
  std::map<std::string, NpyArray> arrays;
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
    const Surface& surface = scene.surfaces[s];
    if (surface.moving_object) continue;
    json["polygons"].push_back(PolygonJson(surface, seen[s]));
    const ObservedCells& cells = seen[s].cells;
    if (std::none_of(cells.seen.begin(), cells.seen.end(), [](std::uint8_t cell) { return cell != 0; }))
      continue;
    const std::string id = std::to_string(surface.image_id);
    arrays["mask_" + id] =
        NpyArray{"|b1", {static_cast<std::size_t>(cells.nx), static_cast<std::size_t>(cells.ny)}, cells.seen};
    arrays["frame_" + id] = DoublesArray({cells.axis_x.x(), cells.axis_x.y(), cells.axis_x.z(),
                                          cells.axis_y.x(), cells.axis_y.y(), cells.axis_y.z(),
                                          cells.origin_m.x(), cells.origin_m.y(), cells.cell_m});
  }
  json["staircases"] = Json::array();
  for (const SceneStaircase& stairs : scene.staircases) json["staircases"].push_back(StaircaseJson(stairs));
  json["objects"] = Json::array();
  for (const MovingObject& object : scene.moving) json["objects"].push_back(MovingJson(object));
  WriteNpzFile(folder / "observed_cells.npz", arrays);
  const std::string text = json.dump() + "\n";
  WriteFileBytes(folder / "ground_truth.json",
                 {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace terrace::synthetic

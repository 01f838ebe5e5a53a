// SPDX-License-Identifier: BSD-3-Clause
#include "tools/terrain_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "tools/sole_picture.h"
#include "tools/surface_raster.h"

namespace terrace {
namespace {

using Colour = cv::Vec3b;  // blue, green, red

const Colour kPaper(250, 249, 248);
const Colour kInk(60, 52, 45);
const Colour kFaint(228, 226, 224);
const Colour kPath(30, 60, 235);

Colour ColourOf(TerrainLabel label) {
  switch (label) {
    case TerrainLabel::kWalkway:
      return {120, 190, 110};
    case TerrainLabel::kRamp:
      return {60, 195, 245};
    case TerrainLabel::kStairTread:
      return {235, 165, 70};
    case TerrainLabel::kStairRiser:
      return {190, 85, 150};
    case TerrainLabel::kWall:
      return {150, 188, 212};
    case TerrainLabel::kObstacle:
      return {85, 95, 232};
    case TerrainLabel::kLevel:
      return {205, 200, 95};
    case TerrainLabel::kUnknown:
      return {222, 222, 222};
  }
  return kPaper;
}

Colour Mix(const Colour& a, const Colour& b, double share_of_b) {
  Colour mixed;
  for (int c = 0; c < 3; ++c) mixed[c] = cv::saturate_cast<uchar>(a[c] + share_of_b * (b[c] - a[c]));
  return mixed;
}

/// What was not seen is pale.
Colour ColourOf(const TerrainRegion& region) {
  const Colour colour = ColourOf(region.label);
  return region.predicted() ? Mix(colour, kPaper, 0.6) : colour;
}

void Write(cv::Mat3b& image, const std::string& text, const cv::Point& at, double size, const Colour& colour,
           int thickness = 1) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(colour), thickness, cv::LINE_AA);
}

int TextWidth(const std::string& text, double size) {
  int baseline = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline).width;
}

/// Text that can be read on any ground, centred.
void WriteOver(cv::Mat3b& image, const std::string& text, const cv::Point& center, double size) {
  const cv::Point at(center.x - TextWidth(text, size) / 2, center.y + static_cast<int>(11 * size));
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(255, 255, 255), 3, cv::LINE_AA);
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar(kInk), 1, cv::LINE_AA);
}

template <typename... Values>
std::string Format(const char* format, Values... values) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

SurfaceRaster Rasterise(const TerrainMap& map, int width, int height, const Projection& projection) {
  SurfaceRaster raster(width, height, projection);
  for (int i = 0; i < static_cast<int>(map.regions.size()); ++i) raster.Draw(*map.regions[i], i);
  return raster;
}

/// A pixel at which another region begins.
bool OnBorder(const SurfaceRaster& raster, int u, int v) {
  const int here = raster.region_at(u, v);
  return (u + 1 < raster.width() && raster.region_at(u + 1, v) != here) ||
         (v + 1 < raster.height() && raster.region_at(u, v + 1) != here);
}

/// Middle of the pixels at which each region is seen, when there are many.
struct Visible {
  int count = 0;
  double u = 0.0;
  double v = 0.0;
};
std::vector<Visible> WhereVisible(const SurfaceRaster& raster, std::size_t num_regions) {
  std::vector<Visible> visible(num_regions);
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const int i = raster.region_at(u, v);
      if (i < 0) continue;
      ++visible[i].count;
      visible[i].u += u;
      visible[i].v += v;
    }
  }
  for (Visible& where : visible) {
    if (where.count == 0) continue;
    where.u /= where.count;
    where.v /= where.count;
  }
  return visible;
}

/// A row of labels with their colours; returns the x after the last.
int DrawLegend(cv::Mat3b& image, const TerrainMap& map, cv::Point at, double size) {
  std::array<int, kNumTerrainLabels> counts{};
  for (const auto& region : map.regions) ++counts[static_cast<std::size_t>(region->label)];
  const int box = static_cast<int>(26 * size);
  for (int i = 0; i < kNumTerrainLabels; ++i) {
    if (counts[i] == 0) continue;
    const auto label = static_cast<TerrainLabel>(i);
    const cv::Rect rect(at.x, at.y - box + 2, box, box);
    cv::rectangle(image, rect, cv::Scalar(ColourOf(label)), cv::FILLED);
    cv::rectangle(image, rect, cv::Scalar(Mix(ColourOf(label), kInk, 0.5)), 1, cv::LINE_AA);
    std::string name = Name(label);
    std::replace(name.begin(), name.end(), '_', ' ');
    name += Format(" %d", counts[i]);
    Write(image, name, {at.x + box + 6, at.y}, size, kInk);
    at.x += box + 6 + TextWidth(name, size) + static_cast<int>(36 * size);
  }
  return at.x;
}

std::string Describe(const Staircase& s) {
  return Format("staircase %lld: %d risers of %.1f cm, treads %.1f cm, %.2f m wide",
                static_cast<long long>(s.id), s.num_risers, 100.0 * s.riser_m, 100.0 * s.tread_m, s.width_m);
}

/// A part of the picture that shows the map from one side.
struct Panel {
  Projection projection;
  cv::Size size;
  double pixels_per_m = 1.0;
};

/// Places the map in the middle of a panel, as large as it fits.
Panel FitPanel(const TerrainMap& map, const std::vector<ResultPose>& trajectory, Projection projection,
               const cv::Size& most, int margin) {
  Eigen::AlignedBox2d bounds;
  for (const auto& region : map.regions)
    for (const Eigen::Vector3d& p : region->outline_world) bounds.extend(projection.Pixel(p));
  for (const ResultPose& pose : trajectory) bounds.extend(projection.Pixel(pose.T_world_left.translation()));
  if (bounds.isEmpty()) bounds.extend(Eigen::Vector2d::Zero());
  const Eigen::Vector2d extent = bounds.sizes().cwiseMax(0.5);
  const double scale =
      std::min((most.width - 2 * margin) / extent.x(), (most.height - 2 * margin) / extent.y());
  Panel panel;
  panel.pixels_per_m = scale;
  panel.size = {most.width, static_cast<int>(std::ceil(extent.y() * scale)) + 2 * margin};
  panel.projection = projection;
  panel.projection.fx = panel.projection.fy = scale;
  panel.projection.cx = 0.5 * panel.size.width - scale * bounds.center().x();
  panel.projection.cy = 0.5 * panel.size.height - scale * bounds.center().y();
  return panel;
}

/// A scale bar of a round length in the lower right corner.
void DrawScale(cv::Mat3b& image, double pixels_per_m) {
  double length_m = 0.1;
  for (const double candidate : {0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0})
    if (candidate * pixels_per_m < 0.16 * image.cols) length_m = candidate;
  const int length = static_cast<int>(std::lround(length_m * pixels_per_m));
  const cv::Point right(image.cols - 24, image.rows - 16);
  const cv::Point left(right.x - length, right.y);
  cv::line(image, left, right, cv::Scalar(kInk), 2, cv::LINE_AA);
  for (const cv::Point& end : {left, right})
    cv::line(image, end - cv::Point(0, 5), end + cv::Point(0, 5), cv::Scalar(kInk), 2, cv::LINE_AA);
  const std::string text = Format("%g m", length_m);
  Write(image, text, {(left.x + right.x - TextWidth(text, 0.45)) / 2, left.y - 9}, 0.45, kInk);
}

constexpr int kShift = 4;  // points are given to OpenCV in 1/16 px

template <typename Items, typename PointOf>
std::vector<cv::Point> FinePixels(const Items& items, const Projection& projection, PointOf point_of) {
  std::vector<cv::Point> pixels;
  for (const auto& item : items) {
    const Eigen::Vector2d p = projection.Pixel(point_of(item)) * (1 << kShift);
    pixels.emplace_back(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  }
  return pixels;
}

/// Regions seen edge-on show no area: lines, as in the drawing of a section.
void DrawEdgeOn(cv::Mat3b& image, const TerrainMap& map, const Panel& panel) {
  constexpr double kEdgeOn = 0.08;  // 5 deg
  for (const auto& region : map.regions) {
    const Eigen::Vector3d normal = panel.projection.T_view_world.linear() * region->plane_world.normal;
    if (std::abs(normal.z()) > kEdgeOn) continue;
    const std::vector<cv::Point> line =
        FinePixels(region->outline_world, panel.projection, [](const Eigen::Vector3d& p) { return p; });
    cv::polylines(image, line, true, cv::Scalar(Mix(ColourOf(*region), kInk, 0.25)), 2, cv::LINE_AA, kShift);
  }
}

cv::Mat3b DrawPanel(const TerrainMap& map, const std::vector<ResultPose>& trajectory, const Panel& panel,
                    const std::string& title) {
  constexpr int kFine = 2;  // drawn larger and shrunk, so that edges are smooth
  Projection fine = panel.projection;
  fine.fx *= kFine;
  fine.fy *= kFine;
  fine.cx = fine.cx * kFine + 0.5 * (kFine - 1);
  fine.cy = fine.cy * kFine + 0.5 * (kFine - 1);
  const cv::Size size(panel.size.width * kFine, panel.size.height * kFine);
  const SurfaceRaster raster = Rasterise(map, size.width, size.height, fine);
  // Light from above, from the left and from the viewer.
  const Eigen::Vector3d light_view = Eigen::Vector3d(-0.35, -0.8, -0.6).normalized();
  cv::Mat3b image(size, kPaper);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const int i = raster.region_at(u, v);
      if (i >= 0) {
        const TerrainRegion& region = *map.regions[i];
        const Eigen::Vector3d normal = fine.T_view_world.linear() * region.plane_world.normal;
        const double shade = 0.30 * (1.0 - std::max(0.0, normal.dot(light_view)));
        image(v, u) = Mix(ColourOf(region), kInk, shade);
      }
      if (OnBorder(raster, u, v)) image(v, u) = Mix(image(v, u), kInk, 0.55);
    }
  }
  cv::Mat3b shrunk;
  cv::resize(image, shrunk, panel.size, 0, 0, cv::INTER_AREA);

  DrawEdgeOn(shrunk, map, panel);
  const std::vector<cv::Point> path = FinePixels(trajectory, panel.projection, [](const ResultPose& pose) {
    return Eigen::Vector3d(pose.T_world_left.translation());
  });
  if (path.size() > 1) {
    cv::polylines(shrunk, path, false, cv::Scalar(255, 255, 255), 4, cv::LINE_AA, kShift);
    cv::polylines(shrunk, path, false, cv::Scalar(kPath), 2, cv::LINE_AA, kShift);
  }
  if (!path.empty()) {
    cv::circle(shrunk, path.front(), 5 << kShift, cv::Scalar(255, 255, 255), cv::FILLED, cv::LINE_AA, kShift);
    cv::circle(shrunk, path.front(), 5 << kShift, cv::Scalar(kPath), 2, cv::LINE_AA, kShift);
    cv::circle(shrunk, path.back(), 5 << kShift, cv::Scalar(kPath), cv::FILLED, cv::LINE_AA, kShift);
  }
  Write(shrunk, title, {24, 26}, 0.5, Mix(kInk, kPaper, 0.3));
  DrawScale(shrunk, panel.pixels_per_m);
  cv::line(shrunk, {24, 0}, {shrunk.cols - 24, 0}, cv::Scalar(kFaint), 1);
  return shrunk;
}

/// Unit vector of the plan along which the map is drawn from left to right: where the walk led, else x.
Eigen::Vector3d MainDirection(const std::vector<ResultPose>& trajectory) {
  constexpr double kMinWalk_m = 1.0;
  Eigen::Vector3d farthest = Eigen::Vector3d::Zero();
  for (const ResultPose& pose : trajectory) {
    Eigen::Vector3d way = pose.T_world_left.translation() - trajectory.front().T_world_left.translation();
    way.z() = 0.0;
    if (way.norm() > farthest.norm()) farthest = way;
  }
  return farthest.norm() < kMinWalk_m ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(farthest.normalized());
}

double PathLength(const std::vector<ResultPose>& trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length +=
        (trajectory[i].T_world_left.translation() - trajectory[i - 1].T_world_left.translation()).norm();
  return length;
}

}  // namespace

cv::Mat3b DrawFrame(const TerrainMap& map, const cv::Mat1b& left, const StereoCamera& camera,
                    const Eigen::Isometry3d& T_world_left, const footstep_plan_v1_t* plan) {
  constexpr double kOpacity = 0.5;
  const Projection projection = Projection::OfCamera(camera, T_world_left);
  const SurfaceRaster raster = Rasterise(map, left.cols, left.rows, projection);
  cv::Mat3b image;
  cv::cvtColor(left, image, cv::COLOR_GRAY2BGR);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const int i = raster.region_at(u, v);
      if (i >= 0) image(v, u) = Mix(image(v, u), ColourOf(*map.regions[i]), kOpacity);
      if (!OnBorder(raster, u, v)) continue;
      const int border = i >= 0 ? i : u + 1 < image.cols ? raster.region_at(u + 1, v) : -1;
      image(v, u) = border >= 0 ? Mix(ColourOf(*map.regions[border]), kInk, 0.4) : kInk;
    }
  }
  if (plan) {
    DrawSoles(image, projection, *plan, [&](const cv::Point& pixel, std::int64_t region_id) {
      const int i = raster.region_at(pixel.x, pixel.y);
      return i >= 0 && map.regions[i]->id == region_id;
    });
  }
  constexpr int kMinPixels = 300;
  const std::vector<Visible> visible = WhereVisible(raster, map.regions.size());
  for (std::size_t i = 0; i < visible.size(); ++i) {
    if (visible[i].count < kMinPixels) continue;
    const TerrainRegion& region = *map.regions[i];
    std::string text = Format("%lld", static_cast<long long>(region.id));
    if (region.staircase_id && region.step_index) {
      const char kind = region.label == TerrainLabel::kStairRiser ? 'r' : 't';
      text = Format("S%lld %c%d", static_cast<long long>(*region.staircase_id), kind, *region.step_index);
    }
    WriteOver(image, text, {static_cast<int>(visible[i].u), static_cast<int>(visible[i].v)}, 0.38);
  }

  const int strip = 30 + 20 * static_cast<int>(map.staircases.size());
  cv::Mat3b picture(image.rows + strip, image.cols, kPaper);
  image.copyTo(picture.rowRange(0, image.rows));
  DrawLegend(picture, map, {10, image.rows + 20}, 0.38);
  for (std::size_t s = 0; s < map.staircases.size(); ++s)
    Write(picture, Describe(map.staircases[s]), {10, image.rows + 41 + 20 * static_cast<int>(s)}, 0.4, kInk);
  return picture;
}

cv::Mat3b DrawMap(const ReplayResult& result, const footstep_plan_v1_t* plan) {
  constexpr int kWidth = 1280;
  constexpr int kMargin = 44;
  const TerrainMap& map = result.map;
  const Eigen::Vector3d right = MainDirection(result.trajectory);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d away = up.cross(right);
  const auto panel = [&](const Eigen::Vector3d& forward, const Eigen::Vector3d& upward, int max_height,
                         const std::string& title) {
    const Panel fitted =
        FitPanel(map, result.trajectory, Projection::Along(forward, upward), {kWidth, max_height}, kMargin);
    cv::Mat3b drawn = DrawPanel(map, result.trajectory, fitted, title);
    if (plan) DrawSoles(drawn, fitted.projection, *plan, [](const cv::Point&, std::int64_t) { return true; });
    return drawn;
  };
  const std::vector<cv::Mat3b> panels = {
      panel(0.55 * right + 0.75 * away - 0.62 * up, up, 620,
            "from behind on the right, walls seen from behind left out"),
      panel(-up, away, 420, "plan"),
      panel(away, up, 320, "from the right"),
  };

  cv::Mat3b header(66 + 22 * static_cast<int>(std::min<std::size_t>(map.staircases.size(), 6)), kWidth,
                   kPaper);
  Write(header,
        Format("%d regions, %d staircase%s, camera path of %.1f m", static_cast<int>(map.regions.size()),
               static_cast<int>(map.staircases.size()), map.staircases.size() == 1 ? "" : "s",
               PathLength(result.trajectory)),
        {24, 32}, 0.7, kInk);
  int y = 32;
  for (std::size_t s = 0; s < map.staircases.size() && s < 6; ++s)
    Write(header, Describe(map.staircases[s]), {24, y += 24}, 0.5, kInk);
  DrawLegend(header, map, {24, header.rows - 12}, 0.5);

  std::vector<cv::Mat3b> parts{header};
  parts.insert(parts.end(), panels.begin(), panels.end());
  cv::Mat3b picture;
  cv::vconcat(parts, picture);
  return picture;
}

}  // namespace terrace

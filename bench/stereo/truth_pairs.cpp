// SPDX-License-Identifier: BSD-3-Clause
#include "bench/stereo/truth_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/image_file.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

cv::Mat1b ReadGray(const fs::path& path) {
  GrayImage image = ReadGrayImage(path);
  return cv::Mat1b(image.height, image.width, image.data.data()).clone();
}

cv::Mat1f ReadPfm(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic;
  int width = 0, height = 0;
  double scale = 0;
  if (!(file >> magic >> width >> height >> scale) || magic != "Pf" || scale >= 0)
    throw std::runtime_error(path.string() + ": not a little-endian grey PFM file");
  file.get();
  cv::Mat1f image(height, width);
  for (int v = height - 1; v >= 0; --v)
    file.read(reinterpret_cast<char*>(image[v]), static_cast<std::streamsize>(sizeof(float)) * width);
  return image;
}

std::vector<fs::path> Folders(const fs::path& parent) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(parent))
    if (entry.is_directory()) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

/// A pixel is hidden when another one lands on the same place of the right image and is nearer by more than
/// one pixel of disparity, or when it lands outside.
cv::Mat1b VisibilityByWarping(const cv::Mat1f& disparity) {
  cv::Mat1b visibility(disparity.size(), static_cast<std::uint8_t>(kNoTruth));
  for (int v = 0; v < disparity.rows; ++v) {
    std::vector<float> nearest(disparity.cols + 1, -1.0f);
    for (int u = 0; u < disparity.cols; ++u) {
      const float d = disparity(v, u);
      if (std::isnan(d) || static_cast<float>(u) - d < 0) continue;
      const int x = static_cast<int>(std::floor(static_cast<float>(u) - d));
      for (int i : {x, x + 1}) nearest[i] = std::max(nearest[i], d);
    }
    for (int u = 0; u < disparity.cols; ++u) {
      const float d = disparity(v, u);
      if (std::isnan(d)) continue;
      const int x = static_cast<int>(std::lround(static_cast<float>(u) - d));
      visibility(v, u) = static_cast<float>(u) - d >= 0 && nearest[x] <= d + 1.0f ? kVisible : kHidden;
    }
  }
  return visibility;
}

cv::Mat1f ReadScaledDisparity(const fs::path& path, double scale) {
  const cv::Mat1b raw = ReadGray(path);
  cv::Mat1f disparity(raw.size());
  for (int i = 0; i < static_cast<int>(raw.total()); ++i)
    disparity(i) = raw(i) == 0 ? kUnknown : static_cast<float>(raw(i) / scale);
  return disparity;
}

}  // namespace

std::vector<TruthPair> ReadMiddleburyV3(const fs::path& data) {
  std::vector<TruthPair> pairs;
  for (const fs::path& folder : Folders(data / "middlebury/v3_quarter")) {
    TruthPair pair;
    pair.name = folder.filename();
    pair.frame.left = ReadGray(folder / "im0.png");
    pair.frame.right = ReadGray(folder / "im1.png");
    pair.disparity_px = ReadPfm(folder / "disp0GT.pfm");
    pair.visibility = ReadGray(folder / "mask0nocc.png");
    for (int i = 0; i < static_cast<int>(pair.disparity_px.total()); ++i)
      if (!std::isfinite(pair.disparity_px(i))) {
        pair.disparity_px(i) = kUnknown;
        pair.visibility(i) = kNoTruth;
      }
    std::ifstream calib(folder / "calib.txt");
    for (std::string line; std::getline(calib, line);)
      if (const auto at = line.find("ndisp="); at != std::string::npos)
        pair.max_disparity_px = (std::stoi(line.substr(at + 6)) + 15) / 16 * 16;
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

std::vector<TruthPair> ReadMiddlebury2001To2003(const fs::path& data) {
  const std::map<std::string, double> scales = {{"barn2", 8},    {"bull", 8},  {"cones", 4},    {"poster", 8},
                                                {"sawtooth", 8}, {"teddy", 4}, {"tsukuba", 16}, {"venus", 8}};
  std::vector<TruthPair> pairs;
  for (const fs::path& folder : Folders(data / "middlebury/2001_2003")) {
    TruthPair pair;
    pair.name = folder.filename();
    const double scale = scales.at(pair.name);
    pair.frame.left = ReadGray(folder / "im2.png");
    pair.frame.right = ReadGray(folder / "im6.png");
    pair.disparity_px = ReadScaledDisparity(folder / "disp2.png", scale);
    if (!fs::exists(folder / "disp6.png")) {
      pair.visibility = VisibilityByWarping(pair.disparity_px);
    } else {
      const cv::Mat1f right = ReadScaledDisparity(folder / "disp6.png", scale);
      pair.visibility.create(right.size());
      for (int v = 0; v < right.rows; ++v)
        for (int u = 0; u < right.cols; ++u) {
          const float d = pair.disparity_px(v, u);
          const int x = static_cast<int>(std::lround(static_cast<float>(u) - d));
          if (std::isnan(d))
            pair.visibility(v, u) = kNoTruth;
          else if (x < 0 || (!std::isnan(right(v, x)) && std::abs(right(v, x) - d) > 1.0f))
            pair.visibility(v, u) = kHidden;
          else
            pair.visibility(v, u) = std::isnan(right(v, x)) ? kNoTruth : kVisible;
        }
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

std::vector<TruthPair> ReadRendered(const fs::path& sequence, int stride) {
  std::ifstream file(sequence / "ground_truth.json");
  const nlohmann::json truth = nlohmann::json::parse(file);
  std::set<int> steps;
  for (const auto& polygon : truth.at("polygons")) {
    const std::string label = polygon.at("label");
    if (label == "stair_tread" || label == "stair_riser") steps.insert(polygon.at("id").get<int>());
  }
  const auto& c = truth.at("meta").at("camera");
  std::vector<fs::path> depths;
  for (const auto& entry : fs::directory_iterator(sequence / "depth")) depths.push_back(entry.path());
  std::sort(depths.begin(), depths.end());

  std::vector<TruthPair> pairs;
  for (std::size_t i = 0; i < depths.size(); i += stride) {
    TruthPair pair;
    pair.name = depths[i].stem();
    pair.frame.left = ReadGray(sequence / "mav0/cam0/data" / depths[i].filename());
    pair.frame.right = ReadGray(sequence / "mav0/cam1/data" / depths[i].filename());
    pair.max_disparity_px = 128;
    pair.camera = {pair.frame.left.cols, pair.frame.left.rows, c.at("fx"),      c.at("fy"),
                   c.at("cx"),           c.at("cy"),           c.at("baseline")};
    const Gray16Image depth_mm = ReadGray16Png(depths[i]);
    const Gray16Image labels = ReadGray16Png(sequence / "labels" / depths[i].filename());
    pair.disparity_px.create(depth_mm.height, depth_mm.width);
    std::map<int, cv::Mat1b> masks;
    for (int p = 0; p < static_cast<int>(depth_mm.data.size()); ++p) {
      const double depth_m = depth_mm.data[p] / 1000.0;
      pair.disparity_px(p) =
          depth_mm.data[p] == 0 ? kUnknown : static_cast<float>(pair.camera.Disparity(depth_m));
      if (depth_mm.data[p] == 0 || depth_m > 2.5 || pair.disparity_px(p) > 126 ||
          !steps.contains(labels.data[p]))
        continue;
      cv::Mat1b& mask = masks[labels.data[p]];
      if (mask.empty()) mask = cv::Mat1b::zeros(depth_mm.height, depth_mm.width);
      mask(p) = 255;
    }
    pair.visibility = VisibilityByWarping(pair.disparity_px);
    for (int p = 0; p < static_cast<int>(depth_mm.data.size()); ++p)
      if (pair.disparity_px(p) > 127) pair.visibility(p) = kNoTruth;  // nearer than the search goes
    for (auto& [id, mask] : masks) {
      cv::Mat1b inside;
      cv::erode(mask, inside, cv::Mat1b::ones(7, 7), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
      if (cv::countNonZero(inside) >= 300) pair.patches.push_back({inside});
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tbb/global_control.h>

#include "datasets/image_file.h"
#include "stereo/disparity_matcher.h"
#include "tools/commands.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
constexpr int kSmallestSidePx = 16;

struct DisparityOptions {
  std::string left, right, out, calib, color, confidence;
  std::string tier = DisparityConfig().tier;
  int max_disparity_px = 0;  // 0: the calibration's, else the matcher's default
  int threads = 0;           // 0: as many as there are
  int repeat = 1;
};

/// What a Middlebury calib.txt says.
struct PairCalibration {
  double focal_px = 0.0, baseline_m = 0.0, doffs_px = 0.0;
  int num_disparities = 0;
};

PairCalibration ReadCalibration(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path.string() + ": cannot be read");
  PairCalibration c;
  for (std::string line; std::getline(file, line);) {
    const auto value_of = [&](const char* key) -> std::optional<std::string> {
      const auto at = line.find(key);
      if (at == std::string::npos) return std::nullopt;
      return line.substr(at + std::strlen(key));
    };
    const auto number = [&](const std::string& text) {
      double value = 0.0;
      if (!(std::istringstream(text) >> value) || !std::isfinite(value))
        throw std::runtime_error(path.string() + ": '" + line + "' holds no number");
      return value;
    };
    if (const auto text = value_of("cam0=[")) c.focal_px = number(*text);
    if (const auto text = value_of("doffs=")) c.doffs_px = number(*text);
    if (const auto text = value_of("baseline=")) c.baseline_m = number(*text) / 1000.0;
    if (const auto text = value_of("ndisp=")) c.num_disparities = static_cast<int>(number(*text));
  }
  if (c.focal_px <= 0.0 || c.baseline_m <= 0.0)
    throw std::runtime_error(path.string() +
                             ": has no 'cam0=[f ...' and 'baseline=' as Middlebury's calib.txt has");
  return c;
}

cv::Mat1b ReadImage(const fs::path& path) {
  const GrayImage image = ReadGrayImage(path);
  if (image.width < kSmallestSidePx || image.height < kSmallestSidePx)
    throw std::runtime_error(path.string() + ": " + std::to_string(image.width) + "x" +
                             std::to_string(image.height) + " pixels; at least 16x16 are needed");
  cv::Mat1b copy(image.height, image.width);
  std::copy(image.data.begin(), image.data.end(), copy.begin());
  return copy;
}

/// Rows from the bottom to the top, little-endian, infinity = unknown.
void WritePfm(const fs::path& path, const cv::Mat1f& disparity) {
  static_assert(std::endian::native == std::endian::little);
  std::ofstream file(path, std::ios::binary);
  file << "Pf\n" << disparity.cols << ' ' << disparity.rows << "\n-1.0\n";
  std::vector<float> row(disparity.cols);
  for (int v = disparity.rows - 1; v >= 0; --v) {
    for (int u = 0; u < disparity.cols; ++u)
      row[u] = std::isnan(disparity(v, u)) ? std::numeric_limits<float>::infinity() : disparity(v, u);
    file.write(reinterpret_cast<const char*>(row.data()),
               static_cast<std::streamsize>(sizeof(float) * row.size()));
  }
  file.flush();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

/// 256 x pixels, 0 = unknown, as is what is too large for that; what is known is at least 1.
void WriteDisparityPng(const fs::path& path, const cv::Mat1f& disparity) {
  Gray16Image image{disparity.cols, disparity.rows, {}};
  for (const float d : disparity) {
    const long sample = std::isnan(d) ? 0 : std::max(std::lround(256.0f * d), 1L);
    image.data.push_back(static_cast<std::uint16_t>(sample <= 65535 ? sample : 0));
  }
  WritePng(path, image);
}

void WriteColor(const fs::path& path, const cv::Mat1f& disparity) {
  std::vector<float> known;
  for (const float d : disparity)
    if (!std::isnan(d)) known.push_back(d);
  float brightest = 1.0f;
  if (!known.empty()) {
    const auto at = known.begin() + static_cast<std::ptrdiff_t>(known.size() * 99 / 100);
    std::nth_element(known.begin(), at, known.end());
    brightest = std::max(*at, 1.0f);
  }
  cv::Mat1b scaled(disparity.size(), static_cast<std::uint8_t>(0)),
      unknown(disparity.size(), static_cast<std::uint8_t>(0));
  for (int i = 0; i < static_cast<int>(disparity.total()); ++i) {
    if (std::isnan(disparity(i)))
      unknown(i) = 255;
    else
      scaled(i) = static_cast<std::uint8_t>(std::clamp(255.0f * disparity(i) / brightest, 0.0f, 255.0f));
  }
  cv::Mat colored;
  cv::applyColorMap(scaled, colored, cv::COLORMAP_TURBO);
  colored.setTo(cv::Scalar::all(0), unknown);
  if (!cv::imwrite(path.string(), colored)) throw std::runtime_error(path.string() + ": cannot be written");
}

/// 255 for a sigma of zero, half of it at a quarter of a pixel, 0 = unknown.
void WriteConfidence(const fs::path& path, const DisparityImage& disparity) {
  constexpr float kHalfAtPx = 0.25f;
  GrayImage image{disparity.sigma_px.cols, disparity.sigma_px.rows, {}};
  for (int i = 0; i < static_cast<int>(disparity.sigma_px.total()); ++i) {
    const float sigma = disparity.TotalSigma(i);
    image.data.push_back(std::isnan(sigma) ? 0
                                           : static_cast<std::uint8_t>(std::max(
                                                 1L, std::lround(255.0f / (1.0f + sigma / kHalfAtPx)))));
  }
  WritePng(path, image);
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

double CpuMs() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

void MatchPair(const DisparityOptions& options) {
  const std::string extension = fs::path(options.out).extension();
  if (extension != ".pfm" && extension != ".png")
    throw UsageError(options.out + ": must end in .pfm or .png");
  std::optional<PairCalibration> calibration;
  if (!options.calib.empty()) calibration = ReadCalibration(options.calib);

  DisparityConfig config;
  config.tier = options.tier;
  const int asked = options.max_disparity_px > 0 ? options.max_disparity_px
                    : calibration                ? calibration->num_disparities
                                                 : 0;
  if (asked > 0) config.max_disparity_px = (asked + 15) / 16 * 16;
  for (const std::string& problem : config.Problems()) throw UsageError(problem);

  StereoFrame frame;
  frame.left = ReadImage(options.left);
  frame.right = ReadImage(options.right);
  if (frame.left.size() != frame.right.size())
    throw std::runtime_error(options.left + " and " + options.right + " differ in size");

  std::unique_ptr<tbb::global_control> limit;
  if (options.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(options.threads));
  DisparityMatcher matcher(config);
  DisparityImage result;
  std::vector<double> cpu_ms, wall_ms;
  for (int i = 0; i < options.repeat; ++i) {
    const double cpu_start = CpuMs();
    const auto wall_start = std::chrono::steady_clock::now();
    result = matcher.Match(frame);
    cpu_ms.push_back(CpuMs() - cpu_start);
    wall_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall_start).count());
  }

  if (extension == ".pfm")
    WritePfm(options.out, result.disparity_px);
  else
    WriteDisparityPng(options.out, result.disparity_px);
  if (!options.color.empty()) WriteColor(options.color, result.disparity_px);
  if (!options.confidence.empty()) WriteConfidence(options.confidence, result);

  std::vector<double> depth_m;
  std::size_t num_known = 0;
  for (const float d : result.disparity_px) {
    if (std::isnan(d)) continue;
    ++num_known;
    if (calibration)
      depth_m.push_back(calibration->focal_px * calibration->baseline_m / (d + calibration->doffs_px));
  }
  nlohmann::ordered_json line = {
      {"cpu_ms", Median(cpu_ms)},
      {"wall_ms", Median(wall_ms)},
      {"density", static_cast<double>(num_known) / static_cast<double>(frame.left.total())},
      {"width", frame.left.cols},
      {"height", frame.left.rows},
      {"max_disparity_px", config.max_disparity_px.value()},
      {"tier", config.tier}};
  if (!depth_m.empty()) line["median_depth_m"] = Median(depth_m);
  std::printf("%s\n", line.dump().c_str());
}

}  // namespace

void AddDisparityCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("disparity", "Match one rectified pair of images");
  auto options = std::make_shared<DisparityOptions>();
  command->add_option("LEFT", options->left, "left image, grey or colour")->required();
  command->add_option("RIGHT", options->right, "right image of the same size")->required();
  command
      ->add_option("OUT", options->out,
                   ".pfm (pixels, infinity = unknown) or .png (256 x pixels, 0 = unknown)")
      ->required();
  command->add_option("--max-disparity", options->max_disparity_px, "search range in pixels, up to 512")
      ->check(CLI::Range(1, 256));
  command->add_option("--tier", options->tier, "fast or quality")->check(CLI::IsMember({"fast", "quality"}));
  command->add_option("--threads", options->threads, "most threads to use")->check(CLI::Range(1, 1024));
  command->add_option("--repeat", options->repeat, "match so often and give the median times")
      ->check(CLI::Range(1, 10000));
  command->add_option(
      "--calib", options->calib,
      "Middlebury's calib.txt: its ndisp is the search range, and the median depth is printed");
  command->add_option("--color", options->color, "picture of the disparities, PNG");
  command->add_option("--confidence", options->confidence,
                      "PNG, 8 bit: 255 / (1 + sigma / 0.25 px), 0 = unknown");
  command->callback([options] { MatchPair(*options); });
}

}  // namespace terrace

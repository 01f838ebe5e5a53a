// SPDX-License-Identifier: BSD-3-Clause
// Ours and OpenCV's dense stereo over pairs with truth, in one interleaved run:
//     TERRACE_DATA=... stereo_table [v3] [old] [stairs] [speed] [--dump DIR]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tbb/global_control.h>

#include "bench/stereo/truth_pairs.h"
#include "datasets/image_file.h"
#include "stereo/disparity_matcher.h"

namespace terrace {
namespace {

double CpuMs() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

/// One way to get disparities; NaN = unknown.
struct Method {
  std::string name;
  std::function<DisparityImage(const StereoFrame&, int max_disparity_px)> match;
};

DisparityImage OpenCvMatch(const StereoFrame& frame, int max_disparity_px, int mode, int block) {
  const int p = block * block;
  auto sgbm = cv::StereoSGBM::create(0, max_disparity_px, block, 8 * p, 32 * p, 1, 63, 10, 100, 2, mode);
  cv::Mat left, right, sixteenths;
  cv::copyMakeBorder(frame.left, left, 0, 0, max_disparity_px, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(frame.right, right, 0, 0, max_disparity_px, 0, cv::BORDER_REPLICATE);
  sgbm->compute(left, right, sixteenths);
  DisparityImage result{frame.frame_id, frame.t_capture, cv::Mat1f(frame.left.size()),
                        cv::Mat1f(frame.left.size())};
  for (int v = 0; v < frame.left.rows; ++v)
    for (int u = 0; u < frame.left.cols; ++u) {
      const short d = sixteenths.at<short>(v, u + max_disparity_px);
      result.disparity_px(v, u) =
          d > 0 ? static_cast<float>(d) / 16.0f : std::numeric_limits<float>::quiet_NaN();
    }
  return result;
}

int Env(const char* name, int fallback) {
  return std::getenv(name) ? std::atoi(std::getenv(name)) : fallback;
}

std::vector<Method> Methods() {
  std::vector<Method> methods;
  methods.push_back(
      {"sgbm5", [](const StereoFrame& f, int n) { return OpenCvMatch(f, n, cv::StereoSGBM::MODE_SGBM, 5); }});
  for (const std::string tier : {"fast", "quality"})
    methods.push_back({tier, [tier](const StereoFrame& f, int n) {
                         static std::map<std::pair<std::string, int>, DisparityMatcher> matchers;
                         DisparityConfig config;
                         config.tier = tier;
                         config.max_disparity_px = n;
                         if (const char* census = std::getenv("CENSUS")) config.census = census;
                         config.small_step_penalty = Env("P1", config.small_step_penalty);
                         config.edge_step_penalty = Env("P2MIN", config.edge_step_penalty);
                         config.large_step_penalty = Env("P2MAX", config.large_step_penalty);
                         config.uniqueness_percent = Env("UNIQ", config.uniqueness_percent);
                         return matchers.try_emplace({tier, n}, config).first->second.Match(f);
                       }});
  return methods;
}

struct Marks {
  double bad05 = 0, bad1 = 0, bad2 = 0;  ///< share of the visible pixels, missing ones are bad
  double density = 0, invented = 0;
  double valid_bad1 = 0;
};

Marks Judge(const TruthPair& pair, const cv::Mat1f& disparity) {
  double visible = 0, hidden = 0, known = 0, bad05 = 0, bad1 = 0, bad2 = 0, valid_bad1 = 0, invented = 0;
  for (int i = 0; i < static_cast<int>(disparity.total()); ++i) {
    const bool found = !std::isnan(disparity(i));
    if (pair.visibility(i) == kHidden) {
      ++hidden;
      invented += found;
    }
    if (pair.visibility(i) != kVisible) continue;
    ++visible;
    const float error = found ? std::abs(disparity(i) - pair.disparity_px(i)) : 1e9f;
    known += found;
    bad05 += error > 0.5f;
    bad1 += error > 1.0f;
    bad2 += error > 2.0f;
    valid_bad1 += found && error > 1.0f;
  }
  return {100 * bad05 / visible,
          100 * bad1 / visible,
          100 * bad2 / visible,
          100 * known / visible,
          hidden > 0 ? 100 * invented / hidden : 0,
          known > 0 ? 100 * valid_bad1 / known : 0};
}

/// Disparity a u + b v + c by least squares, reweighted against outliers.
Eigen::Vector3d FitDisparityPlane(const cv::Mat1f& disparity, const cv::Mat1b& mask) {
  std::vector<Eigen::Vector4d> points;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask(v, u) && !std::isnan(disparity(v, u)))
        points.push_back({u - 320.0, v - 240.0, 1.0, disparity(v, u)});
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  double scale = 1e9;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    std::vector<double> residuals;
    for (const auto& p : points) {
      const double r = p[3] - plane.dot(p.head<3>());
      const double x = r / scale;
      const double w = iteration == 0 ? 1.0 : (std::abs(x) < 1 ? (1 - x * x) * (1 - x * x) : 0.0);
      A += w * p.head<3>() * p.head<3>().transpose();
      b += w * p[3] * p.head<3>();
    }
    plane = A.ldlt().solve(b);
    for (const auto& p : points) residuals.push_back(std::abs(p[3] - plane.dot(p.head<3>())));
    if (residuals.empty()) break;
    std::nth_element(residuals.begin(), residuals.begin() + residuals.size() / 2, residuals.end());
    scale = std::max(0.02, 4.7 * 1.48 * residuals[residuals.size() / 2]);
  }
  plane[2] -= 320 * plane[0] + 240 * plane[1];
  return plane;
}

struct PlaneMarks {
  std::vector<double> offset_px, offset_mm, angle_deg;
};

void JudgePlanes(const TruthPair& pair, const cv::Mat1f& disparity, PlaneMarks& marks) {
  const StereoCamera& c = pair.camera;
  for (const TruePatch& patch : pair.patches) {
    const Eigen::Vector3d truth = FitDisparityPlane(pair.disparity_px, patch.mask);
    const Eigen::Vector3d found = FitDisparityPlane(disparity, patch.mask);
    const cv::Moments m = cv::moments(patch.mask, true);
    const Eigen::Vector3d centre(m.m10 / m.m00, m.m01 / m.m00, 1);
    const double offset_px = (found - truth).dot(centre), z = c.Depth(truth.dot(centre));
    const auto normal = [&](const Eigen::Vector3d& p) {
      return Eigen::Vector3d(p[0] * c.fx, p[1] * c.fy, p[0] * c.cx + p[1] * c.cy + p[2]).normalized();
    };
    marks.offset_px.push_back(std::abs(offset_px));
    // Along the normal: z error times the cosine between ray and normal.
    const Eigen::Vector3d ray((centre.x() - c.cx) / c.fx, (centre.y() - c.cy) / c.fy, 1);
    marks.offset_mm.push_back(1000 * c.DepthSigma(z, std::abs(offset_px)) * std::abs(normal(truth).dot(ray)));
    marks.angle_deg.push_back(std::acos(std::clamp(normal(truth).dot(normal(found)), -1.0, 1.0)) * 180 /
                              M_PI);
  }
}

double Median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void Dump(const std::string& path, const cv::Mat1f& disparity) {
  Gray16Image image{disparity.cols, disparity.rows, std::vector<std::uint16_t>(disparity.total())};
  for (int i = 0; i < static_cast<int>(disparity.total()); ++i)
    image.data[i] = std::isnan(disparity(i)) ? 0 : cv::saturate_cast<std::uint16_t>(256 * disparity(i));
  WritePng(path, image);
}

/// 68 % quantile of error / sigma, for each quarter of the pixels by texture (weakest first): what sigma
/// promises is 1.
void PrintSigma(const std::vector<TruthPair>& pairs, const Method& method) {
  std::vector<std::pair<float, float>> texture_and_ratio;
  for (const TruthPair& pair : pairs) {
    const DisparityImage result = method.match(pair.frame, pair.max_disparity_px);
    cv::Mat1f gradient, energy;
    cv::Sobel(pair.frame.left, gradient, CV_32F, 1, 0, 3, 0.125);
    cv::boxFilter(gradient.mul(gradient), energy, CV_32F, {5, 5});
    for (int i = 0; i < static_cast<int>(energy.total()); ++i)
      if (pair.visibility(i) == kVisible && !std::isnan(result.disparity_px(i)))
        texture_and_ratio.emplace_back(
            energy(i), std::abs(result.disparity_px(i) - pair.disparity_px(i)) / result.sigma_px(i));
  }
  std::sort(texture_and_ratio.begin(), texture_and_ratio.end());
  std::printf("  %s, error / sigma, 68 %% quantile by texture:", method.name.c_str());
  for (int quarter = 0; quarter < 4; ++quarter) {
    const std::size_t n = texture_and_ratio.size() / 4;
    std::vector<double> ratios;
    for (std::size_t i = quarter * n; i < (quarter + 1) * n; ++i)
      ratios.push_back(texture_and_ratio[i].second);
    const auto at = ratios.begin() + static_cast<std::ptrdiff_t>(0.68 * static_cast<double>(n));
    std::nth_element(ratios.begin(), at, ratios.end());
    std::printf(" %.2f", *at);
  }
  std::printf("\n");
}

void Run(const std::string& title, const std::vector<TruthPair>& pairs, const std::vector<Method>& methods,
         const std::string& dump, bool each) {
  std::vector<Marks> sums(methods.size());
  std::vector<PlaneMarks> planes(methods.size());
  std::vector<double> cpu(methods.size());
  std::printf("%-14s %-9s %7s %7s %7s %8s %9s %9s %8s\n", title.c_str(), "method", "bad0.5", "bad1", "bad2",
              "density", "invented", "validbad1", "cpu ms");
  for (const TruthPair& pair : pairs)
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const double start = CpuMs();
      const DisparityImage result = methods[m].match(pair.frame, pair.max_disparity_px);
      const double ms = CpuMs() - start;
      cpu[m] += ms;
      const Marks marks = Judge(pair, result.disparity_px);
      JudgePlanes(pair, result.disparity_px, planes[m]);
      if (each)
        std::printf("%-14s %-9s %7.2f %7.2f %7.2f %8.2f %9.2f %9.2f %8.1f\n", pair.name.c_str(),
                    methods[m].name.c_str(), marks.bad05, marks.bad1, marks.bad2, marks.density,
                    marks.invented, marks.valid_bad1, ms);
      if (!dump.empty())
        Dump(dump + "/" + title + "_" + pair.name + "_" + methods[m].name + ".png", result.disparity_px);
      const double n = static_cast<double>(pairs.size());
      sums[m].bad05 += marks.bad05 / n, sums[m].bad1 += marks.bad1 / n, sums[m].bad2 += marks.bad2 / n;
      sums[m].density += marks.density / n, sums[m].invented += marks.invented / n;
      sums[m].valid_bad1 += marks.valid_bad1 / n;
    }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::printf("%-14s %-9s %7.2f %7.2f %7.2f %8.2f %9.2f %9.2f %8.1f", "mean", methods[m].name.c_str(),
                sums[m].bad05, sums[m].bad1, sums[m].bad2, sums[m].density, sums[m].invented,
                sums[m].valid_bad1, cpu[m] / static_cast<double>(pairs.size()));
    std::printf("  x ref: bad1 %.2f bad2 %.2f cpu 1/%.1f", sums[m].bad1 / sums[0].bad1,
                sums[m].bad2 / sums[0].bad2, cpu[0] / cpu[m]);
    if (!planes[m].offset_px.empty())
      std::printf("  planes (%zu): %.4f px %.2f mm %.2f deg", planes[m].offset_px.size(),
                  Median(planes[m].offset_px), Median(planes[m].offset_mm), Median(planes[m].angle_deg));
    std::printf("\n");
  }
  for (const Method& method : methods)
    if (method.name.rfind("sgbm", 0) != 0) PrintSigma(pairs, method);
}

void Speed(const TruthPair& pair, const std::vector<Method>& methods) {
  for (int n : {64, 128})
    if (Env("ONLYN", n) == n) {
      std::vector<std::vector<double>> ms(methods.size());
      for (int repeat = 0; repeat < 9; ++repeat)
        for (std::size_t m = 0; m < methods.size(); ++m) {
          const double start = CpuMs();
          methods[m].match(pair.frame, n);
          ms[m].push_back(CpuMs() - start);
        }
      for (std::size_t m = 0; m < methods.size(); ++m)
        std::printf("%d disparities, %dx%d: %-9s %7.2f ms, 1/%.1f\n", n, pair.frame.left.cols,
                    pair.frame.left.rows, methods[m].name.c_str(), Median(ms[m]),
                    Median(ms[0]) / Median(ms[m]));
    }
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) {
  using namespace terrace;
  const char* data = std::getenv("TERRACE_DATA");
  if (!data) {
    std::fprintf(stderr, "stereo_table: TERRACE_DATA must name the folder of recordings\n");
    return 2;
  }
  std::vector<std::string> parts;
  std::string dump;
  bool each = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--dump" && i + 1 < argc)
      dump = argv[++i];
    else if (argument == "--each")
      each = true;
    else
      parts.push_back(argument);
  }
  const auto wanted = [&](const std::string& part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  cv::setNumThreads(1);
  const std::vector<Method> methods = Methods();
  const std::filesystem::path root = data;
  if (wanted("v3")) Run("v3", ReadMiddleburyV3(root), methods, dump, each);
  if (wanted("old")) Run("2001-2003", ReadMiddlebury2001To2003(root), methods, dump, each);
  if (wanted("stairs")) Run("stairs", ReadRendered(root / "corridor_stairs", 4), methods, dump, each);
  if (wanted("speed")) Speed(ReadRendered(root / "corridor_stairs", 100).front(), methods);
}

// SPDX-License-Identifier: BSD-3-Clause
// Ours and OpenCV's dense stereo over pairs with truth, in one interleaved run, by the evaluator's
// definitions:
//     TERRACE_DATA=... stereo_table [PART...] [--each] [--dump DIR]
// PART: v3 old (Middlebury), damaged (v3, right image), stairs (recording), up down dark sheets (rendered
// here), speed, threads, prior; none: all. Settings to try come from the environment: CENSUS PATHS P1 P2MIN
// P2MAX UNIQ, as in DisparityConfig.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tbb/global_control.h>

#include "bench/stereo/truth_pairs.h"
#include "datasets/image_file.h"
#include "evaluation/disparity_evaluation.h"
#include "evaluation/statistics.h"
#include "stereo/disparity_matcher.h"

namespace terrace {
namespace {

double CpuMs() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double WallMs() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

/// One way to get disparities; NaN = unknown.
struct Method {
  std::string name;
  std::function<DisparityImage(const StereoFrame&, int max_disparity_px)> match;
  bool ours = false;
};

/// With the images padded on the left, because OpenCV returns nothing for the first `max_disparity_px`
/// columns.
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

DisparityImage OurMatch(const StereoFrame& frame, int max_disparity_px, const std::string& tier) {
  static std::map<std::pair<std::string, int>, DisparityMatcher> matchers;
  DisparityConfig config;
  config.tier = tier;
  config.max_disparity_px = max_disparity_px;
  if (const char* census = std::getenv("CENSUS")) config.census = census;
  config.paths = Env("PATHS", config.paths);
  config.small_step_penalty = Env("P1", config.small_step_penalty);
  config.edge_step_penalty = Env("P2MIN", config.edge_step_penalty);
  config.large_step_penalty = Env("P2MAX", config.large_step_penalty);
  config.uniqueness_percent = Env("UNIQ", config.uniqueness_percent);
  return matchers.try_emplace({tier, max_disparity_px}, config).first->second.Match(frame);
}

/// The first is the reference.
std::vector<Method> Methods() {
  const auto opencv = [](int mode, int block) {
    return [mode, block](const StereoFrame& f, int n) { return OpenCvMatch(f, n, mode, block); };
  };
  const auto ours = [](const std::string& tier) {
    return [tier](const StereoFrame& f, int n) { return OurMatch(f, n, tier); };
  };
  return {{"sgbm5", opencv(cv::StereoSGBM::MODE_SGBM, 5)},
          {"3way3", opencv(cv::StereoSGBM::MODE_SGBM_3WAY, 3)},
          {"fast", ours("fast"), true},
          {"quality", ours("quality"), true}};
}

FloatImage ToFloatImage(const cv::Mat1f& image) {
  FloatImage result(image.cols, image.rows);
  std::copy(image.begin(), image.end(), result.data.begin());
  return result;
}

/// What the evaluator finds in one method's images of a set.
struct Marks {
  std::vector<DisparityErrors> each;  ///< of every pair
  DisparityEvaluation all;
  std::vector<EdgeFit> stair_edges;  ///< at about 2 m
  double cpu_ms = 0.0;

  /// Mean over the pairs.
  template <typename Figure>
  double Mean(const Figure& figure) const {
    double sum = 0.0;
    for (const DisparityErrors& errors : each) sum += std::invoke(figure, errors);
    return sum / static_cast<double>(each.size());
  }
};

/// The scene with nothing but its stairs.
TrueScene StairsOf(const TrueScene& scene) {
  TrueScene stairs;
  for (const TruePolygon& polygon : scene.polygons)
    if (polygon.staircase_id) stairs.polygons.push_back(polygon);
  return stairs;
}

void Judge(const TruthSet& set, const TruthPair& pair, const cv::Mat1f& disparity, Marks& marks) {
  const FloatImage image = ToFloatImage(disparity);
  marks.each.emplace_back().Add(image, pair.truth.disparity);
  marks.all.errors.Add(image, pair.truth.disparity);
  if (!set.rendered()) return;
  for (const PlaneFit& plane : FitPlanes(image, pair.truth, set.scene, set.camera, pair.T_world_left))
    marks.all.planes.push_back(plane);
  for (const EdgeFit& edge : FitEdges(image, pair.truth, StairsOf(set.scene), set.camera, pair.T_world_left))
    if (edge.depth_m > 1.5 && edge.depth_m < 2.5) marks.stair_edges.push_back(edge);
}

void Dump(const std::string& path, const cv::Mat1f& disparity) {
  Gray16Image image{disparity.cols, disparity.rows, std::vector<std::uint16_t>(disparity.total())};
  for (int i = 0; i < static_cast<int>(disparity.total()); ++i)
    image.data[i] = std::isnan(disparity(i)) ? 0 : cv::saturate_cast<std::uint16_t>(256 * disparity(i));
  WritePng(path, image);
}

/// 68 % quantile of error / sigma, for each quarter of the pixels by texture (weakest first): what sigma
/// promises is 1.
void PrintSigma(const TruthSet& set, const Method& method) {
  std::vector<std::pair<float, float>> texture_and_ratio;
  for (const TruthPair& pair : set.pairs) {
    const DisparityImage result = method.match(pair.frame, pair.max_disparity_px);
    const DisparityTruth& truth = pair.truth.disparity;
    cv::Mat1f gradient, energy;
    cv::Sobel(pair.frame.left, gradient, CV_32F, 1, 0, 3, 0.125);
    cv::boxFilter(gradient.mul(gradient), energy, CV_32F, {5, 5});
    for (int i = 0; i < static_cast<int>(energy.total()); ++i)
      if (truth.pixels[i] == PixelTruth::kVisible && !std::isnan(result.disparity_px(i)))
        texture_and_ratio.emplace_back(
            energy(i), std::abs(result.disparity_px(i) - truth.disparity_px.data[i]) / result.TotalSigma(i));
  }
  std::sort(texture_and_ratio.begin(), texture_and_ratio.end());
  std::printf("  %s, error / sigma, 68 %% quantile by texture:", method.name.c_str());
  for (int quarter = 0; quarter < 4; ++quarter) {
    const std::size_t n = texture_and_ratio.size() / 4;
    std::vector<double> ratios;
    for (std::size_t i = quarter * n; i < (quarter + 1) * n; ++i)
      ratios.push_back(texture_and_ratio[i].second);
    std::printf(" %.2f", QuantileOf(std::move(ratios), 0.68));
  }
  std::printf("\n");
}

void PrintLine(const std::string& title, const std::string& method, const DisparityErrors& errors) {
  std::printf("%-14s %-9s %7.2f %7.2f %7.2f %8.2f %9.2f %10.2f %9.2f\n", title.c_str(), method.c_str(),
              errors.bad_all_pct(0.5), errors.bad_all_pct(1.0), errors.bad_all_pct(2.0), errors.density_pct(),
              errors.invented_pct(), errors.bad_valid_pct(0.5), errors.bad_valid_pct(1.0));
}

constexpr double kAnyDepth_m = 1e9;

void PrintSummary(const TruthSet& set, const Method& method, const Marks& marks, const Marks& reference) {
  const auto bad = [](double px) { return [px](const DisparityErrors& e) { return e.bad_all_pct(px); }; };
  const auto valid_bad = [](double px) {
    return [px](const DisparityErrors& e) { return e.bad_valid_pct(px); };
  };
  std::printf("%-14s %-9s %7.2f %7.2f %7.2f %8.2f %9.2f %10.2f %9.2f", "mean", method.name.c_str(),
              marks.Mean(bad(0.5)), marks.Mean(bad(1.0)), marks.Mean(bad(2.0)),
              marks.Mean(&DisparityErrors::density_pct), marks.Mean(&DisparityErrors::invented_pct),
              marks.Mean(valid_bad(0.5)), marks.Mean(valid_bad(1.0)));
  std::printf(" %7.1f ms  x ref: validbad0.5 %.2f validbad1 %.2f bad1 %.2f bad2 %.2f cpu 1/%.1f",
              marks.cpu_ms, marks.Mean(valid_bad(0.5)) / reference.Mean(valid_bad(0.5)),
              marks.Mean(valid_bad(1.0)) / reference.Mean(valid_bad(1.0)),
              marks.Mean(bad(1.0)) / reference.Mean(bad(1.0)),
              marks.Mean(bad(2.0)) / reference.Mean(bad(2.0)), reference.cpu_ms / marks.cpu_ms);
  std::printf("  lock %.4f bias %.4f px\n", marks.all.errors.lock_px(), marks.all.errors.bias_px());
  if (!set.rendered()) return;
  const auto print_planes = [](const char* which, const PlaneFigures& planes) {
    if (planes.count == 0) return;
    std::printf("  %s (%d): %.4f px %.2f mm %.2f deg", which, planes.count, planes.offset_px,
                planes.offset_mm, planes.angle_deg);
  };
  std::printf("%24s", "");
  print_planes("planes", marks.all.Planes({}, kAnyDepth_m));
  print_planes("near steps", marks.all.Planes({"stair_tread", "stair_riser"}, 2.5));
  std::vector<double> distances;
  for (const EdgeFit& edge : marks.stair_edges) distances.push_back(edge.distance_px);
  if (!distances.empty())
    std::printf("  stair edges at 2 m (%zu): %.2f px", distances.size(), QuantileOf(distances, 0.5));
  std::printf("\n");
}

void Run(const TruthSet& set, const std::vector<Method>& methods, const std::string& dump, bool each) {
  std::vector<Marks> marks(methods.size());
  std::printf("%-14s %-9s %7s %7s %7s %8s %9s %10s %9s\n", set.name.c_str(), "method", "bad0.5", "bad1",
              "bad2", "density", "invented", "validbad.5", "validbad1");
  for (const TruthPair& pair : set.pairs)
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const double start = CpuMs();
      const DisparityImage result = methods[m].match(pair.frame, pair.max_disparity_px);
      marks[m].cpu_ms += (CpuMs() - start) / static_cast<double>(set.pairs.size());
      Judge(set, pair, result.disparity_px, marks[m]);
      if (each) PrintLine(pair.name, methods[m].name, marks[m].each.back());
      if (!dump.empty())
        Dump(dump + "/" + set.name + "_" + pair.name + "_" + methods[m].name + ".png", result.disparity_px);
    }
  for (std::size_t m = 0; m < methods.size(); ++m) PrintSummary(set, methods[m], marks[m], marks[0]);
  for (const Method& method : methods)
    if (method.ours) PrintSigma(set, method);
}

/// Time for one image. @param what  of the image, as the range goes
void Speed(const std::string& what, const StereoFrame& frame, int n, const std::vector<Method>& methods) {
  std::vector<std::vector<double>> ms(methods.size());
  for (int repeat = 0; repeat < 9; ++repeat)
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const double start = CpuMs();
      methods[m].match(frame, n);
      ms[m].push_back(CpuMs() - start);
    }
  for (std::size_t m = 0; m < methods.size(); ++m)
    std::printf("%d disparities, %s, %dx%d: %-9s %7.2f ms, 1/%.1f\n", n, what.c_str(), frame.left.cols,
                frame.left.rows, methods[m].name.c_str(), QuantileOf(ms[m], 0.5),
                QuantileOf(ms[0], 0.5) / QuantileOf(ms[m], 0.5));
}

bool SameBits(const cv::Mat1f& a, const cv::Mat1f& b) {
  return a.size() == b.size() && std::memcmp(a.data, b.data, a.total() * sizeof(float)) == 0;
}

/// Two threads against one; the least of many times, since others use the machine.
void Threads(const StereoFrame& frame, const std::vector<Method>& methods) {
  for (const Method& method : methods) {
    if (!method.ours) continue;
    DisparityImage results[2];
    double least_ms[2] = {1e9, 1e9};
    for (int repeat = 0; repeat < 15; ++repeat)
      for (const int t : {0, 1}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, t + 1);
        const double start = WallMs();
        results[t] = method.match(frame, 128);
        least_ms[t] = std::min(least_ms[t], WallMs() - start);
      }
    const bool same = SameBits(results[0].disparity_px, results[1].disparity_px) &&
                      SameBits(results[0].sigma_px, results[1].sigma_px);
    std::printf("%s: wall %.2f ms with one thread, %.2f ms with two: x %.2f, %s bits\n", method.name.c_str(),
                least_ms[0], least_ms[1], least_ms[1] / least_ms[0], same ? "the same" : "OTHER");
  }
}

/// A walk with and without a prior. It comes from the disparities of the frame before the last and the motion
/// between the two before that, as in the pipeline; the poses are the true ones.
void Prior(const Walk& walk, const Method& reference) {
  constexpr int kLag = 2;
  for (const std::string tier : {"fast", "quality"}) {
    DisparityConfig config;
    config.tier = tier;
    DisparityMatcher plain(config);
    config.use_prior = true;
    config.prior_margin_px = Env("MARGIN", config.prior_margin_px);
    config.prior_full_every_frames = Env("EVERY", config.prior_full_every_frames);
    DisparityMatcher narrowed(config);
    std::vector<DisparityImage> results;
    DisparityErrors errors[2];
    double cpu_ms[2] = {0.0, 0.0}, prediction_ms = 0.0;
    std::vector<double> reference_ms;
    for (std::size_t k = 0; k < walk.frames.size(); ++k) {
      const Walk::Frame& frame = walk.frames[k];
      DisparityPrior prior(walk.camera.width, walk.camera.height);
      const double start = CpuMs();
      if (k > kLag) {
        const Eigen::Isometry3d& T_world_earlier = walk.frames[k - kLag].T_world_left;
        const Eigen::Isometry3d T_earlier_before =
            T_world_earlier.inverse() * walk.frames[k - kLag - 1].T_world_left;
        Eigen::Isometry3d T_now_earlier = T_earlier_before;
        for (int i = 1; i < kLag; ++i) T_now_earlier = T_now_earlier * T_earlier_before;
        prior = PredictDisparities(results[k - kLag], walk.camera, T_now_earlier);
      }
      const double predicted = CpuMs();
      if (k >= kLag) results[k - kLag] = {};
      results.push_back(narrowed.Match(frame.frame, &prior));
      const double with_prior = CpuMs();
      const DisparityImage without = plain.Match(frame.frame);
      const double n = static_cast<double>(walk.frames.size());
      prediction_ms += (predicted - start) / n;
      cpu_ms[0] += (with_prior - predicted) / n;
      cpu_ms[1] += (CpuMs() - with_prior) / n;
      if (!frame.truth) continue;
      const double start_of_reference = CpuMs();
      reference.match(frame.frame, config.max_disparity_px.value());
      reference_ms.push_back(CpuMs() - start_of_reference);
      errors[0].Add(ToFloatImage(results.back().disparity_px), frame.truth->disparity);
      errors[1].Add(ToFloatImage(without.disparity_px), frame.truth->disparity);
    }
    const double ms = cpu_ms[0] + prediction_ms;
    std::printf(
        "%s on a walk: %.2f ms with a prior (%.2f ms of it to predict), %.2f ms without: x %.2f; 1/%.1f of "
        "%s\n",
        tier.c_str(), ms, prediction_ms, cpu_ms[1], ms / cpu_ms[1], QuantileOf(reference_ms, 0.5) / ms,
        reference.name.c_str());
    PrintLine("  with", tier, errors[0]);
    PrintLine("  without", tier, errors[1]);
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
  const std::filesystem::path root = data;
  const std::filesystem::path stairs = root / "corridor_stairs";
  const std::vector<Method> methods = Methods();
  cv::setNumThreads(1);
  if (wanted("threads")) Threads(ReadRendered("stairs", stairs, 100).pairs[0].frame, methods);

  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  if (wanted("v3")) Run(ReadMiddleburyV3(root), methods, dump, each);
  if (wanted("damaged")) Run(WithDamagedRight(ReadMiddleburyV3(root)), methods, dump, each);
  if (wanted("old")) Run(ReadMiddlebury2001To2003(root), methods, dump, each);
  if (wanted("stairs")) Run(ReadRendered("stairs", stairs, 4), methods, dump, each);
  if (wanted("up")) Run(RenderScene("stairs_up", 1.0, 1.0, 16), methods, dump, each);
  if (wanted("down")) Run(RenderScene("stairs_down", 1.0, 1.0, 16), methods, dump, each);
  if (wanted("dark")) Run(RenderScene("corridor_poor_texture", 0.2, 1.0, 16), methods, dump, each);
  if (wanted("sheets")) Run(RenderScene("sheets", 1.0, 0.5, 6), methods, dump, each);
  if (wanted("prior")) Prior(ReadWalk(stairs), methods[0]);
  if (wanted("speed")) {
    // Of the first frame's floor a quarter is nearer than 64 px show; of the other's hardly anything.
    const TruthSet pairs = ReadRendered("stairs", stairs, 20);
    Speed("a quarter nearer", pairs.pairs[0].frame, 64, methods);
    Speed("within them", pairs.pairs[1].frame, 64, methods);
    Speed("within them", pairs.pairs[0].frame, 128, methods);
  }
}

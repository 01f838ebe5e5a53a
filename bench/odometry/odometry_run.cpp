// SPDX-License-Identifier: BSD-3-Clause
// Plays sequences through the odometry alone and compares with the truth:
//   terrace_odometry_run SEQUENCE... [--no-imu] [--no-priors] [--damage NAME|all]... [--noise N] [--out DIR]
//                        [--every N] [--there-and-back] [--sgbm] [--verbose]
// Memory is what the odometry itself has on the heap after a quarter of the frames and at the end: flat when
// both are alike. --no-imu and --no-priors (body attitude and legs) together: stereo only.
// --damage: one of DamageNames(), or all of them, after the undamaged sequence.
// --noise: each of these once more, N times with other noise of one grey value, and the mean of all: two
// versions differ by less than the spread of these by chance.
// --every N: only every nth frame. --there-and-back: played to the end and then backwards, and how far from
// its start it ends. --verbose: a line a frame.
// --out writes one text line a frame (pose, truth, error, sigmas); --sgbm compares the CPU time with OpenCV's
// StereoSGBM, 128 disparities, padded, on every eighth frame of the same run.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include <malloc.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "damage.h"
#include "odometry/visual_odometry.h"
#include "outcome.h"
#include "recording.h"

namespace terrace {
namespace {

double CpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// What is allocated just now; does not count what has been freed and not given back.
double HeapMib() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / (1024.0 * 1024.0);
}

struct Options {
  bool use_imu = true;
  bool use_priors = true;
  bool sgbm = false;
  bool verbose = false;
  bool and_back = false;
  int every = 1;
  int num_noisy = 0;
  std::string out;
};

void PrintPose(const PoseEstimate& pose, double cpu_s) {
  std::printf("%4lld epoch %d %-8s %3d of %3d agree, %.2f px, sigma %.1f mm, %.1f ms  %s\n",
              static_cast<long long>(pose.frame_id), pose.epoch, Name(pose.status), pose.num_inliers,
              pose.num_matches, pose.rms_px,
              1e3 * std::sqrt(pose.covariance.diagonal().tail<3>().sum() / 3.0), 1e3 * cpu_s,
              pose.reason.c_str());
}

double CpuSecondsOfSgbm(const StereoFrame& frame) {
  cv::Mat left, right, disparity;
  cv::copyMakeBorder(frame.left, left, 0, 0, 128, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(frame.right, right, 0, 0, 128, 0, cv::BORDER_REPLICATE);
  auto sgbm = cv::StereoSGBM::create(0, 128, 5, 200, 800, 1, 63, 10, 100, 2, cv::StereoSGBM::MODE_SGBM);
  const double start = CpuSeconds();
  sgbm->compute(left, right, disparity);
  return CpuSeconds() - start;
}

Trial Play(const Recording& recording, const Options& options) {
  OdometryConfig config;
  config.use_imu = options.use_imu;
  config.use_priors = options.use_priors;
  const double heap_before = HeapMib();
  VisualOdometry odometry(config, recording.camera, recording.mounting);
  Trial trial;
  trial.poses.reserve(recording.frames.size());
  trial.cpu_s.reserve(recording.frames.size());
  double sgbm_s = 0.0;
  int num_sgbm = 0;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const StereoFrame& frame = recording.frames[i];
    const double before = CpuSeconds();
    trial.poses.push_back(frame.left.empty() ? odometry.Bridge(frame.frame_id, frame.t_capture,
                                                               recording.samples[i], "no image")
                                             : odometry.Track(frame, recording.samples[i]));
    trial.cpu_s.push_back(CpuSeconds() - before);
    if (options.verbose) PrintPose(trial.poses.back(), trial.cpu_s.back());
    if (i == recording.frames.size() / 4) trial.heap_early_mib = HeapMib() - heap_before;
    if (options.sgbm && i % 8 == 0 && !frame.left.empty()) {
      sgbm_s += CpuSecondsOfSgbm(frame);
      ++num_sgbm;
    }
  }
  trial.heap_mib = HeapMib() - heap_before;
  if (num_sgbm > 0) trial.sgbm_cpu_s = sgbm_s / num_sgbm;
  trial.gravity = odometry.gravity();
  return trial;
}

Outcome Run(const Recording& recording, const Options& options, const std::string& tag) {
  const Trial trial = Play(recording, options);
  if (!options.out.empty()) WritePoses(trial, recording, options.out + "/" + recording.name + tag + ".txt");
  return Judge(trial, recording);
}

void Print(const std::string& title, const Outcome& o) {
  if (o.num_epochs > 1) std::printf("%d worlds: ", o.num_epochs);
  std::printf("%-34s tracked %d/%d bridging %d lost %d | ATE %.2f mm end %.1f jump %.1f | rel", title.c_str(),
              o.tracked, o.frames, o.bridging, o.lost, o.ate_mm, o.end_mm, o.max_jump_mm);
  for (const auto& [length, percent] : o.relative_percent) std::printf(" %gm %.2f%%", length, percent);
  std::printf(" mean %.3f%% | NEES %.1f (r %.1f t %.1f bridging %.1f) | cpu %.2f ms p99 %.1f max %.1f",
              o.mean_relative, o.nees, o.nees_rotation, o.nees_translation, o.nees_bridging, o.cpu_ms,
              o.p99_ms, o.max_ms);
  if (o.sgbm_ratio > 0.0) std::printf(" sgbm/%.1f", o.sgbm_ratio);
  std::printf(" | heap %.1f %.1f MiB | gravity %s %.2f deg (sigma %.2f) | %016zx\n", o.heap_early_mib,
              o.heap_mib, Name(o.gravity.source), o.gravity_error_deg, 180.0 / M_PI * o.gravity.sigma_rad,
              o.digest);
  std::fflush(stdout);
}

/// Runs and prints a sequence, and again with noise; the first outcome.
Outcome RunAndPrint(const Recording& recording, const Options& options, const std::string& name,
                    const std::string& tag, const Outcome* undamaged) {
  const Outcome outcome = Run(recording, options, tag);
  if (options.and_back)
    std::printf("%-34s back at its start to %.1f mm, which is %.1f of its sigmas\n", name.c_str(),
                outcome.returned_mm, outcome.returned_in_sigmas);
  const char* verdict = "";
  if (undamaged) verdict = outcome.ate_mm <= 3.0 * undamaged->ate_mm && outcome.lost == 0 ? " ok" : " BAD";
  Print(name + verdict, outcome);
  double ate = outcome.ate_mm, relative = outcome.mean_relative, nees = outcome.nees;
  for (int k = 0; k < options.num_noisy; ++k) {
    Recording noisy = recording;
    AddNoise(static_cast<std::uint32_t>(k + 1), noisy.frames);
    const Outcome other = Run(noisy, options, tag + "_noise" + std::to_string(k + 1));
    ate += other.ate_mm;
    relative += other.mean_relative;
    nees += other.nees;
  }
  const int n = options.num_noisy + 1;
  if (n > 1)
    std::printf("%-34s mean of %d: ATE %.3f mm, rel %.4f%%, NEES %.2f\n", name.c_str(), n, ate / n,
                relative / n, nees / n);
  return outcome;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) {
  using namespace terrace;
  std::vector<std::string> sequences;
  std::vector<std::string> damages;
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--no-imu")
      options.use_imu = false;
    else if (argument == "--no-priors")
      options.use_priors = false;
    else if (argument == "--sgbm")
      options.sgbm = true;
    else if (argument == "--verbose")
      options.verbose = true;
    else if (argument == "--there-and-back")
      options.and_back = true;
    else if (argument == "--every" && i + 1 < argc)
      options.every = std::max(1, std::stoi(argv[++i]));
    else if (argument == "--noise" && i + 1 < argc)
      options.num_noisy = std::stoi(argv[++i]);
    else if (argument == "--damage" && i + 1 < argc) {
      const std::string name = argv[++i];
      if (name == "all")
        damages = DamageNames();
      else
        damages.push_back(name);
    } else if (argument == "--out" && i + 1 < argc)
      options.out = argv[++i];
    else
      sequences.push_back(argument);
  }
  cv::setNumThreads(1);
  for (const std::string& path : sequences) {
    Recording recording = LoadRecording(path);
    if (options.every > 1) recording = EveryNth(recording, options.every);
    if (options.and_back) recording = ThereAndBack(recording);
    const std::string name = recording.name +
                             (options.every > 1 ? " every " + std::to_string(options.every) : "") +
                             (options.and_back ? " and back" : "") + (options.use_imu ? "" : " no-imu") +
                             (options.use_priors ? "" : " no-priors");
    const Outcome undamaged = RunAndPrint(recording, options, name, "", nullptr);
    for (const std::string& damage : damages) {
      Recording worse = recording;
      ApplyDamage(damage, worse.frames, worse.samples);
      RunAndPrint(worse, options, name + " " + damage, "_" + damage, &undamaged);
    }
  }
  return 0;
}

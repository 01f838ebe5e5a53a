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
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <malloc.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "damage.h"
#include "evaluation/alignment.h"
#include "odometry/covariance.h"
#include "odometry/rotation.h"
#include "odometry/visual_odometry.h"
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

/// Of rotation (first = 0) or translation (3) alone.
double Chi2OfHalf(const Vector6d& error, const Matrix6d& covariance, int first) {
  Vector6d e = Vector6d::Zero();
  Matrix6d P = Matrix6d::Identity();
  e.segment<3>(first) = error.segment<3>(first);
  P.block<3, 3>(first, first) = covariance.block<3, 3>(first, first);
  return Chi2(e, P);
}

/// Everything measured about one run.
struct Outcome {
  int frames = 0;
  int tracked = 0;
  int bridging = 0;
  int lost = 0;
  double ate_mm = 0.0;
  double end_mm = 0.0;
  double max_jump_mm = 0.0;
  std::map<double, double> relative_percent;
  double mean_relative = 0.0;
  double nees = 0.0;
  double nees_rotation = 0.0;
  double nees_translation = 0.0;
  double nees_bridging = 0.0;  ///< of bridging frames alone
  double cpu_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
  double sgbm_ratio = 0.0;
  double heap_early_mib = 0.0;
  double heap_mib = 0.0;
  Gravity gravity;
  double gravity_error_deg = 0.0;
  double path_m = 0.0;
  int num_epochs = 1;
  double returned_mm = 0.0;         ///< how far the last pose is from the first
  double returned_in_sigmas = 0.0;  ///< the same, in its own sigmas
  std::size_t digest = 0;
};

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

Outcome Run(const Recording& recording, const Options& options, const std::string& tag) {
  OdometryConfig config;
  config.use_imu = options.use_imu;
  config.use_priors = options.use_priors;
  const double heap_before = HeapMib();
  VisualOdometry odometry(config, recording.camera, recording.mounting);
  Outcome out;
  std::vector<PoseEstimate> poses;
  poses.reserve(recording.frames.size());
  std::vector<double> cpu;
  cpu.reserve(recording.frames.size());
  double sgbm_s = 0.0;
  double odometry_s = 0.0;
  int num_sgbm = 0;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const StereoFrame& frame = recording.frames[i];
    const double before = CpuSeconds();
    poses.push_back(frame.left.empty()
                        ? odometry.Bridge(frame.frame_id, frame.t_capture, recording.samples[i], "no image")
                        : odometry.Track(frame, recording.samples[i]));
    cpu.push_back(CpuSeconds() - before);
    if (options.verbose) {
      const PoseEstimate& pose = poses.back();
      std::printf("%4lld epoch %d %-8s %3d of %3d agree, %.2f px, sigma %.1f mm, %.1f ms  %s\n",
                  static_cast<long long>(frame.frame_id), pose.epoch, Name(pose.status), pose.num_inliers,
                  pose.num_matches, pose.rms_px,
                  1e3 * std::sqrt(pose.covariance.diagonal().tail<3>().sum() / 3.0), 1e3 * cpu.back(),
                  pose.reason.c_str());
    }
    if (i == recording.frames.size() / 4) out.heap_early_mib = HeapMib() - heap_before;
    odometry_s += cpu.back();
    if (options.sgbm && i % 8 == 0 && !frame.left.empty()) {
      cv::Mat left, right, disparity;
      cv::copyMakeBorder(frame.left, left, 0, 0, 128, 0, cv::BORDER_REPLICATE);
      cv::copyMakeBorder(frame.right, right, 0, 0, 128, 0, cv::BORDER_REPLICATE);
      auto sgbm = cv::StereoSGBM::create(0, 128, 5, 200, 800, 1, 63, 10, 100, 2, cv::StereoSGBM::MODE_SGBM);
      const double start = CpuSeconds();
      sgbm->compute(left, right, disparity);
      sgbm_s += CpuSeconds() - start;
      ++num_sgbm;
    }
  }

  out.heap_mib = HeapMib() - heap_before;
  out.frames = static_cast<int>(poses.size());
  out.cpu_ms = 1e3 * odometry_s / out.frames;
  std::vector<double> sorted = cpu;
  std::sort(sorted.begin(), sorted.end());
  out.p99_ms = 1e3 * sorted[sorted.size() * 99 / 100];
  out.max_ms = 1e3 * sorted.back();
  if (num_sgbm > 0) out.sgbm_ratio = (sgbm_s / num_sgbm) / (odometry_s / out.frames);
  out.gravity = odometry.gravity();

  // Pairs of estimated and true poses of frames that are not lost.
  std::vector<Eigen::Isometry3d> estimated, truth;
  std::vector<const PoseEstimate*> used;
  for (const PoseEstimate& pose : poses) {
    out.tracked += pose.status == TrackingStatus::kTracking;
    out.bridging += pose.status == TrackingStatus::kBridging;
    out.lost += pose.status == TrackingStatus::kLost;
    for (int k = 0; k < 12; ++k) {
      const double value = pose.T_world_left.matrix()(k % 3, k / 3);
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      out.digest = (out.digest ^ bits) * 1099511628211ull;
    }
    const auto found = recording.truth.find(std::llround(static_cast<double>(pose.t_capture.ns) * 1e-3));
    if (found == recording.truth.end() || pose.status == TrackingStatus::kLost) continue;
    estimated.push_back(pose.T_world_left);
    truth.push_back(found->second);
    used.push_back(&pose);
  }
  out.num_epochs = poses.back().epoch + 1;
  const Vector6d apart = StepBetween(poses.front().T_world_left, poses.back().T_world_left);
  out.returned_mm = 1e3 * apart.tail<3>().norm();
  out.returned_in_sigmas = std::sqrt(Chi2OfHalf(apart, poses.back().covariance, 3));
  if (!options.out.empty()) {
    std::ofstream file(options.out + "/" + recording.name + tag + ".txt");
    file.precision(12);
    const Eigen::Isometry3d T_true_est =
        truth.empty() ? Eigen::Isometry3d::Identity() : Eigen::Isometry3d(truth[0] * estimated[0].inverse());
    for (std::size_t i = 0; i < used.size(); ++i) {
      const Eigen::Isometry3d est = T_true_est * estimated[i];
      const Vector6d e = StepBetween(truth[i], est);
      file << used[i]->frame_id << ' ' << static_cast<int>(used[i]->status) << ' '
           << est.translation().transpose() << ' ' << truth[i].translation().transpose() << ' '
           << e.transpose() << ' ' << used[i]->covariance.diagonal().cwiseSqrt().transpose() << ' '
           << used[i]->num_matches << ' ' << used[i]->num_inliers << ' ' << used[i]->rms_px << ' '
           << 1e3 * cpu[static_cast<std::size_t>(used[i]->frame_id)] << '\n';
    }
  }
  const std::size_t n = estimated.size();
  if (n < 3) return out;

  // Bridged poses are guesses and say so: they count in the relative errors, not in the ATE.
  std::vector<PosePair> seen;
  for (std::size_t i = 0; i < n; ++i)
    if (used[i]->status == TrackingStatus::kTracking)
      seen.push_back({used[i]->t_capture, estimated[i], truth[i]});
  const Eigen::Isometry3d T_true_result = AlignByPositions(seen);
  double square_m2 = 0.0;
  for (const PosePair& pair : seen)
    square_m2 +=
        (T_true_result * pair.T_result_left.translation() - pair.T_true_left.translation()).squaredNorm();
  out.ate_mm = 1e3 * std::sqrt(square_m2 / static_cast<double>(seen.size()));

  std::vector<double> path{0.0};
  for (std::size_t i = 1; i < n; ++i)
    path.push_back(path.back() + (truth[i].translation() - truth[i - 1].translation()).norm());
  out.path_m = path.back();
  const bool far = path.back() > 20.0;
  double sum_of_means = 0.0;
  int num_lengths = 0;
  for (const double length : far ? std::vector<double>{10, 20, 30, 40} : std::vector<double>{0.5, 1, 2, 5}) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0, j = 0; i < n; ++i) {
      while (j < n && path[j] < path[i] + length) ++j;
      if (j == n) break;
      const Eigen::Isometry3d delta =
          (truth[i].inverse() * truth[j]).inverse() * (estimated[i].inverse() * estimated[j]);
      sum += delta.translation().norm() / (path[j] - path[i]);
      ++count;
    }
    if (count == 0) continue;
    out.relative_percent[length] = 100.0 * sum / count;
    if (length != 0.5) {
      sum_of_means += 100.0 * sum / count;
      ++num_lengths;
    }
  }
  if (num_lengths > 0) out.mean_relative = sum_of_means / num_lengths;

  int num_nees = 0;
  for (std::size_t i = 1; i < n; ++i) {
    const Eigen::Isometry3d T_true = truth[0].inverse() * truth[i];
    const Eigen::Isometry3d T_est = estimated[0].inverse() * estimated[i];
    const Vector6d e = StepBetween(T_true, T_est);
    const Matrix6d& P = used[i]->covariance;
    const double nees = Chi2(e, P);
    out.nees += nees;
    if (used[i]->status == TrackingStatus::kBridging) out.nees_bridging += nees;
    out.nees_rotation += Chi2OfHalf(e, P, 0);
    out.nees_translation += Chi2OfHalf(e, P, 3);
    ++num_nees;
    const Eigen::Vector3d jump = (truth[i - 1].inverse() * truth[i]).translation() -
                                 (estimated[i - 1].inverse() * estimated[i]).translation();
    out.max_jump_mm = std::max(out.max_jump_mm, 1e3 * jump.norm());
  }
  out.nees /= num_nees;
  out.nees_bridging /= std::max(out.bridging, 1);
  out.nees_rotation /= num_nees;
  out.nees_translation /= num_nees;
  out.end_mm = 1e3 * StepBetween(truth[0].inverse() * truth[n - 1], estimated[0].inverse() * estimated[n - 1])
                         .tail<3>()
                         .norm();
  // True gravity is -z of the truth's world, seen through the first poses; it drifts with the estimate's
  // rotation.
  const Eigen::Vector3d down_world_end =
      estimated[n - 1].linear() * truth[n - 1].linear().transpose() * -Eigen::Vector3d::UnitZ();
  out.gravity_error_deg =
      180.0 / M_PI * std::acos(std::clamp(down_world_end.dot(out.gravity.down_world), -1.0, 1.0));
  return out;
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

// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/synthesis.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdarg>
#include <limits>

#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include "core/field_problems.h"
#include "core/file_bytes.h"
#include "core/print.h"
#include "datasets/image_file.h"
#include "datasets/synthetic/hash.h"
#include "datasets/synthetic/sensors.h"
#include "datasets/synthetic/truth.h"

namespace terrace::synthetic {
namespace {

namespace fs = std::filesystem;

constexpr Timestamp kStart{1'600'000'000'000'000'000};
constexpr double kImuRate_hz = 200.0;
constexpr double kAttitudeRate_hz = 100.0;
constexpr double kLegsRate_hz = 50.0;
constexpr ImuNoise kImuNoise{1.7e-4, 2e-5, 2e-3, 3e-3};

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A text file that is written at once.
class TextFile {
 public:
  explicit TextFile(fs::path path) : path_(std::move(path)) {}
  [[gnu::format(printf, 2, 3)]] void Line(const char* format, ...) {
    std::va_list arguments;
    va_start(arguments, format);
    PrintArguments(&text_, format, arguments);
    va_end(arguments);
    text_ += '\n';
  }
  void Write() const {
    WriteFileBytes(path_, {reinterpret_cast<const std::uint8_t*>(text_.data()), text_.size()});
  }

 private:
  fs::path path_;
  std::string text_;
};

/// A matrix as the calibration files have it: twelve digits, by rows.
std::string Numbers(const Eigen::Isometry3d& T) {
  std::string text = "[";
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      char number[32];
      std::snprintf(number, sizeof number, "%s%.12g", i + j > 0 ? ", " : "",
                    std::round(T.matrix()(i, j) * 1e12) * 1e-12);
      text += number;
    }
  }
  return text + "]";
}

struct Rig {
  Eigen::Isometry3d T_body_left;
  Eigen::Isometry3d T_body_right;
};

Rig RigOf(const Scene& scene) {
  Rig rig{scene.mounting.T_body_left(), scene.mounting.T_body_left()};
  rig.T_body_right.translation() +=
      scene.camera.baseline_m * rig.T_body_right.linear().col(scene.right.below ? 1 : 0);
  return rig;
}

void WriteBodySensor(const fs::path& path, const char* type, const char* comment) {
  TextFile file(path);
  file.Line("sensor_type: %s", type);
  file.Line("comment: %s", comment);
  file.Line("T_BS:\n  cols: 4\n  rows: 4\n  data: %s", Numbers(Eigen::Isometry3d::Identity()).c_str());
  if (std::string(type) == "imu") {
    file.Line("rate_hz: %g", kImuRate_hz);
    file.Line("gyroscope_noise_density: %g", kImuNoise.gyro_density);
    file.Line("gyroscope_random_walk: %g", kImuNoise.gyro_walk);
    file.Line("accelerometer_noise_density: %g", kImuNoise.accel_density);
    file.Line("accelerometer_random_walk: %g", kImuNoise.accel_walk);
  }
  file.Write();
}

void WriteCalibration(const Scene& scene, double rate_hz, const fs::path& folder) {
  const StereoCamera& c = scene.camera;
  const Rig rig = RigOf(scene);
  for (const bool left : {true, false}) {
    TextFile file(folder / "mav0" / (left ? "cam0" : "cam1") / "sensor.yaml");
    file.Line("sensor_type: camera");
    file.Line("comment: synthetic rectified %s camera (pixel centres at integer coordinates)",
              left ? "left" : "right");
    file.Line("T_BS:\n  cols: 4\n  rows: 4\n  data: %s",
              Numbers(left ? rig.T_body_left : rig.T_body_right).c_str());
    file.Line("rate_hz: %g", rate_hz);
    file.Line("resolution: [%d, %d]", c.width, c.height);
    file.Line("camera_model: pinhole");
    file.Line("intrinsics: [%.6f, %.6f, %.6f, %.6f] #fu, fv, cu, cv", c.fx, c.fy, c.cx, c.cy);
    file.Line("distortion_model: radial-tangential");
    file.Line("distortion_coefficients: [0.0, 0.0, 0.0, 0.0]");
    file.Write();
  }
  TextFile file(folder / "calibration.yaml");
  file.Line("# stereo pair without distortion, %s aligned; disparity = %s * baseline / depth",
            scene.right.below ? "columns" : "rows", scene.right.below ? "fy" : "fx");
  file.Line("image_width: %d", c.width);
  file.Line("image_height: %d", c.height);
  file.Line("fx: %.17g\nfy: %.17g\ncx: %.17g\ncy: %.17g", c.fx, c.fy, c.cx, c.cy);
  file.Line("baseline: %.12g", c.baseline_m);
  file.Line("rate_hz: %g", rate_hz);
  file.Line("exposure_ms: %g", scene.photometry.exposure_s * 1e3);
  file.Line("T_body_leftcam: %s", Numbers(rig.T_body_left).c_str());
  file.Line("T_body_rightcam: %s", Numbers(rig.T_body_right).c_str());
  file.Line("nominal_camera_height: %.12g", scene.mounting.body_height_m + scene.mounting.left_in_body.z());
  file.Line("nominal_camera_pitch_down_deg: %.12g", scene.mounting.pitch_down_rad * 180.0 / std::numbers::pi);
  file.Write();
  TextFile body(folder / "mav0" / "body.yaml");
  body.Line("comment: synthetic hexapod");
  body.Write();
  WriteBodySensor(folder / "mav0" / "imu0" / "sensor.yaml", "imu",
                  "synthetic, body frame x forward y left z up");
  WriteBodySensor(folder / "mav0" / "state_groundtruth_estimate0" / "sensor.yaml", "visual-inertial",
                  "exact body (IMU) state");
  WriteBodySensor(folder / "mav0" / "attitude0" / "sensor.yaml", "attitude",
                  "what the robot's attitude filter says");
  WriteBodySensor(folder / "mav0" / "legs0" / "sensor.yaml", "leg odometry", "what the robot's legs say");
}

void WriteImuAndState(const Trajectory& trajectory, std::uint32_t seed, const fs::path& folder) {
  TextFile imu(folder / "mav0" / "imu0" / "data.csv");
  imu.Line(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]");
  TextFile state(folder / "mav0" / "state_groundtruth_estimate0" / "data.csv");
  state.Line(
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
      "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad "
      "s^-1], "
      "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]");
  for (const ImuRecord& record : SimulateImu(trajectory, kImuNoise, kImuRate_hz, kStart, seed)) {
    const ImuSample& s = record.sample;
    imu.Line("%lld,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f", static_cast<long long>(s.t.ns), s.gyro.x(), s.gyro.y(),
             s.gyro.z(), s.accel.x(), s.accel.y(), s.accel.z());
    const BodyState body = trajectory.At(Seconds(s.t - kStart));
    const Eigen::Vector3d p = body.T_world_body.translation();
    const Eigen::Quaterniond q(body.T_world_body.rotation());
    state.Line("%lld,%.7f,%.7f,%.7f,%.9f,%.9f,%.9f,%.9f,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f,%.7f",
               static_cast<long long>(s.t.ns), p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(),
               body.v_world.x(), body.v_world.y(), body.v_world.z(), record.gyro_bias.x(),
               record.gyro_bias.y(), record.gyro_bias.z(), record.accel_bias.x(), record.accel_bias.y(),
               record.accel_bias.z());
  }
  imu.Write();
  state.Write();
}

void WritePriors(const std::vector<PriorRecord>& records, const fs::path& path) {
  TextFile file(path);
  file.Line(
      "#timestamp [ns], p_x [m], p_y [m], p_z [m], q_w [], q_x [], q_y [], q_z [], sigma_rotation_x [rad], "
      "sigma_rotation_y [rad], sigma_rotation_z [rad], sigma_translation_x [m], sigma_translation_y [m], "
      "sigma_translation_z [m]");
  for (const PriorRecord& r : records) {
    const Eigen::Vector3d p = r.T_odom_body.translation();
    const Eigen::Quaterniond q(r.T_odom_body.rotation());
    file.Line("%lld,%.6f,%.6f,%.6f,%.8f,%.8f,%.8f,%.8f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f",
              static_cast<long long>(r.t.ns), p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(),
              r.rotation_sigma_rad.x(), r.rotation_sigma_rad.y(), r.rotation_sigma_rad.z(),
              r.translation_sigma_m.x(), r.translation_sigma_m.y(), r.translation_sigma_m.z());
  }
  file.Write();
}

Gray16Image DepthImage(const TrueView& view) {
  Gray16Image image{view.width, view.height, std::vector<std::uint16_t>(view.depth_m.size())};
  for (std::size_t i = 0; i < view.depth_m.size(); ++i) {
    image.data[i] = static_cast<std::uint16_t>(std::min(std::lround(view.depth_m[i] * 1e3), 65535L));
  }
  return image;
}

Gray16Image LabelImage(const Scene& scene, const TrueView& view) {
  Gray16Image image{view.width, view.height, std::vector<std::uint16_t>(view.surface.size())};
  for (std::size_t i = 0; i < view.surface.size(); ++i) {
    if (view.surface[i] < 0) continue;
    image.data[i] =
        static_cast<std::uint16_t>(scene.surfaces[static_cast<std::size_t>(view.surface[i])].image_id);
  }
  return image;
}

void WriteReadme(const Scene& scene, const SequenceFacts& facts, int truth_every, const fs::path& folder) {
  TextFile file(folder / "README.md");
  file.Line("# %s (synthetic stereo, made by `terrace synthesize`)", scene.name.c_str());
  if (!scene.description.empty()) file.Line("%s", scene.description.c_str());
  file.Line(
      "%d stereo frames at %g Hz, %dx%d 8-bit grey, rectified, no distortion, global shutter, time stamp = "
      "middle "
      "of the exposure; motion %s, seed %u.",
      facts.num_frames, facts.rate_hz, scene.camera.width, scene.camera.height, facts.motion.c_str(),
      facts.seed);
  file.Line(
      "Depth and label images belong to every %dth frame. What the files mean is said in "
      "datasets/synthetic/README.md "
      "of Terrace.",
      truth_every);
  file.Write();
}

}  // namespace

std::vector<std::string> SynthesisConfig::Problems() const {
  FieldProblems problems;
  problems.RequireAtLeast("max_frames", max_frames, 0);
  problems.RequireWithin("rate_hz", rate_hz, 0.0, 200.0);
  problems.RequireAtLeast("truth_every", truth_every, 0);
  problems.RequireUpTo("gain", gain, 0.0, 100.0);
  std::vector<std::string> all = renderer.Problems();
  const std::vector<std::string> own = problems.Take();
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

Trajectory PlanMotionIn(const Scene& scene, const RayScene& rays, std::uint32_t seed) {
  const auto ground = [&](const Eigen::Vector3d& from) {
    const auto hit = rays.First(from, -Eigen::Vector3d::UnitZ());
    return hit ? from.z() - hit->distance : std::numeric_limits<double>::quiet_NaN();
  };
  return PlanMotion(scene.motion, scene.mounting, ground, seed);
}

SynthesisSummary Synthesize(const Scene& scene, const SynthesisConfig& config, const fs::path& folder,
                            const std::function<void(int, int)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  for (const char* sub : {"mav0/cam0/data", "mav0/cam1/data", "mav0/imu0", "mav0/state_groundtruth_estimate0",
                          "mav0/attitude0", "mav0/legs0", "depth", "labels"}) {
    fs::create_directories(folder / sub);
  }
  SynthesisSummary summary;
  Renderer renderer(scene, config.renderer);
  summary.bake_s = SecondsSince(start);
  const Trajectory trajectory = PlanMotionIn(scene, renderer.rays(), config.seed);
  const double rate = config.rate_hz > 0.0 ? config.rate_hz : scene.rate_hz;
  int num_frames = static_cast<int>(std::floor(trajectory.duration_s() * rate + 1e-6)) + 1;
  if (config.max_frames > 0) num_frames = std::min(num_frames, config.max_frames);

  WriteCalibration(scene, rate, folder);
  WriteImuAndState(trajectory, config.seed, folder);
  WritePriors(SimulateAttitude(trajectory, kAttitudeRate_hz, kStart, config.seed),
              folder / "mav0/attitude0/data.csv");
  WritePriors(SimulateLegs(trajectory, kLegsRate_hz, kStart, config.seed), folder / "mav0/legs0/data.csv");

  TextFile left_list(folder / "mav0/cam0/data.csv");
  TextFile right_list(folder / "mav0/cam1/data.csv");
  TextFile poses(folder / "groundtruth_tum.txt");
  left_list.Line("#timestamp [ns],filename");
  right_list.Line("#timestamp [ns],filename");
  poses.Line(
      "# timestamp tx ty tz qx qy qz qw   T_world_leftcam, optical frame x right y down z forward, world z "
      "up, metres");

  const Rig rig = RigOf(scene);
  Eigen::Isometry3d T_body_right_as_built = rig.T_body_right;
  T_body_right_as_built.rotate(scene.right.Turn(scene.camera.fy));
  const ImageSensor sensor(scene.photometry);
  AutoExposure exposure(config.gain * scene.photometry.target, scene.photometry.exposure_speed_hz, rate);
  SeenSurfaces seen(scene);
  tbb::task_arena arena(ThreadsOf(config.renderer));
  Eigen::Vector3d last_position = Eigen::Vector3d::Zero();
  for (int k = 0; k < num_frames; ++k) {
    const Timestamp t_capture{kStart.ns + static_cast<std::int64_t>(std::llround(k * 1e9 / rate))};
    const double t = Seconds(t_capture - kStart);
    const auto frame_seed = Hash(config.seed, static_cast<std::uint32_t>(k));
    const auto render_start = std::chrono::steady_clock::now();
    const auto left_at = [&](double at) { return trajectory.PoseAt(at) * rig.T_body_left; };
    const auto right_at = [&](double at) { return trajectory.PoseAt(at) * T_body_right_as_built; };
    const Radiance left = renderer.Render(left_at, t, Hash(frame_seed, 1));
    const Radiance right = renderer.Render(right_at, t + scene.right.late_s, Hash(frame_seed, 2));
    const double gain = exposure.GainFor(sensor.MeanOf(left));
    const std::string name = std::to_string(t_capture.ns) + ".png";
    const auto write = [&](const char* camera, const Radiance& light, double of_camera, std::uint32_t seed) {
      WritePng(folder / "mav0" / camera / "data" / name, sensor.Expose(light, of_camera, seed));
    };
    arena.execute([&] {
      tbb::parallel_invoke(
          [&] { write("cam0", left, gain, Hash(frame_seed, 3)); },
          [&] { write("cam1", right, gain * scene.photometry.gain_right, Hash(frame_seed, 4)); });
    });
    summary.render_s += SecondsSince(render_start);

    const Eigen::Isometry3d T_world_left = left_at(t);
    const bool with_truth = config.truth_every > 0 && k % config.truth_every == 0;
    constexpr int kRowStep = 3;
    const TrueView view =
        renderer.Look(T_world_left, t, with_truth ? 0 : k % kRowStep, with_truth ? 1 : kRowStep);
    seen.Add(view, T_world_left, with_truth ? 0 : k % kRowStep, with_truth ? 1 : kRowStep);
    if (with_truth) {
      WritePng(folder / "depth" / name, DepthImage(view));
      WritePng(folder / "labels" / name, LabelImage(scene, view));
    }
    left_list.Line("%lld,%s", static_cast<long long>(t_capture.ns), name.c_str());
    right_list.Line("%lld,%s", static_cast<long long>(t_capture.ns), name.c_str());
    const Eigen::Vector3d p = T_world_left.translation();
    const Eigen::Quaterniond q(T_world_left.rotation());
    poses.Line("%lld.%09lld %.7f %.7f %.7f %.9f %.9f %.9f %.9f",
               static_cast<long long>(t_capture.ns / 1'000'000'000),
               static_cast<long long>(t_capture.ns % 1'000'000'000), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
               q.w());
    if (k > 0) summary.path_length_m += (p - last_position).norm();
    last_position = p;
    if (progress) progress(k + 1, num_frames);
  }
  left_list.Write();
  right_list.Write();
  poses.Write();
  const SequenceFacts facts{num_frames, rate, summary.path_length_m, Name(scene.motion.kind), config.seed};
  WriteReadme(scene, facts, config.truth_every, folder);
  // Last: whoever finds it knows that the sequence is whole.
  WriteTruth(scene, seen.Finish(), facts, folder);
  summary.num_frames = num_frames;
  summary.num_rays = renderer.num_rays();
  summary.total_s = SecondsSince(start);
  return summary;
}

}  // namespace terrace::synthetic

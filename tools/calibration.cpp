// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/angles.h"
#include "core/file_bytes.h"
#include "core/lens.h"
#include "datasets/calibration_file.h"
#include "datasets/rig_file.h"
#include "datasets/sequence.h"
#include "stereo/rectifier.h"
#include "tools/bus.h"
#include "tools/calibration_check.h"
#include "tools/commands.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

struct CalibrationOptions {
  BusOptions channels;
  std::vector<fs::path> files;
  fs::path output;
  bool overwrite = false;
  fs::path check;
  std::string picture;
  std::string size;
  std::string unit;
  std::string cameras;
  double baseline_m = 0.0;
};

std::pair<int, int> ParsePair(const std::string& text, const char* format, const std::string& option) {
  int a = 0, b = 0;
  char more = 0;
  if (std::sscanf(text.c_str(), format, &a, &b, &more) != 2)
    throw UsageError(option + " " + text + ": not understood");
  return {a, b};
}

RigOptions OptionsOf(const CalibrationOptions& given) {
  RigOptions options;
  if (!given.size.empty()) options.size = ParsePair(given.size, "%5dx%5d%c", "--size");
  if (!given.cameras.empty()) options.cameras = ParsePair(given.cameras, "%3d,%3d%c", "--cameras");
  if (given.unit == "m") options.unit_m = 1.0;
  if (given.unit == "cm") options.unit_m = 1e-2;
  if (given.unit == "mm") options.unit_m = 1e-3;
  if (given.baseline_m > 0.0) options.baseline_m = given.baseline_m;
  return options;
}

/// How far a lens sees along a row or a column, between the middles of two borders; as it was calibrated.
std::string ViewOf(const ReadCamera& camera) {
  const Lens lens(camera.lens);
  const auto angle_between = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) -> std::string {
    const auto from = lens.Unproject(a);
    const auto to = lens.Unproject(b);
    if (!from || !to) return "?";
    // Two halves: more than 180 deg is no angle between two rays.
    const double view =
        std::acos(std::clamp(from->z(), -1.0, 1.0)) + std::acos(std::clamp(to->z(), -1.0, 1.0));
    return std::to_string(std::lround(Degrees(view)));
  };
  const RawCamera& c = camera.lens;
  return angle_between({0.0, c.cy}, {camera.width - 1.0, c.cy}) + " x " +
         angle_between({c.cx, 0.0}, {c.cx, camera.height - 1.0}) + " deg";
}

void PrintReadCamera(const ReadCamera& camera) {
  const RawCamera& lens = camera.lens;
  std::printf("  %s\n    %s", camera.place.c_str(), lens.distorted() ? Name(lens.model) : "no distortion");
  if (lens.distorted()) {
    std::printf(" [");
    for (std::size_t i = 0; i < lens.distortion.size(); ++i)
      std::printf("%s%g", i ? ", " : "", lens.distortion[i]);
    std::printf("]");
  }
  std::printf(", f %.2f %.2f px, centre %.2f %.2f px", lens.fx, lens.fy, lens.cx, lens.cy);
  if (camera.width > 0) {
    std::printf(", %dx%d", camera.width, camera.height);
    if (LensProblems(lens, camera.width, camera.height).empty())
      std::printf(", sees %s", ViewOf(camera).c_str());
  }
  std::printf("\n");
}

void PrintRig(const StereoCalibration& rig) {
  const Eigen::Isometry3d T_left_right = rig.T_rawright_rawleft.inverse();
  const Eigen::Vector3d p = T_left_right.translation();
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(T_left_right.linear()));
  const char* where = std::abs(p.x()) >= std::abs(p.y()) ? "beside" : p.y() > 0 ? "below" : "above";
  std::printf("  baseline %.4f m, the right camera %s the left one, turned by %.2f deg against it\n",
              rig.baseline_m(), where, Degrees(turn.angle()));
  const Rectifier rectifier(rig);
  const StereoCamera& camera = rectifier.camera();
  std::printf("  rectified%s: %dx%d, f %.1f px, view %.0f x %.0f deg, 1 px is %.0f mm at 2 m\n",
              rig.rectified() ? " already" : "", camera.width, camera.height, camera.fx,
              Degrees(2.0 * std::atan(0.5 * camera.width / camera.fx)),
              Degrees(2.0 * std::atan(0.5 * camera.height / camera.fy)), 1e3 * camera.DepthSigma(2.0, 1.0));
  if (!rig.T_body_rawleft) {
    std::printf("  body: not known\n");
    return;
  }
  const Eigen::Vector3d& p_body = rig.T_body_rawleft->translation();
  std::printf("  left camera in its body or IMU: (%.3f, %.3f, %.3f) m\n", p_body.x(), p_body.y(), p_body.z());
}

void WriteRig(const CalibrationOptions& options, const StereoCalibration& rig) {
  if (fs::exists(options.output) && !options.overwrite)
    throw UsageError(options.output.string() + ": exists; --overwrite replaces it");
  const std::string text = PrintRigFile(rig);
  WriteFileBytes(options.output, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  std::printf("%s: written\n", options.output.c_str());
}

/// One file may be a recording that carries its calibration.
RigReading ReadFilesOrSequence(const CalibrationOptions& options) {
  if (options.files.size() == 1 && !fs::is_directory(options.files[0] / "mav0")) {
    if (RecogniseSequence(options.files[0])) {
      const auto sequence = OpenSequence(options.files[0], ConfigOf(options.channels).channels);
      RigReading reading;
      reading.format = Name(sequence->info().kind);
      reading.rig = sequence->info().calibration;
      return reading;
    }
  }
  return ReadCalibrationFiles(options.files, OptionsOf(options));
}

/// The left image with what rows are off by, twenty times as long.
void DrawRowErrors(const cv::Mat1b& left, const std::vector<RowMatch>& matches, const std::string& path) {
  constexpr double kMagnification = 20.0;
  cv::Mat3b picture;
  cv::cvtColor(left, picture, cv::COLOR_GRAY2BGR);
  for (const RowMatch& match : matches) {
    const cv::Point2d from(match.left_px.x(), match.left_px.y());
    const double error_px = match.right_px.y() - match.left_px.y();
    const cv::Scalar colour = error_px > 0 ? cv::Scalar(60, 60, 255) : cv::Scalar(255, 160, 40);
    cv::line(picture, from, from + cv::Point2d(0, kMagnification * error_px), colour, 1, cv::LINE_AA);
    cv::circle(picture, from, 2, cv::Scalar(80, 220, 80), cv::FILLED, cv::LINE_AA);
  }
  bool saved = false;
  try {
    saved = cv::imwrite(path, picture);
  } catch (const cv::Exception&) {  // an ending that is no image format
  }
  if (!saved) throw std::runtime_error(path + ": cannot be written as an image");
  std::printf("%s: rows that are off, %.0f times as long; red: lower in the right image\n", path.c_str(),
              kMagnification);
}

void PrintAlignment(const CalibrationCheck& check, const StereoCamera& camera) {
  const RowAlignment& seen = check.rows_as_they_are;
  const RowAlignment& found = check.rows;
  std::printf("  rows: off by %.2f px (median), 95 %% below %.2f px; %d points\n", seen.median_px,
              seen.p95_px, seen.num_matches);
  std::printf(
      "  right image against the left: %+.2f +- %.2f px lower, turned clockwise by %+.3f +- %.3f deg, %.4f "
      "+- %.4f times as large; corrected%s, %.2f px are left\n",
      found.row_shift_px, found.row_shift_sigma_px, Degrees(found.roll_rad), Degrees(found.roll_sigma_rad),
      found.focal_ratio, found.focal_ratio_sigma, check.delay.told() ? ", and for the delay" : "",
      found.left_over_px);
  std::printf(
      "  cost: on edges that run diagonally a row is a disparity: %.0f mm at 2 m (median), %.0f mm (95 %%)\n",
      1e3 * camera.DepthSigma(2.0, seen.median_px), 1e3 * camera.DepthSigma(2.0, seen.p95_px));
}

void PrintDelay(const PairDelay& delay) {
  if (!delay.told()) {
    std::printf("  delay: cannot be told, the image moves by %.0f rows a second; walk, or nod the camera\n",
                delay.row_speed_px_s);
    return;
  }
  std::printf(
      "  delay: the right camera is %+.2f +- %.2f ms late; rows move by %.0f a second, which makes %.2f px "
      "of it\n",
      1e3 * delay.delay_s, 1e3 * delay.sigma_s, delay.row_speed_px_s,
      std::abs(delay.delay_s) * delay.row_speed_px_s);
}

/// Epipolar errors of a recording under a calibration.
void CheckRows(const CalibrationOptions& options, const StereoCalibration& rig) {
  const auto sequence = OpenSequence(options.check, ConfigOf(options.channels).channels);
  const SequenceInfo& info = sequence->info();
  if (info.calibration.width != rig.width || info.calibration.height != rig.height)
    throw SequenceError(options.check.string() + ": its images have another size than the calibration");
  const Rectifier rectifier(rig);
  const CalibrationCheck check = CheckCalibration(rectifier, sequence.get());
  std::printf("%s: checked\n", options.check.c_str());
  if (check.rows_as_they_are.num_matches < RowAlignment::kFewestMatches) {
    throw SequenceError(
        options.check.string() + ": only " + std::to_string(check.rows_as_they_are.num_matches) +
        " points are found in both images, too few to say anything: is it the right calibration?");
  }
  PrintAlignment(check, rectifier.camera());
  PrintDelay(check.delay);
  if (!options.picture.empty()) DrawRowErrors(check.last_left, check.matches, options.picture);
}

void Calibration(const CalibrationOptions& options) {
  const RigReading reading = ReadFilesOrSequence(options);
  std::printf("%s\n", reading.format.c_str());
  for (const ReadCamera& camera : reading.cameras) PrintReadCamera(camera);
  if (reading.rig && reading.problems.empty()) PrintRig(*reading.rig);
  if (reading.imu_minus_camera_s)
    std::printf("  clock: t_imu = t_camera %+.6f s\n", *reading.imu_minus_camera_s);
  for (const std::string& note : reading.notes) std::printf("  note: %s\n", note.c_str());
  for (const std::string& missing : reading.missing)
    std::printf("  missing for a rig: %s\n", missing.c_str());
  if (!reading.problems.empty()) {
    std::string text;
    for (const std::string& problem : reading.problems) text += (text.empty() ? "" : "\n") + problem;
    throw SequenceError(text);
  }
  if (!options.check.empty()) {
    if (!reading.rig) throw SequenceError("nothing to check: the files are no rig yet");
    CheckRows(options, *reading.rig);
  }
  if (options.output.empty()) return;
  if (!reading.rig) throw SequenceError(options.output.string() + ": not written, the files are no rig yet");
  WriteRig(options, *reading.rig);
}

}  // namespace

void AddCalibrationCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "calibration",
      "Say what calibration files of any known tool or device hold; write them as one rig file");
  auto options = std::make_shared<CalibrationOptions>();
  command->add_option(
      "FILE", options->files,
      "one file, or one a camera, or intrinsics and extrinsics: Kalibr, OpenCV, ROS, EuRoC, KITTI, "
      "camodocal, VINS, Basalt, ZED, RealSense, OAK, e-con, a rig file, or a recording");
  command->add_option("--output", options->output, "the rig file to write (terrace-rig, YAML)");
  command->add_flag("--overwrite", options->overwrite, "replace it");
  command->add_option(
      "--check", options->check,
      "a recording whose images are searched for rows that are off; without FILE, under its own calibration");
  AddChannelOptions(command, &options->channels);
  command->add_option("--picture", options->picture,
                      "with --check: the points and what their rows are off by");
  command->add_option("--size", options->size, "of the images, as 640x480, where files leave it open");
  command->add_option("--unit", options->unit, "of lengths, where files leave it open")
      ->check(CLI::IsMember({"m", "cm", "mm"}));
  command
      ->add_option("--baseline-m", options->baseline_m,
                   "the cameras stand side by side, parallel, this far apart")
      ->check(CLI::Range(0.001, 10.0));
  command->add_option("--cameras", options->cameras, "which of several are left and right, as 0,1");
  command->callback([options] {
    if (options->files.empty()) options->files = {options->check};
    if (options->files.front().empty()) throw UsageError("calibration: give FILE, or --check SEQUENCE");
    Calibration(*options);
  });
}

}  // namespace terrace

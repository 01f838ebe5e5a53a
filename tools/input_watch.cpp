// SPDX-License-Identifier: BSD-3-Clause
#include "tools/input_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/angles.h"
#include "core/print.h"
#include "stereo/row_alignment.h"

namespace terrace {
namespace {

using Findings = std::vector<Finding>;

// Ages beyond this are another clock, not lateness.
constexpr double kOtherClockS = 10.0;
constexpr double kLateS = 0.15;
constexpr double kFutureS = 0.002;
// Half of what walking needs to be followed.
constexpr double kSlowImagesHz = 8.0;
constexpr double kSlowImuHz = 80.0;
constexpr double kRowsOffMedianPx = 0.5;
constexpr double kDark = 30.0, kBright = 225.0;
constexpr double kSaturatedShare = 0.2;
constexpr double kBlurred = 0.35;

Finding JudgeInput(bool good, Severity otherwise, const char* code, std::string text, const char* remedy) {
  return {good ? Severity::kGood : otherwise, code, std::move(text),
          good ? std::string() : std::string(remedy)};
}

double SecondsBetween(Timestamp from, Timestamp to) { return Seconds(to - from); }

/// Mean of |Laplacian|.
double Detail(const cv::Mat1b& image) {
  cv::Mat1s laplacian;
  cv::Laplacian(image, laplacian, CV_16S);
  return cv::mean(cv::abs(laplacian))[0];
}

cv::Mat1b View(const GrayImage& image) {
  return {image.height, image.width, const_cast<std::uint8_t*>(image.data.data())};
}

double ShareOfWhite(const cv::Mat1b& image) {
  constexpr int kWhite = 250;
  return static_cast<double>(cv::countNonZero(image >= kWhite)) / static_cast<double>(image.total());
}

/// Rates and gaps of stamps: {rate on arrival [Hz], largest step [s], smallest step [s]}.
struct StampPace {
  double rate_hz = 0.0;
  double max_step_s = 0.0;
  double min_step_s = 0.0;
};

template <typename Stamps>
StampPace PaceOf(const Stamps& stamps) {
  StampPace pace;
  if (stamps.size() < 2) return pace;
  const double duration_s = SecondsBetween(stamps.front().t_arrival, stamps.back().t_arrival);
  if (duration_s > 0.0) pace.rate_hz = static_cast<double>(stamps.size() - 1) / duration_s;
  pace.min_step_s = kOtherClockS;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double step_s = SecondsBetween(stamps[i - 1].t, stamps[i].t);
    pace.max_step_s = std::max(pace.max_step_s, step_s);
    pace.min_step_s = std::min(pace.min_step_s, step_s);
  }
  return pace;
}

void JudgeRows(const Rectifier& rectifier, const std::vector<StereoPair>& pairs, Findings* findings) {
  std::vector<RowMatch> matches;
  RowMatchConfig config;
  config.max_disparity_px = rectifier.camera().width / 4;
  for (const StereoPair& pair : pairs) {
    const std::vector<RowMatch> found = MatchAcrossRows(rectifier.Rectify(0, pair), config);
    matches.insert(matches.end(), found.begin(), found.end());
  }
  const RowAlignment rows = EstimateRowAlignment(matches, rectifier.camera());
  if (rows.num_matches < RowAlignment::kFewestMatches) {
    findings->push_back(
        {Severity::kTrouble, "rows", Printed("only %d points are found in both images", rows.num_matches),
         "left and right swapped? a lens covered? another calibration? Then look at something with "
         "texture"});
    return;
  }
  findings->push_back(JudgeInput(
      rows.median_px <= kRowsOffMedianPx, Severity::kTrouble, "rows",
      Printed(
          "rows are off by %.2f px (median of %d points), right image %+.2f px lower, turned by %+.2f deg",
          rows.median_px, rows.num_matches, rows.row_shift_px, Degrees(rows.roll_rad)),
      "terrace calibration --check on a record for the details; calibrate anew"));
}

}  // namespace

double Sharpness(const GrayImage& image) {
  if (image.width < 4 || image.height < 4) return 0.0;
  cv::Mat1b half;
  cv::resize(View(image), half, {}, 0.5, 0.5, cv::INTER_AREA);
  const double detail_of_half = Detail(half);
  return detail_of_half > 0.0 ? Detail(View(image)) / detail_of_half : 0.0;
}

void InputWatch::AddImageStamp(Timestamp t_capture, Timestamp t_arrival) {
  images_.push_back({t_capture, t_arrival});
}

void InputWatch::AddPair(StereoPair pair) { pairs_.push_back(std::move(pair)); }

void InputWatch::AddImu(const ImuSample& sample, Timestamp t_arrival) {
  imu_.push_back({sample.t, t_arrival});
  accel_norms_.push_back(sample.accel.norm());
  gyro_norms_.push_back(sample.gyro.norm());
}

Findings InputWatch::JudgeStamps() const {
  Findings findings;
  if (images_.empty()) {
    findings.push_back({Severity::kTrouble, "images", "no images are heard",
                        "terrace camera, or the camera's own driver, must send images_t on channels.images"});
    return findings;
  }
  const StampPace pace = PaceOf(images_);
  findings.push_back(JudgeInput(pace.rate_hz >= kSlowImagesHz, Severity::kNote, "images",
                                Printed("%.1f pairs a second, largest step of their stamps %.0f ms",
                                        pace.rate_hz, 1e3 * pace.max_step_s),
                                "15 to 30 a second follow a walk"));
  if (images_.size() > 1) {
    findings.push_back(JudgeInput(
        pace.min_step_s > 0.0, Severity::kTrouble, "image_stamps_order",
        pace.min_step_s > 0.0 ? "stamps of images increase" : "stamps of images stand still or go back",
        "each pair needs the middle of its own exposure, on a clock that is never set back; or two "
        "cameras send on one channel"));
  }
  std::vector<double> ages_s;
  for (const Stamp& image : images_) ages_s.push_back(SecondsBetween(image.t, image.t_arrival));
  const double age_s = Quantile(ages_s, 0.5);
  const std::string text = Printed("images are %.1f ms old when they arrive (median; most %.1f ms)",
                                   1e3 * age_s, 1e3 * *std::max_element(ages_s.begin(), ages_s.end()));
  if (std::abs(age_s) > kOtherClockS) {
    findings.push_back(
        {Severity::kNote, "image_stamps", Printed("images are stamped by another clock, %.0f s off", age_s),
         "mapping does not mind, as long as IMU and legs use the same; ages in the status are then those "
         "since arrival"});
  } else if (age_s < -kFutureS) {
    findings.push_back(
        {Severity::kTrouble, "image_stamps", text, "they are stamped in the future: the driver's clock"});
  } else {
    findings.push_back(JudgeInput(age_s <= kLateS, Severity::kNote, "image_stamps", text,
                                  "a camera that encodes, or a queue in its driver, adds to every age"));
  }
  return findings;
}

std::vector<double> InputWatch::ImuDelays() const {
  std::vector<double> delays_s;
  for (const Stamp& image : images_) {
    const auto covering =
        std::find_if(imu_.begin(), imu_.end(), [&](const Stamp& sample) { return sample.t >= image.t; });
    if (covering == imu_.end() || covering == imu_.begin())
      continue;  // not known, or heard from the middle on
    delays_s.push_back(std::max(0.0, SecondsBetween(image.t_arrival, covering->t_arrival)));
  }
  return delays_s;
}

Findings InputWatch::JudgeImu() const {
  Findings findings;
  if (imu_.size() < 2) {
    findings.push_back(
        {Severity::kNote, "imu", "no IMU is heard",
         "not needed; with one, tracking survives dark, blur and turns (imu_v1_t on channels.imu)"});
    return findings;
  }
  const StampPace pace = PaceOf(imu_);
  findings.push_back(JudgeInput(
      pace.rate_hz >= kSlowImuHz && 1e3 * pace.max_step_s <= config_.imu_gap_ms, Severity::kTrouble, "imu",
      Printed("%.0f IMU samples a second, largest step %.0f ms", pace.rate_hz, 1e3 * pace.max_step_s),
      "100 or more a second, none missing"));
  const double accel = Quantile(accel_norms_, 0.5), gyro = Quantile(gyro_norms_, 0.5);
  findings.push_back(JudgeInput(
      accel > 8.8 && accel < 10.8, Severity::kTrouble, "imu_accel",
      Printed("accelerometer: %.2f m/s2 (median)", accel),
      "9.8 at rest, gravity included: 1.0 means g instead of m/s2, 0 means gravity was taken out"));
  findings.push_back(JudgeInput(gyro < 3.0, Severity::kTrouble, "imu_gyro",
                                Printed("gyroscope: %.3f rad/s (median)", gyro), "rad/s, not deg/s"));
  if (images_.empty()) return findings;
  const double offset_s = SecondsBetween(images_.back().t, imu_.back().t) -
                          SecondsBetween(images_.back().t_arrival, imu_.back().t_arrival);
  if (std::abs(offset_s) > 1.0) {
    findings.push_back({Severity::kTrouble, "imu_clock",
                        Printed("IMU and camera are stamped by different clocks, %.1f s apart", offset_s),
                        "both drivers must stamp on one clock"});
    return findings;
  }
  const double delay_s = Quantile(ImuDelays(), 0.95);
  findings.push_back(JudgeInput(
      1e3 * delay_s <= config_.imu_wait_ms, Severity::kTrouble, "imu_overlap",
      Printed("the IMU reaches the time of a pair %.1f ms after the pair has arrived (95 %%)", 1e3 * delay_s),
      "longer than lcm.imu_wait_ms: the pair goes on without; send samples sooner, in smaller parts"));
  return findings;
}

Findings InputWatch::JudgePairs(const std::optional<StereoCalibration>& calibration,
                                const RectifierConfig& rectifier_config) const {
  Findings findings;
  std::vector<StereoPair> good;
  for (const StereoPair& pair : pairs_) {
    if (!pair.problem.empty()) {
      findings.push_back({Severity::kTrouble, "image_content", "a pair cannot be used: " + pair.problem,
                          "the driver's format: see lcmtypes/image_t.lcm"});
      return findings;
    }
    good.push_back(pair);
  }
  if (good.empty()) return findings;
  double brightness[2] = {0.0, 0.0}, white = 0.0, sharpness = 0.0;
  const double share = 1.0 / static_cast<double>(good.size());
  for (const StereoPair& pair : good) {
    brightness[0] += share * cv::mean(View(pair.left))[0];
    brightness[1] += share * cv::mean(View(pair.right))[0];
    white += share * std::max(ShareOfWhite(View(pair.left)), ShareOfWhite(View(pair.right)));
    sharpness += share * std::min(Sharpness(pair.left), Sharpness(pair.right));
  }
  const bool lit = std::min(brightness[0], brightness[1]) > kDark &&
                   std::max(brightness[0], brightness[1]) < kBright && white < kSaturatedShare;
  findings.push_back(JudgeInput(lit, Severity::kTrouble, "exposure",
                                Printed("mean brightness %.0f and %.0f of 255, %.0f %% white", brightness[0],
                                        brightness[1], 100.0 * white),
                                "exposure and gain of the camera, the same for both"));
  findings.push_back(JudgeInput(sharpness > kBlurred, Severity::kNote, "sharpness",
                                Printed("detail against that of half the size: %.2f", sharpness),
                                "focus, dirt on the lens, a shorter exposure while walking"));
  if (!calibration) return findings;
  const GrayImage& left = good.front().left;
  if (left.width != calibration->width || left.height != calibration->height) {
    findings.push_back({Severity::kTrouble, "image_size",
                        Printed("images of %dx%d, the calibration is for %dx%d", left.width, left.height,
                                calibration->width, calibration->height),
                        "calibrate at the size that the camera sends, or let it send that one"});
    return findings;
  }
  JudgeRows(Rectifier(*calibration, rectifier_config), good, &findings);
  return findings;
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "damage.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

/// The stretch of a sequence in which what lasts ten frames happens.
std::size_t Middle(const std::vector<StereoFrame>& frames) { return frames.size() * 2 / 5; }

void DropBursts(int length, int every, std::vector<StereoFrame>& frames,
                std::vector<SensorSamples>& samples) {
  std::vector<StereoFrame> kept;
  std::vector<SensorSamples> kept_samples;
  SensorSamples pending;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    pending.imu.insert(pending.imu.end(), samples[i].imu.begin(), samples[i].imu.end());
    pending.priors.insert(pending.priors.end(), samples[i].priors.begin(), samples[i].priors.end());
    const int phase = static_cast<int>(i) % every;
    if (phase >= every - length && i + 1 < frames.size()) continue;
    kept.push_back(frames[i]);
    kept.back().frame_id = static_cast<FrameId>(kept.size()) - 1;
    kept_samples.push_back(pending);
    pending = {};
  }
  frames = kept;
  samples = kept_samples;
}

cv::Mat1b MotionBlur(const cv::Mat1b& image, double length_px, double angle) {
  const int radius = static_cast<int>(std::ceil(length_px / 2));
  cv::Mat1f kernel(2 * radius + 1, 2 * radius + 1, 0.0f);
  for (int k = -20; k <= 20; ++k) {
    const double s = length_px / 2 * k / 20.0;
    kernel(static_cast<int>(std::lround(radius + s * std::sin(angle))),
           static_cast<int>(std::lround(radius + s * std::cos(angle)))) += 1.0f / 41.0f;
  }
  cv::Mat1b blurred;
  cv::filter2D(image, blurred, -1, kernel);
  return blurred;
}

/// A textured board, nearer than most of the scene, that swings across the view and covers a third of it.
void DrawBoard(std::size_t i, StereoFrame& frame) {
  constexpr int kDisparityPx = 45;
  const int width = frame.left.cols / 2;
  const int height = frame.left.rows * 2 / 3;
  const int u0 =
      static_cast<int>((frame.left.cols - width) * (0.5 + 0.5 * std::sin(0.11 * static_cast<double>(i))));
  const int v0 =
      static_cast<int>((frame.left.rows - height) * (0.5 + 0.5 * std::sin(0.23 * static_cast<double>(i))));
  for (int side = 0; side < 2; ++side) {
    cv::Mat1b& image = side == 0 ? frame.left : frame.right;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const int at = u0 + u - side * kDisparityPx;
        if (at < 0 || at >= image.cols) continue;
        const unsigned cell =
            static_cast<unsigned>(u / 6 * 73856093) ^ static_cast<unsigned>(v / 6 * 19349663);
        image(v0 + v, at) = static_cast<std::uint8_t>(60 + (cell * 2654435761u >> 25));
      }
    }
  }
}

using Edit = std::function<void(std::size_t i, StereoFrame& frame)>;

void ForEach(const Edit& edit, std::vector<StereoFrame>& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].left.empty()) continue;
    frames[i].left = frames[i].left.clone();
    frames[i].right = frames[i].right.clone();
    edit(i, frames[i]);
  }
}

using EditImu = std::function<void(ImuSample& sample)>;

/// What an IMU does that is configured or wired otherwise than was told.
const std::map<std::string, EditImu>& ImuFaults() {
  static const std::map<std::string, EditImu> faults{
      {"imu_in_g", [](ImuSample& sample) { sample.accel /= 9.81; }},
      {"imu_turned", [](ImuSample& sample) { sample.accel *= -1.0; }},
      {"imu_silent", [](ImuSample& sample) { sample.accel.setZero(); }},
      {"imu_in_degrees", [](ImuSample& sample) { sample.gyro *= 180.0 / M_PI; }},
      {"imu_other_clock", [](ImuSample& sample) { sample.t.ns /= 1000; }},
  };
  return faults;
}

}  // namespace

const std::vector<std::string>& DamageNames() {
  static const std::vector<std::string> names{
      "burst1",         "burst3",         "burst10", "blur30",    "black10",  "gain0.3",    "gain3",
      "half",           "right10",        "box",     "imu_spike", "imu_in_g", "imu_turned", "imu_silent",
      "imu_in_degrees", "imu_other_clock"};
  return names;
}

void ApplyDamage(const std::string& name, std::vector<StereoFrame>& frames,
                 std::vector<SensorSamples>& samples) {
  const std::size_t n = frames.size();
  const std::size_t middle = Middle(frames);
  const auto InMiddle = [middle](std::size_t i) { return i >= middle && i < middle + 10; };
  const auto Gain = [n](double gain) {
    return [gain, n](std::size_t i, StereoFrame& frame) {
      if (i < n / 3 || i >= 2 * n / 3) return;
      frame.left.convertTo(frame.left, -1, gain);
      frame.right.convertTo(frame.right, -1, gain);
    };
  };
  if (name == "burst1") {
    DropBursts(1, 12, frames, samples);
  } else if (name == "burst3") {
    DropBursts(3, 25, frames, samples);
  } else if (name == "burst10") {
    DropBursts(10, 75, frames, samples);
  } else if (name == "blur30") {
    std::mt19937 random(5);
    ForEach(
        [&](std::size_t, StereoFrame& frame) {
          const bool chosen = random() % 10 < 3;
          const double length = 6.0 + random() % 12;
          const double angle = 0.01 * (random() % 314);
          if (!chosen) return;
          frame.left = MotionBlur(frame.left, length, angle);
          frame.right = MotionBlur(frame.right, length, angle);
        },
        frames);
  } else if (name == "black10") {
    ForEach(
        [&](std::size_t i, StereoFrame& frame) {
          if (!InMiddle(i)) return;
          frame.left.setTo(3);
          frame.right.setTo(3);
        },
        frames);
  } else if (name == "blink") {
    ForEach(
        [&](std::size_t i, StereoFrame& frame) {
          constexpr std::size_t kEvery = 24;
          const std::size_t length = 1 + i / kEvery % 10;
          if (i < kEvery || i % kEvery >= length) return;
          frame.left.setTo(3);
          frame.right.setTo(3);
        },
        frames);
  } else if (name == "gain0.3") {
    ForEach(Gain(0.3), frames);
  } else if (name == "gain3") {
    ForEach(Gain(3.0), frames);
  } else if (name == "half") {
    ForEach(
        [&](std::size_t i, StereoFrame& frame) {
          if (i < 10) return;
          frame.left.colRange(0, frame.left.cols / 2).setTo(20);
          frame.right.colRange(0, frame.right.cols / 2).setTo(20);
        },
        frames);
  } else if (name == "right10") {
    ForEach(
        [&](std::size_t i, StereoFrame& frame) {
          if (InMiddle(i)) frame.right.setTo(3);
        },
        frames);
  } else if (name == "black40") {
    ForEach(
        [&](std::size_t i, StereoFrame& frame) {
          if (i < middle || i >= middle + 40) return;
          frame.left.setTo(3);
          frame.right.setTo(3);
        },
        frames);
  } else if (name == "imu_spike") {
    if (!samples[middle].imu.empty()) samples[middle].imu.back().accel.x() = 1e6;
  } else if (const auto fault = ImuFaults().find(name); fault != ImuFaults().end()) {
    for (SensorSamples& of_frame : samples)
      for (ImuSample& sample : of_frame.imu) fault->second(sample);
  } else if (name == "box") {
    ForEach(
        [&](std::size_t i, StereoFrame& frame) {
          if (i >= n / 4 && i < 3 * n / 4) DrawBoard(i, frame);
        },
        frames);
  } else {
    throw std::invalid_argument("no damage is called " + name);
  }
}

void AddNoise(std::uint32_t seed, std::vector<StereoFrame>& frames) {
  std::mt19937 random(seed);
  ForEach(
      [&](std::size_t, StereoFrame& frame) {
        for (cv::Mat1b* image : {&frame.left, &frame.right})
          for (std::uint8_t& grey : *image)
            if (grey > 0 && grey < 255) grey = static_cast<std::uint8_t>(grey + random() % 3 - 1);
      },
      frames);
}

}  // namespace terrace

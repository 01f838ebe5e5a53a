// SPDX-License-Identifier: BSD-3-Clause
// A camera driver of your own: replace Grab() by your camera. Stamps are the middle of the exposure, on the
// system's clock.
#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include <lcm/lcm-cpp.hpp>
#include <terrace/images_t.hpp>

namespace {

constexpr int kWidth = 640, kHeight = 480, kRateHz = 30;

/// Fills `pixels` with 8-bit grey, row after row; returns when the middle of the exposure was [us since the
/// epoch].
std::int64_t Grab(bool right, int frame, std::vector<std::uint8_t>* pixels) {
  pixels->resize(kWidth * kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i)  // a pattern 16 px further left in the right image
    (*pixels)[i] = static_cast<std::uint8_t>(
        ((i % kWidth + (right ? 16 : 0)) / 8 * 37 + i / kWidth / 8 * 91 + frame) & 0xff);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

}  // namespace

int main() {
  lcm::LCM lcm("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  for (int frame = 0; lcm.good(); ++frame) {
    terrace::images_t pair{};
    for (const bool right : {false, true}) {
      terrace::image_t image{};
      image.utime = pair.utime = Grab(right, frame, &image.data);
      image.width = image.row_stride = kWidth;
      image.height = kHeight;
      image.pixelformat = terrace::image_t::GRAY;
      image.size = static_cast<std::int32_t>(image.data.size());
      pair.image_types.push_back(right ? terrace::images_t::RIGHT : terrace::images_t::LEFT);
      pair.images.push_back(std::move(image));
      ++pair.n_images;
    }
    lcm.publish("TERRACE_IMAGES", &pair);
    std::this_thread::sleep_for(std::chrono::milliseconds(1000 / kRateHz));
  }
}

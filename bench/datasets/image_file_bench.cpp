// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>

#include "datasets/image_file.h"

namespace terrace {
namespace {

/// Smooth shapes and camera noise: packs about as well as a photograph.
GrayImage Photograph(int width, int height) {
  std::mt19937 random(1);
  GrayImage image{width, height, {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double grey =
          128 + 60 * std::sin(0.03 * u) * std::cos(0.05 * v) + static_cast<double>(random() % 5);
      image.data.push_back(static_cast<std::uint8_t>(grey));
    }
  }
  return image;
}

void BM_DecodePng(benchmark::State& state) {
  const std::vector<std::uint8_t> bytes = EncodePng(Photograph(752, 480));
  for (auto _ : state) benchmark::DoNotOptimize(DecodeGrayImage(bytes, "bench"));
}
BENCHMARK(BM_DecodePng)->Unit(benchmark::kMillisecond);

void BM_DecodeJpeg(benchmark::State& state) {
  const std::vector<std::uint8_t> bytes = EncodeJpeg(Photograph(752, 480), 95);
  for (auto _ : state) benchmark::DoNotOptimize(DecodeGrayImage(bytes, "bench"));
}
BENCHMARK(BM_DecodeJpeg)->Unit(benchmark::kMillisecond);

void BM_EncodePng(benchmark::State& state) {
  const GrayImage image = Photograph(752, 480);
  for (auto _ : state) benchmark::DoNotOptimize(EncodePng(image));
}
BENCHMARK(BM_EncodePng)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace terrace

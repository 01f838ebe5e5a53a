// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/image_fingerprint.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace terrace {

std::uint64_t ImageFingerprint(const cv::Mat1b& image) {
  constexpr int kEvery = 8;  // rows
  // FNV-1a (Fowler, Noll, Vo), eight bytes at once.
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (int v = kEvery / 2; v < image.rows; v += kEvery) {
    for (int u = 0; u < image.cols; u += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, image[v] + u, static_cast<std::size_t>(std::min(8, image.cols - u)));
      hash = (hash ^ word) * 0x100000001B3u;
      hash ^= hash >> 29;
    }
  }
  return hash == 0 ? 1 : hash;
}

}  // namespace terrace

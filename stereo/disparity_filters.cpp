// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_filters.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "stereo/disparity_units.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

/// Runs of connected pixels, joined to pieces by union-find.
class Pieces {
 public:
  /// @param num_unique  pixels whose pattern does not repeat itself
  int Add(int num_pixels, int num_unique) {
    parent_.push_back(static_cast<int>(parent_.size()));
    size_.push_back({num_pixels, num_unique});
    return parent_.back();
  }
  int Find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(int i, int j) {
    i = Find(i), j = Find(j);
    if (i == j) return;
    if (i > j) std::swap(i, j);
    parent_[j] = i;
    size_[i].num_pixels += size_[j].num_pixels;
    size_[i].num_unique += size_[j].num_unique;
  }
  bool IsSpeckle(int i, int min_pixels) {
    const Size& size = size_[Find(i)];
    return size.num_unique < min_pixels || 2 * size.num_unique < size.num_pixels;
  }

 private:
  struct Size {
    int num_pixels, num_unique;
  };
  std::vector<int> parent_;
  std::vector<Size> size_;
};

struct Run {
  int begin, end;  // columns
  int piece;
};

}  // namespace

void RemoveSpeckles(int min_pixels, float max_difference, cv::Mat1f& disparity, const Steepness& steepness,
                    const Repetition& repetition) {
  Pieces pieces;
  std::vector<float> level(disparity.cols, max_difference), sloped(disparity.cols);
  std::vector<char> parted(disparity.cols);  // from the pixel before, or unknown
  std::vector<std::int16_t> slopes((disparity.cols + 63) / 64 * 64);
  std::vector<Run> runs;
  std::vector<std::size_t> row_begin = {0};
  for (int v = 0; v < disparity.rows; ++v) {
    const float* row = disparity[v];
    const float* max_differences = level.data();
    if (steepness.surfaces &&
        steepness.surfaces->SlopesOfRow(v, steepness.scale, disparity.cols, slopes.data())) {
      for (int u = 0; u < disparity.cols; ++u)
        sloped[u] = max_difference + std::abs(static_cast<float>(slopes[u])) / UnitImage::kUnitsPerPx;
      max_differences = sloped.data();
    }
    for (int u = 1; u < disparity.cols; ++u)
      parted[u] = !(std::abs(row[u] - row[u - 1]) <= max_differences[u]);
    for (int u = 0; u < disparity.cols;) {
      if (std::isnan(row[u])) {
        ++u;
        continue;
      }
      const void* next = std::memchr(parted.data() + u + 1, 1, disparity.cols - u - 1);
      const int end =
          next ? static_cast<int>(static_cast<const char*>(next) - parted.data()) : disparity.cols;
      const int num_repeated =
          repetition.patterns ? repetition.patterns->NumPixels(v, u, end, repetition.scale) : 0;
      runs.push_back({u, end, pieces.Add(end - u, end - u - num_repeated)});
      u = end;
    }
    row_begin.push_back(runs.size());
    if (v == 0) continue;
    const float* above = disparity[v - 1];
    std::size_t i = row_begin[v - 1];
    for (std::size_t j = row_begin[v]; j < row_begin[v + 1]; ++j) {
      while (i < row_begin[v] && runs[i].end <= runs[j].begin) ++i;
      for (std::size_t k = i; k < row_begin[v] && runs[k].begin < runs[j].end; ++k) {
        const int begin = std::max(runs[k].begin, runs[j].begin), end = std::min(runs[k].end, runs[j].end);
        int u = begin;
        while (u < end && std::abs(row[u] - above[u]) > max_differences[u]) ++u;
        if (u < end) pieces.Join(runs[k].piece, runs[j].piece);
      }
    }
  }
  for (int v = 0; v < disparity.rows; ++v)
    for (std::size_t j = row_begin[v]; j < row_begin[v + 1]; ++j)
      if (pieces.IsSpeckle(runs[j].piece, min_pixels))
        std::fill(disparity[v] + runs[j].begin, disparity[v] + runs[j].end, kUnknownDisparity);
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "stereo/census.h"
#include "stereo/path_aggregation.h"

namespace terrace {

/// Semi-global matching written to be obviously right: whole numbers, one pixel and disparity at a time.
class PlainMatcher {
 public:
  PlainMatcher(const cv::Mat1b& left, const cv::Mat1b& right, const std::vector<CensusPair>& pairs,
               const PathPenalties& penalties, const cv::Mat_<std::int16_t>& first, int num_disparities)
      : left_(left), first_(first), penalties_(penalties), n_(num_disparities) {
    const auto left_words = Words(left, pairs), right_words = Words(right, pairs);
    costs_.resize(left.total() * n_);
    for (int v = 0; v < left.rows; ++v)
      for (int u = 0; u < left.cols; ++u)
        for (int i = 0; i < n_; ++i) {
          const int x = u - first(v, u) - i;
          const std::uint32_t word = left_words[v * left.cols + u];
          costs_[At(u, v, i)] = x < 0 ? std::min(std::popcount(word), 10)
                                      : std::popcount(word ^ right_words[v * left.cols + x]);
        }
  }

  /// Sums over the four paths within rows [top, bottom), the vertical ones coming from `lead_in` rows beyond.
  /// Index i of a pixel belongs to disparity first + i.
  std::vector<int> Sums(int top, int bottom, int lead_in) const {
    std::vector<int> sums(costs_.size(), 0);
    const int above = std::max(top - lead_in, 0), below = std::min(bottom + lead_in, left_.rows);
    for (int u = 0; u < left_.cols; ++u) {
      Path(u, above, 0, 1, below, &sums);
      Path(u, below - 1, 0, -1, above - 1, &sums);
    }
    for (int v = top; v < bottom; ++v) {
      Path(0, v, 1, 0, left_.cols, &sums);
      Path(left_.cols - 1, v, -1, 0, -1, &sums);
    }
    for (int& sum : sums) sum = std::min(sum, 255);
    return sums;
  }

  std::size_t At(int u, int v, int i) const {
    return (static_cast<std::size_t>(v) * left_.cols + u) * n_ + i;
  }

 private:
  static std::vector<std::uint32_t> Words(const cv::Mat1b& image, const std::vector<CensusPair>& pairs) {
    std::vector<std::uint32_t> words;
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u) {
        std::uint32_t word = 0;
        for (std::size_t b = 0; b < pairs.size(); ++b) {
          const auto at = [&](int du, int dv) {
            return image(std::clamp(v + dv, 0, image.rows - 1), std::clamp(u + du, 0, image.cols - 1));
          };
          if (at(pairs[b].du1, pairs[b].dv1) > at(pairs[b].du2, pairs[b].dv2)) word |= 1u << b;
        }
        words.push_back(word);
      }
    return words;
  }

  /// One path from (u, v) by steps of (du, dv) until the moving coordinate is `end`.
  void Path(int u, int v, int du, int dv, int end, std::vector<int>* sums) const {
    std::vector<int> before, now(n_);
    for (bool start = true; (du != 0 ? u : v) != end; u += du, v += dv, start = false) {
      for (int i = 0; i < n_; ++i) {
        int best = 0;
        if (!start) {
          const int least = *std::min_element(before.begin(), before.end());
          const int d = first_(v, u) + i - first_(v - dv, u - du);  // index in the neighbour's range
          const auto value = [&](int j) { return j >= 0 && j < n_ ? before[j] : 1000; };
          const int jump = std::abs(int{left_(v, u)} - int{left_(v - dv, u - du)});
          const int p2 = std::max(penalties_.p2_min, penalties_.p2_max - jump);
          best =
              std::min({value(d), value(d - 1) + penalties_.p1, value(d + 1) + penalties_.p1, least + p2}) -
              least;
        }
        now[i] = costs_[At(u, v, i)] + best;
        (*sums)[At(u, v, i)] += now[i];
      }
      before = now;
    }
  }

  cv::Mat1b left_;
  cv::Mat_<std::int16_t> first_;
  PathPenalties penalties_;
  int n_;
  std::vector<int> costs_;
};

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <functional>
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

  /// Sums over 2, 4 or 8 paths within rows [top, bottom), those from row to row coming from `lead_in` rows
  /// beyond; of eight, averages stand for the three from above and the three from below. Index i of a pixel
  /// belongs to disparity first + i.
  std::vector<int> Sums(int top, int bottom, int lead_in, int num_paths = 4) const {
    const int above = std::max(top - lead_in, 0), below = std::min(bottom + lead_in, left_.rows);
    const auto path_by = [&](int du, int dv) {
      std::vector<int> values(costs_.size(), 0);
      const int first_row = dv > 0 ? above : below - 1;
      if (dv == 0)
        for (int v = top; v < bottom; ++v)
          Path(du > 0 ? 0 : left_.cols - 1, v, du, dv, above, below, &values);
      else
        for (int u = 0; u < left_.cols; ++u) Path(u, first_row, du, dv, above, below, &values);
      if (dv != 0 && du != 0)  // those that begin at the side of the image
        for (int v = first_row + dv; v >= above && v < below; v += dv)
          Path(du > 0 ? 0 : left_.cols - 1, v, du, dv, above, below, &values);
      return values;
    };
    const auto each = [](std::vector<int> a, const std::vector<int>& b, auto of) {
      for (std::size_t i = 0; i < a.size(); ++i) a[i] = of(a[i], b[i]);
      return a;
    };
    const auto mean = [](int a, int b) { return (a + b + 1) / 2; };
    std::vector<int> sums = each(path_by(1, 0), path_by(-1, 0), std::plus());
    for (const int dv : {1, -1}) {
      if (num_paths == 2) continue;
      std::vector<int> values = path_by(0, dv);
      if (num_paths == 8) values = each(values, each(path_by(1, dv), path_by(-1, dv), mean), mean);
      sums = each(sums, values, std::plus());
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

  /// One path from (u, v) by steps of (du, dv) until it leaves the image or rows [above, below).
  void Path(int u, int v, int du, int dv, int above, int below, std::vector<int>* sums) const {
    std::vector<int> before, now(n_);
    for (bool start = true; u >= 0 && u < left_.cols && v >= above && v < below;
         u += du, v += dv, start = false) {
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

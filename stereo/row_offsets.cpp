// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/row_offsets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/check.h"
#include "core/parallel_for.h"
#include "stereo/patch_search.h"

namespace terrace {
namespace {

constexpr int kStep = 12;   // between places
constexpr int kWindow = 8;  // pixels of a side
constexpr float kWindowPixels = kWindow * kWindow;
constexpr float kMinTexture =
    8.0f;  // mean square of the gradient across rows, of what is not along them as well
constexpr float kMaxWeight = 200.0f;  // of the same
constexpr float kMaxStep = 1.2f;      // px, from what whole pixels say
constexpr int kMinPlaces = 30;
constexpr float kMaxSpread = 0.25f;  // px
constexpr int kFitRounds = 5;
constexpr int kFirstStride = 6;
/// How far is looked first: what lies farther is rare, and looking for it costs three times as much.
constexpr int kUsualRowOffset = 4;

/// The right image with the mean and the spread of brightness that the left one has.
cv::Mat1b AsBrightAs(const cv::Mat1b& left, const cv::Mat1b& right) {
  const auto moments = [](const cv::Mat1b& image) {
    std::int64_t n = 0, sum = 0, squares = 0;
    for (int v = 0; v < image.rows; v += 4)
      for (int u = 0; u < image.cols; ++u) ++n, sum += image(v, u), squares += image(v, u) * image(v, u);
    const double mean = static_cast<double>(sum) / static_cast<double>(n);
    return std::pair(mean, std::sqrt(static_cast<double>(squares) / static_cast<double>(n) - mean * mean));
  };
  const auto [mean_left, spread_left] = moments(left);
  const auto [mean_right, spread_right] = moments(right);
  const double gain = spread_right > 1.0 ? std::clamp(spread_left / spread_right, 0.2, 5.0) : 1.0;
  cv::Mat1b table(1, 256), matched;
  for (int i = 0; i < 256; ++i)
    table(i) = cv::saturate_cast<std::uint8_t>(mean_left + gain * (i - mean_right));
  cv::LUT(right, table, matched);
  return matched;
}

/// One place and the offset there.
struct Place {
  float x, y;  // from the middle of the right image
  float dy;
  float weight;
};

/// Sums over a window of what its pixels say, column by column.
struct Sums {
  using Columns = std::array<float, kWindow>;
  Columns gx{}, gy{}, l{}, r{}, gxx{}, gxy{}, gyy{}, gxl{}, gyl{}, gxr{}, gyr{}, ll{}, rr{};

  static float Total(const Columns& c) {
    return ((c[0] + c[4]) + (c[2] + c[6])) + ((c[1] + c[5]) + (c[3] + c[7]));
  }
  /// Of products less that of their means.
  static float Centred(const Columns& ab, const Columns& a, const Columns& b) {
    return Total(ab) - Total(a) * Total(b) / (kWindow * kWindow);
  }
};

/// What the windows that begin at (u, v) in the left image and at (x, y) in the right one say.
Sums SumUp(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, float x, float y) {
  Sums s;
  const int whole_x = static_cast<int>(x), whole_y = static_cast<int>(y);
  const float fx = x - static_cast<float>(whole_x), fy = y - static_cast<float>(whole_y);
  for (int b = 0; b < kWindow; ++b) {
    const std::uint8_t *above = left[v + b - 1] + u, *row = left[v + b] + u, *below = left[v + b + 1] + u;
    const std::uint8_t *upper = right[whole_y + b] + whole_x, *lower = right[whole_y + b + 1] + whole_x;
    for (int a = 0; a < kWindow; ++a) {
      const float p = upper[a], q = lower[a];
      const float from = p + fx * (static_cast<float>(upper[a + 1]) - p),
                  to = q + fx * (static_cast<float>(lower[a + 1]) - q);
      const float r = from + fy * (to - from), l = row[a];
      const float gx = 0.5f * static_cast<float>(row[a + 1] - row[a - 1]);
      const float gy = 0.5f * static_cast<float>(below[a] - above[a]);
      s.gx[a] += gx, s.gy[a] += gy, s.l[a] += l, s.r[a] += r;
      s.gxx[a] += gx * gx, s.gxy[a] += gx * gy, s.gyy[a] += gy * gy;
      s.gxl[a] += gx * l, s.gyl[a] += gy * l, s.gxr[a] += gx * r, s.gyr[a] += gy * r;
      s.ll[a] += l * l, s.rr[a] += r * r;
    }
  }
  return s;
}

/// The step of the disparity and of the offset that
///     left - gain * right = -gx * step_x + gy * step_y
/// asks for, without the windows' means, and how much texture says so across the rows.
struct Step {
  float x, y, texture;
};
std::optional<Step> Solve(const Sums& s) {
  const float ll = Sums::Centred(s.ll, s.l, s.l), rr = Sums::Centred(s.rr, s.r, s.r);
  const float gxx = Sums::Centred(s.gxx, s.gx, s.gx) + kWindowPixels, gxy = Sums::Centred(s.gxy, s.gx, s.gy);
  const float texture = Sums::Centred(s.gyy, s.gy, s.gy) - gxy * gxy / gxx;
  if (!(ll > 0.0f && rr > 0.0f && texture >= kMinTexture * kWindowPixels)) return std::nullopt;
  const float gain = std::clamp(std::sqrt(ll / rr), 0.3f, 3.0f);
  const float gxe = Sums::Centred(s.gxl, s.gx, s.l) - gain * Sums::Centred(s.gxr, s.gx, s.r);
  const float gye = Sums::Centred(s.gyl, s.gy, s.l) - gain * Sums::Centred(s.gyr, s.gy, s.r);
  const float y = (gye - gxe * gxy / gxx) / texture;
  return Step{(gxy * y - gxe) / gxx, y, texture / kWindowPixels};
}

std::optional<Place> MeasurePlace(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v,
                                  const PatchRange& range) {
  const std::optional<PatchMatch> match = FindPatch(left, right, u, v, range);
  if (!match) return std::nullopt;
  float disparity = static_cast<float>(match->disparity), dy = static_cast<float>(match->rows);
  float texture = 0.0f;
  for (int round = 0; round < 2; ++round) {
    const float x = static_cast<float>(u - kWindow / 2) - disparity,
                y = static_cast<float>(v - kWindow / 2) + dy;
    if (x < 0.0f || x >= static_cast<float>(right.cols - kWindow) || y < 0.0f ||
        y >= static_cast<float>(right.rows - kWindow))
      return std::nullopt;
    const std::optional<Step> step = Solve(SumUp(left, right, u - kWindow / 2, v - kWindow / 2, x, y));
    if (!step) return std::nullopt;
    disparity += step->x, dy += step->y, texture = step->texture;
    if (std::abs(disparity - static_cast<float>(match->disparity)) > kMaxStep ||
        std::abs(dy - static_cast<float>(match->rows)) > kMaxStep)
      return std::nullopt;
  }
  const float x = static_cast<float>(u) - disparity - 0.5f * static_cast<float>(right.cols);
  const float y = static_cast<float>(v) - 0.5f * static_cast<float>(right.rows);
  return Place{x, y, dy, std::min(texture, kMaxWeight)};
}

/// What is asked of the places of an image.
struct Survey {
  int num_disparities;
  int row_stride;    ///< every so many rows of places
  RowOffsets known;  ///< near which is searched ...
  int margin;        ///< ... so far up and down
};

std::vector<Place> MeasurePlaces(const cv::Mat1b& left, const cv::Mat1b& right, const Survey& survey) {
  const int num_rows = (left.rows - kPatchHeight) / kStep;
  std::vector<std::vector<Place>> of_rows(std::max(num_rows, 0));
  ParallelFor(static_cast<int>(of_rows.size()), [&](int i) {
    if (i % survey.row_stride != 0) return;
    const int v = kPatchHeight / 2 + 2 + i * kStep;
    for (int u = kPatchWidth / 2 + i % 2 * kStep / 2; u < left.cols; u += kStep) {
      const float expected = survey.known.At(static_cast<float>(u) - 0.5f * static_cast<float>(left.cols),
                                             static_cast<float>(v) - 0.5f * static_cast<float>(left.rows));
      const int middle = static_cast<int>(std::lround(expected));
      if (const std::optional<Place> place = MeasurePlace(
              left, right, u, v, {survey.num_disparities, middle - survey.margin, middle + survey.margin}))
        of_rows[i].push_back(*place);
    }
  });
  std::vector<Place> places;
  for (const std::vector<Place>& row : of_rows) places.insert(places.end(), row.begin(), row.end());
  return places;
}

/// Least squares with Cauchy's weights, whose width follows the median distance.
RowOffsets Fit(const std::vector<Place>& places, float width_px, RowOffsets fit) {
  fit.num_places = static_cast<int>(places.size());
  const float scale = 1.0f / width_px;
  std::vector<float> distances(places.size());
  for (int round = 0; round < kFitRounds; ++round) {
    for (std::size_t i = 0; i < places.size(); ++i)
      distances[i] = std::abs(places[i].dy - fit.At(places[i].x, places[i].y));
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    fit.spread_px = *middle;
    // What little is known beforehand: a gradient is less likely than a shift.
    Eigen::Matrix3d normal = Eigen::Vector3d(1.0, 10.0, 10.0).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    const float width = std::max(fit.spread_px, 0.02f);
    for (const Place& place : places) {
      const float distance = (place.dy - fit.At(place.x, place.y)) / width;
      const double weight = place.weight / (1.0f + distance * distance);
      const Eigen::Vector3d row(1.0, place.x * scale, place.y * scale);
      normal += weight * row * row.transpose();
      right += weight * place.dy * row;
    }
    const Eigen::Vector3d solution = normal.ldlt().solve(right);
    fit.centre_px = static_cast<float>(solution[0]);
    fit.per_column = static_cast<float>(solution[1]) * scale;
    fit.per_row = static_cast<float>(solution[2]) * scale;
  }
  return fit;
}

/// The largest offset in an image of that size, up or down.
float Farthest(const RowOffsets& offsets, const cv::Size& size) {
  return std::abs(offsets.centre_px) + 0.5f * (std::abs(offsets.per_column) * static_cast<float>(size.width) +
                                               std::abs(offsets.per_row) * static_cast<float>(size.height));
}

/// The median offset: where a fit may start.
RowOffsets Middle(std::vector<Place> places) {
  const auto middle = places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2);
  std::nth_element(places.begin(), middle, places.end(),
                   [](const Place& a, const Place& b) { return a.dy < b.dy; });
  return {.centre_px = middle->dy};
}

/// Patches do not turn along: where a camera is rolled by more than a degree, few are found, and those not
/// exactly. What is known of it is taken away, and the rest measured again, as long as that helps.
RowOffsets Turned(const cv::Mat1b& left, const cv::Mat1b& right, RowOffsets offsets, int num_disparities) {
  constexpr float kTurned = 0.008f;  // radians, or share of the size
  constexpr int kMostRounds = 4, kMargin = 2;
  const auto width = static_cast<float>(left.cols);
  cv::Mat1b straight;
  for (int round = 0; round < kMostRounds; ++round) {
    if (std::hypot(offsets.per_column, offsets.per_row) < kTurned) break;
    StraightenRows(right, offsets, straight);
    const std::vector<Place> places = MeasurePlaces(left, straight, {num_disparities, 1, {}, kMargin});
    if (static_cast<int>(places.size()) < kMinPlaces) break;
    const RowOffsets rest = Fit(places, width, Middle(places));
    offsets.centre_px += rest.centre_px;
    offsets.per_column += rest.per_column;
    offsets.per_row += rest.per_row;
    offsets.spread_px = rest.spread_px;
    offsets.num_places = rest.num_places;
    constexpr float kLittle = 0.001f;
    if (std::hypot(rest.per_column, rest.per_row) < kLittle) break;
  }
  return offsets;
}

}  // namespace

float RowOffsets::Rms(const cv::Size& size) const {
  const float of_columns = per_column * static_cast<float>(size.width),
              of_rows = per_row * static_cast<float>(size.height);
  return std::sqrt(centre_px * centre_px + (of_columns * of_columns + of_rows * of_rows) / 12.0f);
}

RowOffsets RowOffsets::Scaled(float scale) const {
  return {centre_px * scale, per_column, per_row, spread_px * scale, num_places};
}

RowOffsets MeasureRowOffsets(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities) {
  const cv::Mat1b matched = AsBrightAs(left, right);
  const auto width = static_cast<float>(left.cols);
  for (const int margin : {kUsualRowOffset, kMaxRowOffset}) {
    // Few places, far up and down; then all of them where those say.
    const std::vector<Place> first =
        MeasurePlaces(left, matched, {num_disparities, kFirstStride, {}, margin});
    if (static_cast<int>(first.size()) < kMinPlaces / kFirstStride) continue;
    const RowOffsets near = Fit(first, width, Middle(first));
    const std::vector<Place> places = MeasurePlaces(left, matched, {num_disparities, 1, near, 0});
    if (static_cast<int>(places.size()) < kMinPlaces) continue;
    const RowOffsets offsets = Turned(left, matched, Fit(places, width, near), num_disparities);
    // What is not farther than the usual look reaches would have been found by it.
    const bool farther = Farthest(offsets, left.size()) > kUsualRowOffset;
    if (offsets.spread_px <= kMaxSpread && (margin == kUsualRowOffset || farther)) return offsets;
  }
  return {};
}

void StraightenRows(const cv::Mat1b& right, const RowOffsets& offsets, cv::Mat1b& straight) {
  constexpr int kBlock = 32;      // columns that move alike
  constexpr int kFractions = 32;  // of a pixel
  constexpr int kWeightBits = 6;
  // With 0.5, Catmull's and Rom's, the right image would lose fine texture that the left one has.
  constexpr float kSharpness = 0.75f;
  straight.create(right.size());
  TERRACE_CHECK(straight.data != right.data);
  const int width = right.cols, height = right.rows;
  ParallelFor(height, [&](int v) {
    for (int begin = 0; begin < width; begin += kBlock) {
      const int end = std::min(begin + kBlock, width);
      const float x = 0.5f * static_cast<float>(begin + end - width);
      const float dy = offsets.At(x, static_cast<float>(v) - 0.5f * static_cast<float>(height));
      const int steps = static_cast<int>(std::lround(dy * kFractions));
      const int whole = steps >> 5;
      const float f = static_cast<float>(steps - whole * kFractions) / kFractions;
      const auto rounded = [](float w) {
        return static_cast<std::int16_t>(std::lround(w * (1 << kWeightBits)));
      };
      const std::int16_t w0 = rounded(-kSharpness * f * (1 - f) * (1 - f)),
                         w3 = rounded(-kSharpness * f * f * (1 - f));
      const std::int16_t w2 = rounded(f * (kSharpness + f * ((3 - 2 * kSharpness) + f * (kSharpness - 2))));
      const auto w1 = static_cast<std::int16_t>((1 << kWeightBits) - w0 - w2 - w3);
      const auto row = [&](int i) { return right[std::clamp(v + whole + i, 0, height - 1)]; };
      const std::uint8_t *p0 = row(-1), *p1 = row(0), *p2 = row(1), *p3 = row(2);
      std::uint8_t* to = straight[v];
      for (int u = begin; u < end; ++u) {
        const auto sum = static_cast<std::int16_t>(w0 * p0[u] + w1 * p1[u] + w2 * p2[u] + w3 * p3[u] +
                                                   (1 << (kWeightBits - 1)));
        to[u] = static_cast<std::uint8_t>(
            std::clamp<std::int16_t>(static_cast<std::int16_t>(sum >> kWeightBits), 0, 255));
      }
    }
  });
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline_tracer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "polygonization/ring_simplifier.h"

namespace terrace {
namespace {

constexpr double kMaxPixels = 4e6;

int RadiusPx(double width_m, double pixel_m) { return static_cast<int>(std::floor(0.5 * width_m / pixel_m)); }

cv::Mat Disk(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius + 1, 2 * radius + 1));
}

/// True when no pixel among eight touches one of the next row at a corner only.
bool NoDiagonals(const std::uint8_t* row, const std::uint8_t* next) {
  const auto load = [](const std::uint8_t* from) {
    std::uint64_t eight;
    std::memcpy(&eight, from, sizeof eight);
    return eight;
  };
  const std::uint64_t here = load(row), below = load(next);
  return ((here ^ load(row + 1)) & (below ^ load(next + 1)) & (here ^ below)) == 0;
}

/// Two pixels of one piece that touch at a corner only would make a ring touch itself: fills one of the
/// others. Pixels are 0 or 255.
void FillDiagonals(cv::Mat1b* image) {
  for (bool again = true; again;) {
    again = false;
    for (int y = 0; y + 1 < image->rows; ++y) {
      std::uint8_t* row = image->ptr(y);
      std::uint8_t* next = image->ptr(y + 1);
      for (int x = 0; x + 1 < image->cols; ++x) {
        if (x + 8 < image->cols && NoDiagonals(row + x, next + x)) {
          x += 7;
          continue;
        }
        if (row[x] != next[x + 1] || row[x + 1] != next[x] || row[x] == row[x + 1]) continue;
        (row[x] ? row[x + 1] : row[x]) = 255;
        again = true;
      }
    }
  }
}

}  // namespace

OutlineTracer::OutlineTracer(const OutlineSettings& settings, const Eigen::Vector2d& low,
                             const Eigen::Vector2d& high)
    : settings_(settings), pixel_m_(settings.resolution_m) {
  const Eigen::Vector2d size = high - low;
  while ((size.x() / pixel_m_ + 1.0) * (size.y() / pixel_m_ + 1.0) > kMaxPixels) pixel_m_ *= 2.0;
  // A margin, so that closing never meets the border. Pixels lie on a grid fixed in the plane: an outline
  // does not shiver when the plane's extent grows.
  const int margin = RadiusPx(settings.max_gap_m, pixel_m_) + 2;
  low_ = pixel_m_ * ((low / pixel_m_).array().floor() - margin).matrix();
  const Eigen::Vector2d num = ((high - low_) / pixel_m_).array().ceil() + margin;
  filled_ = cv::Mat1b::zeros(static_cast<int>(num.y()), static_cast<int>(num.x()));
}

void OutlineTracer::Fill(const Eigen::Vector2d& centre, const Eigen::Vector2d& half_x,
                         const Eigen::Vector2d& half_y) {
  const Eigen::Vector2d c = (centre - low_) / pixel_m_ - Eigen::Vector2d::Constant(0.5);  // in pixel centres
  const Eigen::Vector2d hx = half_x / pixel_m_, hy = half_y / pixel_m_;
  const double ex = std::abs(hx.x()) + std::abs(hy.x()), ey = std::abs(hx.y()) + std::abs(hy.y());
  const int y0 = std::max(0, static_cast<int>(std::ceil(c.y() - ey)));
  const int y1 = std::min(filled_.rows - 1, static_cast<int>(std::floor(c.y() + ey)));
  for (int y = y0; y <= y1; ++y) {
    // The rectangle is where |d . h| <= |h|^2 for both half axes h: of each row an interval.
    double low = c.x() - ex, high = c.x() + ex;
    for (const Eigen::Vector2d& h : {hx, hy}) {
      const double limit = std::max(h.squaredNorm(), 1e-12), across = h.y() * (y - c.y());
      if (std::abs(h.x()) < 1e-9) {
        if (std::abs(across) > limit) high = low - 1.0;
        continue;
      }
      const double middle = c.x() - across / h.x(), reach = limit / std::abs(h.x());
      low = std::max(low, middle - reach);
      high = std::min(high, middle + reach);
    }
    const int x0 = std::max(0, static_cast<int>(std::ceil(low)));
    const int x1 = std::min(filled_.cols - 1, static_cast<int>(std::floor(high)));
    if (x0 <= x1) std::fill_n(filled_.ptr(y) + x0, x1 - x0 + 1, std::uint8_t{255});
  }
}

std::vector<TracedPiece> OutlineTracer::Trace() {
  cv::Mat1b closed = filled_.clone();
  const int close_px = RadiusPx(settings_.max_gap_m, pixel_m_);
  const int open_px = RadiusPx(settings_.min_width_m, pixel_m_);
  if (close_px > 0) cv::morphologyEx(closed, closed, cv::MORPH_CLOSE, Disk(close_px));
  if (open_px > 0) {
    // Opening rounds corners; growing back inside the old shape restores them and leaves the tongues away.
    cv::Mat1b opened;
    cv::morphologyEx(closed, opened, cv::MORPH_OPEN, Disk(open_px));
    cv::dilate(opened, opened, Disk(open_px));
    closed &= opened;
  }
  FillDiagonals(&closed);
  pieces_ = BitmapPieces(closed);
  traced_index_.assign(pieces_.pieces().size(), -1);
  const std::vector<int> num_filled = pieces_.CountSet(filled_);
  std::vector<TracedPiece> traced_pieces;
  const double pixel_area = pixel_m_ * pixel_m_;
  for (std::size_t i = 0; i < pieces_.pieces().size(); ++i) {
    const BitmapPieces::Piece& piece = pieces_.pieces()[i];
    if (piece.num_pixels * pixel_area < settings_.min_area_m2) continue;
    std::vector<Ring2> traced;
    for (const std::vector<cv::Point>& corners : pieces_.TraceRings(static_cast<int>(i))) {
      Ring2 ring;
      for (const cv::Point& corner : corners)
        ring.push_back(low_ + pixel_m_ * Eigen::Vector2d(corner.x, corner.y));
      // Small holes are gaps in the data.
      if (SignedArea(ring) < 0.0 && -SignedArea(ring) < settings_.min_area_m2) continue;
      traced.push_back(std::move(ring));
    }
    std::vector<Ring2> rings = SimplifyRings(traced, settings_.simplify_m * pixel_m_ / settings_.resolution_m,
                                             settings_.max_vertices);
    TracedPiece result;
    for (Ring2& ring : rings) {
      result.area_m2 += SignedArea(ring);
      if (SignedArea(ring) > 0.0)
        result.outline = std::move(ring);
      else
        result.holes.push_back(std::move(ring));
    }
    result.centroid = low_ + pixel_m_ * (piece.centroid + Eigen::Vector2d::Constant(0.5));
    result.support = std::min(1.0, double(num_filled[i]) / piece.num_pixels);
    traced_index_[i] = static_cast<int>(traced_pieces.size());
    traced_pieces.push_back(std::move(result));
  }
  return traced_pieces;
}

int OutlineTracer::PieceAt(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d at = (p - low_) / pixel_m_;
  const int piece =
      pieces_.PieceAt(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
  return piece < 0 ? -1 : traced_index_[piece];
}

}  // namespace terrace

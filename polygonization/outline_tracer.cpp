// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline_tracer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

/// A hole is real where so many of its pixels were seen through.
constexpr int kRealHole_px = 6;

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

cv::Mat1b OutlineTracer::Tidy() const {
  cv::Mat1b closed = bitmap_.on.clone();
  const int close_px = RadiusPx(settings_.max_gap_m, bitmap_.pixel_m);
  const int open_px = RadiusPx(settings_.min_width_m, bitmap_.pixel_m);
  if (close_px > 0) {
    cv::morphologyEx(closed, closed, cv::MORPH_CLOSE, Disk(close_px));
    closed.setTo(0, bitmap_.barred);
  }
  if (open_px > 0) {
    // Opening rounds corners; growing back inside the old shape restores them and leaves the tongues away.
    cv::Mat1b opened;
    cv::morphologyEx(closed, opened, cv::MORPH_OPEN, Disk(open_px));
    cv::dilate(opened, opened, Disk(open_px));
    closed &= opened;
  }
  FillDiagonals(&closed);
  return closed;
}

/// Whether a small hole is a gap in the data: hardly any of it was seen through.
bool OutlineTracer::IsGap(const Ring2& hole, const std::vector<cv::Point>& corners) const {
  if (-SignedArea(hole) >= settings_.min_area_m2) return false;
  const cv::Rect box = cv::boundingRect(corners) & cv::Rect(0, 0, bitmap_.barred.cols, bitmap_.barred.rows);
  return cv::countNonZero(bitmap_.barred(box)) < kRealHole_px;
}

std::vector<TracedPiece> OutlineTracer::Trace(const std::vector<EdgeLine>& lines) {
  std::vector<TracedPiece> traced_pieces;
  if (bitmap_.on.empty()) return traced_pieces;
  const double pixel_m = bitmap_.pixel_m;
  pieces_ = BitmapPieces(Tidy());
  traced_index_.assign(pieces_.pieces().size(), -1);
  const std::vector<int> num_seen = pieces_.CountSet(bitmap_.on);
  for (std::size_t i = 0; i < pieces_.pieces().size(); ++i) {
    const BitmapPieces::Piece& piece = pieces_.pieces()[i];
    if (piece.num_pixels * pixel_m * pixel_m < settings_.min_area_m2) continue;
    std::vector<Ring2> traced;
    for (const std::vector<cv::Point>& corners : pieces_.TraceRings(static_cast<int>(i))) {
      Ring2 ring;
      for (const cv::Point& corner : corners)
        ring.push_back(bitmap_.low + pixel_m * Eigen::Vector2d(corner.x, corner.y));
      if (SignedArea(ring) < 0.0 && IsGap(ring, corners)) continue;
      traced.push_back(std::move(ring));
    }
    const SimplifySettings simplify{std::max(settings_.simplify_m, 1.1 * pixel_m), settings_.max_vertices,
                                    1.2 * pixel_m};
    TracedPiece result;
    for (Ring2& ring : SimplifyRings(traced, simplify, lines)) {
      result.area_m2 += SignedArea(ring);
      if (SignedArea(ring) > 0.0)
        result.outline = std::move(ring);
      else
        result.holes.push_back(std::move(ring));
    }
    result.centroid = bitmap_.low + pixel_m * (piece.centroid + Eigen::Vector2d::Constant(0.5));
    result.support = std::min(1.0, double(num_seen[i]) / piece.num_pixels);
    traced_index_[i] = static_cast<int>(traced_pieces.size());
    traced_pieces.push_back(std::move(result));
  }
  return traced_pieces;
}

int OutlineTracer::PieceAt(const Eigen::Vector2d& p) const {
  if (bitmap_.on.empty()) return -1;
  const cv::Point pixel = bitmap_.PixelAt(p);
  const int piece = pieces_.PieceAt(pixel.x, pixel.y);
  return piece < 0 ? -1 : traced_index_[piece];
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
// Faults of one camera of the pair, and of how the two stand to each other.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "datasets/synthetic/fault.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

using Images = std::vector<RecordedImage>;
using Side = Images FaultyRecording::*;
using EditPixels = std::function<void(GrayImage& image, double strength, std::uint32_t seed)>;

/// One camera, while the fault lasts.
auto While(Side side, EditPixels edit) {
  return [=](FaultyRecording& r, const FaultSpan& span, double strength) {
    for (std::size_t i = span.begin; i < span.end; ++i)
      edit((r.*side)[i].Edit(), strength, static_cast<std::uint32_t>(i));
  };
}

/// The right camera, from the first image on: what is built or set wrongly.
auto RightAlways(EditPixels edit) {
  return [=](FaultyRecording& r, const FaultSpan&, double strength) {
    for (std::size_t i = 0; i < r.right.size(); ++i)
      edit(r.right[i].Edit(), strength, static_cast<std::uint32_t>(i));
  };
}

EditPixels FillWith(std::uint8_t grey) {
  return [grey](GrayImage& image, double share, std::uint32_t) {
    const auto columns = static_cast<int>(share * image.width);
    for (int v = 0; v < image.height; ++v) {
      const auto row = image.data.begin() + static_cast<std::ptrdiff_t>(v) * image.width;
      std::fill(row + (image.width - columns), row + image.width, grey);
    }
  };
}

void Cover(GrayImage& image, double, std::uint32_t seed) {
  Random random(seed);
  for (std::uint8_t& grey : image.data)
    grey = static_cast<std::uint8_t>(std::clamp(4.0 + random.Gaussian(), 0.0, 255.0));
}

/// Bilinear; what is not seen repeats the edge.
double At(const GrayImage& image, double u, double v) {
  u = std::clamp(u, 0.0, image.width - 1.001);
  v = std::clamp(v, 0.0, image.height - 1.001);
  const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
  const double a = u - u0, b = v - v0;
  const std::uint8_t* p = image.data.data() + static_cast<std::ptrdiff_t>(v0) * image.width + u0;
  return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[image.width] + a * p[image.width + 1]);
}

/// @param source  of the centred pixel (x, y)
template <typename Source>
void Warp(GrayImage& image, Source source) {
  const GrayImage from = image;
  const double cx = 0.5 * (image.width - 1), cy = 0.5 * (image.height - 1);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const auto [x, y] = source(u - cx, v - cy);
      image.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                 static_cast<std::size_t>(u)] = static_cast<std::uint8_t>(At(from, x + cx, y + cy) + 0.5);
    }
  }
}

void Lower(GrayImage& image, double rows, std::uint32_t) {
  Warp(image, [=](double x, double y) { return std::pair{x, y - rows}; });
}
void Roll(GrayImage& image, double angle_deg, std::uint32_t) {
  const double a = angle_deg * std::numbers::pi / 180.0, c = std::cos(a), s = std::sin(a);
  Warp(image, [=](double x, double y) { return std::pair{c * x + s * y, c * y - s * x}; });
}
void Zoom(GrayImage& image, double percent, std::uint32_t) {
  const double scale = 1.0 / (1.0 + 0.01 * percent);
  Warp(image, [=](double x, double y) { return std::pair{scale * x, scale * y}; });
}
void Shift(GrayImage& image, double columns, std::uint32_t) {
  Warp(image, [=](double x, double y) { return std::pair{x - columns, y}; });
}
void Brighten(GrayImage& image, double gain, std::uint32_t) {
  for (std::uint8_t& grey : image.data)
    grey = static_cast<std::uint8_t>(std::clamp(gain * grey + 0.5, 0.0, 255.0));
}
void Mirror(GrayImage& image, double, std::uint32_t) {
  for (int v = 0; v < image.height; ++v) {
    const auto row = image.data.begin() + static_cast<std::ptrdiff_t>(v) * image.width;
    std::reverse(row, row + image.width);
  }
}
void TurnOver(GrayImage& image, double, std::uint32_t) { std::reverse(image.data.begin(), image.data.end()); }

/// Each image of one camera is the one of so many images before.
auto Late(Side side) {
  return [=](FaultyRecording& r, const FaultSpan&, double images) {
    Images& all = r.*side;
    const auto by = static_cast<std::size_t>(images);
    for (std::size_t i = all.size(); i-- > 0;) all[i].source = all[i - std::min(i, by)].source;
  };
}

/// Every so many images, the one of one camera is the one before.
auto LateNowAndThen(Side side) {
  return [=](FaultyRecording& r, const FaultSpan&, double every) {
    Images& all = r.*side;
    const auto step = std::max<std::size_t>(static_cast<std::size_t>(every), 2);
    for (std::size_t i = step - 1; i < all.size(); i += step) all[i].source = all[i - 1].source;
  };
}

/// About the axis that points down: what is looked at moves sideways, the further out the more.
void Yaw(GrayImage& image, double angle_deg, std::uint32_t) {
  const double t = std::tan(angle_deg * std::numbers::pi / 180.0), f = 0.7 * image.width;
  Warp(image, [=](double x, double y) {
    const double w = 1.0 - t * x / f;
    return std::pair{(x + t * f) / w, y / w};
  });
}

void ExchangeMidway(FaultyRecording& r, const FaultSpan& span, double) {
  for (std::size_t i = span.begin; i < r.left.size(); ++i) std::swap(r.left[i].source, r.right[i].source);
}

void Exchange(FaultyRecording& r, const FaultSpan&, double) {
  for (std::size_t i = 0; i < r.left.size(); ++i) std::swap(r.left[i].source, r.right[i].source);
}

}  // namespace

std::vector<Fault> PairFaults() {
  constexpr Side kLeft = &FaultyRecording::left, kRight = &FaultyRecording::right;
  return {
      {"right_white", "the right image is white, this share of it", 1, While(kRight, FillWith(255))},
      {"right_black", "the right image is black, this share of it", 1, While(kRight, FillWith(0))},
      {"right_grey", "the right image is grey, this share of it", 1, While(kRight, FillWith(128))},
      {"right_covered", "the right lens is covered", 1, While(kRight, Cover)},
      {"left_white", "the left image is white, this share of it", 1, While(kLeft, FillWith(255))},
      {"left_black", "the left image is black, this share of it", 1, While(kLeft, FillWith(0))},
      {"left_covered", "the left lens is covered", 1, While(kLeft, Cover)},
      {"right_half_white", "this share of the right image is white", 0.5, While(kRight, FillWith(255))},
      {"right_half_black", "this share of the right image is black", 0.5, While(kRight, FillWith(0))},
      {"left_half_white", "this share of the left image is white", 0.5, While(kLeft, FillWith(255))},
      {"left_half_black", "this share of the left image is black", 0.5, While(kLeft, FillWith(0))},
      {"right_mirrored", "the right image is mirrored", 1, RightAlways(Mirror)},
      {"right_turned_over", "the right image is upside down", 1, RightAlways(TurnOver)},
      {"cameras_exchanged", "left is right, and right is left", 1, Exchange},
      {"right_late", "the right image is so many images late", 1, Late(kRight)},
      {"left_late", "the left image is so many images late", 1, Late(kLeft)},
      {"exchanged_midway", "left becomes right, and right left", 1, ExchangeMidway},
      {"right_late_at_times", "every so many images the right one is an image late", 3,
       LateNowAndThen(kRight)},
      {"left_late_at_times", "every so many images the left one is an image late", 3, LateNowAndThen(kLeft)},
      {"right_yawed", "the right camera is yawed by so many degrees", 0.3, RightAlways(Yaw)},
      {"both_zoomed", "both images are so many percent too large", 3,
       [](FaultyRecording& r, const FaultSpan&, double percent) {
         for (auto* images : {&r.left, &r.right})
           for (RecordedImage& image : *images) Zoom(image.Edit(), percent, 0);
       }},
      {"right_flicker", "the brightness of the right image changes by up to this share", 0.5,
       RightAlways([](GrayImage& image, double share, std::uint32_t seed) {
         Brighten(image, 1.0 + share * (2.0 * Unit(Hash(seed)) - 1.0), seed);
       })},
      {"rows_off", "the right image is so many rows too low", 1.25, RightAlways(Lower)},
      {"right_rolled", "the right camera is rolled by so many degrees", 0.4, RightAlways(Roll)},
      {"right_zoomed", "the right image is so many percent too large", 1, RightAlways(Zoom)},
      {"columns_off", "the right image is so many columns too far to the right", 3, RightAlways(Shift)},
      {"right_dim", "the right image has this share of the brightness", 0.4, RightAlways(Brighten)},
      {"right_glaring", "the right image is so many times as bright", 3, RightAlways(Brighten)},
  };
}

}  // namespace terrace::synthetic

// SPDX-License-Identifier: BSD-3-Clause
// Faults of what both images show, and of their files.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/file_bytes.h"
#include "datasets/image_file.h"
#include "datasets/synthetic/fault.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

std::uint8_t Grey(double value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); }

using EditPixels = std::function<void(GrayImage& image, double strength, std::uint32_t seed)>;

/// Both images, while the fault lasts.
auto Meanwhile(EditPixels edit) {
  return [edit = std::move(edit)](FaultyRecording& r, const FaultSpan& span, double strength) {
    for (std::size_t i = span.begin; i < span.end; ++i) {
      edit(r.left[i].Edit(), strength, Hash(1, static_cast<std::uint32_t>(i)));
      edit(r.right[i].Edit(), strength, Hash(2, static_cast<std::uint32_t>(i)));
    }
  };
}

void Fill(GrayImage& image, std::uint8_t grey) { std::fill(image.data.begin(), image.data.end(), grey); }

/// Mean over 2 r + 1 pixels along rows and then along columns: a lens out of focus.
void Blur(GrayImage& image, int radius) {
  const auto along = [&](int step, int length, int lines, int line_step) {
    std::vector<int> line(static_cast<std::size_t>(length));
    for (int l = 0; l < lines; ++l) {
      std::uint8_t* first = image.data.data() + static_cast<std::ptrdiff_t>(l) * line_step;
      for (int i = 0; i < length; ++i)
        line[static_cast<std::size_t>(i)] = first[static_cast<std::ptrdiff_t>(i) * step];
      for (int i = 0; i < length; ++i) {
        const int from = std::max(0, i - radius), to = std::min(length - 1, i + radius);
        int sum = 0;
        for (int k = from; k <= to; ++k) sum += line[static_cast<std::size_t>(k)];
        first[static_cast<std::ptrdiff_t>(i) * step] = static_cast<std::uint8_t>(sum / (to - from + 1));
      }
    }
  };
  along(1, image.width, image.height, image.width);
  along(image.width, image.height, image.width, 1);
}

void AddPixelNoise(GrayImage& image, double sigma, std::uint32_t seed) {
  Random random(seed);
  for (std::uint8_t& grey : image.data) grey = Grey(grey + sigma * random.Gaussian());
}

/// A textured board at `disparity_px` that slides from right to left through the view of both cameras, and
/// for a while fills `share` of its width.
void SlideBoard(FaultyRecording& r, const FaultSpan& span, double share) {
  constexpr int kDisparityPx = 66, kTexel = 5;
  const double frames = static_cast<double>(span.end - span.begin);
  for (std::size_t i = span.begin; i < span.end; ++i) {
    const double done = static_cast<double>(i - span.begin) / frames;
    for (const bool left : {true, false}) {
      GrayImage& image = (left ? r.left : r.right)[i].Edit();
      const int width = static_cast<int>(std::lround(share * image.width)) + (left ? 0 : 0);
      const int u0 = static_cast<int>(std::lround(image.width - done * (image.width + width)));
      for (int v = 0; v < image.height; ++v) {
        for (int u = 0; u < width; ++u) {
          const int at = u0 + u - (left ? 0 : kDisparityPx);
          if (at < 0 || at >= image.width) continue;
          const auto texel =
              Hash(static_cast<std::uint32_t>(u / kTexel), static_cast<std::uint32_t>(v / kTexel));
          image.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                     static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(60 + (texel >> 25));
        }
      }
    }
  }
}

/// The lower part of an image is that of the one before.
void Tear(FaultyRecording& r, const FaultSpan& span, double share) {
  for (std::size_t i = span.end; i-- > span.begin;) {
    for (auto* images : {&r.left, &r.right}) {
      RecordedImage before = (*images)[i - 1];
      const GrayImage& old = before.Edit();
      GrayImage& image = (*images)[i].Edit();
      const auto from = static_cast<std::ptrdiff_t>((1.0 - share) * image.height) * image.width;
      std::copy(old.data.begin() + from, old.data.end(), image.data.begin() + from);
    }
  }
}

void Freeze(FaultyRecording& r, const FaultSpan& span, bool left, bool right) {
  for (std::size_t i = span.begin; i < span.end; ++i) {
    if (left) r.left[i].source = r.left[span.begin].source;
    if (right) r.right[i].source = r.right[span.begin].source;
  }
}

/// Every so many images, from the second on, both are those of the moment before, under a new time stamp.
void Repeat(FaultyRecording& r, const FaultSpan&, double every) {
  const auto step = std::max<std::size_t>(static_cast<std::size_t>(every), 2);
  for (std::size_t i = step - 1; i < r.left.size(); i += step) {
    r.left[i].source = r.left[i - 1].source;
    r.right[i].source = r.right[i - 1].source;
  }
}

/// Dirt on the middle of a lens, so wide that it covers a share of the image: grey, and sharp nowhere.
void Soil(GrayImage& image, double share, std::uint32_t) {
  const double cx = 0.5 * image.width, cy = 0.5 * image.height;
  const double radius = std::sqrt(share * image.width * image.height / std::numbers::pi);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const double out = std::hypot(u - cx, v - cy) / radius;
      const double through = std::clamp(4.0 * (out - 0.9), 0.0, 1.0);
      std::uint8_t& grey = image.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                                      static_cast<std::size_t>(u)];
      grey = Grey(through * grey + (1.0 - through) * 90.0);
    }
}

using EditBytes = std::function<std::vector<std::uint8_t>(std::vector<std::uint8_t> bytes)>;

/// The files of both images, while the fault lasts.
auto Files(EditBytes edit) {
  return [edit = std::move(edit)](FaultyRecording& r, const FaultSpan& span, double) {
    for (std::size_t i = span.begin; i < span.end; ++i)
      for (RecordedImage* image : {&r.left[i], &r.right[i]})
        image->bytes = edit(ReadFileBytes(image->source));
  };
}

GrayImage HalfSize(const GrayImage& image) {
  GrayImage half{image.width / 2, image.height / 2, {}};
  for (int v = 0; v < half.height; ++v)
    for (int u = 0; u < half.width; ++u)
      half.data.push_back(image.data[static_cast<std::size_t>(2 * v) * static_cast<std::size_t>(image.width) +
                                     static_cast<std::size_t>(2 * u)]);
  return half;
}

}  // namespace

std::vector<Fault> ImageFaults() {
  return {
      {"both_black", "both images are black", 1,
       Meanwhile([](GrayImage& m, double, std::uint32_t) { Fill(m, 0); })},
      {"both_white", "both images are white", 1,
       Meanwhile([](GrayImage& m, double, std::uint32_t) { Fill(m, 255); })},
      {"both_dark", "both lenses are covered: nothing but noise", 1,
       Meanwhile([](GrayImage& m, double, std::uint32_t seed) { Fill(m, 3), AddPixelNoise(m, 1.0, seed); })},
      {"dimmed", "the light goes down to this share", 0.15,
       Meanwhile([](GrayImage& m, double gain, std::uint32_t) {
         for (std::uint8_t& grey : m.data) grey = Grey(gain * grey);
       })},
      {"glaring", "both images are so many times too bright", 4,
       Meanwhile([](GrayImage& m, double gain, std::uint32_t) {
         for (std::uint8_t& grey : m.data) grey = Grey(gain * grey);
       })},
      {"flicker", "the brightness changes by up to this share from image to image", 0.5,
       Meanwhile([](GrayImage& m, double share, std::uint32_t seed) {
         const double gain = 1.0 + share * (2.0 * Unit(seed) - 1.0);
         for (std::uint8_t& grey : m.data) grey = Grey(gain * grey);
       })},
      {"black_flashes", "every so many images both are black", 4,
       [](FaultyRecording& r, const FaultSpan&, double every) {
         const auto step = std::max<std::size_t>(static_cast<std::size_t>(every), 2);
         for (std::size_t i = step - 1; i < r.left.size(); i += step)
           Fill(r.left[i].Edit(), 0), Fill(r.right[i].Edit(), 0);
       }},
      {"repeated", "every so many images both are those of the moment before", 3, Repeat},
      {"dirty_left", "dirt covers this share of the left lens", 0.3,
       [](FaultyRecording& r, const FaultSpan&, double share) {
         for (RecordedImage& image : r.left) Soil(image.Edit(), share, 0);
       }},
      {"dirty", "dirt covers this share of both lenses", 0.3,
       [](FaultyRecording& r, const FaultSpan&, double share) {
         for (auto* images : {&r.left, &r.right})
           for (RecordedImage& image : *images) Soil(image.Edit(), share, 0);
       }},
      {"defocus", "both images are blurred over so many pixels to either side", 6,
       Meanwhile([](GrayImage& m, double radius, std::uint32_t) { Blur(m, static_cast<int>(radius)); })},
      {"noise", "noise of so many grey values", 25,
       Meanwhile([](GrayImage& m, double sigma, std::uint32_t seed) { AddPixelNoise(m, sigma, seed); })},
      {"box_passes", "something near slides through the view, this share of it wide", 1.2, SlideBoard},
      {"torn", "this share of the image is that of the image before", 0.5, Tear},
      {"frozen", "both cameras give the same images again and again", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) { Freeze(r, span, true, true); }},
      {"frozen_left", "the left camera gives the same image again and again", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) { Freeze(r, span, true, false); }},
      {"frozen_right", "the right camera gives the same image again and again", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) { Freeze(r, span, false, true); }},
      {"files_cut", "image files end in the middle", 1, Files([](auto bytes) {
         bytes.resize(bytes.size() / 2);
         return bytes;
       })},
      {"files_empty", "image files are empty", 1, Files([](auto) { return std::vector<std::uint8_t>(); })},
      {"files_garbage", "image files hold something else", 1, Files([](auto bytes) {
         for (std::size_t i = 0; i < bytes.size(); ++i)
           bytes[i] = static_cast<std::uint8_t>(Hash(static_cast<std::uint32_t>(i)));
         return bytes;
       })},
      {"other_size", "images have half the size", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         for (std::size_t i = span.begin; i < span.end; ++i)
           for (RecordedImage* image : {&r.left[i], &r.right[i]}) image->pixels = HalfSize(image->Edit());
       }},
      {"left_missing", "the left camera gives no images", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         std::erase_if(r.left, [&](const RecordedImage& image) { return span.Holds(image.t); });
       }},
      {"right_missing", "the right camera gives no images", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         std::erase_if(r.right, [&](const RecordedImage& image) { return span.Holds(image.t); });
       }},
      {"eight_of_sixteen_bits", "8 bits of grey stand in 16 bits", 1,
       [](FaultyRecording& r, const FaultSpan&, double) {
         for (auto* images : {&r.left, &r.right}) {
           for (RecordedImage& image : *images) {
             const GrayImage& grey = image.Edit();
             const Gray16Image wide{grey.width, grey.height, {grey.data.begin(), grey.data.end()}};
             image.bytes = EncodePng(wide);
           }
         }
       }},
  };
}

}  // namespace terrace::synthetic

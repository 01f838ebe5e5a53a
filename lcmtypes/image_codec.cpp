// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/image_codec.h"

#include <charconv>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>

#include <turbojpeg.h>
#include <zstd.h>

#include "core/check.h"
#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

constexpr const char* kCaptureKey = "t_capture_ns";
constexpr const char* kProblemKey = "problem";
constexpr int kJpegQuality = 95;
// Level 1 is as good as 3 on camera noise and twice as fast.
constexpr int kZstdLevel = 1;
// More than any stereo camera has; what an image may make us allocate.
constexpr std::int64_t kMaxPixels = 64 << 20;

using JpegHandle = std::unique_ptr<void, int (*)(tjhandle)>;

/// A reason why an image cannot be used; stays within this file.
class ImageProblem : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Differences to the pixel before, of the first pixel of a row to the one above.
std::vector<std::uint8_t> Differences(const GrayImage& image) {
  std::vector<std::uint8_t> differences(image.data.size());
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const bool starts_row = i % width == 0;
    const std::uint8_t before = !starts_row ? image.data[i - 1] : i == 0 ? 0 : image.data[i - width];
    differences[i] = static_cast<std::uint8_t>(image.data[i] - before);
  }
  return differences;
}

/// The inverse of Differences, in place.
void AddUp(std::size_t width, std::vector<std::uint8_t>* data) {
  for (std::size_t i = 0; i < data->size(); ++i) {
    const bool starts_row = i % width == 0;
    const std::uint8_t before = !starts_row ? (*data)[i - 1] : i == 0 ? 0 : (*data)[i - width];
    (*data)[i] = static_cast<std::uint8_t>((*data)[i] + before);
  }
}

std::vector<std::uint8_t> CompressZstd(const GrayImage& image) {
  const std::vector<std::uint8_t> differences = Differences(image);
  std::vector<std::uint8_t> out(ZSTD_compressBound(differences.size()));
  const std::size_t size =
      ZSTD_compress(out.data(), out.size(), differences.data(), differences.size(), kZstdLevel);
  TERRACE_CHECK(!ZSTD_isError(size), ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::vector<std::uint8_t> CompressJpeg(const GrayImage& image) {
  const JpegHandle jpeg(tjInitCompress(), tjDestroy);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(jpeg.get(), image.data.data(), image.width, 0, image.height, TJPF_GRAY,
                                 &buffer, &size, TJSAMP_GRAY, kJpegQuality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(buffer, tjFree);
  TERRACE_CHECK(result == 0, tjGetErrorStr2(jpeg.get()));
  return {buffer, buffer + size};
}

void AddMetadata(const std::string& key, const std::string& value, image_t* message) {
  image_metadata_t metadata{};
  metadata.key = key;
  metadata.n = static_cast<std::int32_t>(value.size());
  metadata.value.assign(value.begin(), value.end());
  message->metadata.push_back(std::move(metadata));
  ++message->nmetadata;
}

image_t Encode(const GrayImage& image, ImageEncoding encoding) {
  image_t message{};
  message.width = message.row_stride = image.width;
  message.height = image.height;
  switch (encoding) {
    case ImageEncoding::kRaw:
      message.pixelformat = image_t::GRAY;
      message.data = image.data;
      break;
    case ImageEncoding::kLossless:
      message.pixelformat = image_t::GRAY_ZSTD;
      message.data = CompressZstd(image);
      break;
    case ImageEncoding::kMjpeg:
      message.pixelformat = image_t::MJPEG;
      message.data = CompressJpeg(image);
      break;
  }
  message.size = static_cast<std::int32_t>(message.data.size());
  return message;
}

void DecodeGray(const image_t& message, GrayImage* image) {
  const std::int64_t stride = message.row_stride;
  const std::int64_t needed = stride * (image->height - 1) + image->width;
  if (stride < image->width || static_cast<std::int64_t>(message.data.size()) < needed) {
    throw ImageProblem(std::to_string(message.data.size()) + " bytes are too few for its size");
  }
  image->data.reserve(static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height));
  for (std::int64_t row = 0; row < image->height; ++row) {
    const auto begin = message.data.begin() + row * stride;
    image->data.insert(image->data.end(), begin, begin + image->width);
  }
}

void DecodeZstd(const image_t& message, GrayImage* image) {
  const std::size_t num_pixels =
      static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height);
  if (ZSTD_getFrameContentSize(message.data.data(), message.data.size()) != num_pixels) {
    throw ImageProblem("its compressed data are not of its size");
  }
  image->data.resize(num_pixels);
  if (ZSTD_decompress(image->data.data(), num_pixels, message.data.data(), message.data.size()) !=
      num_pixels) {
    throw ImageProblem("its compressed data are damaged");
  }
  AddUp(static_cast<std::size_t>(image->width), &image->data);
}

void DecodeJpeg(const image_t& message, GrayImage* image) {
  const JpegHandle jpeg(tjInitDecompress(), tjDestroy);
  const auto size = static_cast<unsigned long>(message.data.size());
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(jpeg.get(), message.data.data(), size, &width, &height, &subsampling,
                          &colorspace) != 0 ||
      width != image->width || height != image->height) {
    throw ImageProblem("its JPEG data are not of its size");
  }
  image->data.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // A warning (a truncated stream, say) counts as damage: half an image must not enter the map.
  if (tjDecompress2(jpeg.get(), message.data.data(), size, image->data.data(), width, 0, height, TJPF_GRAY,
                    TJFLAG_ACCURATEDCT) != 0) {
    throw ImageProblem("its JPEG data are damaged");
  }
}

GrayImage Decode(const image_t& message) {
  GrayImage image{message.width, message.height, {}};
  if (image.width <= 0 || image.height <= 0 || std::int64_t{image.width} * image.height > kMaxPixels) {
    throw ImageProblem("its size of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                       " cannot be");
  }
  switch (message.pixelformat) {
    case image_t::GRAY:
      DecodeGray(message, &image);
      return image;
    case image_t::GRAY_ZSTD:
      DecodeZstd(message, &image);
      return image;
    case image_t::MJPEG:
      DecodeJpeg(message, &image);
      return image;
    default:
      throw ImageProblem("its pixel format " + std::to_string(message.pixelformat) + " is not read");
  }
}

const image_t* Find(const images_t& message, std::int16_t type) {
  for (std::size_t i = 0; i < message.images.size(); ++i) {
    if (message.image_types[i] == type) return &message.images[i];
  }
  return nullptr;
}

std::optional<std::string> Metadata(const image_t& image, const std::string& key) {
  for (const image_metadata_t& metadata : image.metadata) {
    if (metadata.key == key) return std::string(metadata.value.begin(), metadata.value.end());
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImageEncoding> ImageEncodingFromName(const std::string& name) {
  if (name == "raw") return ImageEncoding::kRaw;
  if (name == "lossless") return ImageEncoding::kLossless;
  if (name == "mjpeg") return ImageEncoding::kMjpeg;
  return std::nullopt;
}

images_t ToMessage(const StereoPair& pair, ImageEncoding encoding) {
  images_t message{};
  message.utime = pair.t_capture.utime();
  for (const auto& [type, image] :
       {std::pair{images_t::LEFT, &pair.left}, std::pair{images_t::RIGHT, &pair.right}}) {
    image_t encoded{};
    if (pair.problem.empty()) {
      encoded = Encode(*image, encoding);
    } else {
      AddMetadata(kProblemKey, pair.problem, &encoded);
    }
    encoded.utime = message.utime;
    AddMetadata(kCaptureKey, std::to_string(pair.t_capture.ns), &encoded);
    message.image_types.push_back(type);
    message.images.push_back(std::move(encoded));
    ++message.n_images;
  }
  return message;
}

std::optional<Timestamp> CaptureTime(const images_t& message) {
  const std::optional<Timestamp> coarse = TimeFromMicroseconds(message.utime);
  const image_t* left = Find(message, images_t::LEFT);
  const std::optional<std::string> text = left ? Metadata(*left, kCaptureKey) : std::nullopt;
  if (!coarse || !text) return coarse;
  std::int64_t ns = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), ns);
  const bool whole = error == std::errc() && end == text->data() + text->size();
  const std::optional<Timestamp> fine = whole ? TimeFromNanoseconds(ns) : std::nullopt;
  // Nanoseconds of another microsecond are left over from before someone changed the time of the message.
  return fine && fine->utime() == message.utime ? fine : coarse;
}

StereoPair FromMessage(const images_t& message) {
  StereoPair pair;
  const std::optional<Timestamp> t_capture = CaptureTime(message);
  if (!t_capture) {
    pair.problem = "the time of the images cannot be";
    return pair;
  }
  const image_t* left = Find(message, images_t::LEFT);
  const image_t* right = Find(message, images_t::RIGHT);
  pair.t_capture = *t_capture;
  for (const auto& [name, image, out] :
       {std::tuple{"left", left, &pair.left}, std::tuple{"right", right, &pair.right}}) {
    try {
      if (image == nullptr) throw ImageProblem("it is missing");
      if (const auto problem = Metadata(*image, kProblemKey); problem && !problem->empty()) {
        pair.problem = PlainText(*problem);
      } else {
        *out = Decode(*image);
      }
    } catch (const ImageProblem& problem) {
      pair.problem = std::string(name) + " image cannot be used: " + problem.what();
    }
    if (!pair.problem.empty()) break;
  }
  if (!pair.problem.empty()) pair.left = pair.right = {};
  return pair;
}

}  // namespace terrace

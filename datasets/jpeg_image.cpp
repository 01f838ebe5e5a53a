// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <memory>
#include <vector>

#include <turbojpeg.h>

#include "core/check.h"
#include "datasets/image_format.h"

namespace terrace {
namespace {

using JpegHandle = std::unique_ptr<void, decltype(&tjDestroy)>;

ImageHeader ReadSizeOfJpeg(tjhandle jpeg, std::span<const std::uint8_t> bytes, const std::string& name) {
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(jpeg, bytes.data(), bytes.size(), &width, &height, &subsampling, &colorspace) !=
      0) {
    RefuseImage(name, std::string("not a readable JPEG: ") + tjGetErrorStr2(jpeg));
  }
  CheckImageSize(width, height, name);
  return {ImageFormat::kJpeg, width, height, 8, colorspace == TJCS_GRAY ? 1 : 3};
}

}  // namespace

ImageHeader ReadJpegHeader(std::span<const std::uint8_t> bytes, const std::string& name) {
  const JpegHandle jpeg(tjInitDecompress(), &tjDestroy);
  TERRACE_CHECK(jpeg != nullptr);
  return ReadSizeOfJpeg(jpeg.get(), bytes, name);
}

GrayImage DecodeJpeg(std::span<const std::uint8_t> bytes, const std::string& name) {
  const JpegHandle jpeg(tjInitDecompress(), &tjDestroy);
  TERRACE_CHECK(jpeg != nullptr);
  const ImageHeader size = ReadSizeOfJpeg(jpeg.get(), bytes, name);
  // A block of 8x8 pixels takes 2 bits at the least.
  if (std::uint64_t{1} * size.width * size.height / 64 / 4 > bytes.size()) {
    RefuseImage(name, "not a readable JPEG: the file ends early");
  }
  GrayImage image{size.width, size.height, {}};
  image.data.resize(static_cast<std::size_t>(size.width) * size.height);
  // turbojpeg calls a file that ends early a warning and fills up with grey: refused all the same.
  if (tjDecompress2(jpeg.get(), bytes.data(), bytes.size(), image.data.data(), size.width, size.width,
                    size.height, TJPF_GRAY, TJFLAG_ACCURATEDCT) != 0) {
    RefuseImage(name, std::string("not a readable JPEG: ") + tjGetErrorStr2(jpeg.get()));
  }
  return image;
}

std::vector<std::uint8_t> EncodeJpeg(const GrayImage& image, int quality) {
  TERRACE_CHECK(!image.empty() && quality >= 1 && quality <= 100, quality);
  const JpegHandle jpeg(tjInitCompress(), &tjDestroy);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(jpeg.get(), image.data.data(), image.width, image.width, image.height,
                                 TJPF_GRAY, &buffer, &size, TJSAMP_GRAY, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owner(buffer, &tjFree);
  TERRACE_CHECK(failed == 0, tjGetErrorStr2(jpeg.get()));
  return {buffer, buffer + size};
}

}  // namespace terrace

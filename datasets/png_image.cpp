// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include <png.h>

#include "core/check.h"
#include "datasets/image_format.h"

namespace terrace {
namespace {

// libpng reports errors by longjmp: nothing with a destructor may be created between setjmp and the
// last libpng call of a function, so buffers live in the struct and rows are handled outside.

struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const std::uint8_t> bytes;
  std::size_t position = 0;
  char error[160] = "";

  explicit PngReader(std::span<const std::uint8_t> source) : bytes(source) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, &PngReader::OnError, &PngReader::OnWarning);
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
    TERRACE_CHECK(info != nullptr);
    png_set_read_fn(png, this, &PngReader::OnRead);
    png_set_user_limits(png, kMaxImageSidePx, kMaxImageSidePx);
    // Text and profiles are of no use here; a damaged or hostile one must not cost memory.
    png_set_chunk_malloc_max(png, 1 << 20);
    png_set_chunk_cache_max(png, 16);
  }
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  static void OnError(png_structp png, png_const_charp text) {
    auto* self = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(self->error, text, sizeof(self->error) - 1);
    png_longjmp(png, 1);
  }
  static void OnWarning(png_structp, png_const_charp) {}
  static void OnRead(png_structp png, png_bytep out, std::size_t count) {
    auto* self = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > self->bytes.size() - self->position) png_error(png, "the file ends early");
    std::memcpy(out, self->bytes.data() + self->position, count);
    self->position += count;
  }

  bool ReadHeader() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_info(png, info);
    return true;
  }
  /// Sets up rows of 8-bit grey or 8-bit RGB without alpha.
  bool AskForEightBits() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_strip_alpha(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    return true;
  }
  /// Sets up rows of 8- or 16-bit grey with the stored values, 16 bits in the order of this processor.
  bool AskForStoredValues() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_packing(png);
    if (std::endian::native == std::endian::little) png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    return true;
  }
  bool ReadRows(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
  }
};

/// Deflate cannot pack more than this: shorter data belong to a truncated file, refused before memory is
/// taken.
constexpr std::uint64_t kMaxDeflateRatio = 1032;

/// The image as libpng gives it after a set-up, rows without padding.
std::vector<std::uint8_t> ReadPngRows(PngReader& reader, const std::string& name) {
  const std::size_t row_bytes = png_get_rowbytes(reader.png, reader.info);
  const std::size_t height = png_get_image_height(reader.png, reader.info);
  const std::uint64_t packed_bits = std::uint64_t{png_get_image_width(reader.png, reader.info)} * height;
  if (packed_bits / 8 / kMaxDeflateRatio > reader.bytes.size())
    RefuseImage(name, "not a readable PNG: the file ends early");
  std::vector<std::uint8_t> data(row_bytes * height);
  std::vector<png_bytep> rows(height);
  for (std::size_t v = 0; v < height; ++v) rows[v] = data.data() + v * row_bytes;
  if (!reader.ReadRows(rows.data())) RefuseImage(name, std::string("not a readable PNG: ") + reader.error);
  return data;
}

ImageHeader ReadSizeOfPng(PngReader& reader, const std::string& name) {
  if (!reader.ReadHeader()) RefuseImage(name, std::string("not a readable PNG: ") + reader.error);
  const auto width = png_get_image_width(reader.png, reader.info);
  const auto height = png_get_image_height(reader.png, reader.info);
  CheckImageSize(width, height, name);
  const png_byte colour = png_get_color_type(reader.png, reader.info);
  return {ImageFormat::kPng, static_cast<int>(width), static_cast<int>(height),
          png_get_bit_depth(reader.png, reader.info),
          colour == PNG_COLOR_TYPE_PALETTE ? 3 : png_get_channels(reader.png, reader.info)};
}

struct PngWriter {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::uint8_t> bytes;

  PngWriter() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
    TERRACE_CHECK(info != nullptr);
    png_set_write_fn(
        png, this,
        [](png_structp p, png_bytep data, std::size_t count) {
          auto* self = static_cast<PngWriter*>(png_get_io_ptr(p));
          self->bytes.insert(self->bytes.end(), data, data + count);
        },
        [](png_structp) {});
  }
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  bool Write(int width, int height, int bit_depth, int compression, const std::uint8_t* data) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_compression_level(png, compression);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bit_depth,
                 PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    if (bit_depth == 16 && std::endian::native == std::endian::little) png_set_swap(png);
    const std::size_t row_bytes = static_cast<std::size_t>(width) * (bit_depth / 8);
    for (int v = 0; v < height; ++v) png_write_row(png, data + v * row_bytes);
    png_write_end(png, nullptr);
    return true;
  }
};

template <typename Image>
std::vector<std::uint8_t> EncodePngOf(const Image& image, int bit_depth, int compression) {
  TERRACE_CHECK(image.width >= 1 && image.height >= 1 && image.width <= kMaxImageSidePx &&
                    image.height <= kMaxImageSidePx &&
                    image.data.size() == static_cast<std::size_t>(image.width) * image.height,
                image.width, image.height, image.data.size());
  PngWriter writer;
  const bool written = writer.Write(image.width, image.height, bit_depth, compression,
                                    reinterpret_cast<const std::uint8_t*>(image.data.data()));
  TERRACE_CHECK(written);
  return std::move(writer.bytes);
}

}  // namespace

ImageHeader ReadPngHeader(std::span<const std::uint8_t> bytes, const std::string& name) {
  PngReader reader(bytes);
  return ReadSizeOfPng(reader, name);
}

GrayImage DecodePng(std::span<const std::uint8_t> bytes, const std::string& name) {
  PngReader reader(bytes);
  const ImageHeader size = ReadSizeOfPng(reader, name);
  if (!reader.AskForEightBits()) RefuseImage(name, std::string("not a readable PNG: ") + reader.error);
  const int channels = png_get_channels(reader.png, reader.info);
  TERRACE_CHECK(channels == 1 || channels == 3, channels);
  GrayImage image{size.width, size.height, ReadPngRows(reader, name)};
  const bool only_low_bits =
      size.bits == 16 && std::ranges::all_of(image.data, [](std::uint8_t grey) { return grey <= 1; });
  if (only_low_bits)
    RefuseImage(name,
                "its 16 bits a pixel hold no more than 8 bits of grey, or it is black: write 8-bit files");
  if (channels == 3) {
    const std::size_t num_pixels = image.data.size() / 3;
    for (std::size_t i = 0; i < num_pixels; ++i) {
      image.data[i] = Luma(image.data[3 * i], image.data[3 * i + 1], image.data[3 * i + 2]);
    }
    image.data.resize(num_pixels);
    image.data.shrink_to_fit();
  }
  return image;
}

Gray16Image DecodeGray16Png(std::span<const std::uint8_t> bytes, const std::string& name) {
  PngReader reader(bytes);
  const ImageHeader size = ReadSizeOfPng(reader, name);
  if (png_get_color_type(reader.png, reader.info) != PNG_COLOR_TYPE_GRAY)
    RefuseImage(name, "must be a grey PNG");
  if (!reader.AskForStoredValues()) RefuseImage(name, std::string("not a readable PNG: ") + reader.error);
  const bool wide = png_get_bit_depth(reader.png, reader.info) == 16;
  const std::vector<std::uint8_t> rows = ReadPngRows(reader, name);
  Gray16Image image{size.width, size.height, {}};
  image.data.resize(static_cast<std::size_t>(size.width) * size.height);
  if (wide) {
    std::memcpy(image.data.data(), rows.data(), rows.size());
  } else {
    std::copy(rows.begin(), rows.end(), image.data.begin());
  }
  return image;
}

std::vector<std::uint8_t> EncodePng(const GrayImage& image, int compression) {
  return EncodePngOf(image, 8, compression);
}

std::vector<std::uint8_t> EncodePng(const Gray16Image& image, int compression) {
  return EncodePngOf(image, 16, compression);
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/image_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>

#include <png.h>
#include <turbojpeg.h>

#include "core/check.h"

namespace terrace {
namespace {

std::optional<ImageFormat> FormatOf(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (bytes.size() >= 8 && std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin())) {
    return ImageFormat::kPng;
  }
  if (bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff)
    return ImageFormat::kJpeg;
  if (bytes.size() >= 3 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6')) return ImageFormat::kPnm;
  return std::nullopt;
}

constexpr const char* kNoKnownFormat = "neither PNG nor JPEG nor binary PNM";

[[noreturn]] void Refuse(const std::string& name, const std::string& why) {
  throw FileError(name + ": " + why);
}

void CheckSize(std::int64_t width, std::int64_t height, const std::string& name) {
  if (width < 1 || height < 1 || width > kMaxImageSidePx || height > kMaxImageSidePx) {
    Refuse(name, "image of " + std::to_string(width) + "x" + std::to_string(height) +
                     " must lie within 1x1 and " + std::to_string(kMaxImageSidePx) + "x" +
                     std::to_string(kMaxImageSidePx));
  }
}

/// Luma of BT.601 in 14-bit fixed point; the weights add up to one exactly.
std::uint8_t Luma(int r, int g, int b) {
  return static_cast<std::uint8_t>((4899 * r + 9617 * g + 1868 * b + 8192) >> 14);
}

// ---- PNG. libpng reports errors by longjmp: nothing with a destructor may be created between setjmp and the
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
    Refuse(name, "not a readable PNG: the file ends early");
  std::vector<std::uint8_t> data(row_bytes * height);
  std::vector<png_bytep> rows(height);
  for (std::size_t v = 0; v < height; ++v) rows[v] = data.data() + v * row_bytes;
  if (!reader.ReadRows(rows.data())) Refuse(name, std::string("not a readable PNG: ") + reader.error);
  return data;
}

ImageHeader ReadPngHeader(PngReader& reader, const std::string& name) {
  if (!reader.ReadHeader()) Refuse(name, std::string("not a readable PNG: ") + reader.error);
  const auto width = png_get_image_width(reader.png, reader.info);
  const auto height = png_get_image_height(reader.png, reader.info);
  CheckSize(width, height, name);
  const png_byte colour = png_get_color_type(reader.png, reader.info);
  return {ImageFormat::kPng, static_cast<int>(width), static_cast<int>(height),
          png_get_bit_depth(reader.png, reader.info),
          colour == PNG_COLOR_TYPE_PALETTE ? 3 : png_get_channels(reader.png, reader.info)};
}

GrayImage DecodePng(std::span<const std::uint8_t> bytes, const std::string& name) {
  PngReader reader(bytes);
  const ImageHeader size = ReadPngHeader(reader, name);
  if (!reader.AskForEightBits()) Refuse(name, std::string("not a readable PNG: ") + reader.error);
  const int channels = png_get_channels(reader.png, reader.info);
  TERRACE_CHECK(channels == 1 || channels == 3, channels);
  GrayImage image{size.width, size.height, ReadPngRows(reader, name)};
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

// ---- JPEG

using JpegHandle = std::unique_ptr<void, decltype(&tjDestroy)>;

ImageHeader ReadJpegHeader(tjhandle jpeg, std::span<const std::uint8_t> bytes, const std::string& name) {
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(jpeg, bytes.data(), bytes.size(), &width, &height, &subsampling, &colorspace) !=
      0) {
    Refuse(name, std::string("not a readable JPEG: ") + tjGetErrorStr2(jpeg));
  }
  CheckSize(width, height, name);
  return {ImageFormat::kJpeg, width, height, 8, colorspace == TJCS_GRAY ? 1 : 3};
}

GrayImage DecodeJpeg(std::span<const std::uint8_t> bytes, const std::string& name) {
  const JpegHandle jpeg(tjInitDecompress(), &tjDestroy);
  TERRACE_CHECK(jpeg != nullptr);
  const ImageHeader size = ReadJpegHeader(jpeg.get(), bytes, name);
  // A block of 8x8 pixels takes 2 bits at the least.
  if (std::uint64_t{1} * size.width * size.height / 64 / 4 > bytes.size()) {
    Refuse(name, "not a readable JPEG: the file ends early");
  }
  GrayImage image{size.width, size.height, {}};
  image.data.resize(static_cast<std::size_t>(size.width) * size.height);
  // turbojpeg calls a file that ends early a warning and fills up with grey: refused all the same.
  if (tjDecompress2(jpeg.get(), bytes.data(), bytes.size(), image.data.data(), size.width, size.width,
                    size.height, TJPF_GRAY, TJFLAG_ACCURATEDCT) != 0) {
    Refuse(name, std::string("not a readable JPEG: ") + tjGetErrorStr2(jpeg.get()));
  }
  return image;
}

// ---- PNM, binary

struct PnmHeader {
  ImageHeader image;
  int max_value = 255;
  std::size_t data_begin = 0;
};

PnmHeader ReadPnmHeader(std::span<const std::uint8_t> bytes, const std::string& name) {
  std::size_t i = 2;
  const auto next_number = [&]() -> std::int64_t {
    while (i < bytes.size() && (std::isspace(bytes[i]) != 0 || bytes[i] == '#')) {
      if (bytes[i] == '#') {
        while (i < bytes.size() && bytes[i] != '\n') ++i;
      } else {
        ++i;
      }
    }
    std::int64_t value = 0;
    const std::size_t begin = i;
    for (; i < bytes.size() && std::isdigit(bytes[i]) != 0 && i - begin < 9; ++i)
      value = 10 * value + bytes[i] - '0';
    if (i == begin) Refuse(name, "not a readable PNM: the header holds no width, height and largest value");
    return value;
  };
  const std::int64_t width = next_number();
  const std::int64_t height = next_number();
  const std::int64_t max_value = next_number();
  CheckSize(width, height, name);
  if (max_value < 1 || max_value > 65535)
    Refuse(name, "not a readable PNM: the largest value must be 1 to 65535");
  return {{ImageFormat::kPnm, static_cast<int>(width), static_cast<int>(height), max_value > 255 ? 16 : 8,
           bytes[1] == '6' ? 3 : 1},
          static_cast<int>(max_value),
          i + 1};
}

GrayImage DecodePnm(std::span<const std::uint8_t> bytes, const std::string& name) {
  const PnmHeader header = ReadPnmHeader(bytes, name);
  const std::size_t num_pixels = static_cast<std::size_t>(header.image.width) * header.image.height;
  const int sample_bytes = header.max_value > 255 ? 2 : 1;
  if (header.data_begin > bytes.size() ||
      num_pixels * header.image.channels * sample_bytes > bytes.size() - header.data_begin) {
    Refuse(name, "not a readable PNM: the file ends early");
  }
  const std::uint8_t* in = bytes.data() + header.data_begin;
  const auto next_sample = [&] {
    const int value = sample_bytes == 2 ? 256 * in[0] + in[1] : in[0];
    in += sample_bytes;
    return (255 * std::min(value, header.max_value) + header.max_value / 2) / header.max_value;
  };
  GrayImage image{header.image.width, header.image.height, std::vector<std::uint8_t>(num_pixels)};
  for (std::uint8_t& pixel : image.data) {
    const int first = next_sample();
    if (header.image.channels == 1) {
      pixel = static_cast<std::uint8_t>(first);
    } else {
      const int green = next_sample();
      pixel = Luma(first, green, next_sample());
    }
  }
  return image;
}

// ---- writing

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

const char* Name(ImageFormat format) {
  switch (format) {
    case ImageFormat::kPng:
      return "PNG";
    case ImageFormat::kJpeg:
      return "JPEG";
    case ImageFormat::kPnm:
      return "PNM";
  }
  TERRACE_CHECK(false, static_cast<int>(format));
}

GrayImage DecodeGrayImage(std::span<const std::uint8_t> bytes, const std::string& name) {
  const std::optional<ImageFormat> format = FormatOf(bytes);
  if (format == ImageFormat::kPng) return DecodePng(bytes, name);
  if (format == ImageFormat::kJpeg) return DecodeJpeg(bytes, name);
  if (format == ImageFormat::kPnm) return DecodePnm(bytes, name);
  Refuse(name, kNoKnownFormat);
}

GrayImage ReadGrayImage(const std::filesystem::path& path) {
  return DecodeGrayImage(ReadFileBytes(path), path.string());
}

Gray16Image ReadGray16Png(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  const std::string name = path.string();
  if (FormatOf(bytes) != ImageFormat::kPng) Refuse(name, "not a PNG");
  PngReader reader(bytes);
  const ImageHeader size = ReadPngHeader(reader, name);
  if (png_get_color_type(reader.png, reader.info) != PNG_COLOR_TYPE_GRAY) Refuse(name, "must be a grey PNG");
  if (!reader.AskForStoredValues()) Refuse(name, std::string("not a readable PNG: ") + reader.error);
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

ImageHeader ReadImageHeader(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  const std::string name = path.string();
  const std::optional<ImageFormat> format = FormatOf(bytes);
  if (format == ImageFormat::kPng) {
    PngReader reader(bytes);
    return ReadPngHeader(reader, name);
  }
  if (format == ImageFormat::kJpeg) {
    const JpegHandle jpeg(tjInitDecompress(), &tjDestroy);
    TERRACE_CHECK(jpeg != nullptr);
    return ReadJpegHeader(jpeg.get(), bytes, name);
  }
  if (format == ImageFormat::kPnm) return ReadPnmHeader(bytes, name).image;
  Refuse(name, kNoKnownFormat);
}

bool IsImageFile(const std::filesystem::path& path) {
  std::array<char, 8> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return FormatOf({reinterpret_cast<const std::uint8_t*>(head.data()), head.size()}).has_value();
}

std::vector<std::uint8_t> EncodePng(const GrayImage& image, int compression) {
  return EncodePngOf(image, 8, compression);
}

std::vector<std::uint8_t> EncodePng(const Gray16Image& image, int compression) {
  return EncodePngOf(image, 16, compression);
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

void WritePng(const std::filesystem::path& path, const GrayImage& image) {
  WriteFileBytes(path, EncodePng(image));
}

void WritePng(const std::filesystem::path& path, const Gray16Image& image) {
  WriteFileBytes(path, EncodePng(image));
}

}  // namespace terrace

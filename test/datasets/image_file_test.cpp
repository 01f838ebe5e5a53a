// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/image_file.h"

#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include "small_sequences.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

using testing::HasSubstr;

/// What libpng's simplified interface writes, for formats that our own writer does not have.
std::vector<std::uint8_t> PngOf(int width, int height, png_uint_32 format, const void* pixels,
                                const void* palette = nullptr, int num_colours = 0) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = format;
  image.colormap_entries = static_cast<png_uint_32>(num_colours);
  std::vector<std::uint8_t> bytes(1 << 16);
  png_alloc_size_t size = bytes.size();
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, palette), 0);
  bytes.resize(size);
  return bytes;
}

std::string ProblemOf(const std::vector<std::uint8_t>& bytes) {
  try {
    DecodeGrayImage(bytes, "photo");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(PngTest, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const GrayImage image = SmallImage(3, 37, 21);
  WritePng(folder.path() / "a.png", image);
  const ImageHeader header = ReadImageHeader(folder.path() / "a.png");
  EXPECT_EQ(header.format, ImageFormat::kPng);
  EXPECT_EQ(header.width, 37);
  EXPECT_EQ(header.height, 21);
  EXPECT_EQ(header.bits, 8);
  EXPECT_EQ(header.channels, 1);
  const GrayImage read = ReadGrayImage(folder.path() / "a.png");
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 21);
  EXPECT_EQ(read.data, image.data);
  EXPECT_EQ(EncodePng(image), EncodePng(image));
}

TEST(PngTest, KeepsSixteenBitsWhenAskedAndScalesThemOtherwise) {
  const TemporaryFolder folder;
  const Gray16Image image{2, 2, {0, 1, 256, 65535}};
  WritePng(folder.path() / "depth.png", image);
  EXPECT_EQ(ReadGray16Png(folder.path() / "depth.png").data, image.data);
  EXPECT_EQ(ReadGrayImage(folder.path() / "depth.png").data, (std::vector<std::uint8_t>{0, 0, 1, 255}));
  WritePng(folder.path() / "labels.png", GrayImage{2, 1, {7, 255}});
  EXPECT_EQ(ReadGray16Png(folder.path() / "labels.png").data, (std::vector<std::uint16_t>{7, 255}));
}

TEST(PngTest, NamesEightBitsThatStandInSixteen) {
  const Gray16Image image{2, 2, {0, 17, 200, 255}};
  EXPECT_THAT(ProblemOf(EncodePng(image)), HasSubstr("16 bits a pixel hold no more than 8 bits"));
}

TEST(PngTest, TurnsColourIntoLumaAndForgetsAlpha) {
  const std::vector<std::uint8_t> rgb = {255, 0, 0, 0, 255, 0, 0, 0, 255, 90, 90, 90};
  EXPECT_EQ(DecodeGrayImage(PngOf(4, 1, PNG_FORMAT_RGB, rgb.data()), "rgb").data,
            (std::vector<std::uint8_t>{76, 150, 29, 90}));
  const std::vector<std::uint8_t> rgba = {255, 0, 0, 255, 90, 90, 90, 3};
  EXPECT_EQ(DecodeGrayImage(PngOf(2, 1, PNG_FORMAT_RGBA, rgba.data()), "rgba").data,
            (std::vector<std::uint8_t>{76, 90}));
  const std::vector<std::uint8_t> grey_alpha = {17, 255, 200, 9};
  EXPECT_EQ(DecodeGrayImage(PngOf(2, 1, PNG_FORMAT_GA, grey_alpha.data()), "ga").data,
            (std::vector<std::uint8_t>{17, 200}));
  const std::vector<std::uint8_t> palette = {10, 10, 10, 255, 0, 0};
  const std::vector<std::uint8_t> index = {1, 0, 1};
  EXPECT_EQ(
      DecodeGrayImage(PngOf(3, 1, PNG_FORMAT_RGB_COLORMAP, index.data(), palette.data(), 2), "palette").data,
      (std::vector<std::uint8_t>{76, 10, 76}));
}

TEST(PngTest, RefusesColourWhereValuesAreMeant) {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> rgb = {1, 2, 3};
  WriteFileBytes(folder.path() / "c.png", PngOf(1, 1, PNG_FORMAT_RGB, rgb.data()));
  EXPECT_THROW(ReadGray16Png(folder.path() / "c.png"), FileError);
}

TEST(PngTest, RefusesATruncatedFileAtAnyLength) {
  const std::vector<std::uint8_t> whole = EncodePng(SmallImage(0));
  for (std::size_t length = 0; length + 12 < whole.size(); ++length) {  // the last 12 bytes only say "end"
    EXPECT_THAT(ProblemOf({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)}),
                HasSubstr("photo: "))
        << length;
  }
}

TEST(PngTest, RefusesASizeThatNoCameraHasBeforeAllocatingForIt) {
  // An image header with its checksum, and no data behind it.
  const auto header_of = [](std::uint32_t side) {
    std::vector<std::uint8_t> bytes = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n',
                                       0,    0,   0,   13,  'I',  'H',  'D',  'R'};
    const auto append = [&](std::uint32_t value) {
      for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
    };
    append(side);
    append(side);
    bytes.insert(bytes.end(), {8, 0, 0, 0, 0});
    append(static_cast<std::uint32_t>(crc32(0, bytes.data() + 12, 17)));
    // The beginning of an empty IDAT chunk ends the header.
    bytes.insert(bytes.end(), {0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e});
    return bytes;
  };
  EXPECT_THAT(ProblemOf(header_of(1'000'000)), HasSubstr("photo: not a readable PNG"));
  EXPECT_THAT(ProblemOf(header_of(16'000)), HasSubstr("photo: not a readable PNG: the file ends early"));
  EXPECT_THAT(ProblemOf(header_of(0)), HasSubstr("photo: not a readable PNG"));
}

TEST(JpegTest, ComesBackAlmostAsItWas) {
  GrayImage image{64, 48, {}};
  for (int i = 0; i < 64 * 48; ++i) image.data.push_back(static_cast<std::uint8_t>(i % 64 + i / 64));
  const std::vector<std::uint8_t> bytes = EncodeJpeg(image, 95);
  const GrayImage read = DecodeGrayImage(bytes, "photo");
  ASSERT_EQ(read.data.size(), image.data.size());
  for (std::size_t i = 0; i < read.data.size(); ++i) EXPECT_NEAR(read.data[i], image.data[i], 4);
  EXPECT_THAT(ProblemOf({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2)}),
              HasSubstr("photo: not a readable JPEG"));
}

TEST(PnmTest, ReadsGreyAndColourWithComments) {
  const std::string grey = "P5\n# a comment\n3 1\n255\n\x05\x80\xff";
  EXPECT_EQ(DecodeGrayImage({reinterpret_cast<const std::uint8_t*>(grey.data()), grey.size()}, "p").data,
            (std::vector<std::uint8_t>{5, 128, 255}));
  const std::string colour = "P6 1 1 255 \xff" + std::string(2, '\0');
  EXPECT_EQ(DecodeGrayImage({reinterpret_cast<const std::uint8_t*>(colour.data()), colour.size()}, "p").data,
            (std::vector<std::uint8_t>{76}));
  const std::string wide =
      std::string("P5 2 1 65535 ") + "\xff\xff" + std::string(1, '\x01') + std::string(1, '\0');
  EXPECT_EQ(DecodeGrayImage({reinterpret_cast<const std::uint8_t*>(wide.data()), wide.size()}, "p").data,
            (std::vector<std::uint8_t>{255, 1}));
}

TEST(PnmTest, RefusesWhatIsShortOrHuge) {
  for (const std::string text : {"P5", "P5 ", "P5 3", "P5 3 3 255 ab", "P5 999999999 999999999 255 ab",
                                 "P5 0 0 255 ", "P5 3 3 0 abcdefghi", "P5 3 3 99999 abcdefghi"}) {
    EXPECT_THAT(ProblemOf({text.begin(), text.end()}), HasSubstr("photo: ")) << text;
  }
}

TEST(ImageFileTest, NamesWhatIsNoImage) {
  const TemporaryFolder folder;
  WriteText(folder.path() / "note.png", "this is a note");
  EXPECT_THROW(ReadGrayImage(folder.path() / "note.png"), FileError);
  EXPECT_THROW(ReadImageHeader(folder.path() / "note.png"), FileError);
  EXPECT_FALSE(IsImageFile(folder.path() / "note.png"));
  EXPECT_FALSE(IsImageFile(folder.path() / "none.png"));
  EXPECT_THROW(ReadGrayImage(folder.path()), FileError);
  EXPECT_THROW(ReadGrayImage(folder.path() / "none.png"), FileError);
  EXPECT_THROW(ReadGrayImage("/dev/zero"), FileError);
  EXPECT_THROW(WritePng(folder.path() / "no" / "such" / "folder.png", SmallImage(0)), FileError);
}

}  // namespace
}  // namespace terrace

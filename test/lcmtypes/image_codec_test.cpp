// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/image_codec.h"

#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/lcmtypes/over_memq.h"

namespace terrace {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

GrayImage NoisyRamp(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 3.0);
  GrayImage image{width, height, {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      image.data.push_back(
          static_cast<std::uint8_t>(std::clamp(40.0 + u + 0.5 * v + noise(random), 0.0, 255.0)));
    }
  }
  return image;
}

StereoPair SomePair() { return {{1600000000066666667}, NoisyRamp(67, 41, 1), NoisyRamp(67, 41, 2), ""}; }

StereoPair AfterTrip(const images_t& message) {
  const auto received = OverMemq(message);
  EXPECT_TRUE(received);
  return received ? FromMessage(*received) : StereoPair();
}

TEST(ImageCodecTest, CarriesPixelsAndNanosecondsExactlyWhenRawOrLossless) {
  const StereoPair pair = SomePair();
  for (const ImageEncoding encoding : {ImageEncoding::kRaw, ImageEncoding::kLossless}) {
    const StereoPair back = AfterTrip(ToMessage(pair, encoding));
    EXPECT_EQ(back.t_capture, pair.t_capture);
    EXPECT_THAT(back.problem, IsEmpty());
    EXPECT_EQ(back.left.width, 67);
    EXPECT_EQ(back.left.height, 41);
    EXPECT_EQ(back.left.data, pair.left.data);
    EXPECT_EQ(back.right.data, pair.right.data);
  }
}

TEST(ImageCodecTest, CompressesWithoutLossToLessThanRaw) {
  const images_t message = ToMessage(SomePair(), ImageEncoding::kLossless);
  EXPECT_LT(message.images[0].size, 67 * 41 * 3 / 4);
}

TEST(ImageCodecTest, CarriesNearlyTheSamePixelsAsMjpeg) {
  const StereoPair pair = SomePair();
  const StereoPair back = AfterTrip(ToMessage(pair, ImageEncoding::kMjpeg));
  ASSERT_EQ(back.left.data.size(), pair.left.data.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < pair.left.data.size(); ++i)
    sum += std::abs(pair.left.data[i] - back.left.data[i]);
  EXPECT_LT(sum / static_cast<double>(pair.left.data.size()), 2.0);
}

TEST(ImageCodecTest, CarriesTheProblemOfAPairThatCouldNotBeRead) {
  const StereoPair back =
      AfterTrip(ToMessage({{1600000000066666667}, {}, {}, "a.png: no PNG file"}, ImageEncoding::kRaw));
  EXPECT_EQ(back.problem, "a.png: no PNG file");
  EXPECT_EQ(back.t_capture.ns, 1600000000066666667);
  EXPECT_TRUE(back.left.empty());
}

TEST(ImageCodecTest, GivesForeignTextOnOneLineOfUtf8) {
  const auto back = [](const std::string& problem) {
    return AfterTrip(ToMessage({{1600000000066666667}, {}, {}, problem}, ImageEncoding::kRaw)).problem;
  };
  EXPECT_EQ(back("kein Licht: \xC3\x9C\xE2\x82\xAC\xF0\x9F\x98\x80"),
            "kein Licht: \xC3\x9C\xE2\x82\xAC\xF0\x9F\x98\x80");
  EXPECT_EQ(back("Latin-1: \xDC!"), "Latin-1: ?!");
  EXPECT_EQ(back("cut \xE2\x82"), "cut ??");
  EXPECT_EQ(back("overlong \xC0\x80, half a pair \xED\xA0\x80"), "overlong ??, half a pair ???");
  EXPECT_EQ(back("a line\nof another\x1B[2J"), "a line?of another?[2J");
  EXPECT_EQ(back(std::string(1000, 'x')), std::string(500, 'x') + "...");
}

TEST(ImageCodecTest, ReadsRowsWithPaddingAndTakesTheTimeOfTheMessageWithoutMetadata) {
  images_t message = ToMessage({{5000}, {2, 2, {1, 2, 3, 4}}, {2, 2, {5, 6, 7, 8}}, ""}, ImageEncoding::kRaw);
  message.images[0].row_stride = 3;
  message.images[0].data = {1, 2, 0, 3, 4};
  message.images[0].size = 5;
  message.images[0].metadata.clear();
  message.images[0].nmetadata = 0;
  const StereoPair pair = AfterTrip(message);
  EXPECT_THAT(pair.problem, IsEmpty());
  EXPECT_EQ(pair.left.data, (std::vector<std::uint8_t>{1, 2, 3, 4}));
  EXPECT_EQ(pair.t_capture.ns, 5000);
}

TEST(ImageCodecTest, TakesNanosecondsOfAnotherMicrosecondForStale) {
  images_t message = ToMessage(SomePair(), ImageEncoding::kRaw);
  message.utime += 10;
  EXPECT_EQ(AfterTrip(message).t_capture.ns, 1600000000066676000);
}

TEST(ImageCodecTest, SaysWhyAPairCannotBeUsed) {
  const images_t good = ToMessage(SomePair(), ImageEncoding::kRaw);
  const auto problem_when = [&](auto change) {
    images_t bad = good;
    change(&bad);
    const StereoPair pair = FromMessage(bad);
    EXPECT_TRUE(pair.left.empty() && pair.right.empty());
    return pair.problem;
  };
  EXPECT_THAT(problem_when([](images_t* m) { m->image_types[1] = images_t::DISPARITY; }),
              HasSubstr("right image"));
  EXPECT_THAT(problem_when([](images_t* m) { m->images[0].height = 42; }), HasSubstr("too few"));
  EXPECT_THAT(problem_when([](images_t* m) { m->images[0].row_stride = -67; }), HasSubstr("too few"));
  EXPECT_THAT(problem_when([](images_t* m) { m->images[0].width = 1 << 30; }), HasSubstr("cannot be"));
  EXPECT_THAT(problem_when([](images_t* m) { m->images[1].pixelformat = 5; }), HasSubstr("format 5"));
  EXPECT_THAT(problem_when([](images_t* m) { m->utime = INT64_MIN; }), HasSubstr("time"));
  EXPECT_THAT(problem_when([](images_t* m) { m->images[0].pixelformat = image_t::MJPEG; }),
              HasSubstr("JPEG"));
  EXPECT_THAT(problem_when([](images_t* m) { m->images[0].pixelformat = image_t::GRAY_ZSTD; }),
              HasSubstr("compressed"));
}

TEST(ImageCodecTest, SurvivesDamagedCompressedData) {
  std::mt19937 random(7);
  for (const ImageEncoding encoding : {ImageEncoding::kLossless, ImageEncoding::kMjpeg}) {
    const images_t good = ToMessage(SomePair(), encoding);
    for (int trial = 0; trial < 200; ++trial) {
      images_t bad = good;
      auto& data = bad.images[0].data;
      for (int i = 0; i < 5; ++i) data[random() % data.size()] = static_cast<std::uint8_t>(random());
      if (trial % 2 == 0) data.resize(random() % data.size());
      const StereoPair pair = FromMessage(bad);
      EXPECT_TRUE(!pair.problem.empty() || pair.left.data.size() == 67u * 41u);
    }
  }
}

}  // namespace
}  // namespace terrace

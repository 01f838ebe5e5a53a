// SPDX-License-Identifier: BSD-3-Clause
// Readers must survive any bytes: no crash, no hang, no boundless allocation, and nothing thrown but the
// errors that their headers name. Seeded, so that a failure comes back; worth most under the sanitizers.
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "datasets/ground_truth.h"
#include "datasets/image_file.h"
#include "datasets/sequence.h"
#include "small_sequences.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

/// Some bytes changed, cut out, doubled or cut off.
std::vector<std::uint8_t> Corrupted(std::vector<std::uint8_t> bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1));
  };
  const std::size_t num_changes = 1 + below(8);
  for (std::size_t i = 0; i < num_changes && !bytes.empty(); ++i) {
    const std::size_t begin = below(bytes.size());
    const std::size_t end = std::min(bytes.size(), begin + 1 + below(16));
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = bytes.begin() + static_cast<std::ptrdiff_t>(end);
    switch (random() % 6) {
      case 0:
      case 1:
        bytes[begin] = static_cast<std::uint8_t>(random());
        break;
      case 2:
        bytes[begin] = static_cast<std::uint8_t>(bytes[begin] ^ (1u << (random() % 8)));
        break;
      case 3:
        bytes.erase(first, last);
        break;
      case 4: {
        const std::vector<std::uint8_t> copy(first, last);
        bytes.insert(first, copy.begin(), copy.end());
        break;
      }
      case 5:
        if (random() % 4 == 0) bytes.resize(begin);
        break;
    }
  }
  return bytes;
}

void ReadImage(const std::vector<std::uint8_t>& bytes) {
  try {
    const GrayImage image = DecodeGrayImage(bytes, "image");
    EXPECT_EQ(image.data.size(),
              static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  } catch (const FileError&) {
  }
}

TEST(CorruptionTest, ImagesOfEveryFormatAreReadOrRefused) {
  const std::string pgm_head = "P5 32 24 255 ";
  std::vector<std::uint8_t> pgm(pgm_head.begin(), pgm_head.end());
  const GrayImage image = SmallImage(1);
  pgm.insert(pgm.end(), image.data.begin(), image.data.end());
  std::mt19937 random(1);
  for (const std::vector<std::uint8_t>& good :
       {EncodePng(image), EncodePng(Gray16Image{4, 4, std::vector<std::uint16_t>(16, 777)}),
        EncodeJpeg(image, 90), pgm}) {
    for (int i = 0; i < 2000; ++i) ReadImage(Corrupted(good, random));
  }
}

/// Opens and reads what a folder holds, truth included.
void ReadEverything(const fs::path& path) {
  try {
    const auto sequence = OpenSequence(path);
    while (const std::optional<SensorFrame> frame = sequence->Next()) {
      const bool usable = !frame->pair.left.empty() && !frame->pair.right.empty();
      EXPECT_EQ(frame->pair.problem.empty(), usable);
    }
  } catch (const SequenceError&) {
  }
  try {
    LoadTrueTrajectory(path);
  } catch (const FileError&) {
  } catch (const SequenceError&) {
  }
}

/// Damages one file at a time, round after round.
void DamageFilesOf(const fs::path& path, int num_rounds, unsigned seed) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::mt19937 random(seed);
  for (int round = 0; round < num_rounds; ++round) {
    for (const fs::path& file : files) {
      const std::vector<std::uint8_t> good = ReadFileBytes(file);
      WriteFileBytes(file, Corrupted(good, random));
      ReadEverything(path);
      WriteFileBytes(file, good);
    }
  }
}

TEST(CorruptionTest, AnEurocFolderIsReadOrRefused) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  DamageFilesOf(folder.path(), 10, 2);
}

TEST(CorruptionTest, AKittiFolderIsReadOrRefused) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  DamageFilesOf(folder.path(), 10, 3);
}

}  // namespace
}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/folder_needs.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/datasets/small_sequences.h"
#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(FolderNeedsTest, FindsNothingMissingInAWholeFolder) {
  const TemporaryFolder euroc, kitti;
  WriteSmallEuroc(euroc.path());
  WriteSmallKitti(kitti.path());
  EXPECT_THAT(FolderNeeds(euroc.path()), IsEmpty());
  EXPECT_THAT(FolderNeeds(kitti.path()), IsEmpty());
}

TEST(FolderNeedsTest, NamesEverythingThatAnEurocFolderLacks) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  std::filesystem::remove_all(folder.path() / "mav0" / "cam1" / "data");
  std::filesystem::remove(folder.path() / "mav0" / "cam0" / "sensor.yaml");
  EXPECT_THAT(FolderNeeds(folder.path()),
              ElementsAre(HasSubstr("cam0/sensor.yaml: missing"), HasSubstr("cam1/data/: missing")));
  std::filesystem::create_directory(folder.path() / "mav0" / "cam1" / "data");
  EXPECT_THAT(FolderNeeds(folder.path()),
              ElementsAre(HasSubstr("cam0/sensor.yaml"), HasSubstr("holds no PNG")));
}

TEST(FolderNeedsTest, NamesEverythingThatAKittiFolderLacks) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  std::filesystem::remove_all(folder.path() / "image_1");
  std::filesystem::remove(folder.path() / "calib.txt");
  EXPECT_THAT(FolderNeeds(folder.path()),
              ElementsAre(HasSubstr("image_1/: missing"), HasSubstr("calib.txt: missing")));
}

TEST(FolderNeedsTest, SaysWhichFolderToGiveInstead) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  EXPECT_THAT(FolderNeeds(folder.path() / "mav0"), ElementsAre(HasSubstr("mav0/")));
  EXPECT_THAT(FolderNeeds(folder.path() / "mav0" / "cam0" / "data"),
              ElementsAre(HasSubstr("image_0/ and image_1/")));
  EXPECT_THAT(FolderNeeds(folder.path() / "mav0" / "cam0"), ElementsAre(HasSubstr("an EuRoC folder holds")));
}

}  // namespace
}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "client/terrace_file.h"
#include "test/datasets/temporary_folder.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

command_v1_t Command(std::int8_t command, std::string argument = "") {
  command_v1_t message{};
  message.command = command;
  message.argument = std::move(argument);
  return message;
}

class CommandObeyerTest : public ::testing::Test {
 protected:
  CommandActions Actions() {
    return {[this] { ++num_resets_; },
            [this](bool paused) { paused_ = paused; },
            [this] { return map_ != nullptr; },
            [this] {
              return SavedMap{map_, views_};
            },
            Explain,
            [this](SavedMap saved, const std::string& file, const std::optional<BodyInMap>& body) {
              loaded_ = std::move(saved.map);
              loaded_views_ = std::move(saved.views);
              loaded_file_ = file;
              body_ = body;
              return camera_known_;
            }};
  }

  /// Region 3 and staircase 3 are there, and nothing else.
  static Explanations Explain(std::int64_t id) {
    Explanations explanations;
    if (id != 3) return explanations;
    explanations.regions.emplace_back().text = "region 3: wall.";
    explanations.staircases.emplace_back().text = "staircase 3.";
    return explanations;
  }

  TemporaryFolder folder_;
  TerrainMapPtr map_ = std::make_shared<const TerrainMap>();
  int num_resets_ = 0;
  bool paused_ = false;
  bool camera_known_ = true;
  std::vector<PlaceView> views_;
  TerrainMapPtr loaded_;
  std::vector<PlaceView> loaded_views_;
  std::string loaded_file_;
  std::optional<BodyInMap> body_;
  CommandObeyer obeyer_{folder_.path(), Actions()};
};

TEST_F(CommandObeyerTest, ResetsPausesAndResumes) {
  EXPECT_EQ(obeyer_.Obey(Command(command_v1_t::RESET_MAP)).result, command_reply_v1_t::OK);
  EXPECT_EQ(num_resets_, 1);
  EXPECT_EQ(obeyer_.Obey(Command(command_v1_t::PAUSE)).result, command_reply_v1_t::OK);
  EXPECT_TRUE(paused_);
  EXPECT_EQ(obeyer_.Obey(Command(command_v1_t::RESUME)).result, command_reply_v1_t::OK);
  EXPECT_FALSE(paused_);
  EXPECT_EQ(obeyer_.Obey(Command(99)).result, command_reply_v1_t::REFUSED);
}

TEST_F(CommandObeyerTest, SavesTheMapWholeUnderItsName) {
  const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "hall.json"));
  EXPECT_EQ(reply.result, command_reply_v1_t::OK) << reply.message;
  std::ifstream file(folder_.path() / "hall.json");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("\"terrace-map\""));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "hall.json.partial"));
}

TEST_F(CommandObeyerTest, SavesEveryBitOfTheMapUnderANameThatEndsInTerrace) {
  map_ = std::make_shared<const TerrainMap>(ExampleMaps(3).First(12));
  const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "hall.terrace"));
  EXPECT_EQ(reply.result, command_reply_v1_t::OK) << reply.message;
  EXPECT_EQ(TerraceFileBytes(*LoadTerraceFile(folder_.path() / "hall.terrace").map), TerraceFileBytes(*map_));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1)
      << "something else is left";
}

TEST_F(CommandObeyerTest, LoadsASavedMapAndHearsWhereTheRobotIsInIt) {
  map_ = std::make_shared<const TerrainMap>(ExampleMaps(3).First(12));
  ASSERT_EQ(obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "hall.terrace")).result, command_reply_v1_t::OK);
  command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::LOAD_MAP, "hall.terrace"));
  EXPECT_EQ(reply.result, command_reply_v1_t::OK) << reply.message;
  EXPECT_THAT(reply.message, HasSubstr("stands by itself"));
  ASSERT_NE(loaded_, nullptr);
  EXPECT_EQ(TerraceFileBytes(*loaded_), TerraceFileBytes(*map_));
  EXPECT_EQ(loaded_file_, "hall.terrace");
  EXPECT_FALSE(body_);
  reply = obeyer_.Obey(Command(command_v1_t::LOAD_MAP, "hall.terrace 1.5 -2 0.25 90"));
  EXPECT_EQ(reply.result, command_reply_v1_t::OK) << reply.message;
  ASSERT_TRUE(body_);
  EXPECT_EQ(body_->p_map, Eigen::Vector3d(1.5, -2, 0.25));
  EXPECT_DOUBLE_EQ(body_->yaw_rad, 0.5 * M_PI);
  EXPECT_TRUE(loaded_views_.empty());
  views_.emplace_back().corners.emplace_back();
  ASSERT_EQ(obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "hall.terrace")).result, command_reply_v1_t::OK);
  reply = obeyer_.Obey(Command(command_v1_t::LOAD_MAP, "hall.terrace"));
  EXPECT_THAT(reply.message, HasSubstr("recognised in one of its 1 views"));
  EXPECT_EQ(loaded_views_.size(), 1u);
  camera_known_ = false;
  EXPECT_EQ(obeyer_.Obey(Command(command_v1_t::LOAD_MAP, "hall.terrace")).result,
            command_reply_v1_t::REFUSED);
}

TEST_F(CommandObeyerTest, RefusesToLoadWhatIsDamagedOrPutNowhere) {
  map_ = std::make_shared<const TerrainMap>(ExampleMaps(3).First(12));
  ASSERT_EQ(obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "hall.terrace")).result, command_reply_v1_t::OK);
  for (const char* argument : {"", "other.terrace", "../hall.terrace", "hall.terrace 1 2 3",
                               "hall.terrace 1 2 3 x", "hall.terrace 1 2 3 4 5", "hall.terrace 1 2 nan 4"}) {
    const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::LOAD_MAP, argument));
    EXPECT_EQ(reply.result, command_reply_v1_t::REFUSED) << argument;
  }
  std::fstream file(folder_.path() / "hall.terrace", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(200);
  file.put('x');
  file.close();
  const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::LOAD_MAP, "hall.terrace"));
  EXPECT_EQ(reply.result, command_reply_v1_t::REFUSED);
  EXPECT_THAT(reply.message, HasSubstr("byte"));
  EXPECT_THAT(reply.message, HasSubstr("damaged"));
  EXPECT_EQ(loaded_, nullptr);
}

TEST_F(CommandObeyerTest, RefusesNamesThatLeadElsewhereOrOntoResultsOfTheRun) {
  for (const char* name : {"", ".", "..", "../hall.json", "/hall.json", "terrain_map.json", "frames.jsonl"}) {
    const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::SAVE_MAP, name));
    EXPECT_EQ(reply.result, command_reply_v1_t::REFUSED) << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(CommandObeyerTest, WritesIntoNoPipeThatWouldHangIt) {
  ASSERT_EQ(mkfifo((folder_.path() / "pipe").c_str(), 0600), 0);
  const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "pipe"));
  EXPECT_EQ(reply.result, command_reply_v1_t::REFUSED);
  EXPECT_THAT(reply.message, HasSubstr("no file"));
}

TEST_F(CommandObeyerTest, ExplainsWhatHasTheIdAndRefusesWhatHasNone) {
  const command_reply_v1_t reply = obeyer_.Obey(Command(command_v1_t::EXPLAIN, "3"));
  EXPECT_EQ(reply.result, command_reply_v1_t::OK);
  EXPECT_EQ(reply.message, "region 3: wall.\nstaircase 3.");
  EXPECT_THAT(obeyer_.Obey(Command(command_v1_t::EXPLAIN, "4")).message,
              HasSubstr("neither a region nor a staircase 4"));
  for (const char* argument : {"", "three", "3x", "99999999999999999999"}) {
    const command_reply_v1_t refused = obeyer_.Obey(Command(command_v1_t::EXPLAIN, argument));
    EXPECT_EQ(refused.result, command_reply_v1_t::REFUSED) << argument;
    EXPECT_THAT(refused.message, HasSubstr("must be the id"));
  }
}

TEST_F(CommandObeyerTest, SaysWhenThereIsNoMapOrNoFolder) {
  map_ = nullptr;
  EXPECT_THAT(obeyer_.Obey(Command(command_v1_t::SAVE_MAP, "hall.json")).message, HasSubstr("no map yet"));
  EXPECT_EQ(obeyer_.Obey(Command(command_v1_t::SEND_SNAPSHOT)).result, command_reply_v1_t::REFUSED);
  CommandObeyer nowhere("", Actions());
  EXPECT_THAT(nowhere.Obey(Command(command_v1_t::SAVE_MAP, "hall.json")).message,
              HasSubstr("lcm.save_folder"));
}

}  // namespace
}  // namespace terrace

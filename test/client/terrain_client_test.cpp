// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_client.h"

#include <gtest/gtest.h>
#include <terrace/command_v1_t.hpp>

#include "lcmtypes/codec.h"
#include "lcmtypes/safe_decode.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

void HandleAll(lcm::LCM* lcm) {
  while (lcm->handleTimeout(0) > 0) {
  }
}

TEST(TerrainClientTest, AsksForASnapshotWhenItStartsAndFollowsFromThere) {
  lcm::LCM lcm("memq://");
  int num_requests = 0;
  lcm.subscribeFunction(
      "TERRACE_COMMAND",
      +[](const lcm::ReceiveBuffer* buffer, const std::string&, int* count) {
        const auto command = SafeDecode<command_v1_t>(buffer->data, buffer->data_size);
        if (command && command->command == command_v1_t::SEND_SNAPSHOT) ++*count;
      },
      &num_requests);
  TerrainClient client(&lcm);
  HandleAll(&lcm);
  EXPECT_EQ(num_requests, 1);
  EXPECT_EQ(client.map(), nullptr);

  ExampleMaps maps(1);
  const TerrainMap first = maps.First(10);
  const TerrainMap second = maps.Next(first);
  for (const terrain_v1_t& message : SnapshotMessages(first)) lcm.publish("TERRACE_TERRAIN", &message);
  for (const terrain_v1_t& message : DeltaMessages(first, second)) lcm.publish("TERRACE_TERRAIN", &message);
  HandleAll(&lcm);
  ASSERT_NE(client.map(), nullptr);
  EXPECT_EQ(client.map()->seq, second.seq);
  EXPECT_EQ(client.map()->regions.size(), second.regions.size());
  EXPECT_EQ(num_requests, 1) << "nothing was lost, nothing is asked";
}

}  // namespace
}  // namespace terrace

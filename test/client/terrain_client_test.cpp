// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_client.h"

#include <chrono>

#include <gtest/gtest.h>

#include "lcmtypes/safe_decode.h"
#include "lcmtypes/terrain_codec.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

void HandleAll(lcm::LCM* lcm) {
  while (lcm->handleTimeout(0) > 0) {
  }
}

TEST(TerrainClientTest, AsksUntilItHasAMapThoughItHearsNothingAndFollowsFromThere) {
  lcm::LCM lcm("memq://");
  int num_requests = 0;
  lcm.subscribeFunction(
      "TERRACE_REPAIR",
      +[](const lcm::ReceiveBuffer* buffer, const std::string&, int* count) {
        const auto repair = SafeDecode<terrain_repair_v1_t>(buffer->data, buffer->data_size);
        if (repair && repair->have_seq == -1) ++*count;
      },
      &num_requests);
  TerrainClient client(&lcm);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (num_requests < 3 && std::chrono::steady_clock::now() < patience) lcm.handleTimeout(50);
  EXPECT_EQ(num_requests, 3);
  EXPECT_EQ(client.map(), nullptr);
  EXPECT_FALSE(client.in_step());

  ExampleMaps maps(1);
  const TerrainMap first = maps.First(10);
  const TerrainMap second = maps.Next(first);
  for (const terrain_v1_t& message : SnapshotMessages(first)) lcm.publish("TERRACE_TERRAIN", &message);
  for (const terrain_v1_t& message : DeltaMessages(first, second)) lcm.publish("TERRACE_TERRAIN", &message);
  HandleAll(&lcm);
  ASSERT_NE(client.map(), nullptr);
  EXPECT_EQ(client.map()->seq, second.seq);
  EXPECT_EQ(client.map()->regions.size(), second.regions.size());
  EXPECT_TRUE(client.in_step());
}

}  // namespace
}  // namespace terrace

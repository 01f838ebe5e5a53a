// SPDX-License-Identifier: BSD-3-Clause
#include "tools/host_check.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

namespace terrace {
namespace {

HostFacts GoodHost() {
  HostFacts facts;
  facts.rmem_max_bytes = facts.recv_buffer_bytes = 2097152;
  facts.is_multicast = facts.has_route = facts.clock_is_set = true;
  facts.available_memory_bytes = 2'000'000'000;
  facts.num_cores = 4;
  facts.load = 0.5;
  facts.governor = "performance";
  return facts;
}

std::vector<std::string> NotGood(const HostFacts& facts) {
  std::vector<std::string> codes;
  for (const Finding& finding : JudgeHost(facts)) {
    if (finding.severity == Severity::kGood) continue;
    EXPECT_FALSE(finding.remedy.empty()) << finding.code;
    codes.push_back(finding.code);
  }
  return codes;
}

using Codes = std::vector<std::string>;

TEST(HostCheckTest, FindsNothingWrongWithAGoodHost) { EXPECT_EQ(NotGood(GoodHost()), Codes{}); }

TEST(HostCheckTest, NamesEachFactThatIsWrongAlone) {
  HostFacts facts = GoodHost();
  facts.rmem_max_bytes = 212992;  // as kernels come
  EXPECT_EQ(NotGood(facts), Codes{"rmem_max"});
  facts = GoodHost();
  facts.recv_buffer_bytes = 0;
  EXPECT_EQ(NotGood(facts), Codes{"recv_buffer_asked"});
  facts = GoodHost();
  facts.has_route = false;
  EXPECT_EQ(NotGood(facts), Codes{"multicast_route"});
  facts = GoodHost();
  facts.available_memory_bytes = 100'000'000;
  EXPECT_EQ(NotGood(facts), Codes{"memory"});
  facts = GoodHost();
  facts.governor = "powersave";
  EXPECT_EQ(NotGood(facts), Codes{"governor"});
  facts = GoodHost();
  facts.clock_is_set = false;
  EXPECT_EQ(NotGood(facts), Codes{"clock"});
  facts = GoodHost();
  facts.load = 9.0;
  EXPECT_EQ(NotGood(facts), Codes{"load"});
}

TEST(HostCheckTest, SaysNothingOfTheNetworkWhereNoneIsUsed) {
  HostFacts facts = GoodHost();
  facts.is_multicast = facts.has_route = false;
  facts.rmem_max_bytes = facts.recv_buffer_bytes = 0;
  EXPECT_EQ(NotGood(facts), Codes{});
}

TEST(HostCheckTest, ReadsWhatTheAddressAsksFor) {
  const HostFacts facts = ReadHostFacts("udpm://239.255.76.67:7667?recv_buf_size=1000000&ttl=1");
  EXPECT_TRUE(facts.is_multicast);
  EXPECT_EQ(facts.recv_buffer_bytes, 1000000);
  EXPECT_EQ(facts.ttl, 1);
  EXPECT_GT(facts.rmem_max_bytes, 0);
  EXPECT_GT(facts.available_memory_bytes, 0);
  EXPECT_FALSE(ReadHostFacts("memq://").is_multicast);
}

}  // namespace
}  // namespace terrace

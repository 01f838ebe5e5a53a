// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/open_bus.h"

#include <filesystem>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(OpenBusTest, AServerThatIsNotThereLeavesNoBus) {
  lcm::LCM lcm("tcpq://127.0.0.1:1");
  EXPECT_FALSE(IsOpen(lcm));
}

TEST(OpenBusTest, OneWithinTheProgramIsOpen) {
  lcm::LCM lcm("memq://");
  EXPECT_TRUE(IsOpen(lcm));
}

TEST(OpenBusTest, ALogThatIsWrittenIsOpen) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "terrace_open_bus_test.lcmlog";
  lcm::LCM lcm("file://" + file.string() + "?mode=w");
  EXPECT_TRUE(IsOpen(lcm));
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

std::string Text(const std::string& file) {
  std::ifstream in(std::string(TERRACE_SOURCE_DIR) + "/" + file);
  EXPECT_TRUE(in) << file;
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(ClientReadmeTest, ShowsTheExampleThatIsBuilt) {
  const std::string example = Text("client/example/nearest_staircase.cpp");
  const std::string without_licence = example.substr(example.find('\n') + 1);
  EXPECT_THAT(Text("client/README.md"), testing::HasSubstr("```cpp\n" + without_licence + "```"));
}

}  // namespace
}  // namespace terrace

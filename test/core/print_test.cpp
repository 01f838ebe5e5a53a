// SPDX-License-Identifier: BSD-3-Clause
#include "core/print.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(PrintTest, AppendsWhatPrintfWouldPrint) {
  std::string text = "riser";
  Print(&text, " %d of %d: %.1f %s", 2, 6, 17.25, "cm");
  EXPECT_EQ(text, "riser 2 of 6: 17.2 cm");
  Print(&text, "%s", "");
  EXPECT_EQ(text, "riser 2 of 6: 17.2 cm");
}

TEST(PrintTest, CutsNothingOff) {
  const std::string longer_than_any_line(5000, 'x');
  EXPECT_EQ(Printed("<%s>", longer_than_any_line.c_str()), "<" + longer_than_any_line + ">");
}

}  // namespace
}  // namespace terrace

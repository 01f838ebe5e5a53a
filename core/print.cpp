// SPDX-License-Identifier: BSD-3-Clause
#include "core/print.h"

#include <cstddef>
#include <cstdio>

#include "core/check.h"

namespace terrace {

void PrintArguments(std::string* text, const char* format, std::va_list arguments) {
  std::va_list once_more;
  va_copy(once_more, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  TERRACE_CHECK(length >= 0);
  const std::size_t before = text->size();
  text->resize(before + length + 1);  // and the zero that ends it
  std::vsnprintf(text->data() + before, length + 1, format, once_more);
  text->pop_back();
  va_end(once_more);
}

void Print(std::string* text, const char* format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  PrintArguments(text, format, arguments);
  va_end(arguments);
}

std::string Printed(const char* format, ...) {
  std::string text;
  std::va_list arguments;
  va_start(arguments, format);
  PrintArguments(&text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace terrace

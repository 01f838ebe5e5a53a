// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdarg>
#include <string>

namespace terrace {

/// Appends text formatted as std::printf does; of any length.
[[gnu::format(printf, 2, 3)]] void Print(std::string* text, const char* format, ...);

/// The same for functions that take such arguments themselves.
void PrintArguments(std::string* text, const char* format, std::va_list arguments);

/// Text formatted as std::printf does; of any length.
[[gnu::format(printf, 1, 2)]] std::string Printed(const char* format, ...);

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/log_setup.h"

#include <cstdlib>
#include <memory>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace terrace {
namespace {

/// "<4>": the level as sd-daemon(3) has it.
class JournalLevel : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& text) override {
    const char level = message.level >= spdlog::level::critical ? '2'
                       : message.level == spdlog::level::err    ? '3'
                       : message.level == spdlog::level::warn   ? '4'
                       : message.level == spdlog::level::info   ? '6'
                                                                : '7';
    for (const char c : {'<', level, '>'}) text.push_back(c);
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<JournalLevel>(); }
};

}  // namespace

void LogToStandardError() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("terraced"));
  if (std::getenv("JOURNAL_STREAM") == nullptr) return;
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<JournalLevel>('*').set_pattern("%*%v");
  spdlog::set_formatter(std::move(formatter));
}

void LogToFile(const std::string& path) {
  constexpr std::size_t kBytes = 10'000'000, kFiles = 5;
  auto sink = std::make_shared<spdlog::sinks::rotating_file_sink_mt>(path, kBytes, kFiles);
  spdlog::default_logger()->sinks().push_back(std::move(sink));
  // Whoever reads it after a fall wants the last line, too.
  spdlog::default_logger()->flush_on(spdlog::level::info);
}

}  // namespace terrace

// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/text_table.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>

namespace terrace {
namespace {

constexpr std::size_t kMaxLineLength = 8192;
constexpr std::size_t kMaxCells = 64;
constexpr std::string_view kBlanks = " \t\r";

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

template <typename Number>
std::optional<Number> Parse(std::string_view cell) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> ParseDouble(std::string_view cell) {
  const std::optional<double> value = Parse<double>(cell);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> ParseInt64(std::string_view cell) { return Parse<std::int64_t>(cell); }

std::optional<Timestamp> ParseNanoseconds(std::string_view cell) {
  const std::optional<std::int64_t> ns = ParseInt64(cell);
  return ns && *ns >= 0 ? std::optional(Timestamp{*ns}) : std::nullopt;
}

std::string Counted(std::int64_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::optional<std::vector<double>> ParseDoubles(std::span<const std::string_view> cells, std::size_t first,
                                                std::size_t count) {
  if (cells.size() < first + count) return std::nullopt;
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::optional<double> value = ParseDouble(cells[first + i]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

struct TableReader::Input {
  std::ifstream file;
  char line[kMaxLineLength];
};

TableReader::TableReader(const std::filesystem::path& path, char separator)
    : input_(std::make_unique<Input>()), separator_(separator) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    problem_ = path.string() + ": no such file";
  } else if (!std::filesystem::is_regular_file(path, error)) {
    problem_ = path.string() + ": not a file";
  } else {
    input_->file.open(path, std::ios::binary);
    if (!input_->file) problem_ = path.string() + ": cannot be read";
  }
}

TableReader::~TableReader() = default;

bool TableReader::Next() {
  cells_.clear();
  while (input_->file.is_open() && input_->file.good()) {
    input_->file.getline(input_->line, kMaxLineLength);
    const std::size_t length = static_cast<std::size_t>(input_->file.gcount());
    if (length == 0 && input_->file.eof()) return false;
    ++line_number_;
    if (input_->file.fail() && !input_->file.eof()) {  // longer than the buffer: no row of ours
      input_->file.clear();
      input_->file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      return true;
    }
    std::string_view rest = Trimmed({input_->line, input_->file.eof() ? length : length - 1});
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // as some editors write it
    if (line_number_ == 1 && rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
    if (rest.empty() || rest.front() == '#') continue;
    while (cells_.size() < kMaxCells) {
      const std::size_t cut = separator_ == ' ' ? rest.find_first_of(kBlanks) : rest.find(separator_);
      cells_.push_back(Trimmed(rest.substr(0, cut)));
      if (cut == std::string_view::npos) break;
      rest = separator_ == ' ' ? Trimmed(rest.substr(cut)) : rest.substr(cut + 1);
    }
    return true;
  }
  return false;
}

}  // namespace terrace

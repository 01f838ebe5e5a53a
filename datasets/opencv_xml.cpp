// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/opencv_xml.h"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "core/file_bytes.h"

namespace terrace {
namespace {

constexpr int kMaxDepth = 32;

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Characters that XML does not have in texts.
std::string WithoutEntities(std::string text) {
  constexpr std::array<std::pair<const char*, char>, 5> kEntities{
      std::pair{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
  for (const auto& [entity, character] : kEntities) {
    const std::string_view name = entity;
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; ++at)
      text.replace(at, name.size(), 1, character);
  }
  return text;
}

/// As a scalar of YAML that can be a number or a text: plain where nothing in it has a meaning of its own.
std::string Scalar(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_not_of(
                                          "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                          "0123456789+-._") == std::string::npos;
  if (plain && word != "-") return word;
  std::string quoted = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + "\"";
}

class XmlReader {
 public:
  XmlReader(const std::string& text, const std::string& where) : text_(text), where_(where) {}

  std::string Document() {
    SkipWhatSaysNothing();
    std::string name = OpeningTag();
    if (name != "opencv_storage") Fail("the outermost element must be opencv_storage");
    return Content(name, 0);
  }

 private:
  [[noreturn]] void Fail(const std::string& rule) const {
    const auto line =
        1 + std::count(text_.begin(),
                       text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size())), '\n');
    throw FileError(where_ + ":" + std::to_string(line) + ": " + rule);
  }

  bool StartsWith(std::string_view words) const { return text_.compare(at_, words.size(), words) == 0; }

  void SkipPast(std::string_view end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string::npos) Fail("ends before " + std::string(end));
    at_ = found + end.size();
  }

  /// Spaces, comments and what begins with a question or an exclamation mark.
  void SkipWhatSaysNothing() {
    for (;;) {
      while (at_ < text_.size() && IsSpace(text_[at_])) ++at_;
      if (StartsWith("<!--")) {
        SkipPast("-->");
      } else if (StartsWith("<?") || StartsWith("<!")) {
        SkipPast(">");
      } else {
        return;
      }
    }
  }

  /// Its name; attributes say nothing that rows, cols and dt do not.
  std::string OpeningTag() {
    if (at_ >= text_.size() || text_[at_] != '<') Fail("an element must begin here");
    const std::size_t begin = ++at_;
    while (at_ < text_.size() && !IsSpace(text_[at_]) && text_[at_] != '>' && text_[at_] != '/') ++at_;
    const std::string name = text_.substr(begin, at_ - begin);
    if (name.empty()) Fail("an element must have a name");
    const std::size_t end = text_.find('>', at_);
    if (end == std::string::npos) Fail("ends within <" + name);
    is_empty_ = text_[end - 1] == '/';
    at_ = end + 1;
    return name;
  }

  void ClosingTag(const std::string& name) {
    const std::string tag = "</" + name;
    if (!StartsWith(tag)) Fail(tag + "> must stand here");
    at_ += tag.size();
    SkipPast(">");
  }

  /// What stands between the tags of an element, whose first has been read, as YAML.
  std::string Content(const std::string& name, int depth) {
    if (depth > kMaxDepth) Fail("elements lie too deep in one another");
    if (is_empty_) return "\"\"";
    SkipWhatSaysNothing();
    std::string yaml;
    if (at_ < text_.size() && text_[at_] == '<' && !StartsWith("</")) {
      yaml = Children(depth);
    } else {
      const std::size_t end = std::min(text_.find('<', at_), text_.size());
      yaml = Words(text_.substr(at_, end - at_), name == "data");
      at_ = end;
    }
    ClosingTag(name);
    return yaml;
  }

  std::string Children(int depth) {
    std::string yaml;
    std::set<std::string> names;
    bool is_list = false;
    while (SkipWhatSaysNothing(), !StartsWith("</")) {
      const std::string name = OpeningTag();
      if (names.empty()) is_list = name == "_";
      if (is_list != (name == "_")) Fail("items of a list and keys must not be mixed");
      if (!names.insert(name).second && !is_list) Fail("there are two elements " + name);
      if (!yaml.empty()) yaml += ", ";
      if (!is_list) yaml += Scalar(name) + ": ";
      yaml += Content(name, depth + 1);
    }
    return is_list ? "[" + yaml + "]" : "{" + yaml + "}";
  }

  std::string Words(const std::string& text, bool always_list) const {
    std::vector<std::string> words;
    for (std::size_t i = 0; i < text.size();) {
      if (IsSpace(text[i])) {
        ++i;
        continue;
      }
      const bool quoted = text[i] == '"';
      std::size_t end = quoted ? text.find('"', i + 1) : i;
      if (quoted && end == std::string::npos) Fail("a quoted text does not end");
      if (quoted) {
        words.push_back(WithoutEntities(text.substr(i + 1, end - i - 1)));
        i = end + 1;
        continue;
      }
      while (end < text.size() && !IsSpace(text[end])) ++end;
      words.push_back(WithoutEntities(text.substr(i, end - i)));
      i = end;
    }
    std::string yaml;
    for (const std::string& word : words) yaml += (yaml.empty() ? "" : ", ") + Scalar(word);
    if (words.size() == 1 && !always_list) return yaml;
    return words.empty() && !always_list ? "\"\"" : "[" + yaml + "]";
  }

  const std::string& text_;
  const std::string& where_;
  std::size_t at_ = 0;
  bool is_empty_ = false;  // the element whose tag was read last
};

}  // namespace

std::string YamlFromOpenCvXml(const std::string& text, const std::string& where) {
  return XmlReader(text, where).Document();
}

}  // namespace terrace

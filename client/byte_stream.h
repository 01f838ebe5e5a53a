// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/file_bytes.h"

namespace terrace {

static_assert(std::endian::native == std::endian::little, "files are little endian");

/// Appends numbers as they lie in memory.
class ByteWriter {
 public:
  /// Room for this many bytes, so that they need not be moved while they grow.
  void Reserve(std::size_t num_bytes) { bytes_.reserve(num_bytes); }
  template <typename Number>
  void Put(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(value));
    std::memcpy(bytes_.data() + at, &value, sizeof(value));
  }
  void PutDoubles(const double* values, std::size_t count) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + count * sizeof(double));
    if (count > 0) std::memcpy(bytes_.data() + at, values, count * sizeof(double));
  }
  void PutText(const std::string& text) {
    Put(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  /// Zeros up to a multiple of eight.
  void PadToWords() { bytes_.resize((bytes_.size() + 7) / 8 * 8); }

  std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Takes numbers out of bytes that may be damaged. The first step beyond their end throws FileError with file
/// and place, and nothing is allocated that the bytes do not fill.
class ByteReader {
 public:
  /// @param name  of the file, for sentences
  ByteReader(std::span<const std::uint8_t> bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }

  [[noreturn]] void Fail(const std::string& why) const {
    throw FileError(name_ + ": byte " + std::to_string(at_) + ": " + why);
  }

  template <typename Number>
  Number Take() {
    static_assert(std::is_arithmetic_v<Number>);
    Number value;
    std::memcpy(&value, TakeBytes(sizeof(value)), sizeof(value));
    return value;
  }
  void TakeDoubles(double* values, std::size_t count) {
    if (count > left() / sizeof(double)) Fail("the file ends too early");
    if (count > 0) std::memcpy(values, TakeBytes(count * sizeof(double)), count * sizeof(double));
  }
  /// Of items of which each has `min_bytes` or more.
  std::size_t TakeCount(std::size_t min_bytes) {
    const auto count = Take<std::uint32_t>();
    if (count > left() / min_bytes)
      Fail("says " + std::to_string(count) + " items, more than the file holds");
    return count;
  }
  std::string TakeText() {
    const std::size_t size = TakeCount(1);
    const auto* text = reinterpret_cast<const char*>(TakeBytes(size));
    return {text, size};
  }

 private:
  const std::uint8_t* TakeBytes(std::size_t count) {
    if (count > left()) Fail("the file ends too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }

  const std::span<const std::uint8_t> bytes_;
  const std::string name_;
  std::size_t at_ = 0;
};

}  // namespace terrace

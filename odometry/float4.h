// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

namespace terrace {

// Four numbers at once, by what every compiler makes of its vectors: the same bits on every processor.

typedef float Float4 __attribute__((vector_size(16)));
typedef std::int32_t Int4 __attribute__((vector_size(16)));
typedef std::uint8_t Byte4 __attribute__((vector_size(4)));
typedef std::uint8_t Byte16 __attribute__((vector_size(16)));

inline Float4 Load(const float* p) {
  Float4 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
inline Float4 LoadBytes(const std::uint8_t* p) {
  Byte4 v;
  std::memcpy(&v, p, sizeof v);
  return __builtin_convertvector(v, Float4);
}
inline void Store(float* p, const Float4& v) { std::memcpy(p, &v, sizeof v); }
inline float Sum(const Float4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace terrace

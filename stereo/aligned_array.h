// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include <hwy/aligned_allocator.h>

namespace terrace {

/// Memory aligned for the widest vectors, kept from frame to frame. Its content is not initialised.
template <typename T>
class AlignedArray {
 public:
  /// At least `size` elements; the content is lost when it grows.
  T* Reserve(std::size_t size) {
    if (size > capacity_) {
      data_ = hwy::AllocateAligned<T>(size);
      capacity_ = size;
    }
    return data_.get();
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }

 private:
  hwy::AlignedFreeUniquePtr<T[]> data_;
  std::size_t capacity_ = 0;
};

}  // namespace terrace

// Arrays that grow in place, for the flat kernels. An array reserves address space first, which the system fills with
// memory where the array is touched. So growing copies nothing, and the old and the new array are never in memory
// together.
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "src/base/memory_pool.h"

namespace tessera::flat {

// A vector of plain data. New elements are not initialised: an element must be written before it is read.
template <class T>
class Array {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;
  Array() = default;
  Array(Array&& other) noexcept { swap(other); }
  Array& operator=(Array&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Array() { unmap_memory(mapping_, high_ * sizeof(T)); }

  T* data() { return reinterpret_cast<T*>(mapping_.at); }
  const T* data() const { return reinterpret_cast<const T*>(mapping_.at); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }
  // The bytes that have been used since the last trim(), and so have pages.
  std::size_t touched() const { return high_ * sizeof(T); }
  std::size_t capacity() const { return mapping_.reserved / sizeof(T); }

  // Reserves address space for n elements, which costs no memory until they are touched.
  void reserve(std::size_t n) {
    if (n <= capacity()) return;
    if (mapping_.at) {
      grow_mapping(mapping_, n * sizeof(T));
    } else {
      mapping_ = map_memory(n * sizeof(T));
    }
  }
  // Sets the size to n. New elements are undefined.
  void resize(std::size_t n) {
    if (n > capacity()) reserve(n + n / 2 + 64);
    size_ = n;
    if (n > high_) high_ = n;
  }
  void push_back(const T& value) {
    resize(size_ + 1);
    data()[size_ - 1] = value;
  }
  // Moves the same bytes into an array of another element type. This array is empty afterwards.
  template <class U>
  Array<U> take_as() {
    static_assert(sizeof(U) == sizeof(T) && alignof(U) <= alignof(T));
    Array<U> other;
    std::swap(other.mapping_, mapping_);
    std::swap(other.size_, size_);
    std::swap(other.high_, high_);
    return other;
  }
  // Gives back the memory behind the last element.
  void trim() {
    shrink_mapping(mapping_, bytes(), high_ * sizeof(T));
    high_ = size_;
  }
  void clear() {
    unmap_memory(mapping_, high_ * sizeof(T));
    size_ = high_ = 0;
  }

 private:
  template <class U>
  friend class Array;
  void swap(Array& other) noexcept {
    std::swap(mapping_, other.mapping_);
    std::swap(size_, other.size_);
    std::swap(high_, other.high_);
  }

  Mapping mapping_;
  std::size_t size_ = 0;
  std::size_t high_ = 0;  // the largest size since the last trim
};

// Empties vectors and gives back their memory, which clear() and `= {}` would keep.
template <class... Vectors>
void release(Vectors&... vectors) {
  ((vectors = Vectors()), ...);
}

}  // namespace tessera::flat

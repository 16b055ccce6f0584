// Turns values and flat arrays into bytes and back. The bytes have the layout and byte order of the memory, so only the
// same machine and version can read them. The reader checks lengths all the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/big_vector.h"

namespace tessera {

class FlatWriter {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* p = reinterpret_cast<const std::byte*>(&v);
    bytes_.insert(bytes_.end(), p, p + sizeof(T));
  }
  // Appends a contiguous list: its length as 64 bits, then its elements.
  template <class List>
  void list(const List& v) {
    using T = typename List::value_type;
    static_assert(std::is_trivially_copyable_v<T>);
    value(static_cast<std::uint64_t>(v.size()));
    const auto* p = reinterpret_cast<const std::byte*>(v.data());
    bytes_.insert(bytes_.end(), p, p + v.size() * sizeof(T));
  }
  // Appends a list and frees its memory.
  template <class List>
  void last(List& v) {
    list(v);
    List().swap(v);
  }
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  std::size_t size() const { return bytes_.size(); }
  BigVector<std::byte> take() { return std::move(bytes_); }

 private:
  BigVector<std::byte> bytes_;
};

// Reads what a FlatWriter wrote, in the same order. A function returns false when too few bytes are left. After that
// the value, and all that is read later, is unspecified.
class FlatReader {
 public:
  explicit FlatReader(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class T>
  bool value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (rest_.size() < sizeof(T)) return false;
    std::memcpy(&v, rest_.data(), sizeof(T));
    rest_ = rest_.subspan(sizeof(T));
    return true;
  }
  // Reads a list. Never allocates more than the bytes that are left.
  template <class List>
  bool list(List& v) {
    using T = typename List::value_type;
    static_assert(std::is_trivially_copyable_v<T>);
    std::uint64_t n = 0;
    if (!value(n) || n > rest_.size() / sizeof(T)) return false;
    v.resize(n);
    if (n > 0) std::memcpy(v.data(), rest_.data(), n * sizeof(T));
    rest_ = rest_.subspan(n * sizeof(T));
    return true;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace tessera

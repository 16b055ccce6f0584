// Memory of the flat kernels: arrays that grow in place. Address space is reserved first and filled as it is touched,
// so growing copies nothing and never holds the old and the new array at once. Large arrays ask for huge pages: page
// faults cost 0.4 s a GiB with small pages, a quarter of it with huge ones. Mappings that are given back are kept by
// their thread, up to a bound, and used again: the pages of the next tile are there already.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace tessera::flat {

// Small pages: for arrays that are gone through in order. In 2D huge pages made the triangulation itself no faster, and
// a virtual machine may take far longer to come by them: 2.2 s a GiB where memory had been idle, against 0.4 s.
enum class Pages : std::uint8_t { huge, small };

struct Mapping {
  std::byte* at = nullptr;
  std::size_t reserved = 0;  // bytes of address space
  Pages pages = Pages::huge;
};

// A mapping of at least `bytes`, from this thread's pool if one fits. Content undefined. Throws std::bad_alloc.
Mapping map_memory(std::size_t bytes, Pages pages);
// The same memory with at least `bytes`; may move. Throws std::bad_alloc.
void grow_mapping(Mapping& mapping, std::size_t bytes);
// Gives the memory back, of which the first `used` bytes may have been touched.
void unmap_memory(Mapping& mapping, std::size_t used) noexcept;
// Gives the pages behind the first `kept` of `used` bytes back to the system.
void shrink_mapping(const Mapping& mapping, std::size_t kept, std::size_t used) noexcept;
// Gives the whole pages among the first `bytes` back to the system.
void release_pages(const Mapping& mapping, std::size_t bytes) noexcept;

// A vector of plain data without initialisation. Elements must not be read before they are written.
template <class T, Pages pages = Pages::huge>
class Array {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
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
  std::size_t capacity() const { return mapping_.reserved / sizeof(T); }

  // Address space for n elements: costs no memory until they are touched.
  void reserve(std::size_t n) {
    if (n <= capacity()) return;
    if (mapping_.at) {
      grow_mapping(mapping_, n * sizeof(T));
    } else {
      mapping_ = map_memory(n * sizeof(T), pages);
    }
  }
  // New elements are undefined.
  void resize(std::size_t n) {
    if (n > capacity()) reserve(n + n / 2 + 64);
    size_ = n;
    if (n > high_) high_ = n;
  }
  void push_back(const T& value) {
    resize(size_ + 1);
    data()[size_ - 1] = value;
  }
  // Gives back what lies behind the last element.
  void trim() {
    shrink_mapping(mapping_, bytes(), high_ * sizeof(T));
    high_ = size_;
  }
  // Gives back the pages of the first n elements, which must not be read any more.
  void release_front(std::size_t n) { release_pages(mapping_, n * sizeof(T)); }
  void clear() {
    unmap_memory(mapping_, high_ * sizeof(T));
    size_ = high_ = 0;
  }

 private:
  void swap(Array& other) noexcept {
    std::swap(mapping_, other.mapping_);
    std::swap(size_, other.size_);
    std::swap(high_, other.high_);
  }

  Mapping mapping_;
  std::size_t size_ = 0;
  std::size_t high_ = 0;  // the largest size since the last trim
};

}  // namespace tessera::flat

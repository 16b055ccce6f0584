#include "src/io/npy/array_source.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "the header says so");

class ArraySource : public ByteSource {
 public:
  ArraySource(std::filesystem::path name, std::span<const double> coordinates, int dimension)
      : name_(std::move(name)), body_(std::as_bytes(coordinates)) {
    const std::size_t rows = coordinates.size() / static_cast<std::size_t>(dimension);
    const std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                             std::to_string(dimension) + "), }\n";
    head_ = std::string("\x93NUMPY\x01\x00", 8);
    head_ += static_cast<char>(text.size());
    head_ += '\0';
    head_ += text;
  }

  const std::filesystem::path& path() const override { return name_; }
  std::uint64_t size() const override { return head_.size() + body_.size(); }
  std::int64_t modified_ns() const override { return 0; }

  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (out.empty()) return success();  // memcpy takes no null pointers, not even for nothing
    if (offset < head_.size()) {
      const auto part = std::as_bytes(std::span(head_)).subspan(offset);
      const std::size_t n = std::min(part.size(), out.size());
      std::memcpy(out.data(), part.data(), n);
      out = out.subspan(n);
      offset += n;
    }
    if (!out.empty()) std::memcpy(out.data(), body_.data() + (offset - head_.size()), out.size());
    return success();
  }
  Status check_unchanged() const override { return success(); }

 private:
  std::filesystem::path name_;
  std::string head_;
  std::span<const std::byte> body_;
};

}  // namespace

std::unique_ptr<ByteSource> array_source(const std::string& name, std::span<const double> coordinates, int dimension) {
  return std::make_unique<ArraySource>(name, coordinates, dimension);
}

}  // namespace tessera

#include "src/input/npy/array_source.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "the header says so");

class ArraySource : public ByteSource {
 public:
  // `type` and `shape` are written into the header as they are.
  ArraySource(std::filesystem::path name, std::span<const std::byte> body, const std::string& type,
              const std::string& shape)
      : name_(std::move(name)), body_(body) {
    const std::string text = "{'descr': " + type + ", 'fortran_order': False, 'shape': " + shape + ", }\n";
    head_ = std::string("\x93NUMPY\x02\x00", 8);
    for (unsigned shift = 0; shift < 32; shift += 8) head_ += static_cast<char>(text.size() >> shift & 0xff);
    head_ += text;
  }

  const std::filesystem::path& path() const override { return name_; }
  std::uint64_t size() const override { return head_.size() + body_.size(); }
  std::int64_t modified_ns() const override { return 0; }

  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (out.empty()) return success();  // memcpy() takes no null pointers, even for 0 bytes
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
  const std::size_t rows = coordinates.size() / static_cast<std::size_t>(dimension);
  return std::make_unique<ArraySource>(name, std::as_bytes(coordinates), "'<f8'",
                                       "(" + std::to_string(rows) + ", " + std::to_string(dimension) + ")");
}

std::unique_ptr<ByteSource> record_source(const std::string& name, std::span<const std::byte> bytes,
                                          const std::string& columns, std::uint64_t rows) {
  return std::make_unique<ArraySource>(name, bytes, columns, "(" + std::to_string(rows) + ",)");
}

}  // namespace tessera

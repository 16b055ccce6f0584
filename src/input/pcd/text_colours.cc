#include "src/input/pcd/text_colours.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

std::uint32_t bits_of(double number) {
  if (number >= 0 && number <= UINT32_MAX && std::floor(number) == number) return static_cast<std::uint32_t>(number);
  return std::bit_cast<std::uint32_t>(static_cast<float>(number));
}

class TextColours : public PlyVertices {
 public:
  // The bytes of the colours follow the record of `inner`; `first` is the property of the lowest of them, blue.
  TextColours(std::unique_ptr<PlyVertices> inner, std::size_t colour, std::size_t first, std::size_t bytes)
      : inner_(std::move(inner)) {
    for (const auto& scalar : inner_->scalars()) {
      if (scalar.property == colour) offset_ = scalar.offset;
      scalars_.push_back(scalar);
    }
    for (std::size_t i = 0; i < bytes; ++i)
      scalars_.push_back({first + i, inner_->record_bytes() + i, AttributeType::u8, false});
    record_bytes_ = inner_->record_bytes() + sizeof(std::uint32_t);
  }

  Result<std::span<const std::byte>> next(std::size_t most) override {
    BOOST_OUTCOME_TRY(block, inner_->next(most));
    const std::size_t from = inner_->record_bytes(), n = block.size() / from;
    block_.resize(n * record_bytes_);
    for (std::size_t i = 0; i < n; ++i) {
      double number = 0;
      std::memcpy(&number, block.data() + i * from + offset_, sizeof number);
      const std::uint32_t bits = bits_of(number);
      std::memcpy(block_.data() + i * record_bytes_, block.data() + i * from, from);
      std::memcpy(block_.data() + i * record_bytes_ + from, &bits, sizeof bits);
    }
    return std::span<const std::byte>(block_);
  }
  bool seek(std::uint64_t index) override { return inner_->seek(index); }
  std::string place(std::size_t index) const override { return inner_->place(index); }

 private:
  std::unique_ptr<PlyVertices> inner_;
  std::size_t offset_ = 0;
  std::vector<std::byte> block_;
};

}  // namespace

std::unique_ptr<PlyVertices> unpack_text_colours(std::unique_ptr<PlyVertices> vertices, std::size_t colour,
                                                 PlyElement& element) {
  const bool alpha = element.properties[colour].name == "rgba";
  const std::size_t first = element.properties.size();
  for (const char* name : {"blue", "green", "red"})
    element.properties.push_back({.name = name, .type = AttributeType::u8, .count = {}});
  if (alpha) element.properties.push_back({.name = "alpha", .type = AttributeType::u8, .count = {}});
  element.properties[colour].name = "_";
  return std::make_unique<TextColours>(std::move(vertices), colour, first, alpha ? 4 : 3);
}

}  // namespace tessera

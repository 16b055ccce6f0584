#include "src/input/pcd/compressed_vertices.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/pcd/lzf_stream.h"

namespace tessera {
namespace {

class CompressedVertices : public PlyVertices {
 public:
  CompressedVertices(std::unique_ptr<ByteSource> source, std::uint64_t points, const PlyElement& element)
      : source_(std::move(source)), points_(points) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      scalars_.push_back({i, record_bytes_, element.properties[i].type, false});
      record_bytes_ += size_of(element.properties[i].type);
    }
  }

  // Adds the field whose bytes are at `offset` of a record.
  Status add(const PcdField& field, std::size_t offset, std::uint64_t packed_at, std::uint64_t packed_bytes) {
    LzfStream stream(*source_, packed_at, packed_bytes);
    BOOST_OUTCOME_TRYV(stream.skip(offset * points_));
    fields_.push_back({stream, offset, field.bytes()});
    return success();
  }

  Result<std::span<const std::byte>> next(std::size_t most) override {
    const auto n =
        static_cast<std::size_t>(std::min<std::uint64_t>(points_ - position_, points_at_once(most, record_bytes_)));
    if (n == 0) {
      BOOST_OUTCOME_TRYV(source_->check_unchanged());
    }
    first_ = position_;
    block_.assign(n * record_bytes_, std::byte{0});
    for (auto& field : fields_) {
      column_.resize(n * field.bytes);
      BOOST_OUTCOME_TRYV(field.stream.read(column_));
      for (std::size_t i = 0; i < n; ++i)
        std::memcpy(block_.data() + i * record_bytes_ + field.offset, column_.data() + i * field.bytes, field.bytes);
    }
    position_ += n;
    return std::span<const std::byte>(block_);
  }
  bool seek(std::uint64_t) override { return false; }
  std::string place(std::size_t index) const override { return "record " + std::to_string(first_ + index); }

 private:
  struct Field {
    LzfStream stream;
    std::size_t offset, bytes;
  };

  std::unique_ptr<ByteSource> source_;
  std::uint64_t points_, position_ = 0, first_ = 0;
  std::vector<Field> fields_;
  std::vector<std::byte> block_, column_;
};

}  // namespace

Result<std::unique_ptr<PlyVertices>> open_compressed_vertices(std::unique_ptr<ByteSource> source,
                                                              const PcdHeader& header, const PlyElement& element,
                                                              bool coordinates_only) {
  constexpr std::uint64_t sizes_bytes = 8;
  const auto wrong = [&](const std::string& what) {
    return error(Errc::bad_input, source->path().string() + ": " + what);
  };
  if (source->size() - header.body_at < sizes_bytes) return wrong("the file ends before the compressed points");
  std::array<std::byte, sizes_bytes> sizes{};
  BOOST_OUTCOME_TRYV(source->read(header.body_at, sizes));
  const std::uint64_t packed = load<std::uint32_t>(sizes.data()), unpacked = load<std::uint32_t>(sizes.data() + 4);
  const std::uint64_t there = source->size() - header.body_at - sizes_bytes;
  if (packed > there)
    return wrong("the compressed points take " + std::to_string(packed) + " bytes, but the file ends after " +
                 std::to_string(there));
  if (unpacked / header.point_bytes() != header.points || unpacked % header.point_bytes() != 0)
    return wrong("the compressed points hold " + std::to_string(unpacked) + " bytes, but " +
                 std::to_string(header.points) + " points take " + std::to_string(header.point_bytes()) + " each");
  auto vertices = std::make_unique<CompressedVertices>(share(std::shared_ptr<const ByteSource>(std::move(source))),
                                                       header.points, element);
  std::size_t offset = 0;
  for (const auto& field : header.fields) {
    const bool coordinate = field.name.size() == 1 && std::string_view("xyzXYZ").find(field.name) < 6;
    if (field.name != "_" && (coordinate || !coordinates_only)) {
      BOOST_OUTCOME_TRYV(vertices->add(field, offset, header.body_at + sizes_bytes, packed));
    }
    offset += field.bytes();
  }
  return std::unique_ptr<PlyVertices>(std::move(vertices));
}

}  // namespace tessera

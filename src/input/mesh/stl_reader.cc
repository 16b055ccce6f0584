#include "src/input/mesh/stl_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/mesh/stl_text.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

constexpr std::size_t header_bytes = 84;    // 80 arbitrary bytes and the number of triangles
constexpr std::size_t triangle_bytes = 50;  // a normal, three corners, two bytes
constexpr std::size_t corner_bytes = 3 * sizeof(float);

std::uint64_t promised_bytes(std::span<const std::byte> begin) {
  return header_bytes + std::uint64_t{triangle_bytes} * load<std::uint32_t>(begin.data() + header_bytes - 4);
}

class StlReader : public PointReader {
 public:
  StlReader(FileInfo info, RecordStream triangles, std::size_t row_bytes)
      : info_(std::move(info)), triangles_(std::move(triangles)), row_bytes_(row_bytes) {}

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    // A batch may begin and end within a triangle. Such a triangle is read twice.
    const auto skipped = static_cast<std::size_t>(position_ % 3);
    const std::size_t corners = std::min(most, batch_points_max);
    triangles_.seek(position_ / 3);
    BOOST_OUTCOME_TRY(block, triangles_.next((skipped + corners + 2) / 3));
    const std::size_t there = block.size() / triangle_bytes * 3;
    const std::size_t n = std::min(corners, there - std::min(there, skipped));
    first_ = position_;
    position_ += n;
    batch.points.resize(n);
    batch.rows.assign(n * row_bytes_, std::byte{0});
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t corner = skipped + i;
      const auto* at = block.data() + corner / 3 * triangle_bytes + (1 + corner % 3) * corner_bytes;
      for (int axis = 0; axis < 3; ++axis)
        batch.points[i][axis] = load<float>(at + static_cast<std::size_t>(axis) * sizeof(float));
    }
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    position_ = std::min(index, *info_.points);
    return true;
  }

  std::string place(std::size_t index) const override { return "triangle " + std::to_string((first_ + index) / 3); }

 private:
  FileInfo info_;
  RecordStream triangles_;
  std::size_t row_bytes_;
  std::uint64_t position_ = 0, first_ = 0;  // in points
};

std::string begin_word(std::span<const std::byte> begin) {
  std::string word;
  for (const auto byte : begin.first(std::min<std::size_t>(5, begin.size())))
    word += static_cast<char>(std::tolower(static_cast<unsigned char>(byte)));
  return word;
}

}  // namespace

bool is_binary_stl(std::span<const std::byte> begin, std::optional<std::uint64_t> bytes) {
  if (begin.size() < header_bytes) return false;
  const std::uint64_t promised = promised_bytes(begin);
  if (bytes) return *bytes == promised;
  if (begin.size() < header_bytes + triangle_bytes || promised < begin.size()) return false;
  for (std::size_t at = header_bytes; at < header_bytes + 4 * corner_bytes; at += sizeof(float))
    if (!std::isfinite(load<float>(begin.data() + at))) return false;
  return true;
}

bool looks_like_text_stl(std::string_view begin) {
  const std::size_t end = begin.find('\n');
  std::vector<std::string_view> words;
  if (end == std::string_view::npos || !begin.starts_with("solid")) return false;
  split_line(begin.substr(0, end), Delimiter::blanks, 1, words);
  if (words[0] != "solid" && words[0] != "solid\r") return false;
  begin.remove_prefix(end + 1);
  begin.remove_prefix(std::min(begin.find_first_not_of(" \t\r\n"), begin.size()));
  return begin.starts_with("facet") || begin.starts_with("endsolid");
}

Result<std::unique_ptr<PointReader>> open_stl(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  const std::string name = source->path().string();
  std::array<std::byte, header_bytes> head{};
  const auto begin =
      std::span(head).first(static_cast<std::size_t>(std::min<std::uint64_t>(head.size(), source->size())));
  BOOST_OUTCOME_TRYV(source->read(0, begin));
  if (!is_binary_stl(begin, source->size())) {
    const bool text = check_is_text(*source).has_value();
    if (text && begin_word(begin) == "solid") return open_stl_text(std::move(source), attributes);
    if (text || begin.size() < header_bytes)
      return error(Errc::bad_input, name + ": is not STL: it neither begins with 'solid' nor is it binary");
    return error(Errc::bad_input, name + ": is binary STL of " + std::to_string(promised_bytes(begin)) +
                                      " bytes by the number of triangles in its header, but has " +
                                      std::to_string(source->size()));
  }
  FileInfo info = info_of(*source, "stl");
  const std::uint32_t triangles = load<std::uint32_t>(begin.data() + header_bytes - 4);
  info.detail = "STL, binary, float";
  info.points = std::uint64_t{3} * triangles;
  RecordStream records(std::move(source), header_bytes, triangle_bytes, triangles);
  return std::unique_ptr<PointReader>(new StlReader(std::move(info), std::move(records), row_bytes(attributes)));
}

}  // namespace tessera

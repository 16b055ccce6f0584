#include "src/input/las_copy/laz_body.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>

#include "src/input/las_copy/integer_encoder.h"

namespace tessera::laz {
namespace {

template <class T>
void push(std::vector<std::byte>& to, T value) {
  const auto raw = std::as_bytes(std::span(&value, 1));
  to.insert(to.end(), raw.begin(), raw.end());
}

}  // namespace

std::vector<std::byte> laszip_payload(const LazLayout& layout, std::span<const std::byte> before) {
  std::vector<std::byte> payload;
  push(payload, static_cast<std::uint16_t>(layout.compressor));
  push(payload, std::uint16_t{0});  // arithmetic coding
  if (before.empty()) {
    // The version of LASzip whose format this is: 3.4, revision 3. No options.
    push(payload, std::uint8_t{3});
    push(payload, std::uint8_t{4});
    push(payload, std::uint16_t{3});
    push(payload, std::uint32_t{0});
  } else {
    const auto kept = before.subspan(4, 8);
    payload.insert(payload.end(), kept.begin(), kept.end());
  }
  push(payload, layout.chunk_points);
  push(payload, std::int64_t{-1});  // no special extended records, and no place of them
  push(payload, std::int64_t{-1});
  push(payload, static_cast<std::uint16_t>(layout.items.size()));
  for (const auto& item : layout.items) {
    push(payload, static_cast<std::uint16_t>(item.type));
    push(payload, item.bytes);
    push(payload, item.version);
  }
  return payload;
}

LazBody::LazBody(OutputFile& file, const LazLayout& layout, std::size_t record_bytes, std::uint64_t at)
    : file_(file), layout_(layout), record_bytes_(record_bytes), begin_(at), end_(at) {}

Status LazBody::begin() { return append(std::array<std::byte, 8>{}); }

Status LazBody::add(std::span<const std::byte> records) {
  while (!records.empty()) {
    if (!encoder_) encoder_ = make_chunk_encoder(layout_, record_bytes_);
    const std::uint64_t n = std::min<std::uint64_t>(records.size() / record_bytes_, layout_.chunk_points - encoded_);
    encoder_->encode(records.first(n * record_bytes_));
    records = records.subspan(n * record_bytes_);
    if ((encoded_ += n) == layout_.chunk_points) {
      BOOST_OUTCOME_TRYV(end_chunk());
    }
  }
  return success();
}

Status LazBody::end_chunk() {
  if (!encoder_) return success();
  const auto bytes = encoder_->finish();
  if (bytes.size() > std::numeric_limits<std::uint32_t>::max())
    return error(Errc::bad_input, file_.path().string() + ", chunk " + std::to_string(chunks_.size()) + ": its " +
                                      std::to_string(encoded_) + " points take more than 4 GiB");
  chunks_.push_back(
      {end_, end_ + bytes.size(), chunks_.empty() ? 0 : chunks_.back().first + chunks_.back().points, encoded_});
  encoder_.reset();
  encoded_ = 0;
  return append(bytes);
}

Status LazBody::finish() {
  BOOST_OUTCOME_TRYV(end_chunk());
  std::array<std::byte, 8> table_at{};
  std::memcpy(table_at.data(), &end_, sizeof end_);
  BOOST_OUTCOME_TRYV(append(table()));
  return file_.overwrite(begin_, table_at);
}

Status LazBody::append(std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(file_.append(bytes));
  end_ += bytes.size();
  return success();
}

std::vector<std::byte> LazBody::table() const {
  std::vector<std::byte> table;
  push(table, std::uint32_t{0});  // version
  push(table, static_cast<std::uint32_t>(chunks_.size()));
  if (chunks_.empty()) return table;
  ArithmeticEncoder encoder;
  IntegerEncoder<32, 2> integers;
  std::int32_t last_points = 0, last_bytes = 0;
  for (const auto& chunk : chunks_) {
    const auto points = static_cast<std::int32_t>(chunk.points),
               bytes = static_cast<std::int32_t>(chunk.end - chunk.begin);
    if (layout_.variable_chunks()) integers.next(encoder, last_points, points, 0);
    integers.next(encoder, last_bytes, bytes, 1);
    last_points = points;
    last_bytes = bytes;
  }
  const auto bytes = encoder.finish();
  table.insert(table.end(), bytes.begin(), bytes.end());
  return table;
}

}  // namespace tessera::laz

#include "src/input/las_copy/laz_body.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "src/base/on_threads.h"
#include "src/input/las_copy/integer_encoder.h"

namespace tessera::laz {
namespace {

// A chunk of 50,000 points has some 2 MB of records.
constexpr std::size_t records_waiting_bytes_max = std::size_t{16} << 20;

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

LazBody::LazBody(OutputFile& file, const LazLayout& layout, std::size_t record_bytes, std::uint64_t at,
                 unsigned threads)
    : file_(file), layout_(layout), record_bytes_(record_bytes), threads_(threads), begin_(at), end_(at) {}

Status LazBody::begin() { return append(std::array<std::byte, 8>{}); }

Status LazBody::add(std::span<const std::byte> records) {
  while (!records.empty()) {
    const std::uint64_t n =
        std::min<std::uint64_t>(records.size() / record_bytes_, layout_.chunk_points - part_.points);
    const auto taken = records.first(n * record_bytes_);
    part_.records.insert(part_.records.end(), taken.begin(), taken.end());
    records = records.subspan(taken.size());
    part_.points += n;
    if (part_.points == layout_.chunk_points) {
      BOOST_OUTCOME_TRYV(end_chunk());
    } else if (part_.records.size() >= records_waiting_bytes_max) {
      encode(part_);
    }
  }
  return success();
}

Status LazBody::end_chunk() {
  if (part_.points == 0) return success();
  ended_.push_back(std::exchange(part_, {}));
  return ended_.size() < threads_ ? success() : compress_ended();
}

void LazBody::encode(Part& part) const {
  if (!part.encoder) part.encoder = make_chunk_encoder(layout_, record_bytes_);
  part.encoder->encode(part.records);
  part.records.clear();
}

// Compresses the chunks that have ended, at once, and appends them in order.
Status LazBody::compress_ended() {
  std::vector<std::vector<std::byte>> compressed(ended_.size());
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  BOOST_OUTCOME_TRYV(on_threads(static_cast<unsigned>(ended_.size()), failed, [&]() -> Status {
    for (std::size_t i = next++; i < ended_.size() && !failed; i = next++) {
      encode(ended_[i]);
      compressed[i] = ended_[i].encoder->finish();
    }
    return success();
  }));
  for (std::size_t i = 0; i < ended_.size(); ++i) {
    const auto& bytes = compressed[i];
    if (bytes.size() > std::numeric_limits<std::uint32_t>::max())
      return error(Errc::bad_input, file_.path().string() + ", chunk " + std::to_string(chunks_.size()) + ": its " +
                                        std::to_string(ended_[i].points) + " points take more than 4 GiB");
    chunks_.push_back({end_, end_ + bytes.size(), chunks_.empty() ? 0 : chunks_.back().first + chunks_.back().points,
                       ended_[i].points});
    BOOST_OUTCOME_TRYV(append(bytes));
  }
  ended_.clear();
  return success();
}

Status LazBody::finish() {
  BOOST_OUTCOME_TRYV(end_chunk());
  if (!ended_.empty()) {
    BOOST_OUTCOME_TRYV(compress_ended());
  }
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

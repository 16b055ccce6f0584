#include "src/input/las_copy/las_parts.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::size_t head_bytes = 54, extended_head_bytes = 60;

// Reads `count` records from `at` on, and moves `at` behind them.
Status read_records_at(const ByteSource& source, std::uint64_t& at, std::uint32_t count, bool extended,
                       std::vector<LasRecord>& records) {
  for (std::uint32_t i = 0; i < count; ++i) {
    LasRecord record{.head = std::vector<std::byte>(extended ? extended_head_bytes : head_bytes), .source = {}};
    BOOST_OUTCOME_TRYV(source.read(at, record.head));
    record.source.at = at + record.head.size();
    const std::byte* length = record.head.data() + 20;
    record.source.bytes = extended ? load<std::uint64_t>(length) : load<std::uint16_t>(length);
    at = record.source.at + record.source.bytes;
    records.push_back(std::move(record));
  }
  return success();
}

// Finds the record of waveforms, if the file says that it has one and the list of extended records does not have it.
Status read_waveforms(const ByteSource& source, LasParts& parts) {
  constexpr std::uint16_t inside = 2;  // of the global encoding: waveforms are in this file
  if (parts.header.size() < waveforms_at + sizeof(std::uint64_t)) return success();
  const auto begin = load<std::uint64_t>(parts.header.data() + waveforms_at);
  if (begin == 0 || (load<std::uint16_t>(parts.header.data() + 6) & inside) == 0) return success();
  for (const auto& record : parts.extended)
    if (record.begins_at() == begin) return success();
  std::uint64_t at = begin;
  std::vector<LasRecord> found;
  BOOST_OUTCOME_TRYV(read_records_at(source, at, 1, true, found));
  if (!found.front().is("LASF_Spec", 65535))
    return error(Errc::bad_input, source.path().string() + ": says that its waveforms begin at byte " +
                                      std::to_string(begin) + ", but no record of waveforms begins there");
  parts.waveforms = std::move(found.front());
  return success();
}

}  // namespace

bool LasRecord::is(std::string_view user, std::uint16_t id) const {
  const std::string_view stored(reinterpret_cast<const char*>(head.data() + 2), 16);
  return stored.substr(0, stored.find('\0')) == user && load<std::uint16_t>(head.data() + 18) == id;
}

Result<LasParts> read_las_parts(const ByteSource& source, const LasHeader& header) {
  std::array<std::byte, 2> raw{};
  BOOST_OUTCOME_TRYV(source.read(94, raw));
  LasParts parts;
  parts.header.resize(load<std::uint16_t>(raw.data()));
  BOOST_OUTCOME_TRYV(source.read(0, parts.header));
  std::uint64_t at = parts.header.size();
  BOOST_OUTCOME_TRYV(read_records_at(source, at, load<std::uint32_t>(parts.header.data() + 100), false, parts.records));
  parts.gap = {at, header.points_at - at};
  if (header.minor >= 4) {
    at = load<std::uint64_t>(parts.header.data() + 235);
    BOOST_OUTCOME_TRYV(
        read_records_at(source, at, load<std::uint32_t>(parts.header.data() + 243), true, parts.extended));
  }
  BOOST_OUTCOME_TRYV(read_waveforms(source, parts));
  return parts;
}

Result<std::vector<std::byte>> read_payload(const ByteSource& source, const LasRecord& record) {
  if (record.payload) return *record.payload;
  std::vector<std::byte> bytes(record.source.bytes);
  BOOST_OUTCOME_TRYV(source.read(record.source.at, bytes));
  return bytes;
}

LasRecord new_record(std::string_view user, std::uint16_t id, std::string_view description,
                     std::vector<std::byte> payload) {
  LasRecord record{.head = std::vector<std::byte>(head_bytes), .source = {}, .payload = std::move(payload)};
  std::memcpy(record.head.data() + 2, user.data(), user.size());
  store_at(record.head, 18, id);
  std::memcpy(record.head.data() + 22, description.data(), description.size());
  return record;
}

Status append_from(const ByteSource& source, SourceBytes bytes, OutputFile& file) {
  constexpr std::uint64_t piece_bytes = 1 << 20;
  std::vector<std::byte> piece;
  while (bytes.bytes > 0) {
    piece.resize(std::min(bytes.bytes, piece_bytes));
    BOOST_OUTCOME_TRYV(source.read(bytes.at, piece));
    BOOST_OUTCOME_TRYV(file.append(piece));
    bytes.at += piece.size();
    bytes.bytes -= piece.size();
  }
  return success();
}

Status append_record(const ByteSource& source, const LasRecord& record, OutputFile& file) {
  if (!record.payload) {
    BOOST_OUTCOME_TRYV(file.append(record.head));
    return append_from(source, record.source, file);
  }
  auto head = record.head;
  if (record.extended()) {
    store_at(head, 20, std::uint64_t{record.payload->size()});
  } else {
    store_at(head, 20, static_cast<std::uint16_t>(record.payload->size()));
  }
  BOOST_OUTCOME_TRYV(file.append(head));
  return file.append(*record.payload);
}

}  // namespace tessera

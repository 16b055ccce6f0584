// The parts of a LAS or LAZ file around its points, as bytes, so that a copy keeps what nobody here understands.
// Source: ASPRS, LAS Specification 1.4 - R15 (2019).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/files/output_file.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/las/las_header.h"

namespace tessera {

// Where the header says at which byte the record of waveforms begins, since LAS 1.3.
inline constexpr std::size_t waveforms_at = 227;

// Bytes of a source.
struct SourceBytes {
  std::uint64_t at = 0, bytes = 0;
};

// A variable length record (VLR), or an extended one (EVLR).
struct LasRecord {
  std::vector<std::byte> head;  // 54 bytes, of an extended record 60; its length is that of the input
  SourceBytes source;           // the payload in the input
  std::optional<std::vector<std::byte>> payload = {};  // the payload of the copy, when it differs

  bool extended() const { return head.size() == 60; }
  std::uint64_t begins_at() const { return source.at - head.size(); }  // in the input
  bool is(std::string_view user, std::uint16_t id) const;
  std::uint64_t payload_bytes() const { return payload ? payload->size() : source.bytes; }
  std::uint64_t bytes() const { return head.size() + payload_bytes(); }
};

struct LasParts {
  std::vector<std::byte> header;  // as long as the header says
  std::vector<LasRecord> records, extended;
  SourceBytes gap;  // bytes between the last record and the points
  // The record of waveforms, where the header alone says where it is: in LAS 1.3, which has no list of extended
  // records.
  std::optional<LasRecord> waveforms = {};
};

// Errors: those of the source; bad_input when the record of waveforms is not where the header says. REQUIRES: `header`
// is that of `source`.
Result<LasParts> read_las_parts(const ByteSource& source, const LasHeader& header);
Result<std::vector<std::byte>> read_payload(const ByteSource& source, const LasRecord& record);
// A record that the input does not have. REQUIRES: user has at most 16 bytes, description 32, payload 65535.
LasRecord new_record(std::string_view user, std::uint16_t id, std::string_view description,
                     std::vector<std::byte> payload);

// Appends bytes of the source, or a whole record, to a file.
Status append_from(const ByteSource& source, SourceBytes bytes, OutputFile& file);
Status append_record(const ByteSource& source, const LasRecord& record, OutputFile& file);

template <class T>
void store_at(std::vector<std::byte>& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace tessera

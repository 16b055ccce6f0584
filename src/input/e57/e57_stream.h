// The values of one field of a scan, in order. Records are stored in packets; a packet holds a stretch of each field's
// stream of bits. Source: ASTM E2807-11, section 9 (compressed vector binary sections).
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/result.h"
#include "src/input/e57/e57_header.h"
#include "src/input/e57/e57_pages.h"

namespace tessera {

// Where the packets of a scan are, in logical bytes.
struct E57Section {
  std::uint64_t begin = 0, end = 0;
};

// Finds the packets of a scan. Error bad_input when there is no such section.
Result<E57Section> find_section(E57Pages& pages, const E57Scan& scan);

// Reads one field forward. Each field of a scan has its own stream, so that no packet must be kept for another field.
class E57Stream {
 public:
  // `index` is the number of the field in its scan, which has `fields` fields. `pages` must live longer.
  E57Stream(E57Pages& pages, E57Section section, const E57Field& field, std::size_t index, std::size_t fields);

  // Replaces `values` by the next `n` values. Error bad_input: the packets end before, or are damaged.
  Status read(std::size_t n, std::vector<double>& values);
  // The same for a field of kind integer.
  Status read(std::size_t n, std::vector<std::int64_t>& values);

 private:
  // Reads the next packet with bits of this field.
  Status next_packet();
  // Replaces raw_ by the next `n` stored values.
  Status read_raw(std::size_t n);
  Error damaged(const std::string& what) const;

  E57Pages* pages_;
  E57Section section_;
  E57Field field_;
  std::size_t index_, fields_;
  std::uint64_t at_;  // the next packet
  std::vector<std::byte> bytes_;
  std::size_t next_byte_ = 0;
  // What is left of the byte that is being read, the next bit lowest.
  unsigned byte_ = 0, byte_bits_ = 0;
  std::vector<std::uint64_t> raw_;
};

}  // namespace tessera

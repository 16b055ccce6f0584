// Files over HTTP: validators, conditions and single byte ranges (RFC 9110, 13 and 14).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "src/service/http/message.h"
#include "src/service/reply.h"

namespace tessera::service::http {

struct ByteRange {
  std::uint64_t offset = 0, bytes = 0;
  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

enum class RangeKind : std::uint8_t { whole, part, unsatisfiable };
struct RangeFound {
  RangeKind kind = RangeKind::whole;
  ByteRange range;
};

// The range that "Range: `header`" selects of `size` bytes. Anything but a single byte range means the whole file.
RangeFound find_range(std::string_view header, std::uint64_t size);

// True if a list of If-None-Match or If-Match contains the entity tag. With `weakly`, W/ is ignored.
bool names_tag(std::string_view list, std::string_view etag, bool weakly);

// The answer to GET or HEAD of a file: 200, 206, 304, 412 or 416. Takes over the descriptor.
Answer file_answer(const Request& request, const ServedFile& served);

}  // namespace tessera::service::http

// Files over HTTP: validators, conditions and one range of bytes (RFC 9110, 13 and 14).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "src/service/http/message.h"
#include "src/service/service.h"

namespace tessera::http {

struct ByteRange {
  std::uint64_t offset = 0, bytes = 0;
  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

enum class RangeKind : std::uint8_t { whole, part, unsatisfiable };
struct RangeFound {
  RangeKind kind = RangeKind::whole;
  ByteRange range;
};

// What "Range: `header`" asks of `size` bytes. Whatever is no single range of bytes is not understood: the whole file.
RangeFound find_range(std::string_view header, std::uint64_t size);

// Whether a list of If-None-Match or If-Match names that entity tag; `weakly`: W/ is ignored.
bool names_tag(std::string_view list, std::string_view etag, bool weakly);

// The answer to GET or HEAD of a file: 200, 206, 304, 412 or 416. Takes the descriptor.
Answer file_answer(const Request& request, const ServedFile& served);

}  // namespace tessera::http

// Names that strangers give, numbers of jobs, and times as text.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera {

// Whether a folder or file may be called so: 1 to 100 bytes of UTF-8 without '/', '\' and what is not printable
// (base/printable.h), and no dot first. Error usage, with the end of a sentence.
Status check_name(std::string_view name);

// "0193e1f0a2b4-0001-9f3a2b1c": milliseconds since 1970, a counter within one, 32 random bits. Sorted as texts they are
// in the order in which they were made, also when the clock is set back: then the last time is kept.
class JobIds {
 public:
  static bool is_id(std::string_view text);
  // Ids that are made from now on come after this one.
  void seen(std::string_view id);
  // Safe from one thread at a time.
  std::string next(std::chrono::system_clock::time_point now);

 private:
  std::uint64_t last_ms_ = 0;
  std::uint32_t last_count_ = 0;
};

// RFC 3339, UTC, milliseconds: "2026-11-22T08:40:28.123Z". What time_of() cannot read is 1970.
std::string time_text(std::chrono::system_clock::time_point time);
std::chrono::system_clock::time_point time_of(std::string_view text);

}  // namespace tessera

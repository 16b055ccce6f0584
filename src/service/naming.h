// Checks names that clients give, makes ids of jobs, and converts times to text.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera::service {

// Checks a name of a folder or file: 1 to 100 bytes of UTF-8, without '/', '\' and characters that are not printable
// (base/printable.h), and not beginning with a dot. Error usage, with the end of a sentence.
Status check_name(std::string_view name);

// Makes ids such as "0193e1f0a2b4-0001-9f3a2b1c": milliseconds since 1970, a counter within a millisecond, 32 random
// bits. Sorted as text, ids are in the order in which they were made. When the clock is set back, the last time is
// used.
class JobIds {
 public:
  static bool is_id(std::string_view text);
  // Makes later ids greater than this one.
  void seen(std::string_view id);
  // Not thread-safe.
  std::string next(std::chrono::system_clock::time_point now);

 private:
  std::uint64_t last_ms_ = 0;
  std::uint32_t last_count_ = 0;
};

// RFC 3339 in UTC with milliseconds: "2026-11-22T08:40:28.123Z". time_of() returns 1970 for a text that it cannot read.
std::string time_text(std::chrono::system_clock::time_point time);
std::chrono::system_clock::time_point time_of(std::string_view text);
// The text of a file's time.
std::string time_of_file(std::int64_t seconds, std::int64_t nanoseconds = 0);

}  // namespace tessera::service

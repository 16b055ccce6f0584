#include "src/service/naming.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <random>

#include "src/base/printable.h"
#include "src/base/utf8.h"

namespace tessera::service {
namespace {

using Clock = std::chrono::system_clock;

constexpr std::size_t ms_digits = 12, count_digits = 4, random_digits = 8;

std::uint64_t hexadecimal(std::string_view digits) {
  std::uint64_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  return value;
}

}  // namespace

Status check_name(std::string_view name) {
  constexpr std::size_t bytes_max = 100;
  if (name.empty()) return error(Errc::usage, "is empty");
  if (name.size() > bytes_max) return error(Errc::usage, "is longer than " + std::to_string(bytes_max) + " bytes");
  if (!is_utf8(name)) return error(Errc::usage, "is not UTF-8");
  if (name.front() == '.') return error(Errc::usage, "begins with a dot");
  if (name.find_first_of("/\\") != std::string_view::npos) return error(Errc::usage, "holds a slash or backslash");
  if (printable(name) != name)
    return error(Errc::usage, "holds a control character, or a character that changes the direction of text");
  return success();
}

bool JobIds::is_id(std::string_view text) {
  constexpr std::size_t first = ms_digits, second = first + 1 + count_digits, end = second + 1 + random_digits;
  if (text.size() != end || text[first] != '-' || text[second] != '-') return false;
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return c == '-' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); }) &&
         std::count(text.begin(), text.end(), '-') == 2;
}

void JobIds::seen(std::string_view id) {
  if (!is_id(id)) return;
  const auto ms = hexadecimal(id.substr(0, ms_digits));
  const auto count = static_cast<std::uint32_t>(hexadecimal(id.substr(ms_digits + 1, count_digits)));
  if (ms < last_ms_ || (ms == last_ms_ && count <= last_count_)) return;
  last_ms_ = ms;
  last_count_ = count;
}

std::string JobIds::next(Clock::time_point now) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
  if (ms > 0 && static_cast<std::uint64_t>(ms) > last_ms_) {
    last_ms_ = static_cast<std::uint64_t>(ms);
    last_count_ = 0;
  } else if (++last_count_ > 0xffff) {
    ++last_ms_;
    last_count_ = 0;
  }
  static thread_local std::random_device random;
  char text[64];
  std::snprintf(text, sizeof text, "%012llx-%04x-%08x", static_cast<unsigned long long>(last_ms_), last_count_,
                static_cast<unsigned>(random()));
  return text;
}

std::string time_text(Clock::time_point time) {
  const auto ms = std::chrono::floor<std::chrono::milliseconds>(time.time_since_epoch()).count();
  const auto seconds = static_cast<std::time_t>(ms >= 0 ? ms / 1000 : (ms - 999) / 1000);
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[96];
  std::snprintf(text, sizeof text, "%04d-%02d-%02dT%02d:%02d:%02d.%03dZ", parts.tm_year + 1900, parts.tm_mon + 1,
                parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec,
                static_cast<int>(ms - static_cast<long long>(seconds) * 1000));
  return text;
}

Clock::time_point time_of(std::string_view text) {
  std::tm parts{};
  int ms = 0;
  if (std::sscanf(std::string(text).c_str(), "%4d-%2d-%2dT%2d:%2d:%2d.%3dZ", &parts.tm_year, &parts.tm_mon,
                  &parts.tm_mday, &parts.tm_hour, &parts.tm_min, &parts.tm_sec, &ms) != 7)
    return {};
  parts.tm_year -= 1900;
  parts.tm_mon -= 1;
  return Clock::from_time_t(::timegm(&parts)) + std::chrono::milliseconds(ms);
}

std::string time_of_file(std::int64_t seconds, std::int64_t nanoseconds) {
  return time_text(std::chrono::system_clock::from_time_t(seconds) +
                   std::chrono::milliseconds(nanoseconds / 1'000'000));
}

}  // namespace tessera::service

#include "src/base/printable.h"

#include <algorithm>
#include <cstddef>

#include "src/base/utf8.h"

namespace tessera {
namespace {

std::string replaced(std::string_view text, bool lines) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const bool is_space = text[0] >= '\t' && text[0] <= '\r';
    if (is_printable(text, length) || (lines && text[0] == '\n'))
      clean += text.substr(0, length);
    else
      clean += is_space ? ' ' : '?';
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return clean;
}

}  // namespace

bool is_printable(std::string_view text, std::size_t length) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (length == 0) return false;
  if (length == 1) return at(0) >= 0x20 && at(0) != 0x7F;
  const char32_t second = at(1) & 0x3Fu;
  if (length == 2) {
    const char32_t point = (at(0) & 0x1Fu) << 6 | second;
    return point >= 0xA0 && point != 0x061C;
  }
  if (length != 3) return true;
  const char32_t point = (at(0) & 0x0Fu) << 12 | second << 6 | (at(2) & 0x3Fu);
  const auto is_in = [point](char32_t first, char32_t last) { return point >= first && point <= last; };
  return !is_in(0x200E, 0x200F) && !is_in(0x2028, 0x202E) && !is_in(0x2066, 0x2069);
}

std::string printable(std::string_view text) { return replaced(text, false); }

std::string printable_lines(std::string_view text) { return replaced(text, true); }

std::string in_quotes(std::string_view text) {
  constexpr std::size_t bytes_max = 40;
  return "'" + printable(text.substr(0, bytes_max)) + (text.size() > bytes_max ? "..." : "") + "'";
}

}  // namespace tessera

#include "src/input/bytes/number.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace tessera {
namespace {

// Whether a number that is "out of range" for from_chars is too large. The decimal exponent of the first digit that is
// not 0 decides. Out of range means below 10^-300 or above 10^300, so the sign of this exponent is enough.
bool is_huge(std::string_view text) {
  const std::size_t e = text.find_first_of("eE");
  long long exponent = 0;
  if (e != std::string_view::npos) {
    std::string_view digits = text.substr(e + 1);
    if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
    if (code == std::errc::result_out_of_range) return digits.front() != '-';
  }
  const std::string_view mantissa = text.substr(0, e);
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  const std::size_t first = mantissa.find_first_of("123456789");
  if (first == std::string_view::npos) return false;
  const auto position = static_cast<long long>(point) - static_cast<long long>(first);
  // This cannot overflow: a text is far shorter than 2^62, and an exponent near the limits decides alone.
  if (exponent > (1LL << 62)) return true;
  if (exponent < -(1LL << 62)) return false;
  return exponent + position > 0;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || code == std::errc::invalid_argument) return std::nullopt;
  if (code == std::errc::result_out_of_range) {
    value = is_huge(text) ? std::numeric_limits<double>::infinity() : 0.0;
    if (text.front() == '-') value = -value;
  }
  return value;
}

}  // namespace tessera

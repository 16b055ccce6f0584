#include "src/service/http/target.h"

#include <algorithm>
#include <cstddef>

#include "src/base/utf8.h"

namespace tessera::service::http {
namespace {

constexpr std::size_t parameters_max = 32;

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool is_encoded_at(std::string_view text, std::size_t at) {
  return text[at] == '%' && at + 2 < text.size() && hex_value(text[at + 1]) >= 0 && hex_value(text[at + 2]) >= 0;
}

Error refused(const char* what) { return error(Errc::usage, std::string("the address ") + what); }

Result<std::string> decode(std::string_view text, bool in_query) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '%') {
      if (!is_encoded_at(text, at)) return refused("has a '%' that is not followed by two hexadecimal digits");
      decoded += static_cast<char>(hex_value(text[at + 1]) * 16 + hex_value(text[at + 2]));
      at += 2;
    } else {
      decoded += in_query && text[at] == '+' ? ' ' : text[at];
    }
  }
  if (std::any_of(decoded.begin(), decoded.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
    return refused("has a control character");
  if (!is_utf8(decoded)) return refused("is not UTF-8");
  return decoded;
}

Result<std::string> decode_segment(std::string_view text) {
  BOOST_OUTCOME_TRY(segment, decode(text, false));
  if (segment == "." || segment == "..") return refused("has a '.' or '..' segment");
  if (segment.find_first_of("/\\") != std::string::npos) return refused("has an encoded slash or a backslash");
  for (std::size_t at = 0; at < segment.size(); ++at)
    if (is_encoded_at(segment, at)) return refused("is encoded twice");
  return std::move(segment);
}

Status parse_query(std::string_view text, Target& target) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('&'), text.size());
    const std::string_view pair = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (pair.empty()) continue;
    const std::size_t equals = std::min(pair.find('='), pair.size());
    BOOST_OUTCOME_TRY(name, decode(pair.substr(0, equals), true));
    BOOST_OUTCOME_TRY(value, decode(pair.substr(std::min(equals + 1, pair.size())), true));
    if (target.parameter(name)) return refused("has a parameter twice");
    if (target.query.size() == parameters_max) return refused("has more than 32 parameters");
    target.query.emplace_back(std::move(name), std::move(value));
  }
  return success();
}

}  // namespace

std::optional<std::string_view> Target::parameter(std::string_view name) const {
  for (const auto& [key, value] : query)
    if (key == name) return value;
  return std::nullopt;
}

Result<Target> parse_target(std::string_view text) {
  if (text.empty() || text[0] != '/') return refused("must begin with a slash");
  if (text.find('#') != std::string_view::npos) return refused("has a '#'");
  Target target;
  const std::size_t question = std::min(text.find('?'), text.size());
  target.path = text.substr(0, question);
  std::string_view rest = std::string_view(target.path).substr(1);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('/'), rest.size());
    if (end == 0) return refused("has an empty segment");
    BOOST_OUTCOME_TRY(segment, decode_segment(rest.substr(0, end)));
    target.segments.push_back(std::move(segment));
    if (end + 1 == rest.size()) return refused("ends with a slash");
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (question < text.size()) {
    BOOST_OUTCOME_TRYV(parse_query(text.substr(question + 1), target));
  }
  return target;
}

std::string encode_segment(std::string_view text) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       std::string_view("-._~").find(c) != std::string_view::npos;
    if (plain) {
      encoded += c;
    } else {
      encoded += '%';
      encoded += digits[byte >> 4];
      encoded += digits[byte & 15];
    }
  }
  return encoded;
}

std::string relative_reference(std::string_view from, std::string_view to) {
  // The common beginning up to a slash is left out; each further part of `from` becomes "..".
  std::size_t common = 0;
  for (std::size_t at = 0; at < from.size() && at < to.size() && from[at] == to[at]; ++at)
    if (from[at] == '/') common = at + 1;
  std::string reference;
  for (std::size_t at = common; at < from.size(); ++at)
    if (from[at] == '/') reference += "../";
  reference += to.substr(common);
  // An empty first segment, or one with a colon, would have another meaning (RFC 3986, 4.2).
  const std::size_t colon = reference.find(':');
  if (reference.empty() || colon < reference.find('/')) reference.insert(0, "./");
  return reference;
}

}  // namespace tessera::service::http

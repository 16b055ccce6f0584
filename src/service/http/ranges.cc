#include "src/service/http/ranges.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <utility>

namespace tessera::service::http {
namespace {

// A number of digits only. Too large a number becomes the largest one, which is beyond the end of every file.
std::optional<std::uint64_t> number(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  std::uint64_t value = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc()) return UINT64_MAX;
  return value;
}

std::string quoted_range(const ByteRange& range, std::uint64_t size) {
  return "bytes " + std::to_string(range.offset) + "-" + std::to_string(range.offset + range.bytes - 1) + "/" +
         std::to_string(size);
}

}  // namespace

RangeFound find_range(std::string_view header, std::uint64_t size) {
  constexpr std::string_view unit = "bytes=";
  if (!header.starts_with(unit)) return {};
  header.remove_prefix(unit.size());
  const std::size_t dash = header.find('-');
  if (dash == std::string_view::npos) return {};
  const std::string_view first = header.substr(0, dash), last = header.substr(dash + 1);
  const std::optional<std::uint64_t> begin = number(first), end = number(last);
  if ((!begin && !first.empty()) || (!end && !last.empty()) || (!begin && !end)) return {};
  if (!begin) {  // the last bytes
    const std::uint64_t bytes = std::min(*end, size);
    if (bytes == 0) return {RangeKind::unsatisfiable, {}};
    return {RangeKind::part, {size - bytes, bytes}};
  }
  if (end && *end < *begin) return {};
  if (*begin >= size) return {RangeKind::unsatisfiable, {}};
  const std::uint64_t stop = end ? std::min(*end, size - 1) : size - 1;
  return {RangeKind::part, {*begin, stop - *begin + 1}};
}

bool names_tag(std::string_view list, std::string_view etag, bool weakly) {
  if (etag.empty()) return false;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    std::string_view tag = list.substr(0, comma);
    list.remove_prefix(std::min(comma + 1, list.size()));
    while (!tag.empty() && tag.front() == ' ') tag.remove_prefix(1);
    while (!tag.empty() && tag.back() == ' ') tag.remove_suffix(1);
    if (tag == "*") return true;
    if (weakly && tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == etag) return true;
  }
  return false;
}

Answer file_answer(const Request& request, const ServedFile& served) {
  FileHandle file(served.descriptor);
  if (const std::string_view match = request.header("if-match");
      !match.empty() && !names_tag(match, served.etag, false))
    return problem(412, "the file has another ETag than those of If-Match");
  Answer answer;
  answer.headers.emplace_back("Accept-Ranges", "bytes");
  if (!served.etag.empty()) {
    answer.headers.emplace_back("ETag", served.etag);
    // A file with this ETag never changes, but another file may get this name.
    answer.headers.emplace_back("Cache-Control", "private, no-cache");
  } else {
    answer.headers.emplace_back("Cache-Control", "no-store");
  }
  if (names_tag(request.header("if-none-match"), served.etag, true)) {
    answer.status = 304;
    return answer;
  }
  answer.headers.emplace_back("Content-Type", served.type);
  const std::string_view only_if = request.header("if-range");
  RangeFound found;
  // A date in If-Range never matches, because there is no Last-Modified.
  if (only_if.empty() || (!served.etag.empty() && only_if == served.etag))
    found = find_range(request.header("range"), served.bytes);
  if (found.kind == RangeKind::unsatisfiable) {
    Answer refused = problem(416, "the file has " + std::to_string(served.bytes) + " bytes");
    refused.headers.emplace_back("Content-Range", "bytes */" + std::to_string(served.bytes));
    return refused;
  }
  ByteRange range{0, served.bytes};
  if (found.kind == RangeKind::part) {
    range = found.range;
    answer.status = 206;
    answer.headers.emplace_back("Content-Range", quoted_range(range, served.bytes));
  }
  answer.file = FilePart{std::move(file), range.offset, range.bytes};
  return answer;
}

}  // namespace tessera::service::http

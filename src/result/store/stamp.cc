#include "src/result/store/stamp.h"

#include <charconv>

#include "src/result/store/digest.h"

namespace tessera {

namespace {

constexpr std::string_view before_version = "result: version ", before_digest = ", digest ";

// Reads what comment_of() has written.
std::optional<ResultStamp> parse_comment(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (!line.starts_with(before_version)) return std::nullopt;
  line.remove_prefix(before_version.size());
  ResultStamp stamp;
  const auto [end, wrong] = std::from_chars(line.data(), line.data() + line.size(), stamp.version);
  if (wrong != std::errc()) return std::nullopt;
  line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  if (line.empty()) return stamp;
  if (!line.starts_with(before_digest)) return std::nullopt;
  line.remove_prefix(before_digest.size());
  if (!parse_digest(line)) return std::nullopt;
  stamp.digest = line;
  return stamp;
}

}  // namespace

ResultStamp stamp_of(const Manifest& manifest) {
  return {.version = manifest.version, .digest = manifest.digest ? digest_text(*manifest.digest) : ""};
}

std::string comment_of(const ResultStamp& stamp) {
  return std::string(before_version) + std::to_string(stamp.version) +
         (stamp.digest.empty() ? "" : std::string(before_digest) + stamp.digest);
}

std::optional<ResultStamp> stamp_in_comments(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) break;  // the line may be cut off
    for (const std::string_view mark : {"comment ", "# "}) {
      const std::string_view line = text.substr(0, end);
      if (!line.starts_with(mark)) continue;
      if (auto stamp = parse_comment(line.substr(mark.size()))) return stamp;
    }
    text.remove_prefix(end + 1);
  }
  return std::nullopt;
}

MetadataItems metadata_of(const ResultStamp& stamp, const std::optional<ResultStamp>& lower) {
  MetadataItems items{{"RESULT_VERSION", std::to_string(stamp.version)}};
  if (!stamp.digest.empty()) items.emplace_back("RESULT_DIGEST", stamp.digest);
  if (!lower) return items;
  for (const auto& [name, value] : metadata_of(*lower)) items.emplace_back("LOWER_" + name, value);
  return items;
}

std::string json_of(const ResultStamp& stamp) {
  return "{\"version\":" + std::to_string(stamp.version) +
         (stamp.digest.empty() ? "" : ",\"digest\":\"" + stamp.digest + "\"") + "}";
}

}  // namespace tessera

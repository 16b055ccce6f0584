#include "src/input/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::size_t header_bytes_max = std::size_t{256} << 10;
constexpr std::size_t properties_max = 4096;

std::optional<AttributeType> type_named(std::string_view name) {
  using enum AttributeType;
  constexpr std::array<std::pair<std::string_view, AttributeType>, 18> names{{{"char", i8},
                                                                              {"int8", i8},
                                                                              {"uchar", u8},
                                                                              {"uint8", u8},
                                                                              {"short", i16},
                                                                              {"int16", i16},
                                                                              {"ushort", u16},
                                                                              {"uint16", u16},
                                                                              {"int", i32},
                                                                              {"int32", i32},
                                                                              {"uint", u32},
                                                                              {"uint32", u32},
                                                                              {"float", f32},
                                                                              {"float32", f32},
                                                                              {"double", f64},
                                                                              {"float64", f64},
                                                                              {"int64", i64},
                                                                              {"uint64", u64}}};
  for (const auto& [known, type] : names)
    if (known == name) return type;
  return std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

// Reads a header line. Returns what is wrong with it, or "".
std::string take_format(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() != 3) return "a format line has 3 words";
  if (words[1] == "ascii")
    header.format = PlyFormat::ascii;
  else if (words[1] == "binary_little_endian")
    header.format = PlyFormat::binary_little_endian;
  else if (words[1] == "binary_big_endian")
    header.format = PlyFormat::binary_big_endian;
  else
    return "format '" + printable(words[1]) + "' is not known";
  return words[2] == "1.0" ? "" : "PLY version '" + printable(words[2]) + "' is not known; 1.0 is";
}

std::string take_element(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() != 3) return "an element line has 3 words";
  PlyElement element{.name = std::string(words[1]), .count = 0, .properties = {}};
  const auto [end, code] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
  if (code != std::errc() || end != words[2].data() + words[2].size())
    return "'" + printable(words[2]) + "' is not a number of elements";
  header.elements.push_back(std::move(element));
  return "";
}

std::string take_property(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (header.elements.empty()) return "a property stands before any element";
  const bool list = words.size() > 1 && words[1] == "list";
  if (words.size() != (list ? 5u : 3u)) return "a property line has 3 words, or 5 for a list";
  PlyProperty property;
  property.name = std::string(words.back());
  const auto type = type_named(words[words.size() - 2]);
  if (!type) return "type '" + printable(words[words.size() - 2]) + "' is not known";
  property.type = *type;
  if (list) {
    property.count = type_named(words[2]);
    if (!property.count || *property.count == AttributeType::f32 || *property.count == AttributeType::f64)
      return "'" + printable(words[2]) + "' cannot be the type of a list's length";
  }
  auto& properties = header.elements.back().properties;
  if (properties.size() == properties_max)
    return "an element has more than " + std::to_string(properties_max) + " properties";
  properties.push_back(std::move(property));
  return "";
}

}  // namespace

std::optional<std::size_t> PlyElement::fixed_bytes() const {
  std::size_t bytes = 0;
  for (const auto& property : properties) {
    if (property.count) return std::nullopt;
    bytes += size_of(property.type);
  }
  return bytes;
}

Result<PlyHeader> read_ply_header(const ByteSource& source) {
  std::string text(static_cast<std::size_t>(std::min<std::uint64_t>(header_bytes_max, source.size())), '\0');
  BOOST_OUTCOME_TRYV(source.read(0, std::as_writable_bytes(std::span(text))));
  PlyHeader header;
  bool has_format = false;
  std::size_t at = 0;
  while (true) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos)
      return error(Errc::bad_input, source.path().string() + ": is not a PLY file, or ends within its header");
    const auto words = words_of(std::string_view(text).substr(at, end - at));
    at = end + 1;
    ++header.lines;
    const auto bad = [&](const std::string& what) {
      return error(Errc::bad_input, source.path().string() + ", line " + std::to_string(header.lines) + ": " + what);
    };
    if (header.lines == 1) {
      if (words.size() != 1 || words[0] != "ply") return bad("a PLY file begins with 'ply'");
      continue;
    }
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    std::string wrong = "'" + printable(words[0].substr(0, 40)) + "' is not a PLY header line";
    if (words[0] == "format") {
      wrong = take_format(words, header);
      has_format = true;
    }
    if (words[0] == "element") wrong = take_element(words, header);
    if (words[0] == "property") wrong = take_property(words, header);
    if (!wrong.empty()) return bad(wrong);
  }
  header.body_at = at;
  if (!has_format) return error(Errc::bad_input, source.path().string() + ": the PLY header has no format line");
  const auto vertex = std::find_if(header.elements.begin(), header.elements.end(),
                                   [](const PlyElement& e) { return e.name == "vertex"; });
  if (vertex == header.elements.end())
    return error(Errc::bad_input, source.path().string() + ": the PLY header has no element 'vertex'");
  header.vertex = static_cast<std::size_t>(vertex - header.elements.begin());
  return header;
}

}  // namespace tessera

#include "src/input/e57/e57_header.h"

#include <expat.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"
#include "src/input/bytes/number.h"

namespace tessera {
namespace {

constexpr std::size_t file_header_bytes = 48;
constexpr std::uint64_t xml_bytes_max = std::uint64_t{64} << 20;
constexpr std::size_t depth_max = 64, scans_max = 1'000'000, fields_max = 4096;

std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

// The attributes of an element, as Expat gives them: names and values in turn.
class XmlAttributes {
 public:
  explicit XmlAttributes(const char** list) : list_(list) {}
  std::optional<std::string_view> find(std::string_view name) const {
    for (const char** at = list_; *at != nullptr; at += 2)
      if (name == at[0]) return at[1];
    return std::nullopt;
  }

 private:
  const char** list_;
};

// Takes the elements of the XML section one after the other.
class ScanList {
 public:
  void begin(const char* name, const XmlAttributes& attributes) {
    path_.append("/").append(name);
    text_.clear();
    if (++depth_ > depth_max) return fail("elements are nested more than " + std::to_string(depth_max) + " deep");
    if (path_ == "/e57Root/data3D/vectorChild") {
      if (header_.scans.size() == scans_max) return fail("there are more than " + std::to_string(scans_max) + " scans");
      header_.scans.emplace_back();
      scan().number = header_.scans.size() - 1;
    } else if (path_ == points) {
      take_points(attributes);
    } else if (path_.starts_with(prototype) && path_.find('/', prototype.size()) == std::string::npos) {
      take_field(name, attributes);
    } else if (path_.starts_with(prototype)) {
      fail("field " + in_quotes(scan().fields.back().name) + " has parts, which is not read");
    }
  }
  void text(std::string_view part) {
    if (is_wanted()) text_ += part;
  }
  void end(std::string_view name) {
    constexpr std::string_view rotation = "/e57Root/data3D/vectorChild/pose/rotation/";
    constexpr std::string_view translation = "/e57Root/data3D/vectorChild/pose/translation/";
    if (path_.starts_with(rotation)) {
      scan().posed = true;  // also without a translation: then the scanner was at the origin
      take_number(std::string_view("wxyz").find(name), scan().rotation.data(), 4);
    } else if (path_.starts_with(translation)) {
      scan().posed = true;
      take_number(std::string_view("xyz").find(name), scan().translation.data(), 3);
    } else if (path_ == "/e57Root/coordinateMetadata") {
      header_.crs = text_;
    }
    path_.resize(path_.size() - name.size() - 1);
    --depth_;
  }
  void fail(std::string what) {
    if (wrong_.empty()) wrong_ = std::move(what);
  }
  const std::string& wrong() const { return wrong_; }
  E57Header& header() { return header_; }

 private:
  static constexpr std::string_view points = "/e57Root/data3D/vectorChild/points";
  static constexpr std::string_view prototype = "/e57Root/data3D/vectorChild/points/prototype/";

  bool is_wanted() const {
    return path_.starts_with("/e57Root/data3D/vectorChild/pose/") || path_ == "/e57Root/coordinateMetadata";
  }
  E57Scan& scan() { return header_.scans.back(); }

  // An empty element is the number 0.
  void take_number(std::size_t index, double* numbers, std::size_t count) {
    if (index >= count) return;
    const auto number = text_.empty() ? std::optional(0.0) : parse_number(text_);
    if (!number || !std::isfinite(*number))
      return fail("the pose of scan " + std::to_string(scan().number) + " has " + in_quotes(text_) +
                  ", which is not a finite number");
    numbers[index] = *number;
  }

  void take_points(const XmlAttributes& attributes) {
    const auto offset = attributes.find("fileOffset"), count = attributes.find("recordCount");
    const auto at = offset ? whole_number(*offset) : std::nullopt,
               records = count ? whole_number(*count) : std::nullopt;
    if (!at || *at < 0 || !records || *records < 0)
      return fail("the points of scan " + std::to_string(scan().number) + " have no valid fileOffset and recordCount");
    scan().points_at = static_cast<std::uint64_t>(*at);
    scan().records = static_cast<std::uint64_t>(*records);
  }

  void take_field(const char* name, const XmlAttributes& attributes) {
    if (scan().fields.size() == fields_max)
      return fail("a record has more than " + std::to_string(fields_max) + " fields");
    E57Field field;
    field.name = name;
    const auto type = attributes.find("type").value_or("");
    if (type == "Float")
      field.kind = attributes.find("precision") == "single" ? E57Field::Kind::single : E57Field::Kind::real;
    else if (type == "Integer")
      field.kind = E57Field::Kind::integer;
    else if (type == "ScaledInteger")
      field.kind = E57Field::Kind::scaled;
    else if (type == "String")
      field.kind = E57Field::Kind::text;
    else
      return fail("field " + in_quotes(name) + " has the unknown type " + in_quotes(type));
    if (field.kind == E57Field::Kind::integer || field.kind == E57Field::Kind::scaled) take_range(attributes, field);
    scan().fields.push_back(std::move(field));
  }

  void take_range(const XmlAttributes& attributes, E57Field& field) {
    const auto bad = [&](const char* what) { fail("field " + in_quotes(field.name) + " has no valid " + what); };
    if (const auto text = attributes.find("minimum")) {
      const auto number = whole_number(*text);
      if (!number) return bad("minimum");
      field.minimum = *number;
    }
    if (const auto text = attributes.find("maximum")) {
      const auto number = whole_number(*text);
      if (!number || *number < field.minimum) return bad("maximum");
      field.maximum = *number;
    }
    if (const auto text = attributes.find("scale")) {
      const auto number = parse_number(*text);
      if (!number || !std::isfinite(*number)) return bad("scale");
      field.scale = *number;
    }
    if (const auto text = attributes.find("offset")) {
      const auto number = parse_number(*text);
      if (!number || !std::isfinite(*number)) return bad("offset");
      field.offset = *number;
    }
  }

  E57Header header_;
  std::string path_, text_, wrong_;
  std::size_t depth_ = 0;
};

// Feeds the section to Expat in blocks. Returns what is wrong with the XML, or "".
Result<std::string> parse(E57Pages& pages, std::uint64_t at, std::uint64_t bytes, ScanList& list) {
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                                             &XML_ParserFree);
  if (!parser) return error(Errc::memory, "no memory for reading XML");
  XML_SetUserData(parser.get(), &list);
  XML_SetElementHandler(
      parser.get(),
      [](void* to, const char* name, const char** attributes) {
        static_cast<ScanList*>(to)->begin(name, XmlAttributes(attributes));
      },
      [](void* to, const char* name) { static_cast<ScanList*>(to)->end(name); });
  XML_SetCharacterDataHandler(parser.get(), [](void* to, const char* text, int length) {
    static_cast<ScanList*>(to)->text({text, static_cast<std::size_t>(length)});
  });
  // A document type could define entities. E57 has none.
  XML_SetStartDoctypeDeclHandler(parser.get(), [](void* to, const char*, const char*, const char*, int) {
    static_cast<ScanList*>(to)->fail("it has a document type, which E57 does not have");
  });
  std::vector<char> block(std::size_t{1} << 16);
  while (bytes > 0 && list.wrong().empty()) {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), bytes));
    BOOST_OUTCOME_TRYV(pages.read(at, std::as_writable_bytes(std::span(block).first(n))));
    at += n;
    bytes -= n;
    // Writers pad the section with blanks, and some with zeros.
    std::size_t used = n;
    if (bytes == 0)
      while (used > 0 && block[used - 1] == '\0') --used;
    if (XML_Parse(parser.get(), block.data(), static_cast<int>(used), bytes == 0 ? XML_TRUE : XML_FALSE) ==
            XML_STATUS_ERROR &&
        list.wrong().empty())
      return "line " + std::to_string(XML_GetCurrentLineNumber(parser.get())) +
             " is not well formed: " + XML_ErrorString(XML_GetErrorCode(parser.get()));
  }
  return list.wrong();
}

}  // namespace

unsigned E57Field::bits() const {
  if (kind == Kind::single) return 32;
  if (kind == Kind::real) return 64;
  const auto range = static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum);
  return static_cast<unsigned>(std::bit_width(range));
}

Result<std::size_t> e57_page_bytes(const ByteSource& source) {
  const auto bad = [&](const std::string& what) {
    return error(Errc::bad_input, source.path().string() + ": " + what);
  };
  std::array<std::byte, file_header_bytes> header{};
  if (source.size() < header.size()) return bad("ends within the header of an E57 file");
  BOOST_OUTCOME_TRYV(source.read(0, header));
  if (std::memcmp(header.data(), "ASTM-E57", 8) != 0) return bad("is not an E57 file");
  const auto major = load<std::uint32_t>(header.data() + 8);
  if (major != 1) return bad("is of E57 version " + std::to_string(major) + "; version 1 is read");
  const auto length = load<std::uint64_t>(header.data() + 16), page = load<std::uint64_t>(header.data() + 40);
  if (page != 1024) return bad("has pages of " + std::to_string(page) + " bytes; E57 has pages of 1024");
  if (length != source.size() || length % page != 0)
    return bad("has " + std::to_string(source.size()) + " bytes, but its header promises " + std::to_string(length));
  return static_cast<std::size_t>(page);
}

Result<E57Header> read_e57_header(E57Pages& pages) {
  const std::string path = pages.source().path().string();
  const auto bad = [&](const std::string& what) { return error(Errc::bad_input, path + ": " + what); };
  std::array<std::byte, file_header_bytes> header{};
  BOOST_OUTCOME_TRYV(pages.read(0, header));
  const auto xml_at = load<std::uint64_t>(header.data() + 24), xml_bytes = load<std::uint64_t>(header.data() + 32);
  if (xml_bytes > xml_bytes_max)
    return bad("its XML section has " + std::to_string(xml_bytes) + " bytes; at most " + std::to_string(xml_bytes_max) +
               " are read");
  ScanList list;
  BOOST_OUTCOME_TRY(wrong, parse(pages, pages.logical(xml_at), xml_bytes, list));
  if (!wrong.empty()) return bad("in its XML section, " + wrong);
  for (const auto& scan : list.header().scans) {
    // A record takes at least a bit. Refusing here avoids that code waits for 2^60 points.
    if (scan.records > 8 * pages.size())
      return bad("scan " + std::to_string(scan.number) + " promises " + std::to_string(scan.records) +
                 " points, more than the file can hold");
  }
  return std::move(list.header());
}

}  // namespace tessera

#include "src/input/las/las_header.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "src/base/crs/geotiff.h"
#include "src/base/printable.h"
#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::size_t header_bytes_max = 375;
// Enough for any coordinate system. An extended record may claim to have 2^64 bytes.
constexpr std::uint64_t payload_bytes_max = 1 << 20;
constexpr std::array<std::uint16_t, 11> record_bytes_of_format{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

struct Projection {
  std::string wkt, other_wkt;
  std::vector<std::byte> directory, doubles, ascii;  // GeoTIFF keys
};

std::string_view text_of(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.substr(0, text.find('\0'));
}

Bounds declared_bounds(const std::byte* header) {
  Bounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.hi[axis] = load<double>(header + 179 + 16 * axis);
    bounds.lo[axis] = load<double>(header + 187 + 16 * axis);
    if (!std::isfinite(bounds.lo[axis]) || !std::isfinite(bounds.hi[axis]) || bounds.lo[axis] > bounds.hi[axis])
      return {};
  }
  return bounds;
}

// The standard fields of a point format. Wave packets, scan direction and scanner channel are left out.
std::vector<LasField> standard_fields(int format) {
  using enum AttributeType;
  std::vector<LasField> fields;
  const auto plain = [&](const char* name, AttributeType type, std::size_t offset) {
    fields.push_back({.attribute = {name, type}, .offset = offset, .stored = type});
  };
  const auto bits = [&](const char* name, std::size_t offset, unsigned shift, std::uint8_t mask) {
    fields.push_back({.attribute = {name, u8}, .offset = offset, .stored = u8, .shift = shift, .mask = mask});
  };
  const bool wide = format >= 6;
  plain("intensity", u16, 12);
  bits("return_number", 14, 0, wide ? 0x0F : 0x07);
  bits("number_of_returns", 14, wide ? 4 : 3, wide ? 0x0F : 0x07);
  bits("classification", wide ? 16 : 15, 0, wide ? 0xFF : 0x1F);
  const unsigned flags = wide ? 0 : 5;
  bits("synthetic", 15, flags, 1);
  bits("key_point", 15, flags + 1, 1);
  bits("withheld", 15, flags + 2, 1);
  if (wide) bits("overlap", 15, 3, 1);
  // The angle in degrees: formats 0-5 have whole degrees, formats from 6 on have steps of 0.006.
  fields.push_back({.attribute = {"scan_angle", f32},
                    .offset = wide ? std::size_t{18} : 16,
                    .stored = wide ? i16 : i8,
                    .scale = wide ? 0.006 : 1});
  plain("user_data", u8, 17);
  plain("point_source_id", u16, wide ? 20 : 18);
  if (wide || format == 1 || format >= 3) plain("gps_time", f64, wide ? 22 : 20);
  std::size_t colour = 0;
  if (format == 2) colour = 20;
  if (format == 3 || format == 5) colour = 28;
  if (format == 7 || format == 8 || format == 10) colour = 30;
  if (colour != 0) {
    plain("red", u16, colour);
    plain("green", u16, colour + 2);
    plain("blue", u16, colour + 4);
  }
  if (format == 8 || format == 10) plain("nir", u16, 36);
  return fields;
}

// Adds the extra bytes. Their descriptors have 192 bytes each, in the order of the bytes that they describe. `offset`
// is that of the first extra byte, and becomes that of the next byte.
void add_extra_fields(std::span<const std::byte> descriptors, LasHeader& header, std::size_t& offset) {
  using enum AttributeType;
  constexpr std::array types{u8, i8, u16, i16, u32, i32, u64, i64, f32, f64};
  AttributeNames names;
  for (auto& field : header.fields) names.make(field.attribute.name);
  for (std::size_t at = 0; at + 192 <= descriptors.size(); at += 192) {
    const auto d = descriptors.subspan(at, 192);
    const unsigned kind = load<std::uint8_t>(d.data() + 2), options = load<std::uint8_t>(d.data() + 3);
    if (kind > 30) return;  // a reserved kind has an unknown size, so the offset of the next one is unknown
    const unsigned values = kind == 0 ? 1 : (kind - 1) / 10 + 1;
    const AttributeType type = types[kind == 0 ? 0 : (kind - 1) % 10];
    const std::size_t bytes = kind == 0 ? options : size_of(type) * values;
    if (offset + bytes > header.record_bytes) return;
    if (kind >= 1 && kind <= 10) {  // 11-30 are the deprecated pairs and triples, 0 is undocumented
      LasField field{.attribute = {names.make(text_of(d.subspan(4, 32))), type}, .offset = offset, .stored = type};
      const double scale = load<double>(d.data() + 112), add = load<double>(d.data() + 136);
      if ((options & 0x08) != 0 && std::isfinite(scale) && scale != 0) field.scale = scale;
      if ((options & 0x10) != 0 && std::isfinite(add)) field.add = add;
      if (!field.plain()) field.attribute.type = f64;
      header.fields.push_back(field);
    }
    offset += bytes;
  }
}

// Reads `count` records between `at` and `end`. A record has a head of 54 bytes (VLR) or 60 bytes (extended VLR).
class RecordWalk {
 public:
  RecordWalk(const ByteSource& source, LasHeader& header, Projection& projection)
      : source_(source),
        header_(header),
        projection_(projection),
        extra_at_(record_bytes_of_format[static_cast<std::size_t>(header.point_format)]) {}

  Status walk(std::uint64_t at, std::uint64_t end, std::uint64_t count, bool extended) {
    const std::size_t head_bytes = extended ? 60 : 54;
    const std::string kind = extended ? "extended variable length record " : "variable length record ";
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto bad = [&](const std::string& what) {
        return error(Errc::bad_input, source_.path().string() + ", " + kind + std::to_string(i) + " of " +
                                          std::to_string(count) + ": " + what);
      };
      if (at > end || end - at < head_bytes) return bad("lies outside the part of the file for such records");
      std::array<std::byte, 60> head{};
      BOOST_OUTCOME_TRYV(source_.read(at, std::span(head).first(head_bytes)));
      const std::uint64_t length =
          extended ? load<std::uint64_t>(head.data() + 20) : load<std::uint16_t>(head.data() + 20);
      at += head_bytes;
      if (length > end - at) return bad("claims " + std::to_string(length) + " bytes, more than there are");
      BOOST_OUTCOME_TRYV(
          take(text_of(std::span(head).subspan(2, 16)), load<std::uint16_t>(head.data() + 18), at, length));
      at += length;
    }
    return success();
  }

 private:
  Status take(std::string_view user, std::uint16_t id, std::uint64_t at, std::uint64_t length) {
    const bool projection = user == "LASF_Projection" && (id == 2112 || (id >= 34735 && id <= 34737));
    const bool other_wkt = user == "liblas" && id == 2112;
    const bool extra = user == "LASF_Spec" && id == 4;
    const bool laszip = user == "laszip encoded" && id == 22204;
    const bool copc = user == "copc" && id == 1;
    if (!(projection || other_wkt || extra || laszip || copc) || length > payload_bytes_max) return success();
    std::vector<std::byte> bytes(static_cast<std::size_t>(length));
    BOOST_OUTCOME_TRYV(source_.read(at, bytes));
    if (extra) add_extra_fields(bytes, header_, extra_at_);  // a second record continues where the first one ended
    if (projection && id == 34735) projection_.directory = bytes;
    if (projection && id == 34736) projection_.doubles = bytes;
    if (projection && id == 34737) projection_.ascii = bytes;
    if (projection && id == 2112) projection_.wkt = printable(text_of(bytes));
    if (other_wkt) projection_.other_wkt = printable(text_of(bytes));
    if (laszip)
      header_.laszip = std::move(bytes);
    else if (copc)
      header_.copc = std::move(bytes);
    return success();
  }

  const ByteSource& source_;
  LasHeader& header_;
  Projection& projection_;
  std::size_t extra_at_;
};

// Chooses the coordinate system. Well-known text is exact where GeoTIFF keys may be vague. A few writers store it under
// a name of their own.
void settle_crs(const Projection& projection, LasHeader& header) {
  // A few writers store two quotation marks as the text. The name of a system has letters or digits.
  const bool system = std::any_of(projection.wkt.begin(), projection.wkt.end(),
                                  [](unsigned char c) { return std::isalnum(c) != 0 || c >= 0x80; });
  if (system) header.crs = projection.wkt;
  if (header.crs.empty() && !projection.directory.empty()) {
    auto crs = crs_of({projection.directory, projection.doubles, projection.ascii});
    if (crs) {
      header.crs = printable(crs.value());
    } else {
      header.crs_note = "its GeoTIFF keys are not understood: " + printable(crs.error().where);
    }
  }
  if (header.crs.empty()) header.crs = projection.other_wkt;
  if (header.crs.empty() && !projection.wkt.empty() && header.crs_note.empty())
    header.crs_note = "its well-known text is not understood: " + projection.wkt + " is not a coordinate system";
}

// Scale and offset of each axis. The error: a sentence without the file's name.
Status read_axes(const std::byte* h, LasHeader& header) {
  const auto bad = [](const std::string& what) { return error(Errc::bad_input, what); };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.scale[axis] = load<double>(h + 131 + 8 * axis);
    header.offset[axis] = load<double>(h + 155 + 8 * axis);
    const std::string name(1, "xyz"[axis]);
    if (!std::isfinite(header.scale[axis]) || header.scale[axis] == 0)
      return bad("the scale of " + name + " is " + std::to_string(header.scale[axis]));
    if (!std::isfinite(header.offset[axis]))
      return bad("the offset of " + name + " is " + std::to_string(header.offset[axis]));
  }
  return success();
}

}  // namespace

std::uint16_t standard_record_bytes(int point_format) {
  return record_bytes_of_format[static_cast<std::size_t>(point_format)];
}

Result<LasHeader> read_las_header(const ByteSource& source) {
  const auto bad = [&](const std::string& what) {
    return error(Errc::bad_input, source.path().string() + ": " + what);
  };
  std::array<std::byte, header_bytes_max> h{};
  const auto there = static_cast<std::size_t>(std::min<std::uint64_t>(source.size(), h.size()));
  BOOST_OUTCOME_TRYV(source.read(0, std::span(h).first(there)));
  if (there < 4 || std::memcmp(h.data(), "LASF", 4) != 0)
    return bad("does not begin with LASF, so it is not a LAS file");
  if (there < 227) return bad("ends within the LAS header, after " + std::to_string(there) + " bytes");

  LasHeader header;
  const int major = load<std::uint8_t>(h.data() + 24);
  header.minor = load<std::uint8_t>(h.data() + 25);
  if (major != 1 || header.minor > 4)
    return bad("is LAS " + std::to_string(major) + "." + std::to_string(header.minor) + "; 1.0 to 1.4 are read");
  const auto header_bytes = load<std::uint16_t>(h.data() + 94);
  header.points_at = load<std::uint32_t>(h.data() + 96);
  const auto vlr_count = load<std::uint32_t>(h.data() + 100);
  unsigned format = load<std::uint8_t>(h.data() + 104);
  header.record_bytes = load<std::uint16_t>(h.data() + 105);

  const std::uint16_t header_bytes_min = header.minor == 4 ? 375 : header.minor == 3 ? 235 : 227;
  if (header_bytes < header_bytes_min)
    return bad("the LAS 1." + std::to_string(header.minor) + " header claims " + std::to_string(header_bytes) +
               " bytes, but it has at least " + std::to_string(header_bytes_min));
  if (header_bytes > source.size())
    return bad("ends within the LAS header of " + std::to_string(header_bytes) + " bytes");
  if (header.points_at < header_bytes || header.points_at > source.size())
    return bad("the header puts the points at byte " + std::to_string(header.points_at) + ", but the header is " +
               std::to_string(header_bytes) + " bytes long and the file " + std::to_string(source.size()));
  header.compressed = (format & 0x80u) != 0;
  format &= 0x7Fu;
  if (format > 10) return bad("point format " + std::to_string(format) + " is not known; 0 to 10 are");
  header.point_format = static_cast<int>(format);
  if (header.record_bytes < record_bytes_of_format[format])
    return bad("point records claim " + std::to_string(header.record_bytes) + " bytes, but those of format " +
               std::to_string(format) + " have at least " + std::to_string(record_bytes_of_format[format]));

  const std::uint64_t legacy_count = load<std::uint32_t>(h.data() + 107);
  header.points = legacy_count;
  if (header.minor == 4) {
    const auto count = load<std::uint64_t>(h.data() + 247);
    if (count != 0) header.points = count;
    if (count != 0 && legacy_count != 0 && count != legacy_count)
      return bad("the header gives two numbers of points, " + std::to_string(legacy_count) + " and " +
                 std::to_string(count));
  }
  if (const auto axes = read_axes(h.data(), header); !axes) return bad(axes.error().where);
  header.bounds = declared_bounds(h.data());
  header.fields = standard_fields(header.point_format);

  Projection projection;
  RecordWalk walk(source, header, projection);
  BOOST_OUTCOME_TRYV(walk.walk(header_bytes, header.points_at, vlr_count, false));
  if (header.minor == 4) {
    const auto evlr_at = load<std::uint64_t>(h.data() + 235);
    const auto evlr_count = load<std::uint32_t>(h.data() + 243);
    if (evlr_count != 0) {
      BOOST_OUTCOME_TRYV(walk.walk(evlr_at, source.size(), evlr_count, true));
    }
  }
  settle_crs(projection, header);
  return header;
}

}  // namespace tessera

#include "src/input/las_copy/extra_bytes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::size_t descriptor_bytes = 192, name_at = 4, name_bytes = 32, least_at = 64, greatest_at = 88,
                      description_at = 160;
constexpr std::byte has_least{2}, has_greatest{4};  // of the options of a descriptor
constexpr std::string_view spec_user = "LASF_Spec";
constexpr std::uint16_t extra_bytes_id = 4;

std::string_view name_of(const std::byte* descriptor) {
  const std::string_view name(reinterpret_cast<const char*>(descriptor + name_at), name_bytes);
  return name.substr(0, name.find('\0'));
}

// The bytes that a descriptor describes; none for a reserved kind.
std::optional<std::size_t> bytes_described(const std::byte* descriptor) {
  constexpr std::array<std::size_t, 10> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  const auto kind = load<std::uint8_t>(descriptor + 2), options = load<std::uint8_t>(descriptor + 3);
  if (kind == 0) return options;
  if (kind > 30) return std::nullopt;  // 11 to 30 are the deprecated pairs and triples
  return sizes[(kind - 1u) % 10] * ((kind - 1u) / 10 + 1);
}

std::vector<std::byte> descriptor_of(const ExtraDimension& dimension) {
  std::vector<std::byte> descriptor(descriptor_bytes);
  descriptor[2] = dimension.type == AttributeType::f32 ? std::byte{9} : std::byte{10};
  std::memcpy(descriptor.data() + name_at, dimension.name.data(), dimension.name.size());
  std::memcpy(descriptor.data() + description_at, dimension.description.data(), dimension.description.size());
  return descriptor;
}

class AddDimensions {
 public:
  AddDimensions(const ByteSource& source, const LasHeader& header, LasParts& parts,
                const std::vector<ExtraDimension>& dimensions, bool replace)
      : source_(source),
        header_(header),
        parts_(parts),
        dimensions_(dimensions),
        replace_(replace),
        offset_(standard_record_bytes(header.point_format)) {
    change_.kept.push_back({0, offset_});
  }

  Result<RecordChange> run() {
    for (const auto& dimension : dimensions_)
      if (dimension.name.empty() || dimension.name.size() > name_bytes || dimension.description.size() > name_bytes)
        return error(Errc::usage, "LAS permits no dimension of the name " + in_quotes(dimension.name) +
                                      " and the description " + in_quotes(dimension.description) +
                                      "; a name has 1 to 32 bytes, a description at most 32");
    for (auto* records : {&parts_.records, &parts_.extended})
      for (auto& record : *records)
        if (describes_extra_bytes(record)) {
          BOOST_OUTCOME_TRYV(walk(record));
        }
    std::vector<std::byte> added;
    describe_rest(added);
    std::size_t bytes = 0;
    for (const auto& piece : change_.kept) bytes += piece.bytes;
    for (const auto& dimension : dimensions_) {
      const auto descriptor = descriptor_of(dimension);
      added.insert(added.end(), descriptor.begin(), descriptor.end());
      bytes += size_of(dimension.type);
    }
    if (bytes > std::numeric_limits<std::uint16_t>::max())
      return bad("point records of " + std::to_string(bytes) +
                 " bytes would be longer than LAS permits, which is 65535");
    change_.record_bytes = static_cast<std::uint16_t>(bytes);
    BOOST_OUTCOME_TRYV(append(added));
    return change_;
  }

 private:
  Error bad(const std::string& what) const {
    return error(Errc::bad_input, source_.path().string() + ", extra bytes: " + what);
  }

  // Follows the descriptors of a record. A second record continues where the first one ended.
  Status walk(LasRecord& record) {
    BOOST_OUTCOME_TRY(old, read_payload(source_, record));
    std::vector<std::byte> left;
    std::size_t at = 0;
    for (; at + descriptor_bytes <= old.size(); at += descriptor_bytes) {
      const std::byte* descriptor = old.data() + at;
      const std::string name(name_of(descriptor));
      const auto bytes = bytes_described(descriptor);
      if (!bytes)
        return bad("the dimension " + in_quotes(name) + " is of kind " +
                   std::to_string(load<std::uint8_t>(descriptor + 2)) + ", whose size is not known; 0 to 30 are");
      if (*bytes > header_.record_bytes - offset_)
        return bad("the dimension " + in_quotes(name) + " ends behind the point record, which has " +
                   std::to_string(header_.record_bytes) + " bytes");
      const bool same = std::any_of(dimensions_.begin(), dimensions_.end(),
                                    [&](const auto& dimension) { return dimension.name == name; });
      if (same && !replace_) return bad("the points already have a dimension " + in_quotes(name));
      if (!same) {
        left.insert(left.end(), descriptor, descriptor + descriptor_bytes);
        keep(*bytes);
      }
      offset_ += *bytes;
    }
    left.insert(left.end(), old.begin() + static_cast<std::ptrdiff_t>(at), old.end());
    if (left.size() != old.size()) record.payload = std::move(left);
    last_ = &record;
    return success();
  }

  // Keeps the next bytes of point records.
  void keep(std::size_t bytes) {
    auto& last = change_.kept.back();
    if (last.at + last.bytes == offset_) {
      last.bytes += bytes;
    } else {
      change_.kept.push_back({offset_, bytes});
    }
  }

  // Descriptors of kind 0, which have no more than 255 bytes each, for the bytes that no descriptor describes.
  void describe_rest(std::vector<std::byte>& descriptors) {
    while (offset_ < header_.record_bytes) {
      const std::size_t bytes = std::min<std::size_t>(header_.record_bytes - offset_, 255);
      std::vector<std::byte> descriptor(descriptor_bytes);
      descriptor[3] = static_cast<std::byte>(bytes);
      descriptors.insert(descriptors.end(), descriptor.begin(), descriptor.end());
      keep(bytes);
      offset_ += bytes;
    }
  }

  // Appends descriptors to the last record of them, or makes the first record.
  Status append(const std::vector<std::byte>& descriptors) {
    if (last_ == nullptr) {
      parts_.records.push_back(new_record(spec_user, extra_bytes_id, "Extra Bytes Record", {}));
      last_ = &parts_.records.back();
    }
    BOOST_OUTCOME_TRY(payload, read_payload(source_, *last_));
    payload.resize(payload.size() / descriptor_bytes * descriptor_bytes);  // readers ignore the rest
    payload.insert(payload.end(), descriptors.begin(), descriptors.end());
    if (!last_->extended() && payload.size() > std::numeric_limits<std::uint16_t>::max())
      return bad("the record that describes them has no room for " + std::to_string(payload.size() / descriptor_bytes) +
                 " dimensions");
    last_->payload = std::move(payload);
    return success();
  }

  const ByteSource& source_;
  const LasHeader& header_;
  LasParts& parts_;
  const std::vector<ExtraDimension>& dimensions_;
  bool replace_;
  std::size_t offset_;  // of the first byte of a record that is not looked at yet
  RecordChange change_;
  LasRecord* last_ = nullptr;
};

}  // namespace

Result<RecordChange> add_dimensions(const ByteSource& source, const LasHeader& header, LasParts& parts,
                                    const std::vector<ExtraDimension>& dimensions, bool replace) {
  if (dimensions.empty()) return RecordChange{.kept = {{0, header.record_bytes}}, .record_bytes = header.record_bytes};
  return AddDimensions(source, header, parts, dimensions, replace).run();
}

bool describes_extra_bytes(const LasRecord& record) { return record.is(spec_user, extra_bytes_id); }

LasRecord& describe_ranges(LasParts& parts, std::span<const ValueRange> ranges) {
  LasRecord* last = nullptr;
  for (auto* records : {&parts.records, &parts.extended})
    for (auto& record : *records)
      if (describes_extra_bytes(record)) last = &record;
  auto& payload = *last->payload;
  std::size_t at = payload.size() - ranges.size() * descriptor_bytes;
  for (const auto& range : ranges) {
    if (range.any()) {
      payload[at + 3] |= has_least | has_greatest;
      store_at(payload, at + least_at, range.least);
      store_at(payload, at + greatest_at, range.greatest);
    }
    at += descriptor_bytes;
  }
  return *last;
}

}  // namespace tessera

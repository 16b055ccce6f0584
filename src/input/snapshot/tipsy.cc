#include "src/input/snapshot/tipsy.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/snapshot/snapshot_reader.h"

namespace tessera::snapshot {
namespace {

constexpr std::size_t short_header = 28, long_header = 32;  // the long one ends with four bytes that align doubles

// The numbers of a record behind mass, position and velocity.
struct TipsyKind {
  int type;
  std::vector<const char*> more;
  std::size_t record_bytes() const { return sizeof(float) * (7 + more.size()); }
};

const std::array<TipsyKind, 3>& tipsy_kinds() {
  static const std::array<TipsyKind, 3> all{
      {{0, {"gas_density", "temperature", "smoothing_length", "metals", "potential"}},
       {1, {"softening", "potential"}},
       {4, {"metals", "formation_time", "softening", "potential"}}}};
  return all;
}

struct TipsyHeader {
  double time = 0;
  std::size_t bytes = 0;
  bool swapped = false;
  std::array<std::uint64_t, 3> particles{};
};

std::optional<TipsyHeader> tipsy_header_of(std::span<const std::byte> begin, std::uint64_t size) {
  if (begin.size() < short_header) return std::nullopt;
  for (const bool swapped : {false, true}) {
    const auto integer = [&](std::size_t at) -> std::uint64_t {
      const auto value = load<std::uint32_t>(begin.data() + at);
      return swapped ? __builtin_bswap32(value) : value;
    };
    if (integer(12) != 3) continue;  // dimensions
    const auto time = load<std::uint64_t>(begin.data());
    TipsyHeader header{.time = std::bit_cast<double>(swapped ? __builtin_bswap64(time) : time),
                       .bytes = 0,
                       .swapped = swapped,
                       .particles = {integer(16), integer(20), integer(24)}};
    std::uint64_t body = 0, sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      sum += header.particles[k];
      body += header.particles[k] * tipsy_kinds()[k].record_bytes();
    }
    if (sum == 0 || sum != integer(8)) continue;
    for (const std::size_t bytes : {short_header, long_header}) {
      header.bytes = bytes;
      if (size == bytes + body) return header;
    }
  }
  return std::nullopt;
}

}  // namespace

bool is_tipsy(std::span<const std::byte> begin, std::optional<std::uint64_t> size) {
  return size && tipsy_header_of(begin, *size).has_value();
}

Result<std::unique_ptr<PointReader>> open_tipsy(std::unique_ptr<ByteSource> source,
                                                const std::vector<Attribute>& attributes, const ReadHints& hints) {
  FileInfo info = info_of(*source, "tipsy");
  std::array<std::byte, short_header> begin{};
  if (source->size() >= begin.size()) {
    BOOST_OUTCOME_TRYV(source->read(0, begin));
  }
  const auto header = tipsy_header_of(begin, source->size());
  if (!header) return error(Errc::bad_input, info.path.string() + ": is no Tipsy snapshot");
  Layout layout;
  layout.swapped = header->swapped;
  layout.attributes.push_back({"particle_type", AttributeType::u8});
  const auto column = [&](const char* name) {
    auto& known = layout.attributes;
    const auto found = std::find_if(known.begin(), known.end(), [&](const Attribute& a) { return a.name == name; });
    if (found != known.end()) return 3 + static_cast<std::size_t>(found - known.begin());
    known.push_back({name, AttributeType::f32});
    return 2 + known.size();
  };
  std::uint64_t at = header->bytes;
  for (std::size_t k = 0; k < 3; ++k) {
    const TipsyKind& kind = tipsy_kinds()[k];
    const std::uint64_t count = header->particles[k];
    if (count == 0) continue;
    const auto type = static_cast<std::uint32_t>(kind.type);
    info.particles.push_back({.type = type, .count = count, .mass = 0});
    const bool kept = is_wanted(hints.particles, type);
    layout.kept.add(count, kept);
    if (!kept) {
      layout.particles += count;
      at += count * kind.record_bytes();
      continue;
    }
    Run run{.first = layout.particles, .count = count, .at = at, .record_bytes = kind.record_bytes(), .fields = {}};
    std::vector<std::size_t> columns{column("mass"), 0, 1, 2, column("vx"), column("vy"), column("vz")};
    for (const char* name : kind.more) columns.push_back(column(name));
    for (std::size_t i = 0; i < columns.size(); ++i)
      run.fields.push_back({columns[i], i * sizeof(float), AttributeType::f32});
    layout.constants.push_back({layout.particles, count, 3, static_cast<double>(kind.type)});
    layout.runs.push_back(std::move(run));
    layout.particles += count;
    at += count * kind.record_bytes();
  }
  info.detail = std::string("Tipsy") + (header->swapped ? ", big endian" : "");
  info.stated.emplace_back("time", header->time);
  return read_layout(std::move(info), std::move(source), std::move(layout), attributes);
}

}  // namespace tessera::snapshot

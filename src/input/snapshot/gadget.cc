#include "src/input/snapshot/gadget.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/input/bytes/fields.h"
#include "src/input/snapshot/snapshot_reader.h"

namespace tessera::snapshot {
namespace {

constexpr std::uint32_t header_bytes = 256, label_bytes = 8;
constexpr std::size_t types = 6;

std::uint32_t swapped_if(bool swapped, std::uint32_t value) { return swapped ? __builtin_bswap32(value) : value; }

// Numbers of the header at their places.
class HeaderBytes {
 public:
  HeaderBytes(std::span<const std::byte, header_bytes> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
  std::uint32_t integer(std::size_t at) const { return swapped_if(swapped_, load<std::uint32_t>(bytes_.data() + at)); }
  double real(std::size_t at) const {
    const auto bits = load<std::uint64_t>(bytes_.data() + at);
    return std::bit_cast<double>(swapped_ ? __builtin_bswap64(bits) : bits);
  }

 private:
  std::span<const std::byte, header_bytes> bytes_;
  bool swapped_;
};

struct GadgetHeader {
  std::array<std::uint64_t, types> particles{}, total{};  // in this file; in all files of the snapshot
  std::array<double, types> mass{};                       // of all particles of a type; 0: each has its own
  double time = 0, redshift = 0, box = 0, matter = 0, lambda = 0, hubble = 0;
  std::uint32_t files = 1;
  std::uint64_t all() const { return std::accumulate(particles.begin(), particles.end(), std::uint64_t{0}); }
};

GadgetHeader gadget_header_of(const HeaderBytes& bytes) {
  GadgetHeader header;
  for (std::size_t t = 0; t < types; ++t) {
    header.particles[t] = bytes.integer(4 * t);
    header.mass[t] = bytes.real(24 + 8 * t);
    header.total[t] = bytes.integer(96 + 4 * t) | std::uint64_t{bytes.integer(168 + 4 * t)} << 32;
  }
  header.time = bytes.real(72);
  header.redshift = bytes.real(80);
  header.files = bytes.integer(124);
  header.box = bytes.real(128);
  header.matter = bytes.real(136);
  header.lambda = bytes.real(144);
  header.hubble = bytes.real(152);
  return header;
}

// A block: the bytes between two equal lengths.
struct Block {
  std::string label;  // in format 2: "POS ", "VEL ", ...
  std::uint64_t at = 0, bytes = 0;
};

// Walks over the blocks of a file. Lengths are 32-bit numbers, so those of longer blocks are known modulo 2^32 alone.
class Blocks {
 public:
  Blocks(const ByteSource& source, bool swapped, bool labels) : source_(source), swapped_(swapped), labels_(labels) {}

  // Returns the next block, whose length is one of `lengths`, or any if that is empty. Nothing at the end of the file.
  Result<std::optional<Block>> next(std::span<const std::uint64_t> lengths) {
    if (at_ == source_.size()) return std::optional<Block>();
    Block block;
    if (labels_) {
      BOOST_OUTCOME_TRY(label, next_one(std::array<std::uint64_t, 1>{label_bytes}));
      std::array<char, 4> letters{};
      BOOST_OUTCOME_TRYV(source_.read(label.at, std::as_writable_bytes(std::span(letters))));
      block.label.assign(letters.begin(), letters.end());
    }
    BOOST_OUTCOME_TRY(found, next_one(lengths));
    block.at = found.at;
    block.bytes = found.bytes;
    return std::optional(block);
  }

 private:
  Result<Block> next_one(std::span<const std::uint64_t> lengths) {
    const std::uint64_t begin = at_;
    BOOST_OUTCOME_TRY(length, length_at(begin));
    std::vector<std::uint64_t> possible{length};
    for (const std::uint64_t wanted : lengths)
      if (wanted != length && static_cast<std::uint32_t>(wanted) == length) possible.push_back(wanted);
    for (const std::uint64_t bytes : possible) {
      if (bytes > source_.size() || begin + 4 + bytes > source_.size() - 4) continue;
      BOOST_OUTCOME_TRY(again, length_at(begin + 4 + bytes));
      if (again != length) continue;
      at_ = begin + 8 + bytes;
      return Block{.label = {}, .at = begin + 4, .bytes = bytes};
    }
    return bad("a block begins with the length " + std::to_string(length) +
                   ", which does not stand behind it again: the file is cut off or damaged",
               begin);
  }

  Result<std::uint32_t> length_at(std::uint64_t at) const {
    if (source_.size() < 4 || at > source_.size() - 4) return bad("the file ends before the length of a block", at);
    std::uint32_t length = 0;
    BOOST_OUTCOME_TRYV(source_.read(at, std::as_writable_bytes(std::span(&length, 1))));
    return swapped_if(swapped_, length);
  }

  Error bad(const std::string& what, std::uint64_t at) const {
    return error(Errc::bad_input, source_.path().string() + ", byte " + std::to_string(at) + ": " + what);
  }

  const ByteSource& source_;
  bool swapped_, labels_;
  std::uint64_t at_ = 0;
};

// What a block says of which particles.
struct Known {
  std::string_view label;
  std::vector<const char*> names;  // empty: coordinates
  bool integers = false;
  bool gas = false;         // of gas alone
  bool own_masses = false;  // of those types alone whose mass is not in the header
  std::size_t width() const { return names.empty() ? 3 : names.size(); }  // numbers a particle
};

const std::array<Known, 7>& known_blocks() {
  static const std::array<Known, 7> blocks{{{"POS ", {}},
                                            {"VEL ", {"vx", "vy", "vz"}},
                                            {"ID  ", {"particle_id"}, true},
                                            {"MASS", {"mass"}, false, false, true},
                                            {"U   ", {"internal_energy"}, false, true},
                                            {"RHO ", {"gas_density"}, false, true},
                                            {"HSML", {"smoothing_length"}, false, true}}};
  return blocks;
}

// Turns header and blocks into a layout.
class LayoutMaker {
 public:
  // `wanted`: the types to read; empty: all.
  LayoutMaker(const ByteSource& source, GadgetHeader header, bool swapped, std::span<const std::uint32_t> wanted)
      : source_(source), header_(header) {
    layout_.swapped = swapped;
    layout_.particles = header.all();
    const std::size_t type = column("particle_type", AttributeType::u8);
    std::uint64_t first = 0;
    for (std::size_t t = 0; t < types; first += header.particles[t++]) {
      kept_[t] = is_wanted(wanted, static_cast<std::uint32_t>(t));
      layout_.kept.add(header.particles[t], kept_[t]);
      layout_.constants.push_back({first, header.particles[t], type, static_cast<double>(t)});
    }
  }

  std::uint64_t particles_of(const Known& known) const {
    std::uint64_t count = 0;
    for (std::size_t t = 0; t < types; ++t) count += has(known, t) ? header_.particles[t] : 0;
    return count;
  }

  // The lengths that the block may have: with numbers of four and of eight bytes.
  std::array<std::uint64_t, 2> lengths_of(const Known& known) const {
    const std::uint64_t numbers = particles_of(known) * known.width();
    return {4 * numbers, 8 * numbers};
  }

  Status add(const Known& known, const Block& block) {
    const auto lengths = lengths_of(known);
    if (block.bytes != lengths[0] && block.bytes != lengths[1])
      return error(Errc::bad_input, source_.path().string() + ", byte " + std::to_string(block.at) + ": the block " +
                                        in_quotes(known.label) + " has " + std::to_string(block.bytes) +
                                        " bytes, but " + std::to_string(particles_of(known)) + " particles take " +
                                        std::to_string(lengths[0]) + " or " + std::to_string(lengths[1]));
    bool kept = false;
    for (std::size_t t = 0; t < types; ++t) kept = kept || (has(known, t) && kept_[t] && header_.particles[t] > 0);
    if (!kept) return success();
    const bool wide = block.bytes == lengths[1];
    using enum AttributeType;
    const AttributeType type = known.integers ? (wide ? u64 : u32) : (wide ? f64 : f32);
    Run run{.first = 0, .count = 0, .at = block.at, .record_bytes = 0, .fields = {}};
    for (std::size_t i = 0; i < known.width(); ++i) {
      run.fields.push_back({known.names.empty() ? i : column(known.names[i], type), run.record_bytes, type});
      run.record_bytes += size_of(type);
    }
    std::uint64_t first = 0;
    for (std::size_t t = 0; t < types; first += header_.particles[t++]) {
      if (!has(known, t)) continue;
      run.first = first;
      run.count = header_.particles[t];
      if (run.count > 0 && kept_[t]) layout_.runs.push_back(run);
      run.at += run.count * run.record_bytes;
    }
    return success();
  }

  Layout finish() && {
    const std::size_t mass = column("mass", AttributeType::f64);
    std::uint64_t first = 0;
    for (std::size_t t = 0; t < types; first += header_.particles[t++])
      if (header_.mass[t] != 0 && kept_[t])
        layout_.constants.push_back({first, header_.particles[t], mass, header_.mass[t]});
    return std::move(layout_);
  }

 private:
  bool has(const Known& known, std::size_t type) const {
    if (known.gas) return type == 0;
    return !known.own_masses || header_.mass[type] == 0;
  }

  std::size_t column(const char* name, AttributeType type) {
    auto& attributes = layout_.attributes;
    const auto found = std::find_if(attributes.begin(), attributes.end(), [&](auto& a) { return a.name == name; });
    if (found != attributes.end()) return 3 + static_cast<std::size_t>(found - attributes.begin());
    attributes.push_back({name, type});
    return 2 + attributes.size();
  }

  const ByteSource& source_;
  GadgetHeader header_;
  std::array<bool, types> kept_{};
  Layout layout_;
};

// The numbers of a header that are the same in all files of a snapshot.
SnapshotPart snapshot_of(const GadgetHeader& header) {
  std::string run = json_text(
      nlohmann::json{{"time", header.time}, {"box", header.box}, {"total", header.total}, {"mass", header.mass}});
  return {.run = std::move(run),
          .files = std::max(1u, header.files),
          .points = std::accumulate(header.total.begin(), header.total.end(), std::uint64_t{0})};
}

struct Begin {
  bool swapped = false, labels = false;
};

std::optional<Begin> begin_of(std::span<const std::byte> begin) {
  if (begin.size() < 24) return std::nullopt;
  const auto first = load<std::uint32_t>(begin.data());
  for (const bool swapped : {false, true}) {
    if (swapped_if(swapped, first) == header_bytes) return Begin{swapped, false};
    const std::string_view label(reinterpret_cast<const char*>(begin.data()) + 4, 4);
    if (swapped_if(swapped, first) == label_bytes && label == "HEAD") return Begin{swapped, true};
  }
  return std::nullopt;
}

// Without labels, blocks follow each other in the order of known_blocks(); those without particles are left out. Behind
// the density other blocks may follow, depending on how the program was compiled, so no more are read.
Result<Layout> layout_of(const ByteSource& source, Blocks& blocks, const GadgetHeader& header, const Begin& begin,
                         std::span<const std::uint32_t> wanted) {
  LayoutMaker maker(source, header, begin.swapped, wanted);
  bool positions = false;
  if (begin.labels) {
    while (true) {
      std::vector<std::uint64_t> lengths;
      for (const auto& known : known_blocks())
        for (const std::uint64_t length : maker.lengths_of(known)) lengths.push_back(length);
      BOOST_OUTCOME_TRY(block, blocks.next(lengths));
      if (!block) break;
      for (const auto& known : known_blocks()) {
        if (known.label != block->label || maker.particles_of(known) == 0) continue;
        BOOST_OUTCOME_TRYV(maker.add(known, *block));
        positions = positions || known.names.empty();
      }
    }
  } else {
    for (const auto& known : known_blocks()) {
      if (known.label == "HSML") break;
      if (maker.particles_of(known) == 0) continue;
      BOOST_OUTCOME_TRY(block, blocks.next(maker.lengths_of(known)));
      if (!block) break;
      BOOST_OUTCOME_TRYV(maker.add(known, *block));
      positions = true;
    }
  }
  if (!positions) return error(Errc::bad_input, source.path().string() + ": is a snapshot without positions");
  return std::move(maker).finish();
}

}  // namespace

bool looks_like_gadget(std::span<const std::byte> begin) {
  const auto found = begin_of(begin);
  if (!found || found->labels) return found.has_value();
  // The length stands behind the header again.
  return begin.size() >= header_bytes + 8 &&
         load<std::uint32_t>(begin.data() + 4 + header_bytes) == load<std::uint32_t>(begin.data());
}

Result<std::unique_ptr<PointReader>> open_gadget(std::unique_ptr<ByteSource> source,
                                                 const std::vector<Attribute>& attributes, const ReadHints& hints) {
  FileInfo info = info_of(*source, "gadget");
  const auto bad = [&](const std::string& what) { return error(Errc::bad_input, info.path.string() + ": " + what); };
  std::array<std::byte, 24> first{};
  if (source->size() < first.size()) return bad("ends within its header");
  BOOST_OUTCOME_TRYV(source->read(0, first));
  const auto begin = begin_of(first);
  if (!begin) return bad("does not begin like a Gadget snapshot");
  Blocks blocks(*source, begin->swapped, begin->labels);
  BOOST_OUTCOME_TRY(block, blocks.next(std::array<std::uint64_t, 1>{header_bytes}));
  if (!block || block->bytes != header_bytes) return bad("its header does not have 256 bytes");
  std::array<std::byte, header_bytes> bytes{};
  BOOST_OUTCOME_TRYV(source->read(block->at, bytes));
  const GadgetHeader header = gadget_header_of(HeaderBytes(bytes, begin->swapped));
  const bool empty = header.all() == 0;
  if (empty && header.files < 2) return bad("holds no particles");  // a file of several may have none
  if (!std::isfinite(header.box) || header.box < 0) return bad("says that its box is not a length of 0 or more");
  Layout layout = LayoutMaker(*source, header, begin->swapped, hints.particles).finish();
  if (!empty) {
    BOOST_OUTCOME_TRY(found, layout_of(*source, blocks, header, *begin, hints.particles));
    layout = std::move(found);
  }
  info.detail = std::string("Gadget ") + (begin->labels ? "2" : "1") + (begin->swapped ? ", big endian" : "");
  info.box = {header.box, header.box, header.box};
  info.snapshot = snapshot_of(header);
  for (std::uint32_t t = 0; t < types; ++t)
    if (header.particles[t] > 0)
      info.particles.push_back({.type = t, .count = header.particles[t], .mass = header.mass[t]});
  info.stated = {{"time", header.time},
                 {"redshift", header.redshift},
                 {"omega_matter", header.matter},
                 {"omega_lambda", header.lambda},
                 {"hubble", header.hubble}};
  return read_layout(std::move(info), std::move(source), std::move(layout), attributes);
}

}  // namespace tessera::snapshot

#include "src/input/e57/e57_stream.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::size_t section_header_bytes = 32, packet_header_bytes = 6;
enum class Packet : std::uint8_t { index = 0, data = 1, empty = 2 };

}  // namespace

Result<E57Section> find_section(E57Pages& pages, const E57Scan& scan) {
  const auto bad = [&](const char* what) {
    return error(Errc::bad_input, pages.source().path().string() + ": " + what + " at byte " +
                                      std::to_string(scan.points_at) + ", where a scan has its points");
  };
  std::array<std::byte, section_header_bytes> header{};
  const std::uint64_t at = pages.logical(scan.points_at);
  BOOST_OUTCOME_TRYV(pages.read(at, header));
  if (header[0] != std::byte{1}) return bad("there is no section of points");
  const auto length = load<std::uint64_t>(header.data() + 8), data = load<std::uint64_t>(header.data() + 16);
  const E57Section section{.begin = pages.logical(data), .end = at + length};
  if (length > pages.size() - at || data > pages.source().size() || (scan.records > 0 && section.begin < at))
    return bad("there is a section whose length or place is impossible");
  return section;
}

E57Stream::E57Stream(E57Pages& pages, E57Section section, const E57Field& field, std::size_t index, std::size_t fields)
    : pages_(&pages), section_(section), field_(field), index_(index), fields_(fields), at_(section.begin) {}

Error E57Stream::damaged(const std::string& what) const {
  return error(Errc::bad_input, pages_->source().path().string() + ": the points are damaged: " + what +
                                    " while field " + in_quotes(field_.name) + " is read");
}

Status E57Stream::next_packet() {
  while (true) {
    if (at_ > section_.end || section_.end - at_ < packet_header_bytes) return damaged("their packets end");
    std::array<std::byte, packet_header_bytes> header{};
    BOOST_OUTCOME_TRYV(pages_->read(at_, header));
    const std::uint64_t length = std::uint64_t{load<std::uint16_t>(header.data() + 2)} + 1, packet = at_;
    const auto type = static_cast<Packet>(header[0]);
    if (length > section_.end - at_ || (type != Packet::data && type != Packet::index && type != Packet::empty))
      return damaged("byte " + std::to_string(at_) + " begins no packet");
    at_ += length;
    if (type != Packet::data) continue;
    const std::size_t streams = load<std::uint16_t>(header.data() + 4);
    if (streams != fields_)
      return damaged("a packet has " + std::to_string(streams) + " streams, but a record has " +
                     std::to_string(fields_) + " fields");
    std::vector<std::uint16_t> lengths(streams);
    const std::uint64_t begin = packet_header_bytes + 2 * std::uint64_t{streams};
    if (begin > length) return damaged("a packet is shorter than its header");
    BOOST_OUTCOME_TRYV(pages_->read(packet + packet_header_bytes, std::as_writable_bytes(std::span(lengths))));
    std::uint64_t from = begin;
    for (std::size_t i = 0; i < index_; ++i) from += lengths[i];
    if (from + lengths[index_] > length) return damaged("a packet is shorter than its streams");
    if (lengths[index_] == 0) continue;
    bytes_.resize(lengths[index_]);
    next_byte_ = 0;
    return pages_->read(packet + from, bytes_);
  }
}

Status E57Stream::read_raw(std::size_t n) {
  const unsigned width = field_.bits();
  raw_.assign(n, 0);
  if (width == 0) return success();
  for (auto& value : raw_) {
    for (unsigned known = 0; known < width;) {
      if (byte_bits_ == 0) {
        if (next_byte_ == bytes_.size()) {
          BOOST_OUTCOME_TRYV(next_packet());
        }
        byte_ = static_cast<unsigned>(bytes_[next_byte_++]);
        byte_bits_ = 8;
      }
      const unsigned taken = std::min(width - known, byte_bits_);
      value |= std::uint64_t{byte_ & ((1U << taken) - 1)} << known;
      byte_ >>= taken;
      byte_bits_ -= taken;
      known += taken;
    }
  }
  return success();
}

Status E57Stream::read(std::size_t n, std::vector<std::int64_t>& values) {
  BOOST_OUTCOME_TRYV(read_raw(n));
  const auto range = static_cast<std::uint64_t>(field_.maximum) - static_cast<std::uint64_t>(field_.minimum);
  values.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (raw_[i] > range) return damaged("a value is above its maximum");
    values[i] = static_cast<std::int64_t>(static_cast<std::uint64_t>(field_.minimum) + raw_[i]);
  }
  return success();
}

Status E57Stream::read(std::size_t n, std::vector<double>& values) {
  using Kind = E57Field::Kind;
  if (field_.kind == Kind::integer || field_.kind == Kind::scaled) {
    std::vector<std::int64_t> stored;
    BOOST_OUTCOME_TRYV(read(n, stored));
    values.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto value = static_cast<double>(stored[i]);
      values[i] = field_.kind == Kind::scaled ? value * field_.scale + field_.offset : value;
    }
    return success();
  }
  BOOST_OUTCOME_TRYV(read_raw(n));
  values.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    values[i] = field_.kind == Kind::single
                    ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw_[i])))
                    : std::bit_cast<double>(raw_[i]);
  return success();
}

}  // namespace tessera

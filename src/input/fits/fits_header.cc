#include "src/input/fits/fits_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "src/base/printable.h"

namespace tessera::fits {
namespace {

constexpr std::size_t card_bytes = 80, header_block_bytes = 2880;
constexpr std::uint64_t header_blocks_max = 2912;  // 8 MiB; 999 columns take some 500 KB
constexpr std::uint64_t hdus_max = 100'000;

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

// Whether a card says how large or what the data is.
bool is_kept(std::string_view key) {
  constexpr std::array<std::string_view, 12> whole{"SIMPLE", "XTENSION", "BITPIX",  "NAXIS",  "PCOUNT", "GCOUNT",
                                                   "GROUPS", "TFIELDS",  "EXTNAME", "ZTABLE", "ZIMAGE", "THEAP"};
  constexpr std::array<std::string_view, 7> numbered{"NAXIS", "TTYPE", "TFORM", "TUNIT", "TSCAL", "TZERO", "TNULL"};
  if (std::find(whole.begin(), whole.end(), key) != whole.end()) return true;
  return std::any_of(numbered.begin(), numbered.end(), [&](std::string_view begin) {
    return key.size() > begin.size() && key.starts_with(begin) &&
           key.substr(begin.size()).find_first_not_of("0123456789") == std::string_view::npos;
  });
}

// The greatest sizes fit into 64 bits, or none is.
std::optional<std::uint64_t> product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t result = 0;
  return __builtin_mul_overflow(a, b, &result) ? std::nullopt : std::optional(result);
}

}  // namespace

bool looks_like_fits(std::string_view begin) {
  return begin.size() >= 30 && begin.starts_with("SIMPLE  =") && trimmed(begin.substr(9, 21)) == "T";
}

std::string Cards::add(std::string_view card) {
  const std::string key(trimmed(card.substr(0, 8)));
  if (card.substr(8, 2) != "= " || !is_kept(key)) return "";
  Value value;
  const std::string_view field = trimmed(card.substr(10));
  if (field.starts_with('\'')) {
    value.quoted = true;
    bool closed = false;
    for (std::size_t i = 1; i < field.size() && !closed; ++i) {
      if (field[i] != '\'') {
        value.text += field[i];
      } else if (i + 1 < field.size() && field[i + 1] == '\'') {
        value.text += field[i++];  // two quotes stand for one
      } else {
        closed = true;
      }
    }
    if (!closed) return "has a card " + in_quotes(key) + " whose text has no end";
    value.text.erase(value.text.find_last_not_of(' ') + 1);
  } else {
    value.text = trimmed(field.substr(0, field.find('/')));
  }
  if (!values_.emplace(key, std::move(value)).second) return "has two cards " + in_quotes(key);
  return "";
}

std::optional<std::string> Cards::text(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end() || !found->second.quoted) return std::nullopt;
  return found->second.text;
}

std::optional<std::int64_t> Cards::integer(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end() || found->second.quoted) return std::nullopt;
  std::string_view text = found->second.text;
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> Cards::real(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end() || found->second.quoted) return std::nullopt;
  std::string text = found->second.text;
  std::replace(text.begin(), text.end(), 'D', 'E');  // as FORTRAN writes exponents of doubles
  const std::size_t begin = text.starts_with('+') ? 1 : 0;
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data() + begin, text.data() + text.size(), value);
  if (problem != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool Cards::is_true(const std::string& key) const {
  const auto found = values_.find(key);
  return found != values_.end() && !found->second.quoted && found->second.text == "T";
}

std::string Hdu::title() const {
  return "HDU " + std::to_string(number) + (name().empty() ? "" : " " + in_quotes(name()));
}

Result<std::optional<Hdu>> Hdus::next() {
  if (at_ >= source_.size()) return std::optional<Hdu>();
  if (number_ > 0) {  // what is no HDU, such as padding, is the end
    std::array<char, 8> first{};
    if (source_.size() - at_ < first.size()) return std::optional<Hdu>();
    BOOST_OUTCOME_TRYV(source_.read(at_, std::as_writable_bytes(std::span(first))));
    if (std::string_view(first.data(), first.size()) != "XTENSION") return std::optional<Hdu>();
  }
  BOOST_OUTCOME_TRY(hdu, read_header());
  if (number_ == hdus_max) return bad(hdu, "is not read: a file may have " + std::to_string(hdus_max) + " HDUs");
  BOOST_OUTCOME_TRYV(measure(hdu));
  ++number_;
  const std::uint64_t rest = hdu.data_bytes % header_block_bytes;
  at_ = hdu.data_at + hdu.data_bytes + (rest == 0 ? 0 : header_block_bytes - rest);
  return std::optional(std::move(hdu));
}

Result<Hdu> Hdus::read_header() {
  Hdu hdu{.number = number_, .header_at = at_, .data_at = 0, .data_bytes = 0, .cards = {}};
  std::vector<char> block(header_block_bytes);
  for (std::uint64_t i = 0; i < header_blocks_max; ++i) {
    if (source_.size() - at_ < block.size())
      return bad(hdu, "has a header without an END: the file is cut off or damaged");
    BOOST_OUTCOME_TRYV(source_.read(at_, std::as_writable_bytes(std::span(block))));
    at_ += block.size();
    for (std::size_t c = 0; c < block.size(); c += card_bytes) {
      const std::string_view card(block.data() + c, card_bytes);
      if (trimmed(card) == "END") {
        hdu.data_at = at_;
        return hdu;
      }
      if (const std::string wrong = hdu.cards.add(card); !wrong.empty()) return bad(hdu, wrong);
    }
  }
  return bad(hdu, "has a header of more than 8 MiB, or one without an END");
}

// data bytes = |BITPIX| / 8 * GCOUNT * (PCOUNT + NAXIS1 * NAXIS2 * ...)
Status Hdus::measure(Hdu& hdu) const {
  const Cards& cards = hdu.cards;
  const auto bits = cards.integer("BITPIX"), axes = cards.integer("NAXIS");
  constexpr std::array<std::int64_t, 6> known{8, 16, 32, 64, -32, -64};
  if (!bits || std::find(known.begin(), known.end(), *bits) == known.end())
    return bad(hdu, "has no BITPIX that FITS knows");
  if (!axes || *axes < 0 || *axes > 999) return bad(hdu, "has no NAXIS from 0 to 999");
  const auto parameters = cards.has("PCOUNT") ? cards.integer("PCOUNT") : 0;
  const auto groups = cards.has("GCOUNT") ? cards.integer("GCOUNT") : 1;
  if (!parameters || *parameters < 0 || !groups || *groups < 0)
    return bad(hdu, "has a PCOUNT or GCOUNT that is no number of 0 or more");
  const bool random_groups = cards.is_true("GROUPS");  // their NAXIS1 is 0, and does not count
  std::optional<std::uint64_t> values = *axes == 0 ? 0 : 1;
  for (std::int64_t axis = 1; axis <= *axes; ++axis) {
    const std::string key = "NAXIS" + std::to_string(axis);
    const auto length = cards.integer(key);
    if (!length || *length < 0) return bad(hdu, "has no " + key + " of 0 or more");
    if (axis == 1 && *length == 0 && random_groups) continue;
    if (values) values = product(*values, static_cast<std::uint64_t>(*length));
  }
  std::uint64_t all = 0;
  if (values && __builtin_add_overflow(*values, static_cast<std::uint64_t>(*parameters), &all)) values.reset();
  if (values) values = product(all, static_cast<std::uint64_t>(*groups));
  if (values) values = product(*values, static_cast<std::uint64_t>(std::abs(*bits) / 8));
  const std::uint64_t there = source_.size() - hdu.data_at;
  if (!values || *values > there)
    return bad(hdu, "says that it has " + (values ? std::to_string(*values) : "more than 2^64") +
                        " bytes of data, but the file has " + std::to_string(there) + " behind its header");
  hdu.data_bytes = *values;
  return success();
}

Error Hdus::bad(const Hdu& hdu, const std::string& what) const {
  return error(Errc::bad_input,
               source_.path().string() + ", byte " + std::to_string(hdu.header_at) + ": " + hdu.title() + " " + what);
}

}  // namespace tessera::fits

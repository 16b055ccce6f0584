// The headers of a FITS file: a chain of HDUs, each a header of cards and the data that it describes.
// Source: FITS Standard, version 4.0 (IAU FITS Working Group, 2018), sections 3 to 4 and 7.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera::fits {

// Whether a file begins as FITS does.
bool looks_like_fits(std::string_view begin);

// The cards of a header that say what its data is: sizes, columns, names. Values of other cards are not kept.
class Cards {
 public:
  // Takes a card of 80 bytes. Returns the end of a sentence about a card that stands twice, or whose text is not
  // closed; "" otherwise.
  std::string add(std::string_view card);

  bool has(const std::string& key) const { return values_.contains(key); }
  std::optional<std::string> text(const std::string& key) const;  // without quotes and blanks at the end
  std::optional<std::int64_t> integer(const std::string& key) const;
  std::optional<double> real(const std::string& key) const;  // finite
  bool is_true(const std::string& key) const;

 private:
  struct Value {
    std::string text;
    bool quoted = false;
  };
  std::unordered_map<std::string, Value> values_;
};

struct Hdu {
  std::uint64_t number = 0;     // 0: the primary one
  std::uint64_t header_at = 0;  // in the file
  std::uint64_t data_at = 0, data_bytes = 0;
  Cards cards;
  std::string name() const { return cards.text("EXTNAME").value_or(""); }
  bool is_table() const { return cards.text("XTENSION") == "BINTABLE" || cards.text("XTENSION") == "A3DTABLE"; }
  // How a sentence names the HDU: "HDU 1 'GALAXIES'".
  std::string title() const;
};

// Reads the HDUs of a file, one after the other. What it reads is bounded: at most 8 MiB of a header.
class Hdus {
 public:
  explicit Hdus(const ByteSource& source) : source_(source) {}
  // The next HDU, whose data lies within the file; nothing behind the last one. Errors: bad_input for headers without
  // an end, for sizes that are missing, negative, or larger than the file, for cards that stand twice.
  Result<std::optional<Hdu>> next();

 private:
  Result<Hdu> read_header();
  Status measure(Hdu& hdu) const;
  Error bad(const Hdu& hdu, const std::string& what) const;

  const ByteSource& source_;
  std::uint64_t at_ = 0, number_ = 0;
};

}  // namespace tessera::fits

#include "src/base/crs/wkt.h"

#include <algorithm>
#include <string>

namespace tessera {
namespace {

constexpr std::size_t bytes_max = 65535;  // the largest record of a LAS file
constexpr int depth_max = 16;             // PROJ reads no deeper nesting

// Lists of words between blanks. The first list has the keywords that begin a coordinate system.
constexpr std::string_view systems =
    " BOUNDCRS COMPD_CS COMPOUNDCRS DERIVEDPROJCRS ENGCRS ENGINEERINGCRS GEOCCS GEODCRS GEODETICCRS GEOGCRS GEOGCS "
    "GEOGRAPHICCRS LOCAL_CS PROJCRS PROJCS PROJECTEDCRS VERTCRS VERTCS VERTICALCRS VERT_CS ";
// The second list has the keywords whose text is a name for people, or another text for people.
constexpr std::string_view labels =
    " ABRIDGEDTRANSFORMATION ANCHOR ANGLEUNIT AREA AXIS BASEENGCRS BASEGEODCRS BASEGEOGCRS BASEPROJCRS BASEVERTCRS "
    "CITATION CONVERSION DATUM EDATUM ELLIPSOID ENGINEERINGDATUM ENSEMBLE GEODETICDATUM LENGTHUNIT LOCAL_DATUM MEMBER "
    "PRIMEM PRIMEMERIDIAN REMARK SCALEUNIT SCOPE SPHEROID TRF UNIT URI VDATUM VERTICALDATUM VERT_DATUM VRF ";

bool is_one_of(const std::string& word, std::string_view words) { return words.find(" " + word + " ") != words.npos; }

// Reads WKT. This class is stricter than PROJ: what PROJ would read in another way is refused.
class Walk {
 public:
  explicit Walk(std::string_view text) : rest_(text), size_(text.size()) {}

  Status systems_to_the_end() {
    do {  // ESRI writes the parts of a compound system one behind the other
      skip_blank();
      const std::string keyword = take_word();
      if (keyword.empty() || !is_one_of(keyword, systems))
        return bad("it does not begin with the keyword of a coordinate system");
      BOOST_OUTCOME_TRYV(values_of(keyword, 1));
    } while (take(','));
    return rest_.empty() ? success() : Status(unexpected());
  }

 private:
  static Error bad(const std::string& why) { return error(Errc::bad_input, why); }
  Error unexpected() const {
    return bad(rest_.empty() ? "it ends too early"
                             : "it is not WKT from byte " + std::to_string(size_ - rest_.size()) + " on");
  }

  void skip_blank() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n\v\f"), rest_.size())); }
  bool take(char c) {
    skip_blank();
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  // Reads a keyword, or a value without quotation marks. Returns it in capital letters.
  std::string take_word() {
    constexpr std::string_view more = "_.+-:";
    const auto is_in_word = [&](char c) {
      return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || more.find(c) != more.npos;
    };
    const auto end = std::find_if_not(rest_.begin(), rest_.end(), is_in_word);
    std::string word(rest_.begin(), end);
    rest_.remove_prefix(word.size());
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return word;
  }

  Status values_of(const std::string& keyword, int depth) {
    if (depth > depth_max) return bad("it is nested too deep");
    skip_blank();
    const char end = rest_.starts_with('(') ? ')' : ']';
    if (!take('(') && !take('[')) return unexpected();
    do {
      skip_blank();
      if (rest_.starts_with('"')) {
        BOOST_OUTCOME_TRYV(quoted_of(keyword));
        continue;
      }
      const std::string word = take_word();
      if (word.empty()) return unexpected();
      skip_blank();
      if (rest_.starts_with('[') || rest_.starts_with('(')) {
        BOOST_OUTCOME_TRYV(values_of(word, depth + 1));
      }
    } while (take(','));
    return take(end) ? success() : Status(unexpected());
  }

  Status quoted_of(const std::string& keyword) {
    std::size_t end = rest_.find('"', 1);
    while (end < rest_.size() && rest_.substr(end + 1).starts_with('"'))
      end = rest_.find('"', end + 2);  // a doubled quotation mark is part of the text
    if (end >= rest_.size()) return bad("it ends within quotation marks");
    const auto value = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    if (value.find_first_of("/\\") == value.npos) return success();
    const bool is_label = is_one_of(keyword, labels) || is_one_of(keyword, systems);
    if (!is_label || value.find('=') != value.npos)
      return bad("its " + keyword + " holds a slash, so it may name a file");
    return success();
  }

  std::string_view rest_;
  std::size_t size_;
};

}  // namespace

Status check_wkt(std::string_view text) {
  if (text.size() > bytes_max)
    return error(Errc::bad_input, "it is longer than " + std::to_string(bytes_max) + " bytes");
  return Walk(text).systems_to_the_end();
}

}  // namespace tessera

// Finds the columns of a table that are coordinates.
#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string_view>

#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/column_names.h"
#include "src/input/fits/fits_table.h"

namespace tessera::fits {
namespace {

using Names = std::span<const std::string_view>;
template <std::size_t n>
using NameList = std::array<std::string_view, n>;

constexpr NameList<4> position_names{"pos", "position", "positions", "coordinates"};
constexpr NameList<4> right_ascension_names{"ra", "raj2000", "ra_j2000", "alpha_j2000"};
constexpr NameList<7> declination_names{"dec", "de", "decj2000", "dej2000", "dec_j2000", "de_j2000", "delta_j2000"};
constexpr NameList<3> distance_names{"distance", "dist", "comoving_distance"};
constexpr NameList<2> redshift_names{"z", "redshift"};

bool equal(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

std::string listed(const Table& table) {
  constexpr std::size_t most = 30;
  std::string names;
  for (std::size_t i = 0; i < table.columns.size() && i < most; ++i)
    names += (names.empty() ? "" : ", ") + printable(table.columns[i].name);
  if (table.columns.size() > most) names += ", and " + std::to_string(table.columns.size() - most) + " more";
  return names.empty() ? "none" : names;
}

class PlaceFinder {
 public:
  PlaceFinder(const Table& table, const std::string& path) : table_(table), begin_(path + ": " + table.title) {}

  Error bad(Errc code, const std::string& what) const { return error(code, begin_ + " " + what); }

  // The column of one of the names, the first name of the list before others.
  std::optional<std::size_t> find(Names names) const {
    for (const auto name : names)
      for (std::size_t i = 0; i < table_.columns.size(); ++i)
        if (equal(table_.columns[i].name, name)) return i;
    return std::nullopt;
  }
  std::optional<std::size_t> find_number(Names names) const {
    const auto found = find(names);
    return found && table_.columns[*found].count == 1 ? found : std::nullopt;
  }

  Result<Places> by_option(const std::vector<std::string>& named) const {
    Places places;
    for (const auto& [key, name] : named_columns(named)) {
      const auto column = find(NameList<1>{name});
      if (!column)
        return bad(Errc::usage, "has no column of numbers " + in_quotes(name) + ", which " + option("columns") +
                                    " names; it has " + listed(table_) + left_out());
      if (std::count_if(table_.columns.begin(), table_.columns.end(),
                        [&, n = name](auto& c) { return equal(c.name, n); }) > 1)
        return bad(Errc::usage, "has several columns " + in_quotes(name));
      if (key == "distance") places.of = Places::Of::distance;
      if (key == "redshift") places.of = Places::Of::redshift;
      const bool vector = key == "position";
      if (const std::size_t count = table_.columns[*column].count; count != (vector ? 3U : 1U))
        return bad(Errc::usage, "has " + std::to_string(count) + (count == 1 ? " number" : " numbers") +
                                    " a row in its column " + in_quotes(name) +
                                    (vector ? "; a position has three" : "; a coordinate is one"));
      if (vector) {
        places.elements = {{*column, 0}, {*column, 1}, {*column, 2}};
      } else {
        places.elements.push_back({*column, 0});
      }
    }
    return places;
  }

  Result<Places> by_header(bool redshift_first) const {
    const auto x = find_number(NameList<1>{"x"}), y = find_number(NameList<1>{"y"}), z = find_number(NameList<1>{"z"});
    if (x && y) {
      Places places{.of = Places::Of::xyz, .elements = {{*x, 0}, {*y, 0}}};
      if (z) places.elements.push_back({*z, 0});
      return places;
    }
    if (const auto at = find(position_names); at && table_.columns[*at].count == 3)
      return Places{.of = Places::Of::xyz, .elements = {{*at, 0}, {*at, 1}, {*at, 2}}};
    const auto ra = find_number(right_ascension_names), dec = find_number(declination_names);
    const std::string how = "name the columns by " + option("columns") + ", as x=NAME,y=NAME,z=NAME or " +
                            "ra=NAME,dec=NAME,redshift=NAME; it has " + listed(table_) + left_out();
    if (!ra || !dec)
      return bad(Errc::bad_input,
                 "has no columns for coordinates: neither x and y, nor a pos of three numbers, nor ra and dec; " + how);
    const auto distance = find_number(distance_names), redshift = find_number(redshift_names);
    if (!distance && !redshift)
      return bad(Errc::bad_input,
                 "has ra and dec, but neither a distance nor a redshift, so its points have no place "
                 "in space; " +
                     how + "; x=NAME,y=NAME with the names of ra and dec takes the plane of degrees");
    const bool by_redshift = redshift && (redshift_first || !distance);
    return Places{.of = by_redshift ? Places::Of::redshift : Places::Of::distance,
                  .elements = {{*ra, 0}, {*dec, 0}, {by_redshift ? *redshift : *distance, 0}}};
  }

  // Angles must be in degrees. Integers of 64 bits would be rounded.
  Status check(const Places& places) const {
    for (std::size_t i = 0; i < places.elements.size(); ++i) {
      const NumberColumn& column = table_.columns[places.elements[i].column];
      const bool angle = places.of != Places::Of::xyz && i < 2;
      if (angle && !column.unit.empty() && !equal(column.unit.substr(0, 3), "deg"))
        return bad(Errc::bad_input, "has the column " + in_quotes(column.name) + " in " + in_quotes(column.unit) +
                                        "; angles must be in degrees");
      if (column.stored == AttributeType::i64 && !column.scale)
        return bad(Errc::bad_input, "has integers of 64 bits in its column " + in_quotes(column.name) +
                                        ", which coordinates, as doubles, would round");
      if (column.logical)
        return bad(Errc::bad_input, "has truth values in its column " + in_quotes(column.name) + ", not coordinates");
    }
    return success();
  }

 private:
  std::string left_out() const {
    if (table_.left_out.empty()) return "";
    std::string names;
    constexpr std::size_t most = 10;
    for (std::size_t i = 0; i < table_.left_out.size() && i < most; ++i) names += ", " + table_.left_out[i];
    return ", and, which are no numbers" + names;
  }

  const Table& table_;
  std::string begin_;
};

}  // namespace

Result<Places> places_of(const Table& table, const std::vector<std::string>& named, bool redshifts,
                         const std::string& path) {
  const PlaceFinder finder(table, path);
  BOOST_OUTCOME_TRY(places, named.empty() ? finder.by_header(redshifts) : finder.by_option(named));
  BOOST_OUTCOME_TRYV(finder.check(places));
  return std::move(places);
}

}  // namespace tessera::fits

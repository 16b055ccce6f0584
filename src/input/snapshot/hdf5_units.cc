#include "src/input/snapshot/hdf5_units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace tessera::snapshot {
namespace {

std::string six_digits(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6).ptr};
}

// A product of powers of units.
class UnitText {
 public:
  explicit UnitText(double factor) : text_(factor == 1 ? "" : six_digits(factor)) {}
  UnitText& times(const char* base, std::optional<double> exponent) {
    if (!exponent || *exponent == 0 || !std::isfinite(*exponent)) return *this;
    text_ += (text_.empty() ? "" : " ") + std::string(base) + (*exponent == 1 ? "" : "^" + six_digits(*exponent));
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

bool is_factor(std::optional<double> factor) { return factor && std::isfinite(*factor) && *factor > 0; }

struct Stated {
  const char* name;
  const char* group;
  const char* attribute;
};

// Of several lines with one name, the first that a file has counts.
constexpr std::array<Stated, 25> known{{{"time", "/Header", "Time"},
                                        {"redshift", "/Header", "Redshift"},
                                        {"redshift", "/Cosmology", "Redshift"},
                                        {"hubble", "/Cosmology", "h"},
                                        {"hubble", "/Header", "HubbleParam"},
                                        {"hubble", "/Parameters", "HubbleParam"},
                                        {"omega_matter", "/Cosmology", "Omega_m"},
                                        {"omega_matter", "/Header", "Omega0"},
                                        {"omega_matter", "/Header", "Omega_Matter"},
                                        {"omega_matter", "/Parameters", "Omega0"},
                                        {"omega_lambda", "/Cosmology", "Omega_lambda"},
                                        {"omega_lambda", "/Header", "OmegaLambda"},
                                        {"omega_lambda", "/Header", "Omega_Lambda"},
                                        {"omega_lambda", "/Parameters", "OmegaLambda"},
                                        {"unit_length_cgs", "/Units", "Unit length in cgs (U_L)"},
                                        {"unit_length_cgs", "/Units", "UnitLength_in_cm"},
                                        {"unit_length_cgs", "/Header", "UnitLength_In_CGS"},
                                        {"unit_length_cgs", "/Parameters", "UnitLength_in_cm"},
                                        {"unit_mass_cgs", "/Units", "Unit mass in cgs (U_M)"},
                                        {"unit_mass_cgs", "/Units", "UnitMass_in_g"},
                                        {"unit_mass_cgs", "/Header", "UnitMass_In_CGS"},
                                        {"unit_mass_cgs", "/Parameters", "UnitMass_in_g"},
                                        {"unit_velocity_cgs", "/Header", "UnitVelocity_In_CGS"},
                                        {"unit_velocity_cgs", "/Parameters", "UnitVelocity_in_cm_per_s"},
                                        {"unit_time_cgs", "/Units", "Unit time in cgs (U_t)"}}};

}  // namespace

std::string unit_of_table(const Hdf5File& file, const std::string& group, const std::string& table) {
  const auto number = [&](const char* attribute) { return file.number_of_table(group, table, attribute); };
  // Gadget-4 and AREPO: powers of length, mass and velocity.
  if (const auto factor = number("to_cgs"); is_factor(factor)) {
    const double length = number("length_scaling").value_or(0), mass = number("mass_scaling").value_or(0),
                 velocity = number("velocity_scaling").value_or(0);
    return UnitText(*factor)
        .times("a", number("a_scaling"))
        .times("h", number("h_scaling"))
        .times("cm", length + velocity)
        .times("g", mass)
        .times("s", -velocity)
        .text();
  }
  if (const auto factor = number("Conversion factor to CGS (not including cosmological corrections)");
      is_factor(factor)) {  // SWIFT
    return UnitText(*factor)
        .times("a", number("a-scale exponent"))
        .times("h", number("h-scale exponent"))
        .times("cm", number("U_L exponent"))
        .times("g", number("U_M exponent"))
        .times("s", number("U_t exponent"))
        .times("K", number("U_T exponent"))
        .times("A", number("U_I exponent"))
        .text();
  }
  if (const auto factor = number("CGSConversionFactor"); is_factor(factor)) {  // EAGLE
    UnitText unit(*factor);
    unit.times("a", number("aexp-scale-exponent")).times("h", number("h-scale-exponent"));
    return unit.text().empty() ? "" : unit.text() + " cgs";
  }
  return "";
}

std::vector<std::pair<std::string, double>> stated_numbers(const Hdf5File& file) {
  std::vector<std::pair<std::string, double>> found;
  for (const auto& [name, group, attribute] : known) {
    if (!found.empty() && found.back().first == name) continue;
    const auto numbers = file.numbers(group, attribute);
    if (numbers && numbers->size() == 1) found.emplace_back(name, numbers->front());
  }
  return found;
}

}  // namespace tessera::snapshot

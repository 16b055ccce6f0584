// Distances of redshifts in a flat universe of matter and a cosmological constant.
// Source: D. W. Hogg, Distance measures in cosmology (1999), astro-ph/9905116, equations 14 and 15.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

namespace tessera {

// The flat cosmology that turns redshifts into distances. Radiation is neglected.
struct Cosmology {
  double hubble = 0;  // H0 in km/s/Mpc
  double matter =
      0;  // the density of matter today, in units of the critical one; the rest is the cosmological constant
  friend bool operator==(const Cosmology&, const Cosmology&) = default;
};

// What is wrong with a cosmology, as the end of a sentence; "" when nothing is.
std::string why_no_cosmology(const Cosmology& cosmology);

// The line-of-sight comoving distance in Mpc,
//   D(z) = c/H0 * integral over t from 0 to z of dt / sqrt(matter (1 + t)^3 + 1 - matter),
// with a relative error below 1e-12, and the same bits on every machine: of arithmetic and square roots alone. By
// Gauss-Legendre with eight points on intervals in which 1 + t grows by an eighth: the integrand's singularities are so
// far from these that the error of the formula is below 1e-20.
class ComovingDistance {
 public:
  static constexpr double greatest_redshift = 10'000;
  // REQUIRES: why_no_cosmology() is "".
  explicit ComovingDistance(const Cosmology& cosmology);
  // Returns NaN for a redshift that is negative, above the greatest one, or NaN.
  double operator()(double redshift) const;

 private:
  double between(double low, double high) const;

  static constexpr std::size_t nodes = 80;  // (9/8)^79 is more than greatest_redshift
  Cosmology cosmology_;
  std::array<double, nodes> redshifts_{}, integrals_{};  // from 0 to there
};

}  // namespace tessera

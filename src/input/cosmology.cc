#include "src/input/cosmology.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr double light_km_s = 299'792.458;

// Half of the eight places and weights on [-1, 1]; the other places have the other sign.
// Source: Abramowitz and Stegun, Handbook of mathematical functions (1964), table 25.4.
constexpr std::array<double, 4> gauss_places{0.18343464249564980494, 0.52553240991632898582, 0.79666647741362673959,
                                             0.96028985649753623168};
constexpr std::array<double, 4> gauss_weights{0.36268378337836198297, 0.31370664587788728734, 0.22238103445337447054,
                                              0.10122853629037625915};

}  // namespace

std::string why_no_cosmology(const Cosmology& cosmology) {
  constexpr double hubble_max = 1e6;
  if (!(cosmology.hubble > 0 && cosmology.hubble <= hubble_max))
    return "H0, in km/s/Mpc, must be a number above 0, such as 70, or 100 for distances in Mpc/h";
  if (!(cosmology.matter >= 0 && cosmology.matter <= 1))
    return "the density of matter must be a number from 0 to 1, such as 0.3";
  return "";
}

ComovingDistance::ComovingDistance(const Cosmology& cosmology) : cosmology_(cosmology) {
  double scale = 1;
  for (std::size_t i = 1; i < nodes; ++i) {
    scale *= 1.125;
    redshifts_[i] = scale - 1;
    integrals_[i] = integrals_[i - 1] + between(redshifts_[i - 1], redshifts_[i]);
  }
}

double ComovingDistance::operator()(double redshift) const {
  if (!(redshift >= 0 && redshift <= greatest_redshift)) return std::numeric_limits<double>::quiet_NaN();
  const auto behind = std::upper_bound(redshifts_.begin(), redshifts_.end(), redshift);
  const auto i = static_cast<std::size_t>(behind - redshifts_.begin()) - 1;
  return light_km_s / cosmology_.hubble * (integrals_[i] + between(redshifts_[i], redshift));
}

double ComovingDistance::between(double low, double high) const {
  const double half = (high - low) / 2, middle = low + half;
  const auto integrand = [&](double z) {
    const double scale = 1 + z;
    return 1 / std::sqrt(cosmology_.matter * scale * scale * scale + (1 - cosmology_.matter));
  };
  double sum = 0;
  for (std::size_t i = 0; i < gauss_places.size(); ++i) {
    const double off = half * gauss_places[i];
    sum += gauss_weights[i] * (integrand(middle - off) + integrand(middle + off));
  }
  return half * sum;
}

}  // namespace tessera

#include "python/bindings/weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace tessera::python {
namespace {

__extension__ using Quad = __float128;  // 113 bits, exponents to 2^16383: nothing underflows or overflows below

template <class T>
T magnitude(T x) {
  return x < 0 ? -x : x;
}

template <class T>
struct Volume {
  T value = 0, terms = 0;  // terms: the sum of the absolute values of all summands, which bounds the error of `value`
  void add(T term) { value += term, terms += magnitude(term); }
};

template <class T, int D>
using Vector = std::array<T, D>;

template <class T>
Volume<T> volume(const Vector<T, 2>& a, const Vector<T, 2>& b) {
  Volume<T> sum;
  sum.add(a[0] * b[1]);
  sum.add(-a[1] * b[0]);
  return sum;
}

template <class T>
Volume<T> volume(const Vector<T, 3>& a, const Vector<T, 3>& b, const Vector<T, 3>& c) {
  Volume<T> sum;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum.add(a[i] * (b[j] * c[k]));
    sum.add(-a[i] * (b[k] * c[j]));
  }
  return sum;
}

// Computes the weights of the corners: the weight of a corner is the volume that the query spans with the other
// corners, divided by the sum of these volumes. Returns false if the rounding error may exceed some 1e-10 of the sum;
// for Quad only if the sum is zero.
template <class T, int D>
bool weigh(const std::array<const double*, D + 1>& corners, const double* q, double* out) {
  std::array<Vector<T, D>, D + 1> from;
  for (int i = 0; i <= D; ++i) {
    for (int axis = 0; axis < D; ++axis) from[i][axis] = T(corners[i][axis]) - T(q[axis]);
  }
  std::array<T, D + 1> weights;
  T sum = 0, terms = 0;
  for (int i = 0; i <= D; ++i) {
    Volume<T> opposite;
    if constexpr (D == 2) {
      opposite = volume<T>(from[(i + 1) % 3], from[(i + 2) % 3]);
    } else {
      opposite = volume<T>(from[(i + 1) % 4], from[(i + 2) % 4], from[(i + 3) % 4]);
    }
    weights[i] = magnitude(opposite.value);
    sum += weights[i];
    terms += opposite.terms;
  }
  constexpr bool last_try = sizeof(T) > sizeof(double);
  const bool sound = sum > terms * T(1e-5) && terms > T(1e-270) && terms < T(1e300);
  if (last_try ? !(sum > 0) : !sound) return false;
  for (int i = 0; i <= D; ++i) out[i] = static_cast<double>(weights[i] / sum);
  return true;
}

template <int D>
void all_weights(std::span<const double> points, std::span<const std::int32_t> simplices,
                 std::span<const double> queries, std::span<const std::int32_t> found, std::span<double> out) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    double* mine = &out[i * (D + 1)];
    if (found[i] < 0) {
      std::fill_n(mine, D + 1, std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    std::array<const double*, D + 1> corners;
    for (int k = 0; k <= D; ++k) {
      const std::size_t vertex = static_cast<std::size_t>(simplices[static_cast<std::size_t>(found[i]) * (D + 1) + k]);
      corners[k] = &points[vertex * D];
    }
    const double* q = &queries[i * D];
    if (weigh<double, D>(corners, q, mine) || weigh<Quad, D>(corners, q, mine)) continue;
    std::fill_n(mine, D + 1, 1.0 / (D + 1));  // flatter than 113 bits can tell: any weights are as good
  }
}

}  // namespace

void barycentric_weights(std::span<const double> points, std::span<const std::int32_t> simplices, int dimension,
                         std::span<const double> queries, std::span<const std::int32_t> found, std::span<double> out) {
  if (dimension == 2) {
    all_weights<2>(points, simplices, queries, found, out);
  } else {
    all_weights<3>(points, simplices, queries, found, out);
  }
}

}  // namespace tessera::python

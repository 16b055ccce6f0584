#include "src/result/terrain/square_cells.h"

namespace tessera::terrain {

SquareCells::SquareCells(const Lattice& part, const Lattice& whole, std::vector<double> values)
    : part_(part), whole_(whole), values_(std::move(values)) {
  constexpr double number_max = 0x1p31;
  for (const double value : values_) too_far_ = too_far_ || std::abs(value) >= number_max;
  if (too_far_) return;
  for (std::int64_t row = 0; row + 1 < part_.height; ++row) {
    for (std::int64_t column = 0; column + 1 < part_.width; ++column) {
      const Square square = square_at(column, row);
      if (square.low >= square.high) continue;
      if (begin_ == end_) {
        begin_ = square.low;
        end_ = square.high;
      }
      begin_ = std::min(begin_, square.low);
      end_ = std::max(end_, square.high);
    }
  }
}

SquareCells::Square SquareCells::square_at(std::int64_t column, std::int64_t row) const {
  const auto first = static_cast<std::int32_t>(row * part_.width + column),
             above = static_cast<std::int32_t>(part_.width);
  Square square{.nodes = {first, first + 1, first + above + 1, first + above}, .values = {}};
  for (std::size_t k = 0; k < 4; ++k) square.values[k] = values_[static_cast<std::size_t>(square.nodes[k])];
  const auto& v = square.values;
  // NaN if a value is NaN.
  if (std::isnan((v[0] + v[1]) + (v[2] + v[3]))) return square;
  const auto [least, most] = std::minmax({v[0], v[1], v[2], v[3]});
  square.low = static_cast<std::int64_t>(std::floor(least)) + 1;
  square.high = static_cast<std::int64_t>(std::floor(most)) + 1;
  return square;
}

std::vector<std::uint64_t> SquareCells::most_pieces() const {
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(end_ - begin_) + 1);
  for (std::int64_t row = 0; row + 1 < part_.height; ++row) {
    for (std::int64_t column = 0; column + 1 < part_.width; ++column) {
      const Square square = square_at(column, row);
      if (square.low >= square.high) continue;
      counts[static_cast<std::size_t>(square.low - begin_)] += 2;
      counts[static_cast<std::size_t>(square.high - begin_)] -= 2;
    }
  }
  for (std::size_t k = 1; k < counts.size(); ++k) counts[k] += counts[k - 1];
  counts.pop_back();
  return counts;
}

Point SquareCells::crossing(const TileEdge& side, std::int64_t level) const {
  const double at_a = values_[static_cast<std::size_t>(side.a)], at_b = values_[static_cast<std::size_t>(side.b)];
  constexpr double least = 0x1p-10;
  const double part = std::clamp((static_cast<double>(level) - at_a) / (at_b - at_a), least, 1 - least);
  const auto place = [&](std::int64_t from, std::int64_t to) {
    const double u = static_cast<double>(from) * part_.res, v = static_cast<double>(to) * part_.res;
    return std::clamp(u + part * (v - u), u, v);  // monotone in the level, also when rounded
  };
  const std::int64_t width = part_.width;
  return without_negative_zero({place(part_.column0 + side.a % width, part_.column0 + side.b % width),
                                place(part_.row0 + side.a / width, part_.row0 + side.b / width), 0});
}

PointId SquareCells::id_of(std::int32_t node) const {
  const std::int64_t column = part_.column0 + node % part_.width, row = part_.row0 + node / part_.width;
  return PointId{static_cast<std::uint64_t>((row - whole_.row0) * whole_.width + column - whole_.column0)};
}

}  // namespace tessera::terrain

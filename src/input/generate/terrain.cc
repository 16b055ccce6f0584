#include "src/input/generate/terrain.h"

#include <algorithm>
#include <cmath>

#include "src/input/generate/portable_math.h"

namespace tessera {
namespace {

constexpr double west = 650'000, south = 6'860'000;  // metres, Lambert-93
constexpr double spacing = 0.288675;                 // makes 12 points a square metre
constexpr double block = 40;                         // the side of a square that has one building or none
constexpr double roof_share = 0.25;                  // the share of squares with a building

double rounded(double v) { return std::floor(v / Terrain::step() + 0.5) / (1 / Terrain::step()); }

double unit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace

Terrain::Terrain(std::uint64_t points, std::uint64_t seed) : random_(seed), seed_(seed) {
  columns_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::sqrt(static_cast<double>(points))));
  rows_ = points / columns_ + 1;
  for (auto& phase : phase_) phase = random_.unit();
}

Bounds Terrain::bounds() const {
  Bounds bounds;
  bounds.add(Point{west - 1, south - 1, 0});
  bounds.add(
      Point{west + 1 + spacing * static_cast<double>(columns_), south + 1 + spacing * static_cast<double>(rows_), 400});
  return bounds;
}

// The height of the ground: between 40 and 200 m, with slopes up to a third.
double Terrain::ground(double x, double y) const {
  const double u = x - west, v = y - south;
  return 120 + 45 * sine_of_turns(u / 1900 + phase_[0]) * sine_of_turns(v / 2300 + phase_[1]) +
         12 * sine_of_turns((u + 0.6 * v) / 430 + phase_[2]) + 4 * sine_of_turns((u - 1.3 * v) / 97 + phase_[3]);
}

Terrain::Roof Terrain::roof_near(double x, double y) const {
  const double column = std::floor((x - west) / block), row = std::floor((y - south) / block);
  std::uint64_t bits =
      mixed_bits(seed_ ^ mixed_bits(static_cast<std::uint64_t>(static_cast<std::int64_t>(column)) * 0x1F3D5B79u +
                                    static_cast<std::uint64_t>(static_cast<std::int64_t>(row))));
  const auto draw = [&] { return unit(bits = mixed_bits(bits)); };
  Roof roof{};
  roof.there = draw() < roof_share;
  const double width = 8 + 22 * draw(), depth = 8 + 22 * draw();
  roof.x_lo = west + column * block + (block - width) * draw();
  roof.y_lo = south + row * block + (block - depth) * draw();
  roof.x_hi = roof.x_lo + width;
  roof.y_hi = roof.y_lo + depth;
  // A roof is flat to the centimetre, with thousands of points in one plane, as real roofs have.
  roof.height = rounded(ground(roof.x_lo, roof.y_lo) + 4 + 9 * draw());
  return roof;
}

Terrain::Return Terrain::at(std::uint64_t index) {
  const std::uint64_t row = index / columns_;
  std::uint64_t column = index % columns_;
  if (row % 2 == 1) column = columns_ - 1 - column;  // the mirror swings back
  const double x = rounded(west + spacing * (static_cast<double>(column) + random_.between(0.1, 0.9)));
  const double y = rounded(south + spacing * (static_cast<double>(row) + random_.between(0.1, 0.9)));
  const double noise = random_.between(-0.03, 0.03), chance = random_.unit(), tall = random_.unit();

  const Roof roof = roof_near(x, y);
  if (roof.there && x >= roof.x_lo && x <= roof.x_hi && y >= roof.y_lo && y <= roof.y_hi)
    return {{x, y, roof.height}, class_building};
  const double z = ground(x, y) + noise;
  // Wood grows where the product of two waves is positive, which is half of the land. Two fifths of its returns are
  // from trees.
  const bool wood = sine_of_turns((x - west) / 310 + phase_[4]) * sine_of_turns((y - south) / 270 + phase_[5]) > 0;
  if (wood && chance < 0.4) return {{x, y, rounded(z + 0.5 + 17.5 * tall * (1 - 0.3 * tall))}, class_tree};
  return {{x, y, rounded(z)}, class_ground};
}

}  // namespace tessera

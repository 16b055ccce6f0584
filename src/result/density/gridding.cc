#include "src/result/density/gridding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "src/base/image.h"
#include "src/base/option.h"
#include "src/geometry/mesh/image_order.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/density/shares.h"
#include "src/result/measure/values.h"
#include "src/result/pass.h"
#include "src/result/tile_queue.h"

namespace tessera::density {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
// Of a voxel. A field has no mean over a smaller part: a cell that only touches a voxel may have one, by rounding.
constexpr double least_part = 0x1p-30;
// Sums have room for as many terms.
constexpr std::uint64_t cells_max = std::uint64_t{1} << 38;

Error stopped() { return error(Errc::interrupted, "interrupted while putting cells on a grid"); }

// The code of the vertex's offset (src/base/image.h).
std::uint32_t code_of(const TileMesh& mesh, std::size_t vertex) {
  return mesh.offsets.empty() ? 0 : mesh.offsets[vertex];
}

// The corners of a cell in their order (image_order.h), so that everything has the same bits in all tiles. Of the
// copies of a cell in a periodic cloud this is the one whose first corner lies in the box.
struct SortedCell {
  std::array<std::size_t, 4> vertices{};
  std::array<Point, 4> corners;
  std::array<std::uint8_t, 4> oriented{};  // the places of the corners in the cell's own order, which is positive
  bool positive = true;                    // the sorted order
};

SortedCell sorted_cell(const TileMesh& mesh, const Period& period, std::span<const std::int32_t> vertices) {
  SortedCell cell;
  std::array<std::uint8_t, 4> order{0, 1, 2, 3};
  const auto id = [&](std::uint8_t k) { return image_order(mesh, static_cast<std::size_t>(vertices[k])); };
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    for (std::size_t j = i; j > 0 && id(order[j]) < id(order[j - 1]); --j) {
      std::swap(order[j], order[j - 1]);
      cell.positive = !cell.positive;
    }
  }
  const PeriodOffset first = image::offset(code_of(mesh, static_cast<std::size_t>(vertices[order[0]])));
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    cell.vertices[k] = static_cast<std::size_t>(vertices[order[k]]);
    cell.corners[k] = period.shifted(mesh.points[cell.vertices[k]], PeriodOffset{} - first);  // is not rounded
    if (mesh.dimension == 2) cell.corners[k].z = 0;
    cell.oriented[order[k]] = static_cast<std::uint8_t>(k);
  }
  return cell;
}

// Columns of a pass for numbers of any size.
std::vector<PassColumn> density_columns() {
  return {{false, {"fraction", AttributeType::f64}}, {false, {"exponent", AttributeType::i32}}};
}

PassValues pass_values(const std::vector<ScaledDouble>& numbers) {
  std::vector<double> fractions;
  std::vector<std::int32_t> exponents;
  for (const auto& number : numbers) {
    fractions.push_back(number.fraction);
    exponents.push_back(number.exponent);
  }
  return {as_bytes(fractions), as_bytes(exponents)};
}

std::vector<ScaledDouble> numbers_of(const PassValues& values) {
  std::vector<ScaledDouble> numbers(values[0].size() / sizeof(double));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::memcpy(&numbers[i].fraction, values[0].data() + i * sizeof(double), sizeof(double));
    std::memcpy(&numbers[i].exponent, values[1].data() + i * sizeof(std::int32_t), sizeof(std::int32_t));
  }
  return numbers;
}

Status check_names(const GridOptions& options) {
  const bool is_density = options.kind == GridKind::density;
  if (!is_density && !options.mass.empty())
    return error(Errc::usage, option("mass") + ": has the masses for a density, but a field has none");
  return success();
}

// Sums have places for the voxels of the manifest's bounds and their images alone.
Status check_bounds(const TileSource& source, std::size_t index, const TileMesh& mesh) {
  const Bounds& bounds = source.manifest().bounds;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Point p = source.period().shifted(mesh.points[v], PeriodOffset{} - image::offset(code_of(mesh, v)));
    for (int axis = 0; axis < mesh.dimension; ++axis)
      if (!(p[axis] >= bounds.lo[axis] && p[axis] <= bounds.hi[axis]))
        return error(Errc::corrupt, source.file(index).string() + ": has a vertex outside of the manifest's bounds");
  }
  return success();
}

}  // namespace

Result<GridRequest> check_request(const std::filesystem::path& out, const GridOptions& options) {
  BOOST_OUTCOME_TRYV(check_names(options));
  BOOST_OUTCOME_TRY(source, TileSource::open(out, Periods::known));
  const Manifest& manifest = source.manifest();
  if (options.kind == GridKind::density && manifest.region)
    return error(Errc::usage, out.string() +
                                  ": is a region, where not all cells around a vertex are known; densities "
                                  "need a whole triangulation");
  if (manifest.cells > cells_max) return error(Errc::usage, out.string() + ": has more cells than a grid can take");
  // A box without heights has infinite ones.
  if (options.shape.box && std::isfinite(options.shape.box->lo.z) != (manifest.dimension == 3))
    return error(Errc::usage, option("bbox") + (manifest.dimension == 3 ? ": has 4 numbers, but a 3D result takes 6"
                                                                        : ": has 6 numbers, but a 2D result takes 4"));
  BOOST_OUTCOME_TRY(quantity, Quantity::find(out, manifest, options.kind, options.names));
  BOOST_OUTCOME_TRY(grid,
                    voxels_over(out.string(), manifest.dimension, source.period(), options.shape, manifest.bounds));
  return GridRequest{std::move(source), std::move(quantity), grid};
}

Result<Gridding> Gridding::begin(const GridRequest& request, const GridOptions& options,
                                 const std::filesystem::path& scratch, std::stop_token stop) {
  const std::size_t components = request.quantity.components();
  BOOST_OUTCOME_TRY(sums, SumFile::create(scratch, components + (options.kind == GridKind::density ? 0 : 1)));
  return Gridding(request, options, scratch, std::move(stop), std::move(sums));
}

Status Gridding::run(const std::function<void(double)>& progress) {
  // A quarter of the memory is for sums, the rest for tiles.
  sums_bytes_ =
      std::max<std::uint64_t>(options_.memory_bytes / 4 / options_.threads, 8 * ThreadSums::block_bytes(sums_.sums()));
  return options_.kind == GridKind::density ? run_density(progress) : run_field(progress);
}

Status Gridding::run_density(const std::function<void(double)>& progress) {
  const TileSource& source = request_.source;
  BOOST_OUTCOME_TRY(masses, VertexMasses::open(source, options_.mass, options_.memory_bytes));
  shared_->note = masses.note();
  // The second round holds a tile with its cells, for which the pass does not allow.
  Pass pass(source, density_columns(), scratch_,
            {.threads = options_.threads,
             .memory_bytes = options_.memory_bytes / 3,
             .tile_factor = 1.5,
             .stop = stop_,
             .progress = progress});
  return pass.run(
      [&](std::size_t index, const StoredTile& tile) -> Result<PassValues> {
        BOOST_OUTCOME_TRY(own, masses.of(source, index, tile.mesh));
        BOOST_OUTCOME_TRY(densities, star_densities(source, index, tile.mesh, own, stop_));
        const std::lock_guard lock(shared_->mutex);
        for (const double mass : own) shared_->mass.add(ScaledDouble::of(mass));
        return pass_values(densities);
      },
      [&](std::size_t index, const PassValues& values) { return put(index, numbers_of(values)); });
}

Status Gridding::run_field(const std::function<void(double)>& progress) {
  return for_each_tile(request_.source,
                       {.threads = options_.threads,
                        .memory_bytes = options_.memory_bytes / 4 * 3,
                        .tile_factor = 1.5,
                        .stop = stop_,
                        .progress = progress},
                       [&](const TileSource&, std::size_t index) { return put(index, {}); });
}

Status Gridding::put(std::size_t index, std::span<const ScaledDouble> densities) {
  const TileSource source = request_.source.stopped_by(stop_);
  BOOST_OUTCOME_TRY(tile, source.read(index, {.rows = request_.quantity.needs_rows()}));
  BOOST_OUTCOME_TRYV(check_bounds(source, index, tile.mesh));
  ThreadSums sums(request_.grid, sums_.sums());
  Status status = success();
  BOOST_OUTCOME_TRYV(
      for_each_cell(source, index, tile.mesh, stop_,
                    [&](std::size_t cell, std::span<const std::int32_t> vertices, const ScaledInteger& exact) {
                      if (tile.mesh.cell_ghost[cell] == 0 && status)
                        status = put_cell(tile, vertices, scaled_quotient(exact, 1), densities, sums);
                    }));
  BOOST_OUTCOME_TRYV(std::move(status));
  return sums_.add(sums);
}

// `volume` is d! times the volume.
Status Gridding::put_cell(const StoredTile& tile, std::span<const std::int32_t> vertices, const ScaledDouble& volume,
                          std::span<const ScaledDouble> densities, ThreadSums& sums) {
  const SortedCell cell = sorted_cell(tile.mesh, request_.source.period(), vertices);
  const std::size_t corners = vertices.size(), components = request_.quantity.components();
  const auto points = std::span(cell.corners).first(corners);
  const ScaledDouble cell_volume = volume / ScaledDouble::of(corners == 3 ? 2 : 6);
  std::optional<CellFunctions> functions;  // of a cell that meets the grid
  Status status = success();
  std::uint64_t taken = 0;
  const auto take = [&](const CellShare& share) {
    if (!functions) {
      const ScaledDouble signed_volume{cell.positive ? volume.fraction : -volume.fraction, volume.exponent};
      functions =
          request_.quantity.in_cell(tile, std::span(cell.vertices).first(corners), points, signed_volume, densities);
    }
    const ScaledDouble& unit = share.of_voxel ? voxel_volume_ : cell_volume;
    OrderFreeSum* const at = sums.at(share.at);
    for (std::size_t c = 0; c < components; ++c) {
      if ((*functions)[c].known)
        at[c].add((*functions)[c].over(share.weights) * unit);
      else
        at[c].spoil();
    }
    if (sums_.sums() > components) {
      const double part = share.weights[0] + share.weights[1] + share.weights[2] + share.weights[3];
      at[components].add(ScaledDouble::of(part) * unit);
    }
    // One cell may cover a large grid.
    if (sums.bytes() > sums_bytes_) status = sums_.add(sums);
    if (++taken % 4096 == 0 && status && stop_.stop_requested()) status = stopped();
    return status.has_value();
  };
  if (options_.sample)
    sample_shares(request_.grid, points, std::span(cell.oriented).first(corners), take);
  else
    mean_shares(request_.grid, points, take);
  return status;
}

double Gridding::value_of(const OrderFreeSum* sums, std::size_t component) const {
  if (options_.kind == GridKind::density) return (sums[0].value() / voxel_volume_).value();
  const ScaledDouble volume = sums[request_.quantity.components()].value();
  if (sums[component].spoiled() || !((volume / voxel_volume_).value() >= least_part)) return nan;
  return (sums[component].value() / volume).value();
}

void Gridding::values_of(std::int64_t x, std::int64_t y, std::int64_t z, const BlockSums& block,
                         std::span<double> values, std::size_t line) {
  const Blocking blocking(request_.grid);
  const std::size_t components = request_.quantity.components();
  const auto side = static_cast<std::size_t>(blocking.side);
  const std::size_t depth = request_.grid.dimension == 2 ? 1 : side;
  const std::array<std::int64_t, 3> from{x * blocking.side, y * blocking.side, z * blocking.side};
  const auto& size = request_.grid.size;
  const auto width = static_cast<std::size_t>(std::min(blocking.side, size[0] - from[0]));
  for (std::size_t k = 0; k < depth; ++k) {
    for (std::size_t j = 0; j < side; ++j) {
      if (from[1] + static_cast<std::int64_t>(j) >= size[1] || from[2] + static_cast<std::int64_t>(k) >= size[2])
        continue;
      for (std::size_t i = 0; i < width; ++i) {
        const OrderFreeSum* const sums = block.data() + ((k * side + j) * side + i) * sums_.sums();
        if (options_.kind == GridKind::density) grid_mass_.add(sums[0].value());
        for (std::size_t c = 0; c < components; ++c) {
          const double value = value_of(sums, c);
          known_ += c == 0 && !std::isnan(value) ? 1 : 0;
          values[((k * side + j) * line + i) * components + c] = value;
        }
      }
    }
  }
}

Status Gridding::for_each_run(std::uint64_t memory_bytes, const TakeRun& take) {
  const Blocking blocking(request_.grid);
  const auto& size = request_.grid.size;
  const std::size_t components = request_.quantity.components();
  const auto lines = static_cast<std::int64_t>(voxels_a_block) / blocking.side;  // of a block
  const auto bytes = static_cast<std::uint64_t>(voxels_a_block) * components * sizeof(double);
  const auto at_once = static_cast<std::int64_t>(
      std::clamp<std::uint64_t>(memory_bytes / bytes, 1, static_cast<std::uint64_t>(blocking.blocks[0])));
  std::vector<double> values;
  BlockSums sums;
  const BlockSums none(static_cast<std::size_t>(voxels_a_block) * sums_.sums());
  for (std::int64_t z = 0; z < blocking.blocks[2]; ++z) {
    for (std::int64_t y = 0; y < blocking.blocks[1]; ++y) {
      for (std::int64_t x = 0; x < blocking.blocks[0]; x += at_once) {
        if (stop_.stop_requested()) return stopped();
        const std::int64_t end = std::min(x + at_once, blocking.blocks[0]);
        const std::int64_t line = (end - x) * blocking.side;
        values.resize(static_cast<std::size_t>(line * lines) * components);
        for (std::int64_t block = x; block < end; ++block) {
          BOOST_OUTCOME_TRY(there, sums_.read(blocking.number(block, y, z), sums));
          const auto first = static_cast<std::size_t>((block - x) * blocking.side) * components;
          values_of(block, y, z, there ? sums : none, std::span(values).subspan(first), static_cast<std::size_t>(line));
        }
        const std::int64_t width = std::min(line, size[0] - x * blocking.side);
        for (std::int64_t i = 0; i < lines; ++i) {
          const std::int64_t row = y * blocking.side + i % blocking.side, layer = z * blocking.side + i / blocking.side;
          if (row >= size[1] || layer >= size[2]) continue;
          const auto place =
              static_cast<std::uint64_t>((layer * size[1] + row) * size[0] + x * blocking.side) * components;
          BOOST_OUTCOME_TRYV(take(place, std::span(values).subspan(static_cast<std::size_t>(i * line) * components,
                                                                   static_cast<std::size_t>(width) * components)));
        }
      }
    }
  }
  return success();
}

GridFacts Gridding::facts() const {
  const VoxelGrid& grid = request_.grid;
  GridFacts facts{.dimension = grid.dimension,
                  .size = grid.size,
                  .res = grid.res(),
                  .components = request_.quantity.components(),
                  .known = known_,
                  .note = shared_->note};
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(grid.dimension); ++axis) {
    facts.origin[axis] = grid.axes[axis].plane(grid.first[axis]).at;
    facts.widths[axis] = grid.axes[axis].width();
    facts.period[axis] = request_.source.period().length[axis];
  }
  if (options_.kind == GridKind::density) {
    facts.mass = shared_->mass.value().value();
    facts.grid_mass = grid_mass_.value().value();
  }
  return facts;
}

}  // namespace tessera::density

// Puts the cells of a result on a grid, tile by tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>

#include "src/base/result.h"
#include "src/result/density/density.h"
#include "src/result/density/quantity.h"
#include "src/result/density/sums.h"
#include "src/result/density/voxel_grid.h"
#include "src/result/measure/order_free_sum.h"
#include "src/result/measure/star_density.h"
#include "src/result/tile_source.h"

namespace tessera::density {

// What is asked of a result, checked.
struct GridRequest {
  TileSource source;
  Quantity quantity;
  VoxelGrid grid;
};

// Errors: usage for wrong options, as write_grid(); those of opening a result.
Result<GridRequest> check_request(const std::filesystem::path& out, const GridOptions& options);

class Gridding {
 public:
  // `scratch` is an empty folder. References must stay valid as long as this object. Error io.
  static Result<Gridding> begin(const GridRequest& request, const GridOptions& options,
                                const std::filesystem::path& scratch, std::stop_token stop);

  // Reads all tiles. `progress` gets the fraction that is done. Errors: as write_grid().
  Status run(const std::function<void(double)>& progress);

  // Calls take(place, values) for all values of the grid, in runs along x; `place` is the number of the first value in
  // the order of a .npy file. At most `memory_bytes` are held beside. Errors: those of reading sums and of `take`;
  // interrupted. Call this after run().
  using TakeRun = std::function<Status(std::uint64_t place, std::span<const double> values)>;
  Status for_each_run(std::uint64_t memory_bytes, const TakeRun& take);
  // What is known after for_each_run().
  GridFacts facts() const;

 private:
  // What several threads add to.
  struct Shared {
    std::mutex mutex;
    OrderFreeSum mass;
    std::string note;
  };
  Gridding(const GridRequest& request, const GridOptions& options, std::filesystem::path scratch, std::stop_token stop,
           SumFile sums)
      : request_(request),
        options_(options),
        scratch_(std::move(scratch)),
        stop_(std::move(stop)),
        sums_(std::move(sums)),
        voxel_volume_(request.grid.voxel_volume()),
        shared_(std::make_unique<Shared>()) {}

  Status run_density(const std::function<void(double)>& progress);
  Status run_field(const std::function<void(double)>& progress);
  Status put(std::size_t index, std::span<const ScaledDouble> densities);
  Status put_cell(const StoredTile& tile, std::span<const std::int32_t> vertices, const ScaledDouble& volume,
                  std::span<const ScaledDouble> densities, ThreadSums& sums);
  double value_of(const OrderFreeSum* sums, std::size_t component) const;
  void values_of(std::int64_t x, std::int64_t y, std::int64_t z, const BlockSums& block, std::span<double> values,
                 std::size_t line);

  const GridRequest& request_;
  const GridOptions& options_;
  std::filesystem::path scratch_;
  std::stop_token stop_;
  SumFile sums_;
  ScaledDouble voxel_volume_;
  std::unique_ptr<Shared> shared_;
  std::uint64_t sums_bytes_ = 0;  // that a thread may hold
  std::uint64_t known_ = 0;
  OrderFreeSum grid_mass_;
};

}  // namespace tessera::density

// The change of a result as a job over its tiles, in two stages: tiles tell each other of holes (holes_program.h), and
// exchange points (changed_program.h). When no points are removed, there is only the second stage. When most tiles
// would begin, there is only one stage, too: a first triangulation (anew.h).
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "src/delaunay/run/result_stages.h"

namespace tessera {

// ShareSpec::stages. The second kind is for a change that removes points; the first one has only the second stage.
inline constexpr const char* kind_of_update = "update";
inline constexpr const char* kind_of_update_with_holes = "update-with-holes";

// The job. What its tiles must know is in update_change_file().
struct UpdateJob {
  std::string result;                     // the digest of the result
  std::string tiles;                      // checksum of its tile list
  std::string change;                     // checksum of update_change_file()
  std::map<TileId, std::uint64_t> added;  // the number of new points, by tile
  bool writes = true;                     // false: it is only found out what would change
  std::string anew;                       // checksum of update_anew_file(); empty: tiles exchange what has changed
  std::uint64_t number = 0;               // random number of the run, so that jobs of two runs always differ
};
std::string to_json(const UpdateJob& job);
// `name`: of the file, for errors. Error corrupt.
Result<UpdateJob> read_update_job(std::span<const std::byte> bytes, const std::string& name);

class UpdateStages final : public ResultStages {
 public:
  explicit UpdateStages(bool holes) : holes_(holes) {}
  std::uint32_t count() const override { return holes_ ? 2 : 1; }
  Result<std::vector<std::shared_ptr<const TilePrograms>>> programs(const ResultInput& input) const override;
  Result<std::vector<TileReceipt>> stored(const std::filesystem::path& run, std::uint32_t stage) const override;
  std::uint64_t work_bytes(const TileSource& source, std::size_t i) const override;
  Result<std::vector<std::uint64_t>> weights(const TileSource& source, const std::filesystem::path& run,
                                             std::span<const std::byte> plan) const override;
  void adjust(ScheduleOptions& schedule, const TileSource& source) const override;

 private:
  bool holes_;
};

}  // namespace tessera

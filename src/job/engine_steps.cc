#include "src/job/engine_steps.h"

#include <algorithm>
#include <memory>

#include "src/delaunay/update/update_stages.h"
#include "src/surface/surface_stages.h"

namespace tessera {

KindsOfStages kinds_of_stages() {
  return {{surface::kind_of_surface, std::make_shared<const surface::SurfaceStages>()},
          {kind_of_update, std::make_shared<const UpdateStages>(false)},
          {kind_of_update_with_holes, std::make_shared<const UpdateStages>(true)}};
}

Status EngineSteps::run(const std::filesystem::path& result, const std::filesystem::path& run,
                        const std::filesystem::path& lock_file, const std::function<void(double)>& part,
                        const std::stop_token& stop) {
  return EngineStages(engine_, options_, progress_).run(surface::kind_of_surface, result, run, lock_file, part, stop);
}

Status EngineStages::run(const std::string& kind, const std::filesystem::path& result, const std::filesystem::path& run,
                         const std::filesystem::path& lock_file, const std::function<void(double)>& part,
                         const std::stop_token& stop) {
  ResultJob job{kind, result, run, options_};
  job.options.lock_file = lock_file.string();
  return engine_.run(job, part, progress_, stop);
}

std::uint64_t EngineSteps::bytes_of_one() const {
  constexpr unsigned few_threads = 2;
  const bool cluster = !engine_.shares().empty();
  if (cluster || std::min(engine_.threads(), options_.threads) > few_threads) return 0;
  return options_.memory_bytes / 2;  // the rest is for a tile and mail
}

}  // namespace tessera

// Runs a job from points to a finished result folder, in one process.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "actors/engine/engine.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"
#include "src/job/job_options.h"
#include "src/job/report/summary.h"
#include "src/job/result_folder.h"
#include "src/result/store/tile_store.h"
#include "src/result/store/tile_taker.h"

namespace tessera {

// Opens the points of a job, and sets options.cloud.dimension if it is 0. See open_cloud().
using OpenCloud = std::function<Result<Cloud>(JobOptions& options, const std::stop_token& stop)>;

// Makes the result, or continues the run in `folder`. Returns nothing when the result was complete already. After an
// error the caller decides what stays: folder.abandon(), or folder.abandon_unless_resumable() if the error is
// `interrupted`. Several jobs may run at once on one engine, each in its own folder and with its own threads and
// memory.
Result<std::optional<JobSummary>> run_job(Engine& engine, JobOptions options, const OpenCloud& open,
                                          ResultFolder& folder, Progress& progress, const std::stop_token& stop);

// Makes the consumer of the tiles' cells, once the points are known. The manifest has no tiles yet.
using MakeTaker = std::function<Result<TileConsumer*>(const Manifest& manifest)>;

// Makes no result: the cells of each tile go to the consumer that `make` returns. `folder` holds only temporary files;
// the caller abandons it whether the job succeeds or fails. REQUIRES: the engine is not part of a cluster. Errors: as
// above; of the consumer.
Status run_tiles(Engine& engine, JobOptions options, const OpenCloud& open, const MakeTaker& make, ResultFolder& folder,
                 Progress& progress, const std::stop_token& stop);

}  // namespace tessera

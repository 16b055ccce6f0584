// From points to a finished result folder, in one process.
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

// Opens the points of a job, and settles options.cloud.dimension when it is 0. See open_cloud().
using OpenCloud = std::function<Result<Cloud>(JobOptions& options, const std::stop_token& stop)>;

// Makes the result, or goes on with the run that `folder` holds. Nothing when that result was complete already. After
// an error the caller says what shall stay: folder.abandon(), or, when it is `interrupted`, folder.interrupted().
// Several jobs may run at once on one engine, each in its own folder and with its share of threads and memory.
Result<std::optional<JobSummary>> run_job(Engine& engine, JobOptions options, const OpenCloud& open,
                                          ResultFolder& folder, Progress& progress, const std::stop_token& stop);

// What takes the cells of tiles, made when it is known of which points: the manifest has no tiles yet.
using MakeTaker = std::function<Result<TileConsumer*>(const Manifest& manifest)>;

// Makes no result: the cells of each tile go to what `make` makes, and `folder` holds only what waits on disk
// meanwhile; whatever comes of it, the caller abandons the folder. REQUIRES: the engine is of no cluster. Errors: as
// above; of the taker.
Status run_tiles(Engine& engine, JobOptions options, const OpenCloud& open, const MakeTaker& make, ResultFolder& folder,
                 Progress& progress, const std::stop_token& stop);

}  // namespace tessera

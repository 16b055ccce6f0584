// The writer of LAS 1.4, point format 0; see writer.h.
#pragma once

#include <memory>

#include "src/base/files/output_file.h"
#include "src/input/generate/writer.h"

namespace tessera {

Result<std::unique_ptr<PointWriter>> open_las_writer(OutputFile file, const WriterOptions& options);

}  // namespace tessera

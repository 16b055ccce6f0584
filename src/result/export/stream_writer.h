// The base of the writers whose file is a single stream of bytes.
#pragma once

#include <cstdint>
#include <utility>

#include "src/result/export/mesh_writer.h"
#include "src/result/export/output.h"

namespace tessera::exports {

class StreamWriter : public MeshWriter {
 public:
  explicit StreamWriter(OutputFile file) : file_(std::move(file)), stream_(file_, 0) {}
  Status check() final { return stream_.status(); }
  Result<std::uint64_t> finish() final {
    end();
    BOOST_OUTCOME_TRYV(stream_.flush());
    return file_.finish();
  }

 private:
  OutputFile file_;

 protected:
  // Writes what follows the last cell.
  virtual void end() {}
  Stream stream_;
};

}  // namespace tessera::exports

#include "src/delaunay/run/run_options.h"

#include <utility>

#include "job.pb.h"

namespace tessera {

std::string to_bytes(const DelaunayOptions& options) {
  proto::DelaunayOptions message;
  message.set_kernel(static_cast<proto::DelaunayOptions::Kernel>(options.kernel));
  message.set_keep(static_cast<proto::DelaunayOptions::TileRetention>(options.keep));
  message.set_store(static_cast<proto::DelaunayOptions::Store>(options.store));
  message.set_neighbors(options.neighbors);
  return message.SerializeAsString();
}

Result<DelaunayOptions> delaunay_options_from_bytes(const std::string& bytes) {
  proto::DelaunayOptions message;
  if (!message.ParseFromString(bytes) || !proto::DelaunayOptions::Kernel_IsValid(message.kernel()) ||
      !proto::DelaunayOptions::TileRetention_IsValid(message.keep()) ||
      !proto::DelaunayOptions::Store_IsValid(message.store())) {
    return error(Errc::internal, "the options of a job cannot be read");
  }
  return DelaunayOptions{static_cast<KernelKind>(message.kernel()), static_cast<TileRetention>(message.keep()),
                         static_cast<StoreAs>(message.store()), message.neighbors()};
}

ShareSpec spec_of(const RunOptions& options, std::string run_folder, std::string out_folder) {
  ShareSpec spec;
  spec.threads = options.threads;
  spec.memory_bytes = options.memory_bytes;
  spec.resumable = options.resumable;
  spec.grace_s = options.grace_s;
  spec.lock_file = options.lock_file;
  spec.run_folder = std::move(run_folder);
  spec.out_folder = std::move(out_folder);
  spec.programs = to_bytes(DelaunayOptions{options.kernel, options.keep, options.store, options.neighbors});
  return spec;
}

}  // namespace tessera

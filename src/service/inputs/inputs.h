// Lists what jobs may read, and receives uploads.
#pragma once

#include <memory>
#include <string_view>

#include "src/service/inputs/inputs_backend.h"
#include "src/service/inputs/roots.h"
#include "src/service/inputs/uploads.h"

namespace tessera::service {

class Inputs final : public InputsBackend {
 public:
  // `uploads` is null where uploads are not allowed.
  Inputs(const Roots& roots, Uploads* uploads) : roots_(roots), uploads_(uploads) {}

  Reply<proto::InputList> list(std::string_view folder, std::uint32_t limit, std::string_view after,
                               const Caller& caller) override;
  Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                        const Caller& caller) override;
  Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) override;
  Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) override;

 private:
  const Roots& roots_;
  Uploads* uploads_;
};

}  // namespace tessera::service

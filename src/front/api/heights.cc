#include "tessera/heights.h"

#include <cmath>
#include <optional>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/job/machine.h"
#include "src/result/heights/copies.h"
#include "tessera/triangulation.h"

namespace tessera {

struct HeightsRequest::Impl {
  std::filesystem::path ground;  // empty: made of the inputs
  std::optional<int> ground_class;
  std::string format;
  HeightsOptions heights = {.threads = 0};
  bool overwrite = false;
  std::uint64_t memory_bytes = 0;
};

HeightsRequest::HeightsRequest() : impl_(std::make_unique<Impl>()) {}
HeightsRequest::HeightsRequest(const HeightsRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
HeightsRequest& HeightsRequest::operator=(const HeightsRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
HeightsRequest::~HeightsRequest() = default;

HeightsRequest& HeightsRequest::ground(const std::filesystem::path& result) {
  impl_->ground = result;
  return *this;
}
HeightsRequest& HeightsRequest::ground_class(int number) {
  impl_->ground_class = number;
  return *this;
}
HeightsRequest& HeightsRequest::format(const std::string& name) {
  impl_->format = name;
  return *this;
}
HeightsRequest& HeightsRequest::outside(double height) {
  impl_->heights.outside = height;
  return *this;
}
HeightsRequest& HeightsRequest::replace(bool replace) {
  impl_->heights.replace = replace;
  return *this;
}
HeightsRequest& HeightsRequest::overwrite(bool overwrite) {
  impl_->overwrite = overwrite;
  return *this;
}
HeightsRequest& HeightsRequest::memory_bytes(std::uint64_t bytes) {
  impl_->memory_bytes = bytes;
  return *this;
}
HeightsRequest& HeightsRequest::threads(unsigned threads) {
  impl_->heights.threads = threads;
  return *this;
}
HeightsRequest& HeightsRequest::stop(std::stop_token stop) {
  impl_->heights.stop = std::move(stop);
  return *this;
}

namespace {

[[noreturn]] void refuse(const char* key, const std::string& reason) {
  throw_failure(error(Errc::usage, option(key) + ": " + reason));
}

template <class Asked>
HeightsOptions chosen(const Asked& asked) {
  HeightsOptions options = asked.heights;
  if (!asked.format.empty()) {
    const auto packing = parse_las_packing(asked.format);
    if (!packing) refuse("format", packing.error().where);
    options.packing = packing.value();
  }
  if (options.outside && !std::isfinite(*options.outside)) refuse("outside", "must be finite");
  if (options.threads == 0) options.threads = usable_processors();
  if (options.threads > threads_max)
    refuse("threads", std::to_string(options.threads) + " is more than the limit, " + std::to_string(threads_max));
  if (asked.ground_class && !asked.ground.empty())
    refuse("ground-class", "says of which points the ground is made, but " + option("ground") + " gives the ground");
  return options;
}

}  // namespace

std::vector<CopyWithHeights> write_heights(const std::vector<std::string>& inputs, const std::filesystem::path& folder,
                                           const HeightsRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    const HeightsOptions options = chosen(asked);
    if (inputs.empty()) throw_failure(error(Errc::usage, "no LAS or LAZ file is given"));
    if (folder.empty()) throw_failure(error(Errc::usage, "no folder for the copies is given"));
    const std::uint64_t memory = asked.memory_bytes == 0 ? default_memory() : asked.memory_bytes;
    auto files = value_or_throw(plan_copies(inputs, folder, options, asked.overwrite));
    or_throw(make_directories(folder));
    std::optional<TemporaryFolder> made;
    std::filesystem::path ground = asked.ground;
    if (ground.empty()) {
      made.emplace(value_or_throw(TemporaryFolder::make(temporary_name_of_process((folder / "ground").string()))));
      ground = made->path() / "result";
      triangulate(inputs, TriangulationOptions()
                              .dimension(2)
                              .classes({asked.ground_class.value_or(2)})
                              .folder(ground)
                              .store("points")
                              .threads(options.threads)
                              .memory_bytes(memory)
                              .stop(options.stop));
    }
    const auto surface = value_or_throw(query::StoredTriangulation::open(ground, {.memory_bytes = memory}));
    or_throw(write_copies(surface, files, options, {}));
    std::vector<CopyWithHeights> copies;
    for (const auto& file : files) copies.push_back({file.from, file.to, file.copy.points, file.copy.outside});
    return copies;
  });
}

}  // namespace tessera
